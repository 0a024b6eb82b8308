"""The recorder: writes the output that is due after each step. It never changes the state of the simulation."""

import hashlib
import math
import time as clock
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import RunStopped
from pellucid.ranks.domain import IN_FIRST, NOWHERE, domain
from pellucid.results.metrics import finite
from pellucid.results.storage import checkpoint, frames, history
from pellucid.results.storage.files import OutputError, explained, sync
from pellucid.results.storage.identity import (
    Start,
    digests,
    identity,
    package_commit,
    package_version,
    start_digest,
    users_kinds,
)
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run_folder import RunFolder

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.parts.body import Body


class Recorder:
    """Writes the history (rows), fields (frames) and checkpoints of a run to its folder, and collects the values of its summary
    (`facts`).

    compiling: function that returns the total compilation time of kernels so far [s]. numbers: numbers of the checkpoint from
    which the run continues; None for a new run. start: arrays with which bodies continue an earlier run. In the methods, sim is
    the simulation.
    """

    def __init__(
        self,
        folder: RunFolder,
        case: "Case",
        compiling: Callable[[], float],
        numbers: Mapping[str, Any] | None = None,
        start: Start | None = None,
    ) -> None:
        self.folder, self.case, self._start = folder, case, start_digest(start or {})
        self.resumes_record = numbers is not None and bool(numbers.get("begun", True))
        """True if the run continues from recorded output; False if it settles first."""
        self._begun = False  # not while bodies settle
        self._equilibrium = 0.0
        recorded = numbers or {"rows": {}, "frames": {}, "wall_seconds": 0.0}
        self._rows = Schedule(_row_interval(case), **recorded["rows"])
        self._frames = Schedule(case.output.frames_every(case.time.end), **recorded["frames"])
        self._inputs = recorded.get("inputs") or digests(case)
        self._kinds = users_kinds(case)
        every = [condition for several in case.conditions().values() for condition in several]
        self._states = {name: unit for condition in every for name, unit in condition.columns().items()}
        if case.steady is not None:
            self._states |= case.steady.columns()
        self._probes = ProbeReader(case.probe, recorded.get("probes"), case.periods)
        self._written: dict[str, Any] = defaultdict(hashlib.sha256)  # of all that was added to each file so far
        self._known = recorded.get("written", {})
        self._wall_before = float(recorded["wall_seconds"])
        self._compiling = compiling
        self._checkpointed = clock.monotonic()
        self._started = self._checkpointed - compiling()
        self.facts: dict[str, Any] = {}
        self._writes = domain.group.is_first  # others that share the simulation give their part of what is written

    def begin(self, sim: Any) -> None:
        """Write the initial state of a new run; in a resumed run, cut the files back to the state of the checkpoint. Called
        before the first step."""
        self._begun = True
        if self._writes:
            with explained(self.folder.path):
                self._begin_files(sim)
        if not self.resumes_record:
            self._probes.start(sim.bodies)
            self.after_step(sim)

    def _begin_files(self, sim: Any) -> None:
        if self.resumes_record:
            self._check_what_is_there(sim)
            self.folder.reopen()
            history.cut(self.folder.history, self._rows.done)
            for body in sim.bodies:
                frames.cut(self.folder.fields(body.name), self._frames.done)
        else:
            history.create(self.folder.history, self._columns(sim))
            self.folder.fields("").parent.mkdir(exist_ok=True)

    def after_step(self, sim: Any) -> None:
        """Write a row of the history, a frame of the fields and a checkpoint, each if it is due. Called after each step."""
        if self._rows.due(sim.time):
            self._write_row(sim)
        elif self.case.steady is not None and sim.time > self._equilibrium:  # so that a reaction is that of one equilibrium
            self._probes.count_from(sim.budget.reactions(), sim.time, sim.budget.angular_reactions())
        self._equilibrium = sim.time
        if self._frames.due(sim.time):
            self._write_frame(sim)
        self._checkpoint_now_and_then(sim)

    def while_settling(self, sim: Any) -> None:
        """Write a checkpoint if one is due. Called after each settling step (in which bodies approach equilibrium before
        time 0); settling steps have no other output."""
        self._checkpoint_now_and_then(sim)

    def _checkpoint_now_and_then(self, sim: Any) -> None:
        due = clock.monotonic() - self._checkpointed >= self.case.output.checkpoint
        if domain.group.told(due):
            self.checkpoint(sim)

    def end(self, sim: Any) -> None:
        """Write the last row, frame and checkpoint, and collect the values of the summary."""
        finished = self.case.time.reached(sim.time)
        if not finished:  # an early stop: what is written below is not part of the run and is cut when it goes on
            self.checkpoint(sim)
        self.keep_last(sim)
        if finished:
            self.checkpoint(sim)
        self.facts = self._facts(sim)

    def keep_last(self, sim: Any) -> None:
        """Write a row of the history and a frame of the fields for the current state, each only if none was written in the
        last step."""
        if self._rows.last_step != sim.n_steps:
            self._write_row(sim)
        if self._frames.last_step != sim.n_steps:
            self._write_frame(sim)

    def checkpoint(self, sim: Any) -> None:
        """Write a checkpoint from which the run can be resumed with bitwise identical results."""
        with explained(self.folder.path):
            for path in self._files(sim).values() if self._begun and self._writes else ():
                sync(path)
        recorded = {
            "begun": self._begun,
            "rows": self._rows.to_data(),
            "frames": self._frames.to_data(),
            "probes": self._probes.to_data(),
            "inputs": self._inputs,
            "kinds": self._kinds,
            "identity": identity(self.case, sim.bodies, self._start),
            "wall_seconds": self.wall_seconds(),
            "written": self._digests(),
        }
        with domain.joining(NOWHERE):
            arrays = sim.state_arrays()
        numbers, folder = {"simulation": sim.state_numbers(), "recorder": recorded}, self.folder.checkpoint
        if domain.is_cut:
            self._write_with_others(sim, arrays, numbers)
        elif self._writes:
            checkpoint.write(folder, arrays, numbers)
        self._checkpointed = clock.monotonic()

    def _write_with_others(self, sim: Any, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Write a checkpoint of a simulation that several processes share; each process writes its own rows of the shared
        arrays.

        arrays, numbers: state of the simulation for `checkpoint.write`.
        """
        folder, group = self.folder.checkpoint, domain.group
        serial = group.told(checkpoint.next_serial(folder))
        shared, part = sim.spread_arrays(), ""
        if not self._writes:
            part = checkpoint.write_part(folder, {name: arrays[name] for name in shared}, group.rank, serial)
        parts = [name for name in group.each(part) if name]
        if self._writes:
            checkpoint.write(folder, arrays, numbers, parts, serial)

    def failed(self, sim: Any, error: RunStopped) -> None:
        """Write the reason of an error stop, the whole state and a last row of the history for diagnosis. Errors while writing
        do not replace the original error."""
        what = {"message": str(error), "step": sim.n_steps, "time": sim.time} | error.place
        self.facts = self._facts(sim)
        with domain.joining(IN_FIRST):
            arrays = sim.state_arrays()
        try:
            if self._writes:
                self.folder.write_failure(what, arrays)
        except OSError as trouble:
            error.add_note(f"The forensic dump could not be written: {trouble}")
        try:
            self._write_last_row(sim)
        except (OSError, OutputError, RunStopped) as trouble:
            error.add_note(f"The last row of the history could not be written: {trouble}")

    def wall_seconds(self) -> float:
        """Return the wall-clock time of the run so far without compilation [s], including the time before the run was last
        resumed."""
        return self._wall_before + clock.monotonic() - self._compiling() - self._started

    def _columns(self, sim: Any) -> dict[str, str]:
        ends = "_energy", "_work", "_heat", "_error"
        energies = {entry if entry.endswith(ends) else f"{entry}_energy": "J" for entry in sim.budget.energies()}
        momentum = {f"momentum_{axis}": "kg m/s" for axis in "xyz"}
        clock_columns = {"time": "s", "step": "", "dt": "s"}
        passed = {
            f"{way}_{name}": unit
            for way, counts in (("inflow", sim.budget.inflow), ("outflow", sim.budget.outflow))
            for name, unit in (("points", ""), ("mass", "kg"))
            if name in counts
        }
        return clock_columns | energies | {"energy_error": ""} | momentum | passed | self._states | self._probes.units()

    def _write_row(self, sim: Any) -> None:
        row = [sim.time, int(sim.n_steps), sim.dt, *sim.budget.energies().values(), sim.budget.conservation()["energy"]]
        values = self._probes.read(sim.bodies, sim.budget.reactions(), sim.time, sim.budget.angular_reactions())
        if self._writes:
            with explained(self.folder.path):
                states, passed = sim.parts.columns(), [*sim.budget.inflow.values(), *sim.budget.outflow.values()]
                own = [*sim.momentum(), *passed, *(states[name] for name in self._states)]
                line = history.append(self.folder.history, [*row, *own, *values])
            self._written[self.folder.history.name].update(line)
        self._rows.mark(sim.time, sim.n_steps)

    def _write_last_row(self, sim: Any) -> None:
        """Write a row of the history for the time of an error stop if all its values are finite, so that curves extend to
        this time. The row is removed when the run is resumed."""
        if not sim.budget.is_complete or self._rows.last_step == sim.n_steps or not self._rows.done:
            return
        if np.isfinite([*sim.budget.energies().values(), *sim.momentum()]).all():
            self._write_row(sim)

    def _write_frame(self, sim: Any) -> None:
        for body in sim.bodies:
            with domain.joining(IN_FIRST):
                frame = body.frame()
            if self._writes:
                with explained(self.folder.path):
                    self._written[body.name].update(self._add_frame(sim, body, frame))
        self._frames.mark(sim.time, sim.n_steps)

    def _add_frame(self, sim: Any, body: Any, frame: Mapping[str, np.ndarray]) -> bytes:
        path = self.folder.fields(body.name)
        if self._frames.done == 0:
            room = capacity(self.case.time.end, self._frames.interval)
            return frames.create(path, room, sim.time, frame, body.cells(), body.constant_fields)
        return frames.append(path, sim.time, frame, body.constant_fields)

    def _files(self, sim: Any) -> dict[str, Path]:
        """Return the paths of the files that grow during the run, by name: the history by its file name, the fields by the name
        of the body."""
        history_file = {self.folder.history.name: self.folder.history}
        return {body.name: self.folder.fields(body.name) for body in sim.bodies} | history_file

    def _digests(self) -> dict[str, str]:
        """Return the SHA-256 digest of all data written so far to each growing file, by the names that `_files` uses."""
        return {name: digest.hexdigest() for name, digest in self._written.items()}

    def _check_what_is_there(self, sim: Any) -> None:
        """Raise OutputError if the rows and frames in the files differ from the rows and frames that were written before
        the checkpoint."""
        for name, path in self._files(sim).items():
            is_history = path == self.folder.history
            found = history.first(path, self._rows.done) if is_history else frames.first(path, self._frames.done)
            for part in found:
                self._written[name].update(part)
            if self._digests().get(name) != self._known.get(name):
                what = "rows" if is_history else "frames"
                text = f"{path} was changed: its first {len(found)} {what} are not those written before the checkpoint"
                raise OutputError(f"{text}\n    Restore the old file to continue, or start a new run.")

    def _facts(self, sim: Any) -> dict[str, Any]:
        points, wall, told = sum(body.n_told for body in sim.bodies), self.wall_seconds(), sim.facts()
        steps = sim.n_steps + told.get("settled", {}).get("steps", 0)  # all that took the time
        return {
            "case": self.case.id or self.case.title,
            "version": package_version(),
            "commit": package_commit(),
            "threads": sim.threads,
            "processes": domain.group.size,
            "points": points,
            "steps": sim.n_steps,
            "wall_seconds": wall,
            "point_steps_per_second": points * steps / wall if wall > 0.0 else 0.0,
            "end_time": sim.time,
            "conservation": {name: float(error) for name, error in sim.budget.conservation().items()},
            "energies": {name: float(energy) for name, energy in sim.budget.energies().items()},
            **told,
            **facts_of(sim.bodies),
        }


def _row_interval(case: "Case") -> float:
    """Return the time between rows of the history [s]. In a steady analysis without `output.history` in the case, the
    interval is short enough for a row at each equilibrium."""
    interval = case.output.rows_every(case.time.end)
    if case.steady is None or case.output.history is not None:
        return interval
    levels = np.array(case.steady.levels(case.time.end)) * (case.time.end / case.steady.load_steps)
    return min(interval, 0.5 * float(np.diff(levels).min()))


def facts_of(bodies: "Sequence[Body]") -> dict[str, float | None]:
    """Collect the values that each body reports in `facts()` for the summary, by name; if several bodies use the same name, the
    key includes the name of the body. Values that are not finite become None."""
    facts = {body.name: body.facts() for body in bodies}
    names = [name for of_body in facts.values() for name in of_body]
    shown = {}
    for body, of_body in facts.items():
        for name, value in of_body.items():
            shown[name if names.count(name) == 1 else f"{name} {body}"] = finite(value)
    return shown


CLOSE = 1e-9
"""Tolerance for output times, as a fraction of the interval: sums of time steps do not hit multiples exactly."""


@dataclass
class Schedule:
    """Schedule of output at the simulated times 0, `interval`, 2 `interval`, ... [s], for the rows of the history and the
    frames of the fields.

    `done`: number of outputs so far. `last_step`, `last_time`: step number and time [s] of the last output; -1 and 0 before
    the first output.
    """

    interval: float
    done: int = 0
    last_step: int = -1
    last_time: float = 0.0

    @property
    def next(self) -> int:
        """Index k of the next output; the output time is k times `interval`. If one step passes several output times, a
        single output is written for all of them."""
        return math.floor(self.last_time / self.interval + CLOSE) + 1 if self.done else 0

    def due(self, time: float) -> bool:
        """True if the next output time is reached at `time` [s]."""
        return time >= (self.next - CLOSE) * self.interval

    def mark(self, time: float, step: int) -> None:
        """Record that an output was written at `time` [s] in the step with the number `step`."""
        self.done += 1
        self.last_step, self.last_time = step, time

    def to_data(self) -> dict[str, float]:
        """Return the state for a checkpoint. A run may be resumed with another interval."""
        return {"done": self.done, "last_step": self.last_step, "last_time": self.last_time}


def capacity(end: float, interval: float) -> int:
    """Return the largest number of outputs of a run to `end` [s] with an output every `interval` [s], including the first
    output, the last output, and an output at an early stop."""
    return math.floor(end / interval + CLOSE) + 3
