"""Initial shapes of fluid films: closed curves, meridians of surfaces of revolution, closed surfaces."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.points import coincident, spatial_order
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import Model, Vector, check, parameter

FEWEST = 8
Place2 = tuple[float, float]


class Ellipse(Model):
    """A closed curve in the plane z = 0: an ellipse, or a circle if only one radius is given."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radius: float = parameter("m", "radius along x", gt=0)
    radius_y: float | None = parameter("m", "radius along y. Default: `radius`, a circle", None, gt=0)
    nodes: int = parameter("", "number of equally spaced nodes", ge=FEWEST, le=2000)

    def places(self) -> np.ndarray:
        """Return the nodes in x and y [m], counterclockwise, shape (n, 2)."""
        angle = np.linspace(0.0, 2.0 * np.pi, 64 * self.nodes + 1)
        return np.array(self.centre[:2]) + _even(self, self.nodes + 1, angle)[:-1]

    def at(self, angle: np.ndarray) -> np.ndarray:
        """Return positions on the ellipse relative to its centre [m] at the parameter angles [rad], shape (n, 2)."""
        return np.stack([self.radius * np.cos(angle), (self.radius_y or self.radius) * np.sin(angle)], axis=1)


class Spheroid(Model):
    """A surface of revolution about the z axis: a spheroid, or a sphere if only one radius is given."""

    height: float = parameter("m", "z of the centre", 0.0)
    radius: float = parameter("m", "radius perpendicular to the axis", gt=0)
    radius_z: float | None = parameter("m", "radius along the axis. Default: `radius`, a sphere", None, gt=0)
    nodes: int = parameter("", "number of equally spaced nodes of the meridian, including both poles", ge=FEWEST, le=2000)

    def places(self) -> np.ndarray:
        """Return the nodes in r and z [m] from the lower to the upper pole, shape (n, 2)."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 64 * self.nodes + 1)
        found = _even(self, self.nodes, angle)
        found[[0, -1], 0] = 0.0
        return np.array([0.0, self.height]) + found

    def at(self, angle: np.ndarray) -> np.ndarray:
        """Return positions (r, z) on the meridian relative to the centre [m] at parameter angles from the equator [rad],
        shape (n, 2)."""
        return np.stack([self.radius * np.cos(angle), (self.radius_z or self.radius) * np.sin(angle)], axis=1)


def _even(shape: Ellipse | Spheroid, n: int, angle: np.ndarray) -> np.ndarray:
    """Return n equally spaced positions on a shape [m], shape (n, 2), from the first to the last of a fine sequence of
    parameter angles [rad]."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(shape.at(angle), axis=0), axis=1)))
    return shape.at(np.interp(np.linspace(0.0, along[-1], n), along, angle))


class Curve(Model):
    """A closed curve in the plane z = 0 through given points."""

    points: tuple[Place2, ...] = parameter(
        "m", "x and y of the nodes, counterclockwise; the last node is connected to the first", min_length=FEWEST
    )

    @check
    def _is_a_curve(self) -> None:
        _check(np.array(self.points), closed=True)

    def places(self) -> np.ndarray:
        """Return the nodes in x and y [m], shape (n, 2)."""
        return np.array(self.points)


class Meridian(Model):
    """A surface of revolution about the z axis whose meridian passes through given points."""

    points: tuple[Place2, ...] = parameter(
        "m", "r and z of the nodes, from the lower to the upper pole; both ends lie on the axis", min_length=FEWEST
    )

    @check
    def _is_a_meridian(self) -> None:
        places = np.array(self.points)
        if places[0, 0] != 0.0 or places[-1, 0] != 0.0:
            raise ValueError(
                f"`points` start at r = {places[0, 0]:g} m and end at r = {places[-1, 0]:g} m, so the surface is open; "
                "set r of the first and the last point to 0"
            )
        if (places[1:-1, 0] <= 0.0).any():
            number = 1 + int(np.flatnonzero(places[1:-1, 0] <= 0.0)[0])
            raise ValueError(
                f"point {number} has r = {places[number, 0]:g} m; r must be positive except at both ends: correct this point"
            )
        _check(places, closed=False)

    def places(self) -> np.ndarray:
        """Return the nodes in r and z [m], shape (n, 2)."""
        return np.array(self.points)


