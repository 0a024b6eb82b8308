"""A small run killed at random instants and resumed: the results have the bits of a run that nothing disturbed.

python killed_runs.py 100        writes killed_runs.csv beside this file, or to the file named behind the number
"""

import csv
import json
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

CASE = Path(__file__).parent / "two-blocks.toml"  # with a checkpoint at every step
BEGIN = "import pellucid, sys; pellucid.run(pellucid.load(sys.argv[1]), sys.argv[2], threads=1, report={})"
GO_ON = "import sys; from pellucid.results import resume_case; resume_case(sys.argv[1], threads=1, report={})"
PHASES = ("report", "set-up", "steps", "steps")
"""In which phase the trials are killed, in turn. The clock of a kill starts with the phase, whatever the machine does."""
BEGINS = {"steps": "run.lock", "report": "summary.json"}
"""The file with which a phase begins; the set-up begins with the process."""
LATEST = 600.0  # s that a file may take to appear
OF_THE_MACHINE = ("wall_seconds", "point_steps_per_second")
COLUMNS = (
    *("trial", "killed in", "seconds", "phase", "rows", "frames written", "checkpoints", "draft"),
    *("second kill [s]", "phase then", "same bits", "missing or left"),
)


def begin(out: Path, report: bool) -> list[str | Path]:
    return [sys.executable, "-c", BEGIN.format(report), CASE, out]


def go_on(out: Path, report: bool) -> list[str | Path]:
    return [sys.executable, "-c", GO_ON.format(report), out]


def started(command: list[str | Path]) -> subprocess.Popen:
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def killed(command: list[str | Path], begun: Callable[[], bool], seconds: float) -> None:
    """Start a command and kill it so many seconds after it has begun what is waited for, if it has not ended by then."""
    process, latest = started(command), time.monotonic() + LATEST
    while not begun() and process.poll() is None and time.monotonic() < latest:
        time.sleep(5e-4)
    try:
        process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def checkpoints(out: Path) -> set[str]:
    return {path.name for path in (out / "checkpoint").glob("*.npz")}


def durations(command: list[str | Path], out: Path) -> dict[str, float]:
    """How long each phase of an unbroken run takes [s]."""
    process, begun = started(command), {"set-up": time.monotonic()}
    for phase, name in BEGINS.items():
        while not (out / name).exists() and process.poll() is None:
            time.sleep(5e-4)
        begun[phase] = time.monotonic()
    if process.wait():
        raise SystemExit(f"the unbroken run ended with status {process.returncode}")
    ends = [*list(begun.values())[1:], time.monotonic()]
    return {phase: end - begin for (phase, begin), end in zip(begun.items(), ends, strict=True)}


def names(out: Path) -> set[str]:
    """The files of a run; those of checkpoints by their ending, as their names have their numbers and digests."""
    found = {path.relative_to(out) for path in out.rglob("*") if path.is_file()}
    return {f"checkpoint/*{name.suffix}" if name.parts[0] == "checkpoint" else str(name) for name in found}


def results(out: Path) -> dict[str, object]:
    """Everything that must not depend on how often a run was broken off."""
    summary = json.loads((out / "summary.json").read_text())
    for name in OF_THE_MACHINE:
        del summary[name]
    files = [out / "case.toml", out / "history.csv", *sorted((out / "fields").glob("*.vtkhdf"))]
    return {"summary": summary} | {path.name: path.read_bytes() for path in files}


def state(out: Path) -> tuple[str, int, bool, int, bool]:
    """How far a run has come: phase, rows of its history, whether frames are there, checkpoints, a draft left behind."""
    history, checkpoints = out / "history.csv", list((out / "checkpoint").glob("*.npz"))
    rows = max(0, history.read_bytes().count(b"\n") - 2) if history.exists() else 0
    phases = {
        "report": (out / "figures").exists(),
        "metrics": (out / "summary.json").exists(),
        "running": bool(rows),
        "begun": (out / "run.lock").exists(),
        "set-up": True,
    }
    draft = any(".writing" in path.name for path in out.rglob("*"))
    return next(name for name, there in phases.items() if there), rows, (out / "fields").exists(), len(checkpoints), draft


def trial(number: int, folder: Path, lengths: dict[str, float], whole: Path) -> dict[str, object]:
    """One run, killed once or twice, and resumed; begun again where it had not yet begun."""
    rng, out = random.Random(number), folder / f"run-{number}"
    phase = PHASES[number % len(PHASES)]
    report = phase == "report"
    seconds = rng.random() * lengths[phase]
    killed(begin(out, report), lambda: phase == "set-up" or (out / BEGINS[phase]).exists(), seconds)
    row: dict[str, object] = dict(zip(COLUMNS, (number, phase, f"{seconds:.3f}", *state(out)), strict=False))
    row |= {"second kill [s]": "", "phase then": ""}
    begun = (out / "case.toml").exists()
    if begun and rng.random() < 0.5:
        before, again = checkpoints(out), rng.random() * lengths["report" if report else "steps"]
        ended = (out / "summary.json").exists()  # a resumed run removes it before its first step
        killed(go_on(out, report), lambda: checkpoints(out) != before or (out / "summary.json").exists() != ended, again)
        row |= {"second kill [s]": f"{again:.3f}", "phase then": state(out)[0]}
    ended_well = subprocess.run((go_on if begun else begin)(out, report), capture_output=True, text=True)
    if ended_well.returncode:
        print(number, ended_well.stderr, flush=True)
        return row | {"same bits": False, "missing or left": f"exit status {ended_well.returncode}"}
    wrong = sorted(names(whole) ^ names(out))
    return row | {"same bits": results(out) == results(whole), "missing or left": " ".join(wrong)}


def trials(numbers: range, folder: Path) -> list[dict[str, object]]:
    """The unbroken runs, with a report and without, then the trials."""
    whole = {report: folder / f"whole-{report}" for report in (True, False)}
    lengths = {}
    for report, out in whole.items():
        subprocess.run(begin(out, report), check=True, capture_output=True)  # this one may compile
        shutil.rmtree(out)
        lengths[report] = durations(begin(out, report), out)
        shown = ", ".join(f"{phase} {seconds:.2f} s" for phase, seconds in lengths[report].items())
        print(f"unbroken, {'with' if report else 'without'} a report: {shown}", flush=True)
    rows = []
    for number in numbers:
        report = PHASES[number % len(PHASES)] == "report"
        rows.append(trial(number, folder, lengths[report], whole[report]))
        print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        rows = trials(range(int(sys.argv[1])), Path(folder))
    table = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).parent / "killed_runs.csv"
    with table.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} kills, {sum(bool(row['same bits']) for row in rows)} with the same bits, ", end="")
    print(f"{sum(bool(row['missing or left']) for row in rows)} with files missing or left behind")
