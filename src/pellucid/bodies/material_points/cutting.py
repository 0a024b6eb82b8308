"""How the volume of a region is shared among its points, where its border is no face of its lattice.

The lattice cells at the border are cut. Each is sampled by sub-points, which tell the part of it that is left. A lattice point
that lies in the region has the part of its own cell that is left; the slivers of cells whose own point lies elsewhere go to the
nearest point that is there (those as near share), so that mass is missing nowhere and doubled nowhere. Then all volumes are
scaled to the exact measure: that of the shape less those of the parts left out, as far as these are known (those that lie
inside a box), else as sampled; so is what a plane of symmetry leaves of a shape. A ball of ten cells' radius is sampled to 1e-4
of its volume, a flat face to a sixteenth of a cell, so that the scale hardly differs from one. A part left out that is much
thinner than a cell is taken off in sum, but not just where it is.

Where nothing is left out, a point lies in the middle of the part that it represents, if that is in the region: the border
is smooth, where the points of the lattice make steps. Steps are flat: a ball would touch a plane with a foot as wide as
√(radius x spacing).
"""

from collections.abc import Sequence

import numpy as np

from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box

SAMPLES = 512  # of a lattice cell: 8 along each of three axes, 23 of two;
FEWEST_SAMPLES = 64  # fewer of each where there are many cells, which then are small for what they are cut by,
SAMPLES_IN_ALL = 8_000_000  # so that seeding takes seconds
SAMPLES_AT_ONCE = 200_000  # bounds the memory, some 20 MB
REACH = 1.5  # diagonals of a lattice cell: a sliver farther from every point has nowhere to go
NEIGHBOURS = 8  # points that may be as near to a sliver as each other: those about the middle of a cell
AS_NEAR = 1e-6  # relative difference of distances that rounding may make
LARGEST_SCALE = 0.02  # by which volumes may be corrected


def shares_of_cells(
    shape: Geometry, left_out: Sequence[Geometry], centres: np.ndarray, spacing: np.ndarray, active: tuple[bool, bool, bool]
) -> tuple[np.ndarray, np.ndarray]:
    """The points inside, shape (n, 3), and the measure that each represents [m, m², m³], shape (n,).

    `centres`, shape (m, 3), and `spacing`, shape (3,), are those of the lattice cells [m]. Raises ValueError where more is
    left too far from every point than volumes may be corrected by.
    """
    kept = shape.contains(centres, active)
    for other in left_out:
        kept &= ~other.contains(centres, active)
    cut = _cut(shape, left_out, centres, spacing, active)
    share, middle, taken, overlap = _sampled(shape, left_out, centres, spacing, active, cut)
    cell = float(np.prod(spacing[np.array(active)]))
    share[~cut] = kept[~cut]
    exact = shape.measure(active) + overlap * cell
    for other, sampled in zip(left_out, taken, strict=True):
        known = _in_a_box(other, shape, active)
        exact -= other.measure(active) if known else sampled * cell
    if _sticks_out(shape, centres, spacing, active):
        exact = float(share.sum()) * cell
    moments = middle * share[:, None]
    if kept.any():
        given, taken_by, parts = _slivers(centres, middle, np.flatnonzero(kept), np.flatnonzero(~kept & (share > 0.0)))
        far = REACH * np.linalg.norm(spacing[np.array(active)])
        near = np.linalg.norm(middle[given] - centres[taken_by], axis=1) <= far
        given, taken_by, parts = given[near], taken_by[near], parts[near]
        np.add.at(moments, taken_by, parts[:, None] * moments[given])
        np.add.at(share, taken_by, parts * share[given])
    total = share[kept].sum() * cell
    if left_out and abs(exact - total) > LARGEST_SCALE * exact:
        raise ValueError(
            f"the points represent {total:.4g} of the {exact:.4g} that is left of the shape: what lies between the bodies left "
            f"out is in part thinner than the distance between points"
        )
    places = centres[kept]
    if not left_out:
        middles = moments[kept] / share[kept, None]
        inside = shape.contains(middles, active)
        places[inside] = middles[inside]
    return places, share[kept] * cell * (exact / total if total else 1.0)


