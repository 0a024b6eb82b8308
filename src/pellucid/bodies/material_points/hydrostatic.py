"""Initial states of fluids at rest under gravity: each point has the hydrostatic pressure at its depth."""

from collections.abc import Callable, Mapping
from math import inf

import numpy as np

from pellucid.materials.contract import PointMaterial
from pellucid.materials.eos.equation import ColumnEnds
from pellucid.model import Model, Vector, parameter

FAR = 1.5
"""Largest ratio of densities, in either direction, between the fluid at the given level and the fluid in the body; if it is
larger, the level is assumed to belong to another fluid."""
Bounds = tuple[np.ndarray, np.ndarray]
REMEDY = (
    "lower the top of the body or the level, or increase the pressure at the level; for a liquid, `carries_tension` is possible"
)


class Hydrostatic(Model):
    """A fluid at rest under gravity: the pressure below a given level balances the weight of the fluid above; compression is
    adiabatic."""

    level: float | None = parameter(
        "m",
        "height, from the origin against gravity, at which the material has its `density` and `pressure`; default: the top of "
        "the body's shape",
        None,
    )


class NoRest(ValueError):
    """Raised if a fluid has no state at rest at some height within a body."""


def states_by_height(
    rest: Hydrostatic,
    material: PointMaterial,
    bounds: Bounds,
    gravity: Vector,
    position: np.ndarray,
    largest: Callable[[float], float] = float,
) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
    """Return the hydrostatic densities [kg/m³], shape (n,), and the state arrays of the material at positions [m], shape (n,
    3).

    rest: level at which the fluid has its reference density and pressure; material: the fluid; bounds: bounding box of the
    body [m]; gravity: non-zero [m/s²]; largest: function that returns the largest value over all processes with points of the
    body. Raises NoRest if no state at rest exists.
    """
    strength = float(np.linalg.norm(gravity))
    up = -np.array(gravity) / strength
    level = heights_of_ends(bounds, gravity)[1] if rest.level is None else rest.level
    depth = level - np.sum(position * up, axis=1)  # no matrix product, whose bits depend on how many points there are
    lowest, highest = largest(float(np.max(depth, initial=-inf))), -largest(float(np.max(-depth, initial=-inf)))
    try:  # of the ends of the body too: the column is integrated alike by all processes, whichever points they have
        density, state = material.at_rest(strength, np.append(depth, [lowest, highest]))
        return density[:-2], {name: array[:-2] for name, array in state.items()}
    except ColumnEnds as error:
        side = "above" if error.depth < 0.0 else "below"
        reason = f"{side} a height of {level - error.depth:.6g} m: {error}"
        raise NoRest(f"this fluid has no state at rest under this gravity {reason}") from None


def far_level(
    level: float, material: PointMaterial, body: Bounds, grid: Bounds, gravity: Vector
) -> tuple[float, float, float] | None:
    """Return the lowest and highest height of the grid [m], and the ratio of the hydrostatic density in the body to the
    density at a level (height) [m] outside the grid, if this ratio indicates that another fluid lies there; None otherwise.

    material: the fluid; body, grid: bounding boxes [m]; gravity: [m/s²]. None also if there is no state at rest, which
    `states_by_height` reports.
    """
    bottom, top = heights_of_ends(grid, gravity)
    if bottom <= level <= top:
        return None
    lowest, highest = (min(max(height, bottom), top) for height in heights_of_ends(body, gravity))
    nearest = highest if level > top else lowest
    try:
        density, _ = material.at_rest(float(np.linalg.norm(gravity)), np.array([level - nearest]))
    except ColumnEnds:
        return None
    ratio = float(density[0]) / material.density
    return None if 1.0 / FAR <= ratio <= FAR else (bottom, top, ratio)


def heights_of_ends(bounds: Bounds, gravity: Vector) -> tuple[float, float]:
    """Return the lowest and the highest height of a box [m], where height is the coordinate opposite to gravity. bounds: lower
    and upper corner [m]; gravity: [m/s²].
    """
    up = -np.array(gravity) / np.linalg.norm(gravity)
    lower, upper = bounds
    return float(np.where(up > 0.0, lower, upper) @ up), float(np.where(up > 0.0, upper, lower) @ up)
