"""A run in a folder, opened for reading."""

import shutil
import warnings
import weakref
from collections.abc import Collection
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid import catalogue
from pellucid.errors import UnknownName, UsageError
from pellucid.findings import Named, absent
from pellucid.geometry.meshes.cells import Cells
from pellucid.results.metrics import Metric, Readings, metric_of
from pellucid.results.storage import frames, history
from pellucid.results.storage.run_folder import RunFolder

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.results.storage.run_folder import StoredCase


class Run:
    """Results in the run folder `out`. If `temporary`, the folder is deleted with this object.

    Files are read on first use. Unknown names of columns, fields, bodies and metrics raise `UnknownName`, a `UsageError` and
    `KeyError` that lists the known names.
    """

    def __init__(self, out: Path | str, temporary: bool = False) -> None:
        self.folder = RunFolder(out)
        if temporary:
            weakref.finalize(self, shutil.rmtree, self.out, ignore_errors=True)

    @property
    def out(self) -> Path:
        """Path of the run folder."""
        return self.folder.path

    @cached_property
    def case(self) -> "Case":
        """The resolved case. Raises `CaseError` if a file that the case reads or that registers a kind no longer exists."""
        return self.folder.read_case()

    @cached_property
    def stored(self) -> "StoredCase":
        """The part of the case that is needed to read results. It can be read even if kinds that the case names are unknown."""
        return self.folder.read_stored()

    @cached_property
    def history(self) -> dict[str, np.ndarray]:
        """Columns of `history.csv` by name, each of shape (rows,), in SI units."""
        return Named(self._without("the history", "column"), history.read(self.folder.history))

    @cached_property
    def readings(self) -> Readings:
        """The columns of the history, read as curves."""
        return Readings(self.history, self.stored.means, self.stored.steady is not None)

    def curve(self, y: str, x: str = "time") -> tuple[np.ndarray, np.ndarray]:
        """Return the column `y` of the history against the column `x`, both evaluated at the same times: abscissae and
        ordinates, each of shape (n,).

        A reaction or torque is the mean since the previous row. Its value belongs to the middle of the interval between the
        rows, and the values of the other column are averaged to this time.
        """
        return self.readings.curve(y, x)

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of each column of the history, by name ("1" for a pure number)."""
        return Named(self._without("the history", "column"), history.read_units(self.folder.history))

    @property
    def summary(self) -> dict[str, Any]:
        """Contents of `summary.json`. Raises `UsageError` if the run has not ended."""
        return self.folder.read_summary()

    @property
    def finished(self) -> bool:
        """True if the run reached the end time of its case."""
        if not self.folder.ended or self.stopped:
            return False
        return self.stored.time.reached(self.summary["end_time"])

    @property
    def stopped(self) -> dict[str, Any]:
        """Data of an error stop: message, step, time, and body, point and its state if known; empty if there was no error
        stop."""
        return self.folder.read_failure()

    @property
    def so_far(self) -> dict[str, Any]:
        """The summary; if the run has not ended, the number of steps and the time [s] of the last history row."""
        if self.folder.ended:
            return self.summary
        steps = self.history["step"].tolist() if self.folder.history.is_file() else []
        if not steps:
            raise UsageError(f"The run in {self.out} has no results yet.\n    Run `pellucid resume {self.out}` to continue it.")
        return {"steps": int(steps[-1]), "end_time": float(self.history["time"][-1])}

    @cached_property
    def metrics(self) -> dict[str, Metric]:
        """Metrics of a finished run by name, defined by the checks of the case and by the Python module of the gallery
        case.

        Empty if the run is not finished. If the module cannot evaluate the run, e.g. because changed settings are outside
        the range of its reference, the metrics of the module are omitted with a warning.
        """
        module = catalogue.module(self.stored.id)
        found: dict[str, Metric] = {}
        if self.finished:
            found = {asked.name: metric_of(asked, self.readings, self.units) for asked in self.stored.check}
        if module is not None and self.finished:
            try:
                found |= module.metrics(self)
            except Exception as error:  # the run is done and its results are whole, whatever the module makes of them
                warnings.warn(f"the metrics of {self.stored.id} could not be computed for this run: {error}", stacklevel=2)
        return Named(f"the run in {self.out} has no metric", found)

    def times(self, body: str) -> np.ndarray:
        """Return the times of the stored frames of a body [s], shape (frames,). Raises `UsageError` for a body that the case
        does not have."""
        return frames.times(self._file(body))

    def fields(self, body: str, time: float | None = None, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """Return fields of a body at the frame nearest to `time` [s], by name; default: the last frame and all fields.

        Shapes are (n,), (n, 3) or (n, 6) in SI units; a stress has the order xx, yy, zz, yz, xz, xy. In every frame, points
        have the order of the body's mesh, of the vertices of its surface, or of its seeding. Raises `UsageError` for a body
        or field that the run does not have, and for a time more than half a frame interval before the first or after the
        last frame.
        """
        path, what = self._file(body), f"body {body} of the run in {self.out} has no field"
        wanted = [names] if isinstance(names, str) else names
        if wanted is not None and (unknown := set(wanted) - (known := dict.fromkeys(frames.names(path))).keys()):
            raise UnknownName(absent(what, min(unknown, key=str), known))
        return Named(what, frames.read(path, -1 if time is None else self._nearest(body, time), wanted))

    def cells(self, body: str) -> Cells:
        """Return the cells of a body (the elements of its mesh, or one cell per point), which are the same at all times.
        Points are numbered in the order of `fields`."""
        return frames.read_cells(self._file(body))

    def triangles(self, body: str) -> np.ndarray:
        """Return the triangles of a membrane, shape (m, 3), see `Cells.surface`; empty for bodies of points."""
        return self.cells(body).surface()

    def _without(self, part: str, what: str) -> str:
        return f"{part} of the run in {self.out} has no {what}"

    def _nearest(self, body: str, time: float) -> int:
        """Return the index of the stored frame of a body that is nearest to a time [s]."""
        times = self.times(body)
        slack = 0.5 * self.stored.output.frames_every(self.stored.time.end) * (1.0 + 1e-9)
        try:
            near = times[0] - slack <= time <= times[-1] + slack
        except TypeError:
            raise UsageError(f"{time!r} is not a time; set a number of seconds") from None
        if not near:
            raise UsageError(
                f"body {body} has no frame near t = {time:g} s; its first is at {times[0]:g} s, its last at {times[-1]:g} s"
            )
        return int(np.argmin(np.abs(times - time)))

    def _file(self, body: str) -> Path:
        names = [known.name for known in self.stored.bodies]
        if body not in names:
            raise UnknownName(absent(f"the run in {self.out} has no body", body, names))
        return self.folder.fields(body)

    def __repr__(self) -> str:
        if not self.folder.ended:
            return f"Run({str(self.out)!r})"
        time, steps = self.summary["end_time"], self.summary["steps"]
        return f"Run({str(self.out)!r}, {self.stored.title!r}, to t = {time:g} s in {steps} steps)"
