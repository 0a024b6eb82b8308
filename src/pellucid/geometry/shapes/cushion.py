"""The inside of two sheets that are joined at their edges: a bag that lies flat, or nearly."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, PositiveFloat

from pellucid.geometry.shapes.contract import AXES, ActiveAxes, Geometry
from pellucid.model import Model, Vector, parameter

STEPS = 4001  # along a side, in which its reach is looked for: good to 1e-7 of the height


def _each_once(axes: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(axes)) < len(axes):
        raise ValueError(f"{', '.join(axes)} names an axis twice: name each once")
    return axes


Halves = Annotated[tuple[Literal["x", "y", "z"], ...], AfterValidator(_each_once)]
"""Axes along which only the upper half of something is kept."""


class CushionDimensions(Model):
    """Where a cushion is and how large: what its inside and its surface have in common."""

    centre_: Vector = parameter("m", "middle of the cushion", alias="centre")
    sides: tuple[PositiveFloat, PositiveFloat] = parameter("m", "lengths along x and y")
    height: float = parameter("m", "distance of the sheets in the middle", gt=0)
    halved: Halves = parameter(
        "", "axes along which only the upper half is kept, for a model with planes of symmetry through the centre", ()
    )


class Cushion(CushionDimensions, Geometry):
    """The inside of two domed rectangular sheets that are joined at their four edges.

    At distances ξ and η from the middle, as shares of half the sides, they are ± height/2 (1 - ξ²)(1 - η²) apart from the plane
    of their edges. A rectangle where z is thin; where x or y is, its section through the middle.
    """

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        half, kept = 0.5 * np.array([*self.sides, self.height]), np.array([axis in self.halved for axis in AXES])
        return np.array(self.centre_) - np.where(kept, 0.0, half), np.array(self.centre_) + half

    def reach(self, direction: np.ndarray) -> float:
        """Over η in fine steps; over ξ, where a ξ + k (1 - ξ²) is largest at ξ = a/2k or at an end, exactly."""
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
        """Length, area or volume over the active axes; over a side the mean of 1 - ξ² is 2/3."""
        x, y, z = active
        across = self.sides[0] ** x * self.sides[1] ** y
        up = self.height * (2.0 / 3.0) ** (x + y) if z else 1.0
        return across * up * 0.5 ** sum(active[AXES.index(axis)] for axis in self.halved)


def dome(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Height over the middle's at shares ξ and η of half the sides."""
    return np.asarray((1.0 - xi**2) * (1.0 - eta**2))
