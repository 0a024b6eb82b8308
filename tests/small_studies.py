"""A case for tests of studies, whose runs take almost no time: points move with constant velocities, and members run in
this process."""

import csv
import sys
from pathlib import Path

from free_flight import FakeSimulation, fake_module, free_flight

from pellucid.case import Case, load
from pellucid.errors import PellucidError, RunStopped
from pellucid.running.launch import run_case
from pellucid.studies import pool
from pellucid.studies.members import FAILED, Outcome, outcome, places

SPEED = "body.gas.velocity.0"
LAG = "body.block.velocity.0"
TOO_FAST = 12.0
BEGUN: list[str] = []
"""Digests of the members that were run. The list belongs to the module because dask would copy it with a function."""


class Paced(FakeSimulation):
    """Fake simulation in which the speed of the gas depends on both parameters: the first velocity component of the gas,
    less 0.1 times the square of that of the block. Above TOO_FAST the run fails."""

    def __init__(self, case: Case, threads: int | None = None, start: object = None) -> None:
        super().__init__(case, threads, start)
        self.bodies[0].velocity[:] = 0.0
        self.bodies[0].velocity[:, 0] = case.body[0].velocity[0] - 0.1 * case.body[1].velocity[0] ** 2
        if case.body[0].velocity[0] > TOO_FAST:
            self.breaks_at = 3


def case(**settings: object) -> Case:
    return free_flight(**{"body.block.velocity": [0, 0, 0], **settings})


def run_here(out: Path, digest: str, threads: int, until: float | None) -> Outcome:
    """Run a member in this process; replaces `run_member`."""
    if (found := outcome(out, digest)) is not None:
        return found
    BEGUN.append(digest)
    where = places(out, digest)
    try:
        run_case(load(where.case), where.run, until=until, report=False)
    except RunStopped:
        pass
    except PellucidError as error:
        return Outcome(FAILED, str(error))
    return outcome(out, digest) or Outcome(FAILED, "no summary")


def run_members_here(monkeypatch) -> list[str]:
    """Let studies run their members in this process with the simulation `Paced`; return the list to which the digests of
    members that run are added."""
    module = fake_module()
    module.Simulation = Paced
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", module)
    return run_members_here_as_they_are(monkeypatch)


def run_members_here_as_they_are(monkeypatch) -> list[str]:
    """Let studies run their members in this process with the simulation that is imported; return the list to which the
    digests of members that run are added."""
    monkeypatch.setattr(pool, "run_member", run_here)
    BEGUN.clear()
    return BEGUN


def write_csv(path: Path, *rows: tuple) -> Path:
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return path
