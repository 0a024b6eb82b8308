"""Checks of the position of a body in the grid, shared by several kinds of bodies, and the names of the fields that probes can
read.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.grid.model import GridCase

BETWEEN = 2.0  # smallest gap between a body and its periodic image, in cells
SLACK = 1e-9  # tolerance for round-off, relative to the extent of the grid
COMMON_FIELDS = ("position", "velocity", "density", "pressure", "stress", "mass", "kinetic_energy", "stored_energy")
"""Fields that probes read, common to all bodies with unknowns on the grid."""


def place_problems(
    path: Path,
    bounds: tuple[np.ndarray, np.ndarray],
    grid: GridCase,
    is_surface: bool,
    cut_at: Sequence[str] = (),
    fills: bool = False,
    flows: bool = False,
) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a body at `path` that extends beyond the grid, or touches itself across a
    periodic seam.

    bounds: lower and upper corner of the bounding box of the body [m]; is_surface: True for a membrane; cut_at: faces of
    the grid beyond which the body may extend; fills: True if a body as long as the period continues across the seam without
    a gap; flows: True if the body may touch itself, like a fluid.
    """
    ends = zip("xyz", *bounds, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
    for axis, low, high, grid_low, grid_high, thin in ends:
        if thin:
            continue
        slack = SLACK * (grid_high - grid_low)
        reach = f"along {axis} the body extends from {low:g} to {high:g} m"
        if high <= low and not is_surface:
            yield Finding(path, f"{reach}: it has no extent along this axis", "set the upper end above the lower one")
            continue
        if axis in grid.periodic:
            yield from _seam_problems(path, axis, (low, high), grid, fills, flows)
            continue
        low_free, high_free = f"{axis}-lower" not in cut_at, f"{axis}-upper" not in cut_at
        if (low_free and low < grid_low - slack) or (high_free and high > grid_high + slack):
            text = f"{reach}, outside the grid: {grid_low:g} to {grid_high:g} m"
            yield Finding(path, text, "move or shrink the body, or enlarge grid.lower and grid.upper")
        elif low >= grid_high or high <= grid_low:
            yield Finding(path, f"{reach}: `cut_at` removes all of it", "move the body, or the grid")


def _seam_problems(
    path: Path, axis: str, ends: tuple[float, float], grid: GridCase, fills: bool, flows: bool
) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a body at `path` that lies outside the grid along a periodic axis, or would touch
    itself across the seam.

    ends: lower and upper end of the body along the axis [m]; fills: True if a body as long as the period continues across the
    seam without a gap; flows: True if the body may touch itself, like a fluid.
    """
    (low, high), d = ends, "xyz".index(axis)
    lower, upper = grid.lower[d], grid.extent_upper()[d]
    period, slack = upper - lower, SLACK * (upper - lower)
    most = period - BETWEEN * grid.cell
    reach = f"along {axis} the body extends from {low:g} to {high:g} m"
    if low >= upper or high <= lower:
        text = f"{reach}, outside the periodic grid: {lower:g} to {upper:g} m"
        yield Finding(path, text, "move the body by whole periods so that it starts inside the grid")
    elif high - low > period + slack or (
        high - low > most + slack and not flows and not (fills and high - low >= period - slack)
    ):
        goes_on = f", or exactly {period:g} m, continuing across the seam" if fills else ""
        text = (
            f"{reach}, {high - low:g} m of a period of {period:g} m: it would touch itself across the seam; at "
            f"most {most:g} m, "
            f"two cells less than the period, is allowed{goes_on}"
        )
        yield Finding(path, text, f"make the grid longer along {axis}, or the body shorter")


def longest_edge(places: np.ndarray) -> float:
    """Return the length of the longest edge of all elements [m]. places: positions of their corners [m], shape (m, corners,
    3).
    """
    return float(np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(initial=0.0))
