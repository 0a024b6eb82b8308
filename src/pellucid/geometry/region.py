"""Shapes of a case, selected by one key, and regions: the nodes and faces of a body on which a condition acts, selected in the
initial state.

A region is a shape, a named set of the mesh, a direction of the outward normal, or the intersection of several such
criteria. A node matches a normal if it is a corner of a face with that normal. A face is selected if its three corners are
selected or, on request, if its centre lies in the shape. To add a shape, define its class in a module of `shapes` and add a
field with its key to `Shape`."""

from collections.abc import Iterator, Mapping
from itertools import product
from math import acos, ceil, cos, degrees, floor, isinf, radians
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import field_validator, model_validator

from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.cells import outer_faces, vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry, Space
from pellucid.geometry.shapes.rotation import Rotated, Rotations, plane_problems, rotate_parameter
from pellucid.geometry.shapes.solids import Box, Cushion, Cylinder, Pipe, Shell, Sphere
from pellucid.geometry.surfaces.surface import Inside, Outside
from pellucid.model import Vector, check, parameter
from pellucid.units import in_degrees


class Shape(Choice):
    """A table with exactly one key, which selects the shape."""

    what: ClassVar[str] = "a shape"
    beside: ClassVar[tuple[str, ...]] = ("rotate",)

    box: Box | None = None
    sphere: Sphere | None = None
    cylinder: Cylinder | None = None
    shell: Shell | None = None
    pipe: Pipe | None = None
    inside: Inside | None = None
    cushion: Cushion | None = None
    rotate: Rotations = rotate_parameter("the shape")

    def geometry(self) -> Geometry:
        """Return the selected shape, rotated if `rotate` is given."""
        geometry: Geometry = self.chosen()
        return geometry if self.rotate is None else Rotated(shape=geometry, rotate=self.rotate)


REACH = 1e-9  # of the extent of a body: tolerance by which a node may lie outside a box, so that rounding does not decide
WITHIN = 30.0
EVERY_AXIS = (True, True, True)
NOWHERE = "make it larger or move it"
CONSTRAINS_NOTHING = "constrains nothing: no node of a body lies in it at the start"


class Selectable(NamedTuple):
    """The points or nodes of a body from which a region selects, with the faces and named sets of its mesh."""

    position: np.ndarray  # (n, 3) positions of the points or nodes [m]
    faces: np.ndarray = np.zeros((0, 3), np.int64)  # triangles of its surface, counterclockwise about the outward normal
    boundary: np.ndarray = np.zeros(0, np.int64)  # node numbers on the boundary of a solid or the rim of a membrane
    sets: Mapping[str, np.ndarray] = {}  # node numbers of each set, by its name
    periods: Vector = (0.0, 0.0, 0.0)
    """Periods [m] of the periodic axes of the grid, 0 along the other axes. A node lies in a shape if one of its images does.
    """

    @classmethod
    def of_solid(cls, mesh: SimplexMesh) -> "Selectable":
        """Return the selectable nodes, outer faces and named node sets of a tetrahedral mesh."""
        faces = outer_faces(mesh.cells)
        return cls(mesh.nodes, faces, np.unique(faces), mesh.sets)

    @classmethod
    def of_membrane(
        cls, position: np.ndarray, triangles: np.ndarray, sets: Mapping[str, np.ndarray] | None = None
    ) -> "Selectable":
        """Return the selectable nodes [m], shape (n, 3), triangles and named node sets of a membrane. Its boundary has the
        nodes of edges that belong to only one triangle."""
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        once, count = np.unique(edges, axis=0, return_counts=True)
        return cls(position, triangles, np.unique(once[count == 1]), sets or {})


