"""Operations on a run of the case of free flight, such as starting and resuming it, for this process or another one."""

import json
import time
from multiprocessing.connection import Connection
from pathlib import Path
from unittest import mock

from free_flight import free_flight

from pellucid.results.pictures import figures
from pellucid.results.report.report import write_report
from pellucid.results.storage.run_folder import RunFolder
from pellucid.running.launch import resume_case, run_case

SHORT = {"time.end": 0.5}
OFTEN = {"output.checkpoint": 1e-9}


def begin(out: Path) -> None:
    run_case(free_flight(), out, report=False)


def begin_in_part(out: Path) -> None:
    run_case(free_flight(), out, until=0.3, report=False)


def begin_another(out: Path) -> None:
    run_case(free_flight(**SHORT), out, report=False)


def begin_with_a_checkpoint_each_step(out: Path) -> None:
    run_case(free_flight(**OFTEN), out, report=False)


def go_on(out: Path) -> None:
    resume_case(out, report=False)


def go_on_in_part(out: Path) -> None:
    resume_case(out, until=0.7, report=False)


def go_on_with_another_limit(out: Path) -> None:
    resume_case(out, settings={"energy.warn": 0.05}, report=False)


def write_plain_report(out: Path) -> None:
    """Write a report without figures, which take most of the time."""
    with mock.patch.object(figures, "figures_of", return_value={}):
        write_report(out)


def hold(out: Path, held: Connection) -> None:
    """Lock the folder of a run against other processes, for ever, after a message through `held` that it is locked."""
    with RunFolder(out).held():
        held.send(True)
        time.sleep(1e6)


def results(out) -> dict[str, object]:
    """Return the history, summary and fields of a run, which must not depend on how often the run was interrupted."""
    summary = json.loads((out / "summary.json").read_text())
    for name in ("wall_seconds", "point_steps_per_second"):
        del summary[name]
    fields = {path.name: path.read_bytes() for path in (out / "fields").iterdir() if path.suffix == ".vtkhdf"}
    return {"history": (out / "history.csv").read_bytes(), "summary": summary, "fields": fields}