def _check(places: np.ndarray, closed: bool) -> None:
    """Raise ValueError if nodes coincide, lines between them cross, the curve is open, or the interior of the curve lies to
    the right of its direction. places: nodes in order [m], shape (n, 2); closed: the last node is connected to the first."""
    after = np.roll(places, -1, axis=0) if closed else places[1:]
    before = places if closed else places[:-1]
    gaps = np.linalg.norm(after - before, axis=1)
    first = np.arange(len(before))
    if pair := coincident(places, np.stack([first, (first + 1) % len(places)], axis=1)):
        _refuse_pair(places, *pair, closed)
    if closed and gaps[-1] > 5.0 * gaps[:-1].max():
        raise ValueError(
            f"the last point is {gaps[-1]:g} m from the first, but other neighbours are at most {gaps[:-1].max():g} m apart, "
            "so the curve is open; add points between the last and the first"
        )
    if crossing := _crossing(before, after):
        one, other = crossing
        place = ", ".join(f"{value:g}" for value in before[one])
        text = f"the segment from point {one} at ({place}) m crosses the segment from point {other}"
        raise ValueError(f"{text}: a film must not intersect itself; list the points in their order along the curve")
    if np.sum(before[:, 0] * after[:, 1] - after[:, 0] * before[:, 1]) <= 0.0:
        raise ValueError("`points` are in clockwise order, with the interior to the right: reverse their order")


def _refuse_pair(places: np.ndarray, one: int, other: int, closed: bool) -> None:
    """Raise ValueError for the coincident nodes `one` and `other` (indices in `places` [m], shape (n, 2)); closed: the last
    node is connected to the first."""
    place = ", ".join(f"{value:g}" for value in places[one])
    text = f"points {one} and {other} coincide at ({place}) m"
    if other == one + 1:
        raise ValueError(f"{text}: remove one of them")
    if closed and (one, other) == (0, len(places) - 1):
        raise ValueError(f"{text}: remove the last one, as a closed curve does not repeat its first point")
    raise ValueError(f"{text}, but are not neighbours: a film must not touch itself; move them apart")


def _crossing(before: np.ndarray, after: np.ndarray) -> tuple[int, int] | None:
    """Return the indices of two segments that cross each other, or None; before, after: start and end of each segment [m],
    shape (n, 2) each."""

    def side(of: np.ndarray) -> np.ndarray:
        """Return on which side of each segment (extended to a line) positions lie, shape (segments, positions): 1 to the
        left of its direction from start to end, -1 to the right, 0 on it. of: positions [m], shape (positions, 2)."""
        along, to = after - before, of[None] - before[:, None]
        return np.asarray(np.sign(along[:, None, 0] * to[..., 1] - along[:, None, 1] * to[..., 0]))

    parted = side(before) * side(after) < 0.0
    found = np.argwhere(parted & parted.T)
    return (int(found[0, 0]), int(found[0, 1])) if len(found) else None


class FilmShape(Choice):
    """A table with exactly one key, which selects the shape of a film."""

    what: ClassVar[str] = "the shape of a film"

    ellipse: Ellipse | None = None
    curve: Curve | None = None
    spheroid: Spheroid | None = None
    meridian: Meridian | None = None
    surface: Surface | None = None

    @property
    def span(self) -> Literal["plane", "around", "space"]:
        """Kind of shape: a curve in the plane, a surface of revolution ("around"), or a surface in space."""
        chosen = self.chosen()
        return "plane" if isinstance(chosen, Ellipse | Curve) else "space" if isinstance(chosen, Surface) else "around"

    @property
    def closed(self) -> bool:
        """True if the shape encloses a volume or area."""
        return self.surface.closed if self.surface else True

    def positions(self) -> np.ndarray:
        """Return the positions of the nodes [m], shape (n, 3)."""
        if self.surface is not None:
            return self.surface.triangulate().vertices
        places = self.chosen().places()
        result = np.zeros((len(places), 3))
        result[:, [0, 1] if self.span == "plane" else [0, 2]] = places
        return result

    def numbers(self) -> np.ndarray:
        """Return for each node of the geometry of a film its number in this shape, shape (n,). The two orders differ because
        surfaces store their nodes in spatial order.
        """
        if self.surface is not None:
            return spatial_order(self.surface.triangulate().vertices)
        return np.arange(len(self.positions()))

    def sides(self) -> np.ndarray:
        """Return the nodes of each segment or triangle of the shape, shape (m, 2) or (m, 3)."""
        if self.surface is not None:
            return self.surface.triangulate().triangles
        first = np.arange(len(self.positions()))
        return np.stack([first, np.roll(first, -1)], axis=1)
