"""View of the points of a body for user-defined loads."""

from functools import cached_property
from typing import NoReturn

import numpy as np

from pellucid.findings import absent
from pellucid.parts.annotations import Body
from pellucid.parts.capabilities import Membrane
from pellucid.users.users_code import read_only


class PointsView:
    """Read-only arrays of the points or nodes of a body at the start of a step, without points that left the grid.

    The order is the order of the point numbers (mesh, surface vertices or seeding); it does not change when the grid sorts
    the points. Attributes: position [m] and velocity [m/s], shape (n, 3); mass [kg] and number `id`, shape (n,); for
    membranes also normals, areas and triangles.
    """

    def __init__(self, body: Body) -> None:
        self._body, self._order = body, body.order()

    @cached_property
    def id(self) -> np.ndarray:
        """Point numbers, counted from 0, in ascending order, shape (n,)."""
        return self._seen("id")

    @cached_property
    def position(self) -> np.ndarray:
        """Positions [m], shape (n, 3)."""
        return self._seen("position")

    @cached_property
    def velocity(self) -> np.ndarray:
        """Velocities [m/s], shape (n, 3)."""
        return self._seen("velocity")

    @cached_property
    def mass(self) -> np.ndarray:
        """Masses [kg], shape (n,)."""
        return self._seen("mass")

    @cached_property
    def volume(self) -> np.ndarray:
        """Current volumes [m³], shape (n,); for a membrane, the volume of its material that belongs to each node."""
        return read_only(self._body.volumes()[self._order])

    @cached_property
    def triangles(self) -> np.ndarray:
        """Triangles of a membrane, shape (m, 3): indices of their corners in the arrays, counterclockwise about the normal;
        quadrilaterals are split in two."""
        self._membrane("triangles")
        return read_only(self._body.cells().surface())

    @cached_property
    def vector_area(self) -> np.ndarray:
        """Vector areas of a membrane's points [m²], shape (n, 3), i.e. the forces of a pressure of 1 Pa. Over a closed
        surface they sum to zero."""
        return read_only(self._membrane("vector areas").pressed_areas())

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normals of a membrane's points, shape (n, 3); zero where undefined."""
        size = np.linalg.norm(self.vector_area, axis=1, keepdims=True)
        return read_only(np.divide(self.vector_area, size, out=np.zeros_like(self.vector_area), where=size > 0.0))

    @cached_property
    def area(self) -> np.ndarray:
        """Areas of a membrane's points [m²], shape (n,)."""
        return read_only(self._membrane("areas").surface_areas())

    def as_stored(self, forces: np.ndarray) -> np.ndarray:
        """Reorder forces on the points [N], shape (n, 3), from the order of the point numbers to the storage order of the
        body, with zeros for points that left the grid."""
        stored = np.zeros((self._body.n_points, 3))
        stored[self._order] = forces
        return stored

    def _seen(self, name: str) -> np.ndarray:
        return read_only(self._body.arrays[name][self._order])

    def _membrane(self, what: str) -> Membrane:
        if not isinstance(self._body, Membrane):
            raise ValueError(f"body {self._body.name} is not a membrane: it has no {what}")
        return self._body

    def __getattr__(self, name: str) -> NoReturn:
        raise AttributeError(absent("`PointsView` has no", name, SEEN))


SEEN = [name for name, part in vars(PointsView).items() if isinstance(part, cached_property)]
