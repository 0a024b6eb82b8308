"""Tetrahedral meshes of a box and of a cylinder on a body-centred lattice, whose tetrahedra are nearly regular and, except at
the faces, congruent."""

from math import prod
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from pellucid.findings import Refusal
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.shapes.contract import AXES
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.model import AtLeastOne, Vector, check, parameter

Counts = tuple[int, int, int]
Ratio = Annotated[float, Field(ge=1e-3, le=1e3)]
EVEN = (1.0, 1.0, 1.0)


class BoxMesh(Tetrahedral):
    """A tetrahedral mesh of a box."""

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner")
    cells: tuple[AtLeastOne, AtLeastOne, AtLeastOne] = parameter(
        "", "number of cubes along x, y, z; each is divided into twelve tetrahedra"
    )
    grading: tuple[Ratio, Ratio, Ratio] = parameter(
        "", "ratio of the last to the first cube width along x, y, z; the widths grow by a constant factor", EVEN
    )

    @check
    def _has_volume(self) -> None:
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if high <= low:
                text = f"`upper` must exceed `lower` along {axis}: {high:g} m is not greater than {low:g} m"
                raise Refusal(text, "exchange the two values, or correct one of them")

    def expected_points(self) -> float:
        return 2.0 * prod(map(float, self.cells))

    is_pattern: ClassVar[bool] = True

    def make(self) -> SimplexMesh:
        lower, upper = np.array(self.lower), np.array(self.upper)
        if self.grading == EVEN:
            return box_mesh(lower, upper, self.cells)
        mesh = box_mesh(np.zeros(3), np.array(self.cells, float), self.cells)
        ends = [graded(n, ratio) for n, ratio in zip(self.cells, self.grading, strict=True)]
        share = [np.interp(mesh.nodes[:, axis], np.arange(len(end)), end) for axis, end in enumerate(ends)]
        return SimplexMesh(lower + np.stack(share, axis=1) * (upper - lower), mesh.cells)


def graded(n: int, ratio: float) -> np.ndarray:
    """Return the ends of n intervals of total length 1, shape (n + 1,), whose widths grow by a constant factor.

    ratio: width of the last interval over the width of the first.
    """
    widths = ratio ** (np.arange(n) / max(n - 1, 1))
    return np.asarray(np.append(0.0, np.cumsum(widths)) / widths.sum())


def box_mesh(lower: np.ndarray, upper: np.ndarray, counts: Counts) -> SimplexMesh:
    """Return a mesh of the box between the corners `lower` and `upper` [m] with `counts` cubes along the axes.

    There is a node at each corner and each centre of a cube. Four tetrahedra surround the line between the centres of
    neighbouring cubes; at the faces of the box the pyramid over a square is divided into two.
    """
    shape = np.array(counts)
    corners = np.stack(np.meshgrid(*(np.arange(n + 1) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    middles = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    places = np.concatenate([corners, middles + 0.5])
    cells = []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        for index in range(counts[axis] + 1):  # planes of squares between cubes
            square = middles[middles[:, axis] == 0].copy()
            square[:, axis] = index
            ring = [square + np.eye(3, dtype=int)[one] * i + np.eye(3, dtype=int)[two] * j for i, j in _TURN]
            a, b, c, d = (np.ravel_multi_index(tuple(place.T), tuple(shape + 1)) for place in ring)
            below, above = _middle(square - np.eye(3, dtype=int)[axis], shape), _middle(square, shape)
            if 0 < index < counts[axis]:
                cells += [np.stack([start, end, below, above], axis=1) for start, end in ((a, b), (b, c), (c, d), (d, a))]
            elif index == 0:
                cells += [np.stack([*half, above], axis=1) for half in ((a, b, c), (a, c, d))]
            else:
                cells += [np.stack([*half, below], axis=1) for half in ((a, c, b), (a, d, c))]
    return SimplexMesh(lower + places / shape * (np.asarray(upper) - lower), np.concatenate(cells))


_TURN = ((0, 0), (1, 0), (1, 1), (0, 1))


def _middle(place: np.ndarray, shape: np.ndarray) -> np.ndarray:
    return np.asarray(np.prod(shape + 1) + (place[:, 0] * shape[1] + place[:, 1]) * shape[2] + place[:, 2])


class CylinderMesh(Tetrahedral):
    """A tetrahedral mesh of a circular cylinder."""

    base: Vector = parameter("m", "centre of the lower face")
    radius: float = parameter("m", "radius", gt=0)
    height: float = parameter("m", "height along the axis", gt=0)
    axis: Literal["x", "y", "z"] = parameter("", "direction of the axis", "z")
    across: int = parameter("", "number of cubes of the mesh across the diameter; each is divided into twelve tetrahedra", ge=1)
    along: int = parameter("", "number of cubes of the mesh along the axis", ge=1)

    def expected_points(self) -> float:
        return 2.0 * self.across**2 * self.along

    def make(self) -> SimplexMesh:
        """Return the mesh: a box mesh whose cross-section [-1, 1]² is mapped to the disc by (x √(1 - y²/2), y √(1 - x²/2))."""
        square = box_mesh(np.array([-1.0, -1.0, 0.0]), np.ones(3), (self.across, self.across, self.along))
        x, y, z = square.nodes.T
        disc = self.radius * x * np.sqrt(1.0 - 0.5 * y * y), self.radius * y * np.sqrt(1.0 - 0.5 * x * x), self.height * z
        turned = np.roll(np.stack(disc, axis=1), AXES.index(self.axis) - 2, axis=1)  # a cyclic permutation inverts no cell
        return SimplexMesh(np.array(self.base) + turned, square.cells)
