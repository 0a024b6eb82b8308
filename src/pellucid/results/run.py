"""A run that lies in a folder, opened for reading."""

import shutil
import weakref
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.results import frames, history
from pellucid.results.metrics import Metric, evaluate
from pellucid.results.store import RunFolder

if TYPE_CHECKING:
    from pellucid.case import Case


class Run:
    """What a run left in the folder `out`, which goes with this object if it is `temporary`.

    Everything is read when it is first asked for.
    """

    def __init__(self, out: Path | str, temporary: bool = False) -> None:
        self.folder = RunFolder(out)
        if temporary:
            weakref.finalize(self, shutil.rmtree, self.out, ignore_errors=True)

    @property
    def out(self) -> Path:
        """The folder."""
        return self.folder.path

    @cached_property
    def case(self) -> "Case":
        """The resolved case."""
        return self.folder.read_case()

    @cached_property
    def history(self) -> dict[str, np.ndarray]:
        """Columns of `history.csv` by name, each of shape (rows,)."""
        return history.read(self.folder.history)

    @cached_property
    def units(self) -> dict[str, str]:
        """Units of the columns of the history ("1" for a pure number)."""
        return history.read_units(self.folder.history)

    @property
    def summary(self) -> dict[str, Any]:
        """`summary.json`. Raises `UsageError` where the run has not ended."""
        return self.folder.read_summary()

    @property
    def finished(self) -> bool:
        """Whether the run reached the end of its case."""
        return bool(self.summary["end_time"] >= self.case.time.end * (1.0 - 1e-12))

    @cached_property
    def metrics(self) -> dict[str, Metric]:
        """The metrics of the gallery case by name, computed from the files; see `pellucid.results.metrics.evaluate`."""
        return evaluate(self)

    def times(self, body: str) -> np.ndarray:
        """Instants of the frames of a body [s], shape (frames,)."""
        return frames.times(self.folder.fields(body))

    def fields(self, body: str, time: float | None = None) -> dict[str, np.ndarray]:
        """Fields of a body at the frame nearest to `time` [s], the last by default.

        Shapes (n,), (n, 3) or (n, 6) in SI units; a stress has the order xx, yy, zz, yz, xz, xy. Points keep their
        order from frame to frame.
        """
        index = -1 if time is None else int(np.argmin(np.abs(self.times(body) - time)))
        return frames.read(self.folder.fields(body), index)

    def triangles(self, body: str) -> np.ndarray:
        """Triangles of a membrane, shape (m, 3): numbers of its points in the order of `fields`, the same at all times.

        Counterclockwise about the normal; quadrilaterals are cut in two and come first. Other bodies have none: shape (0, 3).
        """
        return frames.read_triangles(self.folder.fields(body))

    def quads(self, body: str) -> np.ndarray:
        """Quadrilaterals of a membrane of elements, shape (q, 4), numbered and turned as `triangles`; others have none."""
        return frames.read_elements(self.folder.fields(body))[0]

    def __repr__(self) -> str:
        return f"Run({str(self.out)!r})"