class Region(Shape):
    """Region of a body: a shape, a named set, a direction of the outward normal, or the intersection of several such
    criteria."""

    what: ClassVar[str] = "a region"
    beside: ClassVar[tuple[str, ...]] = ("rotate", "set_", "normal", "within")

    outside: Outside | None = None
    set_: str | None = parameter("", "named set of nodes or faces in the mesh file of the body", None, alias="set")
    normal: Vector | None = parameter(
        "", "direction of the outward normal; selects the surface whose normal differs from it by at most `within`", None
    )
    within: float | None = parameter(
        "", f"largest angle between the outward normal and `normal` [degrees]. Default: {WITHIN:g}", None, gt=0, le=180
    )

    @model_validator(mode="before")
    @classmethod
    def _exactly_one(cls, data: Any) -> Any:
        """Require at least one key and at most one shape."""
        if isinstance(data, dict):
            shapes = [name for name in cls.alternatives() if data.get(name) is not None]
            if len(shapes) > 1:
                raise ValueError(f"{cls.what} can have only one shape, but {listed(shapes)} are given: keep one of them")
            if data.get("rotate") is not None and not shapes:
                raise ValueError("`rotate` needs a shape, and this region has none: add a shape, or remove `rotate`")
            if not data.keys() - {"within"}:
                raise ValueError(
                    f"{cls.what} is a table with a shape ({listed(cls.alternatives())}), a named `set` or a `normal`, "
                    "for example { normal = [0, 0, 1], within = 30 }"
                )
        return data

    _in_degrees = field_validator("within", mode="before")(in_degrees)

    @check
    def _normal_has_a_direction(self) -> None:
        if self.within is not None and self.normal is None:
            raise ValueError("`within` is given without `normal`: add `normal`, or remove `within`")
        if self.normal is not None and not any(self.normal):
            raise ValueError("`normal` has zero length: set a direction, such as [0, 0, 1]")

    @property
    def needs_mesh(self) -> bool:
        """True if the region uses a set or a normal, which only bodies with their own mesh have."""
        return self.set_ is not None or self.normal is not None

    @property
    def shape(self) -> Shape | None:
        """The shape of the region, as a region without other criteria, or None."""
        name = next((name for name in self.alternatives() if getattr(self, name) is not None), None)
        return None if name is None else Region(**{name: getattr(self, name)}, rotate=self.rotate)

    def nodes(self, of: Selectable, active: ActiveAxes, reach: float = 0.0) -> np.ndarray:
        """Return a mask of the nodes of a body (`of`) that the region selects, shape (n,). The extent of shapes along axes
        that are not `active` is ignored.

        reach: largest distance of a selected node from a box [m]; at least 1e-9 of the extent of all nodes.
        """
        chosen = self._nodes_of_any_normal(of, active, reach)
        if self.normal is not None:
            facing = np.zeros(len(chosen), bool)
            facing[of.faces[self._facing(of)]] = True
            chosen &= facing
        return chosen

    def faces(self, of: Selectable, active: ActiveAxes, by_centre: bool = False) -> np.ndarray:
        """Return a mask of the faces of a body (`of`) that the region selects, shape (f,). The extent of shapes along axes
        that are not `active` is ignored.

        by_centre: True if the shape selects the faces whose centres lie in the shape; otherwise all corners must lie in the
        shape, and the selected area is systematically smaller than the shape.
        """
        if by_centre:
            chosen = np.ones(len(of.faces), bool) if self.set_ is None else self._named(of)[of.faces].all(axis=1)
            if self.shape is not None:
                a, b, c = (of.position[corner] for corner in of.faces.T)
                chosen &= _in_shape(self.shape, (a + b + c) / 3.0, active, 0.0, of.periods)
        else:
            chosen = self._nodes_of_any_normal(of, active)[of.faces].all(axis=1)
        return np.asarray(chosen if self.normal is None else chosen & self._facing(of))

    def _nodes_of_any_normal(self, of: Selectable, active: ActiveAxes, reach: float = 0.0) -> np.ndarray:
        named, shape = self._named(of), self.shape
        return named if shape is None else named & _in_shape(shape, of.position, active, reach, of.periods)

    def _named(self, of: Selectable) -> np.ndarray:
        """Return a mask of the nodes in the named set, shape (n,); all nodes if no set is named."""
        named = np.full(len(of.position), self.set_ is None)
        if self.set_ is not None:
            named[of.sets[self.set_]] = True
        return named

    def _facing(self, of: Selectable) -> np.ndarray:
        """Return a mask of the faces whose outward normal matches the key `normal`, shape (f,)."""
        return np.asarray(self._cosines(of) >= cos(radians(WITHIN if self.within is None else self.within)) - 1e-12)

    def _cosines(self, of: Selectable) -> np.ndarray:
        """Return the cosines of the angles between the outward normals of the faces and the direction in the key `normal`,
        shape (f,)."""
        areas, direction = vector_areas(of.position, of.faces), np.array(self.normal)
        size = np.linalg.norm(areas, axis=1) * np.linalg.norm(direction)
        return np.asarray(areas @ direction / np.maximum(size, 1e-300))


