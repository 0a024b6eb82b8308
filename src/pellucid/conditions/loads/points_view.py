"""View of the points of a body for users' loads."""

from functools import cached_property
from typing import NoReturn

import numpy as np

from pellucid.findings import absent
from pellucid.parts.annotations import Body
from pellucid.parts.capabilities import Membrane
from pellucid.users.users_code import read_only


class PointsView:
    """The points or nodes of a body at the start of a step: those that have not left the grid, in the order of their numbers,
    which is that of the body's mesh, of the vertices of its surface, or of its seeding, however the grid sorts them.

    position [m] and velocity [m/s], shape (n, 3); mass [kg] and the number `id`, shape (n,); of membranes also normals, areas
    and triangles. The arrays cannot be written to.
    """

    def __init__(self, body: Body) -> None:
        self._body, self._order = body, body.order()

    @cached_property
    def id(self) -> np.ndarray:
        """Numbers from 0 on, shape (n,), ascending."""
        return self._seen("id")

    @cached_property
    def position(self) -> np.ndarray:
        """[m], shape (n, 3)."""
        return self._seen("position")

    @cached_property
    def velocity(self) -> np.ndarray:
        """[m/s], shape (n, 3)."""
        return self._seen("velocity")

    @cached_property
    def mass(self) -> np.ndarray:
        """[kg], shape (n,)."""
        return self._seen("mass")

    @cached_property
    def volume(self) -> np.ndarray:
        """Volume [m³], shape (n,); of the nodes of a membrane their shares of it."""
        return read_only(self._body.volumes()[self._order])

    @cached_property
    def triangles(self) -> np.ndarray:
        """Return the triangles of a membrane, shape (m, 3): indices of their corners in the arrays, counterclockwise about
        the normal; quadrilaterals are cut in two."""
        self._membrane("triangles")
        return read_only(self._body.cells().surface())

    @cached_property
    def vector_area(self) -> np.ndarray:
        """Return the vector areas of a membrane's points [m²], shape (n, 3): the forces of a pressure of 1 Pa. Over a
        closed surface they sum to zero."""
        return read_only(self._membrane("vector areas").pressed_areas())

    @cached_property
    def normal(self) -> np.ndarray:
        """Return the unit normals of a membrane's points, shape (n, 3); zero where undefined."""
        size = np.linalg.norm(self.vector_area, axis=1, keepdims=True)
        return read_only(np.divide(self.vector_area, size, out=np.zeros_like(self.vector_area), where=size > 0.0))

    @cached_property
    def area(self) -> np.ndarray:
        """Return the areas of a membrane's points [m²], shape (n,)."""
        return read_only(self._membrane("areas").surface_areas())

    def as_stored(self, forces: np.ndarray) -> np.ndarray:
        """Reorder values, shape (n, 3), to the storage order of the body; zeros for points that left."""
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
