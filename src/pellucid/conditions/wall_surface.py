"""Surface of a region of the grid at which a fluid does not slip, described at the nodes near it."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.conditions.rigid.no_slip import DEGREES, LEAST_SLOPE, NoSlip, Surface, Window
from pellucid.geometry.region import within
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.grid.actions import NodalActions
from pellucid.model import Vector

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

SAMPLES = 4  # samples in a cell along each axis, for the filled fraction of nodes
MOST_PLACES = 1_000_000  # largest number of positions evaluated at once
BISECTIONS = 40  # bisections to find the distance from the surface
PER_CELL = 4  # positions in a cell at which opposite walls are looked for
NEAR_A_WALL = 2.0  # cells from another wall within which the velocity of the fluid is not interpolated
LEAST_HELD = 0.8  # smallest part of a normal along the axes that a support holds, with which the support stops a fluid there
STOPS_WITHIN = 0.5  # cells outside the surface: on average the fluid then stops at the surface

Inside = Callable[[np.ndarray], np.ndarray]


class WallSurface(NamedTuple):
    """Surface of a region on which a fluid does not slip, described by data at the nodes near it."""

    node: np.ndarray  # (n,) numbers of the nodes, ascending
    held: np.ndarray  # (n,) mask of the nodes that the support holds
    across: np.ndarray  # (n, 3) unit vector along which a node does not move relative to the wall; zero if there is none
    released: np.ndarray  # (n, 3) mask of the axes along which only this support holds the nodes
    surface: Surface  # distance from the surface, normal and curvature at the nodes
    filled: np.ndarray  # (n,) fraction of the volume of each node that the region fills
    share: np.ndarray  # (n,) part of each node within faces that the surface meets
    area: np.ndarray  # (n,) integral of the shape function of each node over the surface [m^2]
    window: Window  # box of nodes around `node`, for interpolation at `samples`
    heights: list[np.ndarray]  # two arrays (n,): distances from the surface at which the fluid's velocity is known [m]
    facing: np.ndarray  # (n,) mask of the nodes for which the second is the distance of another wall
    opposite: np.ndarray  # (n, 3) velocity of that wall [m/s]
    samples: list[np.ndarray]  # two arrays (n, 3): positions at these distances [m]
    signs: list[np.ndarray]  # two arrays (n, 3): factors of sampled velocities, -1 along the normal of a mirror plane, else 1
    neighbours: csr_array  # (n, n) weights with which a node distributes impulse to the nodes next to it


def find_wall(no_slip: NoSlip, actions: NodalActions, row: int, region: Geometry, faces: "Sequence[Support]") -> WallSurface:
    """Return the surface of a region, described at the nodes near it that are free or that the support with index `row`
    constrains. no_slip: computes surfaces on the grid; actions, faces: as in `NoSlipWall.__init__`."""
    grid = actions.field.grid
    lattice, periods = grid.lattice, grid.periods
    x, y, z = grid.thin
    active: ActiveAxes = (not x, not y, not z)
    cell, axes = lattice.cell, np.flatnonzero(active)
    index, place = grid.where()
    order = np.argsort(index)
    index, place = index[order], place[order]
    lower = np.array(lattice.lower)
    upper = lower + cell * np.array(lattice.counts)
    ends = np.stack([np.abs(place - lower) < 0.5 * cell, np.abs(place - upper) < 0.5 * cell], axis=2)
    ends &= np.array(active)[:, None] & ~np.array(grid.periodic)[:, None]
    by_faces, clamped, mirrors = np.zeros((len(place), 3), bool), np.zeros(len(place), bool), np.zeros((3, 2), bool)
    for support in faces:  # nodes on planes of symmetry stay constrained; the fluid is mirrored there
        if (face := support.face()) is not None and support.body is None:
            on, along = ends[:, face[0], face[1]], np.array(support.axes())
            along = along & np.array(active)
            if along[face[0]] and support.velocity[face[0]] == 0.0 and along.sum() == 1:
                by_faces[on, face[0]] = mirrors[face] = True
            else:
                clamped |= on & along.any()
    marks = grid.nodes.constrained[index]
    open_axes = np.array(active) & ~by_faces
    wanted = open_axes & np.array(faces[row].axes())
    held = np.all((marks == row + 1) | ~wanted, axis=1) & wanted.any(axis=1) & ~clamped
    free = np.all((marks == 0) | ~open_axes, axis=1) & ~clamped

    def contains(at: np.ndarray) -> np.ndarray:
        return within(region, _mirrored(at, lower, upper, mirrors)[0], active, periods)

    half = 0.5 * (DEGREES[grid.case.functions] + 1)
    inside = contains(place)
    mixed = np.zeros(len(place), bool)
    for steps in np.ndindex(*np.where(active, 5, 1)):
        by = np.where(active, np.array(steps) - 2, 0) * cell
        mixed |= contains(place + by) != inside
    chosen = np.flatnonzero(mixed & (held | free))
    filled, slope = _find_shares(no_slip, contains, place[chosen], cell, half, active)
    steepness = np.linalg.norm(slope, axis=1)
    keep = (steepness > LEAST_SLOPE) & (filled > 0.0) & (filled < 1.0)
    chosen, filled, slope, steepness = chosen[keep], filled[keep], slope[keep], steepness[keep]
    normal, most = -slope / steepness[:, None], half * cell * np.sqrt(len(axes))
    distance, found = _distances(contains, place[chosen], normal, most)
    # few samples fill nodes far outside: the normal is found again on the surface
    slope = _find_shares(no_slip, contains, place[chosen] - distance[:, None] * normal, cell, half, active)[1]
    steepness_there = np.linalg.norm(slope, axis=1)
    normal = -slope / np.maximum(steepness_there, LEAST_SLOPE)[:, None]
    distance, again = _distances(contains, place[chosen], normal, most)
    found &= again
    node = index[chosen]
    of_plane = no_slip.functions(np.zeros(1))[0]
    certainty = np.where(found, np.minimum(1.0, 2.0 * steepness_there / of_plane), 0.0)
    window = no_slip.find_window(node)
    surface = Surface(distance, normal, certainty, no_slip.curvature_of(window, node, normal, certainty, distance))
    # a face that the surface meets cuts off a part of the area of a node; a face behind the surface does not
    of_grid = np.prod(1.0 + (no_slip.shares_along(node) - 1.0) * (1.0 - normal**2), axis=1)
    area = steepness / cell * grid.cell_volume * of_grid
    on_surface = place[chosen] - distance[:, None] * normal
    walls = Walls(faces, active, periods, lower, upper, mirrors)
    gap, opposite = walls.find_opposite(on_surface, normal, cell, (no_slip.heights[1] + NEAR_A_WALL * cell))
    facing = np.isfinite(gap)
    heights = [
        np.where(facing, np.minimum(no_slip.heights[0], 0.5 * gap), no_slip.heights[0]),
        np.where(facing, gap, no_slip.heights[1]),
    ]
    places = [on_surface + height[:, None] * normal for height in heights]
    samples, signs = zip(*(_mirrored(at, lower, upper, mirrors) for at in places), strict=True)
    released = held[chosen, None] & wanted[chosen] & (marks[chosen] == row + 1)
    neighbours = _neighbours(no_slip, node, active)
    stopped = held[chosen] | (found & (distance < STOPS_WITHIN * cell))
    across = normal * np.array(faces[row].axes())
    size = np.linalg.norm(across, axis=1)
    across[~stopped | (size < LEAST_HELD)] = 0.0
    across /= np.maximum(size, LEAST_HELD)[:, None]
    state = (node, held[chosen], across, released, surface, filled, of_grid, area, window)
    return WallSurface(*state, heights, facing, opposite, list(samples), list(signs), neighbours)


class Walls:
    """All walls of a velocity field on which fluids do not slip: shapes of supports, and faces that supports hold.

    faces: all supports, split so that each acts on at most one face; active: axes along which the grid is more than one cell
    thick; periods: of the grid [m]; lower, upper: corners of the grid [m]; mirrors: as in `_mirrored`.
    """

    def __init__(
        self,
        faces: "Sequence[Support]",
        active: ActiveAxes,
        periods: Vector,
        lower: np.ndarray,
        upper: np.ndarray,
        mirrors: np.ndarray,
    ) -> None:
        self._active, self._periods, self._ends, self._mirrors = active, periods, (lower, upper), mirrors
        whole = [one for one in faces if one.holds_all(active)]
        self._shapes = [(shape.geometry(), one.velocity) for one in whole if (shape := one.wall_of_fluids()) is not None]
        self._faces = [
            (*face, one.velocity)
            for one in whole
            if (face := one.face()) is not None and one.body is None and one.until is None
        ]

    def find_opposite(self, start: np.ndarray, normal: np.ndarray, cell: float, most: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances of the walls that lie opposite the surface of a wall, along its normals, shape (n,) [m],
        infinite if there is none within the distance `most` [m], and their velocities, shape (n, 3) [m/s]. start: positions on
        the surface [m], shape (n, 3); normal: unit normals, shape (n, 3); cell: cell size [m]."""
        gap, velocity = np.full(len(start), np.inf), np.zeros((len(start), 3))
        apart = cell / PER_CELL
        for step in range(round(most / apart)):
            at = start + step * apart * normal
            for wall in (*self._shapes, *self._faces):
                new = np.flatnonzero(np.isinf(gap) & self._contains(wall, at + apart * normal))
                if not len(new):
                    continue
                beyond = _distances(partial(self._contains, wall), at[new], -normal[new], apart)[0]
                # close to the surface rounding may place the start inside its own wall
                gap[new], velocity[new] = step * apart + beyond if step else 0.0, np.asarray(wall[-1], float)
        return np.where(gap > 0.0, gap, np.inf), velocity

    def _contains(self, wall: tuple[Any, ...], place: np.ndarray) -> np.ndarray:
        place = _mirrored(place, *self._ends, self._mirrors)[0]
        if len(wall) == 2:
            return within(wall[0], place, self._active, self._periods)
        axis, end, _ = wall
        return place[:, axis] > self._ends[1][axis] if end else place[:, axis] < self._ends[0][axis]


