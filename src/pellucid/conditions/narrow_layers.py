"""Warning about layers of liquid between a membrane and a wall that are too thin for the grid.

A membrane that moves past a wall slides on a layer of liquid. Membrane and liquid share the nodes of the grid, so in a thin
layer the nodes of the wall also hold the membrane. `validation/slit` has measured errors: with B-splines a cell passes a slit
in the right time, within 3 %, if the layer is nowhere thinner than 0.6 cells, and up to 60 % later if it becomes thinner
than 0.3 cells. With other functions it stops 1.4 cells before the edges of the slit, where such a layer should form.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Lattice
from pellucid.parts.assembly import AssembledBody
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

LEAST_SMOOTH, LEAST_OTHER = 0.5, 1.5  # cells: thinnest layer with B-splines; with other functions, which reach up to this far
FUNCTIONS = 'grid.functions = "quadratic-bspline", and if this warning comes again, '

IsInWall = Callable[[np.ndarray], np.ndarray]
"""Returns a mask of the positions [m], shape (n, 3), that lie in a wall, shape (n,)."""


class NarrowLayers(StepPart):
    """Warns of layers between the membranes of a velocity field and walls on which its liquids do not slip. Points of membranes
    that are near a wall from the start are left out: membranes may be attached there."""

    def __init__(
        self, membranes: Sequence[AssembledBody], walls: Sequence[tuple[str, IsInWall]], actions: NodalActions
    ) -> None:
        """membranes: membranes of the velocity field; walls: name of each wall, and whether positions lie in it; actions:
        actions on the nodes of the field."""
        self._membranes, self._walls, self._grid = membranes, walls, actions.field.grid
        smooth = self._grid.case.is_smooth
        self._least = LEAST_SMOOTH if smooth else LEAST_OTHER
        self._remedy = f"Set {'' if smooth else FUNCTIONS}a smaller grid.cell"
        self._attached = [self._near_points(member) for member in membranes]

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        found = {}
        for member, attached in zip(self._membranes, self._attached, strict=True):
            for (wall, _), near, before in zip(self._walls, self._near_points(member), attached, strict=True):
                if not near <= before:
                    found[f"layer between {member.body.name} and {wall}"] = (
                        f"the membrane {member.body.name} has come within {self._least:g} cells of {wall}. The grid "
                        "is too coarse for the layer of liquid between them: the membrane may be too slow there, or stop. "
                        f"{self._remedy}."
                    )
        return found

    def _near_points(self, member: AssembledBody) -> list[frozenset[int]]:
        """Return, for each wall, the numbers of the points of a membrane that are near it: the wall contains the point, or a
        position that is the least layer away along axes and diagonals."""
        place, number = (np.asarray(member.body.stored_field(name)) for name in ("position", "id"))
        along = [(-1, 0, 1) if active else (0,) for active in member.active_axes]
        steps = self._least * self._grid.lattice.cell * np.array(list(product(*along)))
        around = (place[:, None] + steps).reshape(-1, 3)
        near = (is_in(around).reshape(len(place), -1).any(axis=1) for _, is_in in self._walls)
        return [frozenset(number[mask].tolist()) for mask in near]


def face_walls(supports: "Sequence[Support]", actions: NodalActions) -> list[tuple[str, IsInWall]]:
    """Return the faces of the grid on which supports hold liquids, for `NarrowLayers`; supports: all supports, split so that
    each acts on at most one face."""
    grid = actions.field.grid
    holding = [one.face() for one in supports if one.body is None and one.holds_all(grid.active_axes)]
    return [
        (f"the face {'xyz'[axis]}-{('lower', 'upper')[end]}", partial(_is_beyond, grid.lattice, axis, end))
        for axis, end in (face for face in holding if face is not None)
    ]


def _is_beyond(lattice: Lattice, axis: int, end: int, place: np.ndarray) -> np.ndarray:
    at = place[:, axis] - lattice.lower[axis]
    return np.asarray(at > lattice.cell * lattice.counts[axis] if end else at < 0.0)
