"""Cushion: the inside of two sheets joined at their edges, i.e. a flat or slightly inflated bag."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, PositiveFloat

from pellucid.geometry.shapes.contract import AXES, ActiveAxes, Geometry
from pellucid.model import Model, Vector, parameter

STEPS = 4001  # samples along a side in the search for the reach: accurate to 1e-7 of the height


def _each_once(axes: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(axes)) < len(axes):
        raise ValueError(f"{', '.join(axes)} names an axis twice: name each once")
    return axes


Halves = Annotated[tuple[Literal["x", "y", "z"], ...], AfterValidator(_each_once)]
"""Axes along which only the upper half of a cushion is kept, as in a model with planes of symmetry."""


class CushionDimensions(Model):
    """Position and size of a cushion, shared by its inside and its surface."""

    centre_: Vector = parameter("m", "centre of the cushion", alias="centre")
    sides: tuple[PositiveFloat, PositiveFloat] = parameter("m", "lengths along x and y")
    height: float = parameter("m", "distance of the two sheets at the centre of the cushion", gt=0)
    halved: Halves = parameter(
        "", "axes along which only the upper half is kept, for a model with planes of symmetry through the centre", ()
    )


class Cushion(CushionDimensions, Geometry):
    """The inside of two domed rectangular sheets that are joined at their four edges.

    At distances ξ and η from the middle, divided by half the sides, the sheets lie at ± height/2 (1 - ξ²)(1 - η²) from the
    plane of their edges. The shape is a rectangle if z is thin; if x or y is, it is the section through the middle.
    """

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        half, kept = 0.5 * np.array([*self.sides, self.height]), np.array([axis in self.halved for axis in AXES])
        return np.array(self.centre_) - np.where(kept, 0.0, half), np.array(self.centre_) + half

    def reach(self, direction: np.ndarray) -> float:
        """Return the maximum of x·d over the positions x of the cushion [m] for a direction d. The coordinate η is sampled
        finely; over ξ, the maximum of a ξ + k (1 - ξ²) is exact (at a/2k or at an end)."""
        first, kept = np.array([-1.0, -1.0, -1.0]), [axis in self.halved for axis in AXES]
        first[kept] = 0.0
        a, b, c = direction * 0.5 * np.array([*self.sides, self.height])
        eta = np.linspace(first[1], 1.0, STEPS)
        up = max(c, c * first[2])
        k = up * (1.0 - eta**2)
        xi = np.clip(np.divide(0.5 * a, k, out=np.full(STEPS, np.copysign(np.inf, a)), where=k > 0.0), first[0], 1.0)
        return float(np.array(self.centre_) @ direction + (a * xi + b * eta + up * dome(xi, eta)).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        offset = np.where(active, points - np.array(self.centre_), 0.0)
        xi, eta, zeta = (offset / (0.5 * np.array([*self.sides, self.height]))).T
        inside = (np.abs(xi) <= 1.0) & (np.abs(eta) <= 1.0) & (np.abs(zeta) <= dome(xi, eta))
        for axis in self.halved:
            inside &= offset[:, AXES.index(axis)] >= 0.0
        return np.asarray(inside)

    def measure(self, active: ActiveAxes) -> float:
        x, y, z = active
        across = self.sides[0] ** x * self.sides[1] ** y
        up = self.height * (2.0 / 3.0) ** (x + y) if z else 1.0  # the mean of 1 - ξ² is 2/3
        return across * up * 0.5 ** sum(active[AXES.index(axis)] for axis in self.halved)


def dome(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Return the height of a domed sheet divided by the height in the middle, (1 - ξ²)(1 - η²); xi, eta: distances ξ and η
    from the middle divided by half the sides."""
    return np.asarray((1.0 - xi**2) * (1.0 - eta**2))