def _mirrored(place: np.ndarray, lower: np.ndarray, upper: np.ndarray, mirrors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions `place` [m], shape (n, 3), mirrored into the domain at planes of symmetry, and the factors of
    the velocity components at the mirrored positions: -1 along the normals of these planes, else 1, shape (n, 3). lower,
    upper: corners of the domain [m]; mirrors: mask of the faces that are planes of symmetry, shape (3, 2), by axis and end."""
    place, signs = place.copy(), np.ones(place.shape)
    for axis, end in np.argwhere(mirrors):
        face = (lower, upper)[end][axis]
        beyond = (place[:, axis] < face) if end == 0 else (place[:, axis] > face)
        place[beyond, axis], signs[beyond, axis] = 2.0 * face - place[beyond, axis], -signs[beyond, axis]
    return place, signs


def _neighbours(no_slip: NoSlip, node: np.ndarray, active: ActiveAxes) -> csr_array:
    """Return a sparse matrix of shape (n, n): in each row the weights of the neighbours of a node, at most one cell away
    along each active axis, without the node itself. no_slip: finds nodes at an offset; node: sorted node numbers, shape
    (n,)."""
    rows, columns, weights = [], [], []
    for steps in np.ndindex(*np.where(active, 3, 1)):
        by = np.where(active, np.array(steps) - 1, 0)
        if not (by.any() and len(node)):
            continue
        there, inside = no_slip.find_next(node, by)
        column = np.minimum(np.searchsorted(node, there), len(node) - 1)
        row = np.flatnonzero(inside & (node[column] == there) & (there != node))
        rows.append(row)
        columns.append(column[row])
        weights.append(np.full(len(row), 0.5 ** np.abs(by).sum()))
    entries = [np.concatenate(parts) if parts else np.zeros(0, int) for parts in (weights, rows, columns)]
    return csr_array((entries[0], (entries[1], entries[2])), shape=(len(node), len(node)))


def _find_shares(
    no_slip: NoSlip, contains: Inside, place: np.ndarray, cell: float, half: float, active: ActiveAxes
) -> tuple[np.ndarray, np.ndarray]:
    """Return, for a node at each position, the fraction of its volume that a region fills, shape (n,), and the gradient of
    this fraction, shape (n, 3) [1/cell].

    no_slip: provides the shape functions; contains: function that returns which positions lie in the region; place:
    positions [m], shape (n, 3); cell: cell size [m]; half: half of the width of the shape functions in cells; active:
    axes along which the grid is more than one cell thick.
    """
    axes = np.flatnonzero(active)
    offsets = (np.arange(-half * SAMPLES, half * SAMPLES) + 0.5) / SAMPLES
    weight, rise = no_slip.functions(offsets)
    lattice = np.stack(np.meshgrid(*(offsets if on else [0.0] for on in active), indexing="ij"), axis=-1).reshape(-1, 3)
    along, ones = [np.searchsorted(offsets, lattice[:, d]) for d in range(3)], np.ones(len(lattice))
    weights = [weight[along[d]] if active[d] else ones for d in range(3)]
    shares = np.prod(weights, axis=0) / SAMPLES ** len(axes)
    slopes = np.zeros((len(lattice), 3))
    for d in axes:  # relative to a sample, the position is on the other side
        others = [weights[e] for e in range(3) if e != d]
        slopes[:, d] = -rise[along[d]] * np.prod(others, axis=0) / SAMPLES ** len(axes)
    filled, slope = np.zeros(len(place)), np.zeros((len(place), 3))
    at_once = max(1, MOST_PLACES // len(lattice))
    for k in range(0, len(place), at_once):
        these = place[k : k + at_once, None] + cell * lattice
        inside = contains(these.reshape(-1, 3)).reshape(len(these), -1).astype(float)
        filled[k : k + at_once], slope[k : k + at_once] = inside @ shares, inside @ slopes
    return filled, slope


def _distances(contains: Inside, place: np.ndarray, normal: np.ndarray, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the signed distances of the positions `place` [m], shape (n, 3), from the surface of a region along given unit
    normals, shape (n, 3): in metres, positive outside. Also return a mask of the positions that have a surface within the
    distance `most` [m]. contains: function that returns which positions lie in the region."""
    inside = contains(place)
    sign = np.where(inside, 1.0, -1.0)
    low, high = np.zeros(len(place)), np.full(len(place), most)
    found = contains(place + (sign * high)[:, None] * normal) != inside
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = contains(place + (sign * middle)[:, None] * normal) == inside
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return -sign * 0.5 * (low + high), found