def _slivers(
    centres: np.ndarray, middle: np.ndarray, kept: np.ndarray, slivers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which slivers go to which points, and what part of each; those as near share, so that symmetric shapes stay so."""
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS, len(kept))
    distance, found = cKDTree(centres[kept]).query(middle[slivers], k=range(1, count + 1))
    distances = np.asarray(distance)
    as_near = distances <= distances[:, :1] * (1.0 + AS_NEAR)
    row, column = np.nonzero(as_near)
    return slivers[row], kept[np.asarray(found)[row, column]], 1.0 / as_near.sum(axis=1)[row]


def _cut(
    shape: Geometry, left_out: Sequence[Geometry], centres: np.ndarray, spacing: np.ndarray, active: tuple[bool, bool, bool]
) -> np.ndarray:
    """Which cells may lie partly beyond the region; a box fills its own lattice, so that only bodies left out cut its cells."""
    if not isinstance(shape, Box):
        if left_out:
            return np.ones(len(centres), dtype=bool)
        middle = shape.contains(centres, active)
        corners = np.stack(np.meshgrid(*([-0.5, 0.5] if a else [0.0] for a in active), indexing="ij"), axis=-1).reshape(-1, 3)
        apart = [shape.contains(centres + corner * spacing, active) != middle for corner in corners]
        return np.asarray(np.any(apart, axis=0))
    cut = np.zeros(len(centres), dtype=bool)
    for other in left_out:
        lower, upper = other.bounds()
        meets = (centres + 0.5 * spacing > lower) & (centres - 0.5 * spacing < upper)
        cut |= np.all(meets[:, np.array(active)], axis=1)
    return cut


def _sampled(
    shape: Geometry,
    left_out: Sequence[Geometry],
    centres: np.ndarray,
    spacing: np.ndarray,
    active: tuple[bool, bool, bool],
    cut: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Of each cell the part that is left and its middle [m]; in cells, what each body takes, and what they take twice."""
    each = max(FEWEST_SAMPLES, min(SAMPLES, SAMPLES_IN_ALL // max(int(cut.sum()), 1)))
    n = round(each ** (1.0 / sum(active)))
    inner = (np.arange(n) + 0.5) / n - 0.5
    offsets = np.stack(np.meshgrid(*(inner if a else [0.0] for a in active), indexing="ij"), axis=-1).reshape(-1, 3) * spacing
    share, middle = np.ones(len(centres)), centres.copy()
    taken, once = np.zeros(len(left_out)), 0.0
    for chunk in np.array_split(np.flatnonzero(cut), 1 + int(cut.sum()) * len(offsets) // SAMPLES_AT_ONCE):
        samples = (centres[chunk, None] + offsets).reshape(-1, 3)
        free = shape.contains(samples, active)
        before = free.sum()
        inside = free.copy()
        for k, other in enumerate(left_out):
            there = inside & other.contains(samples, active)
            taken[k] += there.sum()
            free &= ~there
        once += before - free.sum()
        free = free.reshape(len(chunk), len(offsets))
        counts = free.sum(axis=1)
        share[chunk] = counts / len(offsets)
        middle[chunk] += (free @ offsets) / np.maximum(counts, 1)[:, None]
    return share, middle, taken / len(offsets), float(taken.sum() - once) / len(offsets)


def _sticks_out(shape: Geometry, centres: np.ndarray, spacing: np.ndarray, active: tuple[bool, bool, bool]) -> bool:
    """Whether the shape reaches beyond its lattice."""
    lower, upper = shape.bounds()
    slack = 1e-6 * spacing
    low, high = centres.min(axis=0) - 0.5 * spacing - slack, centres.max(axis=0) + 0.5 * spacing + slack
    return bool(np.any(((lower < low) | (upper > high))[np.array(active)]))


def _in_a_box(other: Geometry, shape: Geometry, active: tuple[bool, bool, bool]) -> bool:
    """Whether a shape is a box, turned or not, and the bounds of another lie inside it."""
    corners = np.stack(np.meshgrid(*np.transpose(other.bounds()), indexing="ij"), axis=-1).reshape(-1, 3)
    box, corners = shape.in_own_frame(corners)
    if not isinstance(box, Box):
        return False
    low, high = box.bounds()
    slack = 1e-9 * (high - low)
    return bool(np.all(((corners >= low - slack) & (corners <= high + slack))[:, np.array(active)]))
