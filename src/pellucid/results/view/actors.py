"""Bodies in the interactive view: the selected points, their representation as surface, lines or points, and scalar fields."""

from collections.abc import Sequence

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.results.pictures.bodies_in_space import faceted
from pellucid.results.pictures.quantities import there
from pellucid.results.pictures.rendering.creases import Faceted
from pellucid.results.pictures.rendering.points import ball_radii
from pellucid.results.pictures.seams import way_into_box
from pellucid.results.pictures.walls import fan_of, polygon_of
from pellucid.results.storage.probes import scalar
from pellucid.results.storage.run import Run
from pellucid.results.storage.stored_case import StoredWall
from pellucid.state import FIELDS

GAPLESS = 1.3
"""Factor on the radius of discs in a plane problem, relative to discs of the points' area, so that no gaps are visible."""
UNSEEN = frozenset(("id", "position", "start", "mass", "volume", "driven", "prescribed", "angle", "failed", "in_plane"))
"""Fields that are not offered as colours; failed points have a colour of their own."""

Fields = dict[str, np.ndarray]


class Actor:
    """A body in the interactive view: the selection of its points, and their fields at any time.

    name: name of the body. most: largest number of points to show. If points are omitted, the view shows the selected
    points without the surface or lines of the body. The selection is random, but the same in every page, because a regular
    selection from a lattice would show stripes.
    """

    def __init__(self, run: Run, name: str, most: int) -> None:
        self.name, self._run = name, run
        start = run.fields(name, float(run.times(name)[0]))
        self.total = len(start["position"])
        self._chosen = np.arange(self.total)
        if most < self.total:
            self._chosen = np.sort(np.random.default_rng(0).choice(self.total, most, replace=False))
        self.start = start["position"][self._chosen]
        self.cells = run.cells(name) if most >= self.total else Cells()
        self.surface = faceted(self.cells, self.start)
        self.radius = float(_radius(run, start) * np.cbrt(self.total / len(self._chosen)))

    @property
    def kind(self) -> str:
        """Representation of the body in the view: "surface", "lines" or "points"."""
        return "surface" if len(self.surface.triangles) else "lines" if len(self.cells.lines) else "points"

    def at(self, time: float) -> Fields:
        """Return the stored fields of the shown points, by name, at the frame nearest to a time [s]."""
        return {name: values[self._chosen] for name, values in self._run.fields(self.name, time).items()}

    def in_box(self, position: np.ndarray) -> np.ndarray:
        """Return positions of the points, shape (n, 3) [m], moved into the box of the grid if the grid is periodic."""
        return position + way_into_box(position, self.cells, self._run.stored.grid)

    def shown(self, fields: Fields) -> Fields:
        """Return the scalar fields that the view offers as colours, by name, shape (n,): scalars, lengths of vectors, von Mises
        stresses, and the displacement since the start [m]. fields: result of `at`."""
        found = {"displacement": np.linalg.norm(fields["position"] - self.start, axis=1)}
        for name, values in fields.items():
            if name not in UNSEEN and (values.ndim == 1 or values.shape[1] in (3, 6)):
                found[name] = scalar(values, names=FIELDS[name].names if name in FIELDS else ())
        return {name: values.astype(np.float32) for name, values in found.items()}


class WallActor:
    """A plane wall in the interactive view, clipped to a box and shown as a surface, or as a line in a plane problem. The
    wall moves as a whole and has no fields."""

    radius = 0.0

    def __init__(
        self, wall: StoredWall, box: tuple[np.ndarray, np.ndarray], across: int | None, times: Sequence[float]
    ) -> None:
        """Compute the outline of the wall at the first time at which it intersects the box.

        box: lower and upper corner [m]. across: axis (0 to 2) normal to a plane problem; None in space. times: times that are
        shown [s].
        """
        self.name, self._wall, self.start = wall.name, wall, np.zeros((0, 3))
        for time in times:
            if not len(self.start):
                self.start = polygon_of(wall, time, *box) - self._way(time)
        self.cells, self.surface = Cells(), Faceted(fan_of(len(self.start)), np.arange(len(self.start)))
        if across is not None and len(self.start):
            along = np.cross(wall.normal, np.eye(3)[across])
            ends = self.start[[int(np.argmin(self.start @ along)), int(np.argmax(self.start @ along))]]
            ends[:, across] = 0.5 * (box[0] + box[1])[across]
            self.start, self.cells = ends, Cells(lines=np.array([(0, 1)]))
            self.surface = Faceted(np.zeros((0, 3), np.int64), np.arange(2))

    @property
    def kind(self) -> str:
        return "lines" if len(self.cells.lines) else "surface"

    def places(self, time: float) -> np.ndarray:
        """Return the corners of the drawn part of the wall at a time [s], shape (n, 3) [m]."""
        return np.asarray(self.start + self._way(time))

    def _way(self, time: float) -> np.ndarray:
        return np.asarray(time * float(self._wall.velocity @ self._wall.normal) * self._wall.normal)


def _radius(run: Run, start: Fields) -> float:
    """Return the radius of the balls or discs that show the points of a body [m]. start: the fields of the first frame.

    A ball has the volume of a point. In a plane problem the radius of a disc is GAPLESS times the radius of a disc with the
    area of a point. For the nodes of a fluid film the radius follows from the extent of the film and the number of nodes.
    """
    grid = run.stored.grid
    if "density" not in start or not (kept := there(start)).any():  # nodes of a film
        return float(0.5 * np.ptp(start["position"], axis=0).max() / np.sqrt(len(start["position"])))
    ball = float(np.median(ball_radii(start["mass"][kept], start["density"][kept])))
    if grid is None or not any(grid.thin()):
        return ball
    return GAPLESS * float(np.sqrt(4.0 / 3.0 * ball**3 / grid.slice_thickness()))
