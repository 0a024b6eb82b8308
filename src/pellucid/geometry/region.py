"""Regions: the nodes and faces of a body on which a condition acts, chosen in the state at the start.

A region is a shape, a named set of the mesh, a direction of the outward normal, or what several of these have in common. A node
has a normal where it is a corner of a face with that normal; a face is chosen where its three corners are, or where its centre
is in the shape.
"""

from collections.abc import Iterator, Mapping
from itertools import product
from math import acos, ceil, cos, degrees, floor, radians
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import field_validator, model_validator

from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.meshes.cells import outer_faces, vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.shape import Shape
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.geometry.shapes.rotation import plane_problems
from pellucid.geometry.shapes.solids import Box
from pellucid.model import Vector, check, parameter
from pellucid.units import in_degrees

REACH = 1e-9  # of the extent of a body, by which a node may lie beyond a box and still count: rounding must not decide
WITHIN = 30.0
EVERY_AXIS = (True, True, True)
NOWHERE = "make it larger or move it"
CONSTRAINS_NOTHING = "constrains nothing: no node of a body lies in it at the start"


class Selectable(NamedTuple):
    """What regions choose from: the points or nodes of a body, and what more its mesh knows of them."""

    position: np.ndarray  # (n, 3) [m]
    faces: np.ndarray = np.zeros((0, 3), np.int64)  # triangles of its surface, counterclockwise about the outward normal
    boundary: np.ndarray = np.zeros(0, np.int64)  # numbers of the nodes on the boundary of a solid, on the rim of a membrane
    sets: Mapping[str, np.ndarray] = {}  # numbers of nodes by name
    periods: Vector = (0.0, 0.0, 0.0)
    """Lengths [m] after which places are the same along periodic axes of the grid, 0 along others: a node lies in a shape where
    one of its images does."""

    @classmethod
    def of_solid(cls, mesh: SimplexMesh) -> "Selectable":
        """The nodes of a mesh of tetrahedra, and its outer faces."""
        faces = outer_faces(mesh.cells)
        return cls(mesh.nodes, faces, np.unique(faces), mesh.sets)

    @classmethod
    def of_membrane(
        cls, position: np.ndarray, triangles: np.ndarray, sets: Mapping[str, np.ndarray] | None = None
    ) -> "Selectable":
        """Nodes [m], shape (n, 3), and triangles between them; the rim are the edges that belong to one triangle only."""
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        once, count = np.unique(edges, axis=0, return_counts=True)
        return cls(position, triangles, np.unique(once[count == 1]), sets or {})


class Region(Shape):
    """A shape, a named set or the direction of the outward normal; of several, what they have in common."""

    what: ClassVar[str] = "a region"

    set_: str | None = parameter("", "set of nodes or faces that the mesh file of the body names", None, alias="set")
    normal: Vector | None = parameter("", "direction from which the outward normal of the surface may differ by `within`", None)
    within: float | None = parameter("", f"that angle in degrees; without it {WITHIN:g}", None, gt=0, le=180)

    @model_validator(mode="before")
    @classmethod
    def _exactly_one(cls, data: Any) -> Any:
        """At most one shape, and something at all."""
        if isinstance(data, dict):
            shapes = [name for name in Shape.alternatives() if data.get(name) is not None]
            if len(shapes) > 1:
                raise ValueError(f"{cls.what} has one shape, and here are {listed(shapes)}: keep one of them")
            if data.get("rotate") is not None and not shapes:
                raise ValueError("`rotate` turns the shape of a region, and this one has none: add a shape, or leave it out")
            if not data.keys() - {"within"}:
                raise ValueError(
                    f"{cls.what} is a table with a shape ({listed(Shape.alternatives())}), a named `set` or a `normal`, "
                    "for example { normal = [0, 0, 1], within = 30 }"
                )
        return data

    _in_degrees = field_validator("within", mode="before")(in_degrees)

    @check
    def _normal_has_a_direction(self) -> None:
        if self.within is not None and self.normal is None:
            raise ValueError("`within` belongs to `normal`: give both, or leave it out")
        if self.normal is not None and not any(self.normal):
            raise ValueError("`normal` has no length: give a direction, such as [0, 0, 1]")

    @property
    def needs_mesh(self) -> bool:
        """Whether only bodies with a mesh of their own have what it names."""
        return self.set_ is not None or self.normal is not None

    @property
    def shape(self) -> Shape | None:
        """Its shape, if it has one."""
        name = next((name for name in Shape.alternatives() if getattr(self, name) is not None), None)
        return None if name is None else Shape(**{name: getattr(self, name)}, rotate=self.rotate)

    def nodes(self, of: Selectable, active: ActiveAxes, reach: float = 0.0) -> np.ndarray:
        """Which nodes it chooses, shape (n,); along axes that are not `active` the extent of shapes does not count.

        reach: how far nodes may lie beyond a box and still count [m]; a part of 1e-9 of the extent of all nodes always does.
        """
        chosen = self._nodes_of_any_normal(of, active, reach)
        if self.normal is not None:
            facing = np.zeros(len(chosen), bool)
            facing[of.faces[self._facing(of)]] = True
            chosen &= facing
        return chosen

    def faces(self, of: Selectable, active: ActiveAxes, by_centre: bool = False) -> np.ndarray:
        """Which faces it chooses, shape (f,). by_centre: its shape chooses those whose centres are in it, so that the area of
        all differs from that of the shape to both sides."""
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
        """Which nodes are in its set, shape (n,); all where it names none."""
        named = np.full(len(of.position), self.set_ is None)
        if self.set_ is not None:
            named[of.sets[self.set_]] = True
        return named

    def _facing(self, of: Selectable) -> np.ndarray:
        """Which faces have the normal that the region names, shape (f,)."""
        return np.asarray(self._cosines(of) >= cos(radians(WITHIN if self.within is None else self.within)) - 1e-12)

    def _cosines(self, of: Selectable) -> np.ndarray:
        """Cosines of the angles between the outward normals of the faces and the direction of the region, shape (f,)."""
        areas, direction = vector_areas(of.position, of.faces), np.array(self.normal)
        size = np.linalg.norm(areas, axis=1) * np.linalg.norm(direction)
        return np.asarray(areas @ direction / np.maximum(size, 1e-300))