Where = Literal["boundary"] | Region
"""A region in the keys of a condition; "boundary" is the outer boundary of a solid, or the rim of a membrane."""


def needs_mesh(where: Where) -> bool:
    """Return True if the region refers to a boundary, set or normal, which only bodies with their own mesh have."""
    return isinstance(where, str) or where.needs_mesh


def chosen_nodes(where: Where, of: Selectable, active: ActiveAxes = EVERY_AXIS, reach: float = 0.0) -> np.ndarray:
    """Return a mask of the nodes of a body (`of`) in the region of a condition, shape (n,). active: axes along which the
    extent of shapes counts (the grid is more than one cell thick); reach: largest distance of a selected node from a box
    [m]."""
    if isinstance(where, Region):
        return where.nodes(of, active, reach)
    chosen = np.zeros(len(of.position), bool)
    chosen[of.boundary] = True
    return chosen


def chosen_faces(where: Where, of: Selectable, active: ActiveAxes = EVERY_AXIS, by_centre: bool = False) -> np.ndarray:
    """Return a mask of the faces of a body (`of`) in the region of a condition, shape (f,). active: axes along which the
    extent of shapes counts (the grid is more than one cell thick); by_centre: True to select the faces whose centres lie in
    the region, False to select those with all corners in the region."""
    if isinstance(where, Region):
        return where.faces(of, active, by_centre)
    return np.asarray(chosen_nodes(where, of)[of.faces].all(axis=1))


def faults(
    where: Where,
    of: Selectable,
    path: Path,
    name: str,
    active: ActiveAxes = EVERY_AXIS,
    faces: bool = False,
    by_centre: bool = False,
) -> Iterator[Finding]:
    """Yield findings about a region (`where`) of the body `name`: an unknown set, or an empty selection.

    of: nodes and faces of the body; path: path of the region in the case; active: axes along which the grid is more than
    one cell thick; faces: True if the condition acts on faces, not on nodes; by_centre: True if the region selects faces by
    their centres, not by all corners.
    """
    if isinstance(where, Region) and (turns := list(plane_problems(where.rotate, path, active))):
        yield from turns
        return
    named = where.set_ if isinstance(where, Region) else None
    if not len(of.faces) and needs_mesh(where):
        text = f"body {name} has no mesh of its own, so it has no sets, normals or boundary"
        yield Finding(path, text, "select the region by a shape")
    elif named is not None and not of.sets:
        text, remedy = f"the mesh of body {name} has no named sets", "use a mesh file with named sets, or a shape or normal"
        yield Finding((*path, "set"), text, remedy)
    elif named is not None and named not in of.sets:
        known = list(of.sets)
        text = f"the mesh of body {name} has no set of this name; its sets are {listed(known)}"
        yield Finding((*path, "set"), text, hint(named, known))
    elif not (chosen_faces(where, of, active, by_centre) if faces else chosen_nodes(where, of, active)).any():
        what = "face" if faces else "node" if len(of.faces) else "point"
        why, remedy = _why_empty(where, of, active, faces and not by_centre)
        yield Finding(path, f"no {what} of body {name} lies in it at the start{why}", remedy)


