"""What kinds of bodies share: that they lie in the grid, what bounds their step there, what probes read of them."""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.grid.model import GridCase

SLACK = 1e-9  # of the extent of the grid, for rounding
COMMON_FIELDS = ("position", "velocity", "density", "pressure", "stress", "mass", "kinetic_energy", "stored_energy")
"""What probes read of every body whose unknowns are on the grid."""


def place_problems(
    path: Path, bounds: tuple[np.ndarray, np.ndarray], grid: GridCase, is_surface: bool, cut_at: Sequence[str] = ()
) -> Iterator[Finding]:
    """Findings of a body, whose place is at `path`, that reaches beyond the grid.

    bounds: its lower and upper corner [m]; cut_at: faces of the grid beyond which it may reach.
    """
    ends = zip("xyz", *bounds, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
    for axis, low, high, grid_low, grid_high, thin in ends:
        if thin:
            continue
        slack = SLACK * (grid_high - grid_low)
        reach = f"along {axis} the body reaches from {low:g} to {high:g} m"
        if high <= low and not is_surface:
            yield Finding(path, f"{reach}: it has no extent there", "let the upper end lie above the lower one")
            continue
        low_free, high_free = f"{axis}-lower" not in cut_at, f"{axis}-upper" not in cut_at
        if (low_free and low < grid_low - slack) or (high_free and high > grid_high + slack):
            text = f"{reach}, outside the grid: {grid_low:g} to {grid_high:g} m"
            yield Finding(path, text, "move or shrink the body, or enlarge grid.lower and grid.upper")
        elif low >= grid_high or high <= grid_low:
            yield Finding(path, f"{reach}: `cut_at` leaves nothing of it", "move the body, or the grid")


def longest_edge(places: np.ndarray) -> float:
    """Of all elements [m]; places of their corners: shape (m, corners, 3)."""
    return float(np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(initial=0.0))