Where = Literal["boundary"] | Region
"""How conditions name a region: "boundary" is the outer boundary of a solid, the rim of a membrane."""


def needs_mesh(where: Where) -> bool:
    """Whether only bodies with a mesh of their own have what a condition names."""
    return isinstance(where, str) or where.needs_mesh


def chosen_nodes(where: Where, of: Selectable, active: ActiveAxes = EVERY_AXIS, reach: float = 0.0) -> np.ndarray:
    """Which nodes a condition names, shape (n,); see `Region.nodes`."""
    if isinstance(where, Region):
        return where.nodes(of, active, reach)
    chosen = np.zeros(len(of.position), bool)
    chosen[of.boundary] = True
    return chosen


def chosen_faces(where: Where, of: Selectable, active: ActiveAxes = EVERY_AXIS, by_centre: bool = False) -> np.ndarray:
    """Which faces a condition names, shape (f,); see `Region.faces`."""
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
    """What is wrong with a region at a path, of the body of this name: an unknown set, nothing in it.

    faces: whether the condition acts on faces, not on nodes; by_centre: on those whose centres are in its shape.
    """
    if isinstance(where, Region) and (turns := list(plane_problems(where.rotate, path, active))):
        yield from turns
        return
    named = where.set_ if isinstance(where, Region) else None
    if not len(of.faces) and needs_mesh(where):
        yield Finding(path, f"body {name} has no mesh of its own whose sets, normals and boundary are known", "use a shape")
    elif named is not None and not of.sets:
        text, remedy = f"the mesh of body {name} has no named sets", "use a file that names them, or a shape or normal"
        yield Finding((*path, "set"), text, remedy)
    elif named is not None and named not in of.sets:
        known = list(of.sets)
        text = f"the mesh of body {name} has no set of this name; there are {listed(known)}"
        yield Finding((*path, "set"), text, hint(named, known))
    elif not (chosen_faces(where, of, active, by_centre) if faces else chosen_nodes(where, of, active)).any():
        what = "face" if faces else "node" if len(of.faces) else "point"
        why, remedy = _why_empty(where, of, active, faces and not by_centre)
        yield Finding(path, f"no {what} of body {name} lies in it at the start{why}", remedy)


def _why_empty(where: Where, of: Selectable, active: ActiveAxes, faces: bool) -> tuple[str, str]:
    """More about a region in which there is nothing, and what to do."""
    if not isinstance(where, Region):
        return ": a closed surface has no rim", "use a shape, a set or a normal"
    if where.normal is not None and not where._facing(of).any():
        nearest = degrees(acos(min(float(where._cosines(of).max()), 1.0)))
        text = f": its outward normals differ by {nearest:.3g} degrees or more from `normal`"
        return text, f"let `within` be {ceil(nearest - 1e-6)} or more, or give another direction"
    shapes = where.shape is not None
    if faces and chosen_nodes(where, of, active).any():
        text = ", though nodes do: a face lies in it with all three corners"
        return text, NOWHERE if shapes else "name a set that has whole faces, or use a shape or a normal"
    if where.normal is None:
        return "", NOWHERE if shapes and where.set_ is None else "let its shape and its set overlap"
    return "", "let its shape or set reach where faces have this normal, or raise `within`"


def _in_shape(shape: Shape, position: np.ndarray, active: ActiveAxes, reach: float, periods: Vector) -> np.ndarray:
    """Which places [m], shape (n, 3), or images of them across seams, are in a shape, shape (n,)."""
    inside = np.zeros(len(position), bool)
    if not len(position):
        return inside
    reach, bounds = max(reach, REACH * float(np.ptp(position, axis=0).max())), shape.geometry().bounds()
    for way in images(periods, (position.min(axis=0) - reach, position.max(axis=0) + reach), bounds):
        inside |= _holds(shape, position + way, active, reach)
    return inside


def images(periods: Vector, body: tuple[np.ndarray, np.ndarray], place: tuple[np.ndarray, np.ndarray]) -> Iterator[np.ndarray]:
    """By what [m], shape (3,), to move a body so that its images meet a place; both by their lower and upper corners [m]. Not
    at all where no axis is periodic."""
    ways = []
    for period, low, high, lower, upper in zip(periods, *body, *place, strict=True):
        first, last = (0, 0) if period == 0.0 else (ceil((lower - high) / period), floor((upper - low) / period))
        ways.append(period * np.arange(first, last + 1))
    return (np.array(way) for way in product(*ways))


def within(region: Geometry, places: np.ndarray, active: ActiveAxes, periods: Vector) -> np.ndarray:
    """Which places [m], shape (n, 3), or images of them, lie in a region, shape (n,)."""
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