def _why_empty(where: Where, of: Selectable, active: ActiveAxes, faces: bool) -> tuple[str, str]:
    """Return the reason why a region selects no node or face of a body (`of`), and a remedy. active: axes along which the
    grid is more than one cell thick; faces: True if the condition acts on faces, not on nodes."""
    if not isinstance(where, Region):
        return ": a closed surface has no rim", "use a shape, a set or a normal"
    if where.normal is not None and not where._facing(of).any():
        nearest = degrees(acos(min(float(where._cosines(of).max()), 1.0)))
        text = f": its outward normals differ by {nearest:.3g} degrees or more from `normal`"
        return text, f"set `within` to at least {ceil(nearest - 1e-6)}, or change `normal`"
    shapes = where.shape is not None
    if faces and chosen_nodes(where, of, active).any():
        text = ", although nodes do: a face is selected only if all three of its corners lie in the region"
        return text, NOWHERE if shapes else "use a set that contains whole faces, or a shape or a normal"
    if where.normal is None:
        return "", NOWHERE if shapes and where.set_ is None else "change the shape or the set so that they overlap"
    return "", "extend the shape or set to faces with this normal, or increase `within`"


def _in_shape(shape: Shape, position: np.ndarray, active: ActiveAxes, reach: float, periods: Vector) -> np.ndarray:
    """Return a mask of positions [m], shape (n, 3), that lie in a shape or have a periodic image in it, shape (n,). active,
    periods: as in `within`; reach: largest distance from a box at which a position counts as inside [m]."""
    inside = np.zeros(len(position), bool)
    if not len(position):
        return inside
    reach, bounds = max(reach, REACH * float(np.ptp(position, axis=0).max())), shape.geometry().bounds()
    for way in images(periods, (position.min(axis=0) - reach, position.max(axis=0) + reach), bounds):
        inside |= _holds(shape, position + way, active, reach)
    return inside


def images(periods: Vector, body: tuple[np.ndarray, np.ndarray], place: tuple[np.ndarray, np.ndarray]) -> Iterator[np.ndarray]:
    """Yield the periodic shifts of a body [m], shape (3,), for which the shifted body overlaps a box; only zero if no axis
    is periodic.

    periods: periods of the grid [m], 0 if not periodic; body, place: lower and upper corners [m] of the body and of the
    box. A body or box without ends is not shifted.
    """
    ways = []
    for period, low, high, lower, upper in zip(periods, *body, *place, strict=True):
        first, last = (
            (0, 0)
            if period == 0.0 or isinf(high) or isinf(upper)
            else (ceil((lower - high) / period), floor((upper - low) / period))
        )
        ways.append(period * np.arange(first, last + 1))
    return (np.array(way) for way in product(*ways))


def within(region: Space, places: np.ndarray, active: ActiveAxes, periods: Vector) -> np.ndarray:
    """Return a mask of the positions `places` [m], shape (n, 3), that lie in a region or have a periodic image in
    it, shape (n,). active: axes along which the grid is more than one cell thick; periods: periods of the grid [m], 0 if
    not periodic."""
    inside = np.zeros(len(places), bool)
    if len(places):
        for way in images(periods, (places.min(axis=0), places.max(axis=0)), region.bounds()):
            inside |= region.contains(places + way if way.any() else places, active)
    return inside


def _holds(shape: Shape, position: np.ndarray, active: ActiveAxes, reach: float) -> np.ndarray:
    geometry, own = shape.geometry().in_own_frame(position)
    if not isinstance(geometry, Box):
        return geometry.contains(own, active)
    lower, upper = geometry.bounds()
    inside = (own >= lower - reach) & (own <= upper + reach)
    return np.asarray(inside[:, np.array(active)].all(axis=1))
