"""Where fluid films are at the start: closed curves, meridians of surfaces of revolution, closed surfaces."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.coincident import coincident
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import Model, Vector, check, parameter

FEWEST = 8
Place2 = tuple[float, float]


class Ellipse(Model):
    """A closed curve in the plane z = 0: an ellipse, or with one radius a circle."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radius: float = parameter("m", "radius along x", gt=0)
    radius_y: float | None = parameter("m", "radius along y; without it a circle", None, gt=0)
    nodes: int = parameter("", "nodes at equal distances", ge=FEWEST, le=2000)

    def places(self) -> np.ndarray:
        """Nodes in x and y, counterclockwise, shape (n, 2)."""
        angle = np.linspace(0.0, 2.0 * np.pi, 64 * self.nodes + 1)
        return np.array(self.centre[:2]) + _even(self, self.nodes + 1, angle)[:-1]

    def at(self, angle: np.ndarray) -> np.ndarray:
        """Places at angles, shape (n, 2)."""
        return np.stack([self.radius * np.cos(angle), (self.radius_y or self.radius) * np.sin(angle)], axis=1)


class Spheroid(Model):
    """A surface of revolution about the z axis: a spheroid, or with one radius a sphere."""

    height: float = parameter("m", "z of the centre", 0.0)
    radius: float = parameter("m", "radius across the axis", gt=0)
    radius_z: float | None = parameter("m", "radius along the axis; without it a sphere", None, gt=0)
    nodes: int = parameter("", "nodes of its meridian at equal distances, with those on the axis", ge=FEWEST, le=2000)

    def places(self) -> np.ndarray:
        """Nodes in r and z from the lower pole up, shape (n, 2)."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 64 * self.nodes + 1)
        found = _even(self, self.nodes, angle)
        found[[0, -1], 0] = 0.0
        return np.array([0.0, self.height]) + found

    def at(self, angle: np.ndarray) -> np.ndarray:
        """Places at angles from the equator, shape (n, 2)."""
        return np.stack([self.radius * np.cos(angle), (self.radius_z or self.radius) * np.sin(angle)], axis=1)


def _even(shape: Ellipse | Spheroid, n: int, angle: np.ndarray) -> np.ndarray:
    """n places of a shape at equal distances from the first to the last of many angles."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(shape.at(angle), axis=0), axis=1)))
    return shape.at(np.interp(np.linspace(0.0, along[-1], n), along, angle))


class Curve(Model):
    """A closed curve in the plane z = 0 through given places."""

    points: tuple[Place2, ...] = parameter(
        "m", "x and y of its nodes, counterclockwise; the last is joined to the first", min_length=FEWEST
    )

    @check
    def _is_a_curve(self) -> None:
        _check(np.array(self.points), closed=True)

    def places(self) -> np.ndarray:
        """Nodes in x and y, shape (n, 2)."""
        return np.array(self.points)


class Meridian(Model):
    """A surface of revolution about the z axis with a meridian through given places."""

    points: tuple[Place2, ...] = parameter(
        "m", "r and z of its nodes, from the lower pole to the upper; the first and the last lie on the axis", min_length=FEWEST
    )

    @check
    def _is_a_meridian(self) -> None:
        places = np.array(self.points)
        if places[0, 0] != 0.0 or places[-1, 0] != 0.0:
            raise ValueError(
                f"points begin at r = {places[0, 0]:g} m and end at r = {places[-1, 0]:g} m: the surface is open; let the "
                "first and the last point lie on the axis, at r = 0"
            )
        if (places[1:-1, 0] <= 0.0).any():
            number = 1 + int(np.flatnonzero(places[1:-1, 0] <= 0.0)[0])
            raise ValueError(f"point {number} lies at r = {places[number, 0]:g} m: between its ends r must be above 0")
        _check(places, closed=False)

    def places(self) -> np.ndarray:
        """Nodes in r and z, shape (n, 2)."""
        return np.array(self.points)


def _check(places: np.ndarray, closed: bool) -> None:
    """Raise ValueError where nodes coincide, or the interior lies to the right."""
    after = np.roll(places, -1, axis=0) if closed else places[1:]
    before = places if closed else places[:-1]
    gaps = np.linalg.norm(after - before, axis=1)
    first = np.arange(len(before))
    if pair := coincident(places, np.stack([first, (first + 1) % len(places)], axis=1)):
        _refuse_pair(places, *pair, closed)
    if closed and gaps[-1] > 5.0 * gaps[:-1].max():
        raise ValueError(
            f"the last point is {gaps[-1]:g} m from the first, and neighbours are {gaps[:-1].max():g} m apart at most: the "
            "curve is open; a film is closed: go on with points until the first"
        )
    if crossing := _crossing(before, after):
        one, other = crossing
        place = ", ".join(f"{value:g}" for value in before[one])
        text = f"the line from point {one} at ({place}) m crosses that from point {other}"
        raise ValueError(f"{text}: a film does not pass through itself; list the points in their order along it")
    if np.sum(before[:, 0] * after[:, 1] - after[:, 0] * before[:, 1]) <= 0.0:
        raise ValueError("points run clockwise, with the interior on their right: list them the other way round")


def _refuse_pair(places: np.ndarray, one: int, other: int, closed: bool) -> None:
    """Raise ValueError for two nodes at one place."""
    place = ", ".join(f"{value:g}" for value in places[one])
    text = f"points {one} and {other} coincide at ({place}) m"
    if other == one + 1:
        raise ValueError(f"{text}: leave one out")
    if closed and (one, other) == (0, len(places) - 1):
        raise ValueError(f"{text}: leave one out; a closed curve does not repeat its first point")
    raise ValueError(f"{text}, and are no neighbours: a film does not touch itself; move them apart")


def _crossing(before: np.ndarray, after: np.ndarray) -> tuple[int, int] | None:
    """Two lines between neighbours, from `before` to `after`, shape (n, 2), that cross, if there are any."""

    def side(of: np.ndarray) -> np.ndarray:
        """On which side of each line the places lie, shape (lines, places)."""
        along, to = after - before, of[None] - before[:, None]
        return np.asarray(np.sign(along[:, None, 0] * to[..., 1] - along[:, None, 1] * to[..., 0]))

    parted = side(before) * side(after) < 0.0
    found = np.argwhere(parted & parted.T)
    return (int(found[0, 0]), int(found[0, 1])) if len(found) else None


class FilmShape(Choice):
    """A table with one key that names the shape of a film."""

    what: ClassVar[str] = "the shape of a film"

    ellipse: Ellipse | None = None
    curve: Curve | None = None
    spheroid: Spheroid | None = None
    meridian: Meridian | None = None
    surface: Surface | None = None

    @property
    def span(self) -> Literal["plane", "around", "space"]:
        """A curve in the plane, a surface of revolution, or a surface in space."""
        chosen = self.chosen()
        return "plane" if isinstance(chosen, Ellipse | Curve) else "space" if isinstance(chosen, Surface) else "around"

    @property
    def closed(self) -> bool:
        """Whether it has an inside."""
        return self.surface.closed if self.surface else True
