"""Surface of a region of the grid at which a fluid does not slip, described at the nodes near it."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_array

from pellucid.conditions.areas import Edges, find_areas
from pellucid.conditions.rigid.no_slip import DEGREES, LEAST_SLOPE, NoSlip, Surface, Window
from pellucid.geometry.region import within
from pellucid.geometry.shapes.contract import ActiveAxes, Space
from pellucid.grid.actions import NodalActions
from pellucid.model import Vector

if TYPE_CHECKING:
    from pellucid.conditions.support import Support

SAMPLES = 4  # samples in a cell along each axis, for the filled fraction of nodes
MOST_PLACES = 1_000_000  # largest number of positions evaluated at once
PAIRS_OF_BISECTIONS = 20  # to find the distance from the surface
PER_CELL = 4  # positions in a cell at which opposite walls are looked for
NEAR_A_WALL = 2.0  # cells from another wall within which the velocity of the fluid is not interpolated
LEAST_HELD = 0.8  # smallest part of a normal along the axes that a support holds, with which the support stops a fluid there
STOPS_WITHIN = 0.5  # cells outside the surface: on average the fluid then stops at the surface

Inside = Callable[[np.ndarray], np.ndarray]
ZERO = (0.0, 0.0, 0.0)


class WallMaker(Protocol):
    """Interface of supports or a body whose region acts as a wall of fluids."""

    @property
    def rows(self) -> tuple[int, ...]:
        """Indices of the supports among all supports, split so that each acts on at most one face; none for a body."""

    @property
    def axes(self) -> tuple[bool, bool, bool]:
        """Axes along which the wall stops and drags fluids."""

    @property
    def region(self) -> Space:
        """Region of the wall in this step."""

    def faces_fluid(self, place: np.ndarray) -> np.ndarray:
        """Return a mask of the positions outside the surface [m], shape (n, 3), that fluids may reach, shape (n,)."""


class CutNodes(NamedTuple):
    """Nodes whose volume the region of a wall may partly fill."""

    node: np.ndarray  # (m,) numbers of the nodes, ascending
    filled: np.ndarray  # (m,) fraction of the volume of each node that the region fills


class Slip(NamedTuple):
    """Linear map from velocities of nodes to those at m pieces of the edges of a surface, and back to impulses on nodes."""

    at_edges: csr_array  # (m, nodes of the window box) shape functions at the pieces
    of_wall: csr_array  # (m, n) the same for the nodes of the wall, divided by their sum
    normal: np.ndarray  # (m, 3) unit normals out of the region
    to_nodes: csr_array  # (n, m) integrals of the shape functions of nodes over the pieces [m^2]


class WallSurface(NamedTuple):
    """Surface of a region on which a fluid does not slip, described by data at the nodes near it."""

    node: np.ndarray  # (n,) numbers of the nodes, ascending
    place: np.ndarray  # (n, 3) their positions [m]
    held: np.ndarray  # (n,) mask of the nodes in the region, which have the velocity of the wall across the surface
    across: np.ndarray  # (n, 3) unit vector along which a node does not move relative to the wall; zero if there is none
    released: np.ndarray  # (n, 3) mask of the axes along which only supports of the wall hold the nodes
    surface: Surface  # distance from the surface, normal and curvature at the nodes
    filled: np.ndarray  # (n,) fraction of the volume of each node that the region fills
    share: np.ndarray  # (n,) part of each node within faces that the surface meets
    into: np.ndarray  # (n, 3) unit vectors into the wall, along ∮ N n dA of the node; zero where the wall stops no fluid
    area: np.ndarray  # (n,) integral of the shape function of each node over the surface [m^2]
    edge: np.ndarray  # (n,) part of this area that belongs to edges, between 0 and 1
    slip: Slip  # velocities with which the fluid slips at edges
    window: Window  # box of nodes around `node`, for interpolation at `samples`
    heights: list[np.ndarray]  # two arrays (n,): distances from the surface at which the fluid's velocity is known [m]
    facing: np.ndarray  # (n,) mask of the nodes for which the second is the distance of another wall
    opposite: np.ndarray  # (n, 3) velocity of that wall if it is a support [m/s]
    opposite_body: np.ndarray  # (n,) its index among the bodies that act as walls, else -1
    feet: np.ndarray  # (n, 3) positions on the surface next to the nodes [m]
    known: np.ndarray  # (n,) mask of the nodes for which the surface was found
    samples: list[np.ndarray]  # two arrays (n, 3): positions at these distances [m], mirrored into the domain
    signs: list[np.ndarray]  # two arrays (n, 3): factors of sampled velocities, -1 along the normal of a mirror plane, else 1
    neighbours: csr_array  # (n, n) weights with which a node distributes impulse to the nodes next to it
    cut: CutNodes  # all nodes near the surface, also those on which the wall does not act


def find_wall(
    no_slip: NoSlip, actions: NodalActions, maker: WallMaker, faces: "Sequence[Support]", bodies: Sequence[WallMaker]
) -> WallSurface:
    """Return the surface of the region of a wall (`maker`), described at the nodes near it that are free or that the supports
    of the wall constrain. no_slip: computes surfaces on the grid; actions, faces, bodies: as in `NoSlipWall.__init__`."""
    grid = actions.field.grid
    lattice, periods = grid.lattice, grid.periods
    active: ActiveAxes = grid.active_axes
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
    for body in bodies:
        if body is not maker:
            clamped |= within(body.region, _mirrored(place, lower, upper, mirrors)[0], active, periods)

    def contains(at: np.ndarray) -> np.ndarray:
        return within(maker.region, _mirrored(at, lower, upper, mirrors)[0], active, periods)

    half = 0.5 * (DEGREES[grid.case.functions] + 1)
    inside = contains(place)
    marks = grid.nodes.constrained[index]
    open_axes = np.array(active) & ~by_faces
    wanted = open_axes & np.array(maker.axes)
    free = np.all((marks == 0) | ~open_axes, axis=1) & ~clamped
    own = np.isin(marks, np.array(maker.rows, int) + 1)
    if not maker.rows:
        held = free & inside
    else:
        held = np.all(own | ~wanted, axis=1) & wanted.any(axis=1) & ~clamped
    near = np.flatnonzero(_is_near(contains, inside, place, lower, cell, active))
    filled, slope = _find_shares(no_slip, contains, place[near], cell, half, active)
    cut, acts = CutNodes(index[near], filled), (held | free)[near]
    chosen, filled, slope = near[acts], filled[acts], slope[acts]
    steepness = np.linalg.norm(slope, axis=1)
    keep = (steepness > LEAST_SLOPE) & (filled > 0.0) & (filled < 1.0)
    if not maker.rows:  # no support constrains nodes that lie deeper
        keep |= held[chosen]
    chosen, filled, slope, steepness = chosen[keep], filled[keep], slope[keep], steepness[keep]
    normal = -slope / np.maximum(steepness, LEAST_SLOPE)[:, None]
    into, most = -normal, half * cell * np.sqrt(len(axes))
    distance, found = find_distances(contains, place[chosen], normal, most)
    # few samples fill nodes far outside: the normal is found again on the surface
    slope = _find_shares(no_slip, contains, place[chosen] - distance[:, None] * normal, cell, half, active)[1]
    steepness_there = np.linalg.norm(slope, axis=1)
    normal = -slope / np.maximum(steepness_there, LEAST_SLOPE)[:, None]
    distance, again = find_distances(contains, place[chosen], normal, most)
    found &= again
    on_surface = place[chosen] - distance[:, None] * normal
    wet = maker.faces_fluid(_mirrored(on_surface + cell / PER_CELL * normal, lower, upper, mirrors)[0])
    found &= wet
    node = index[chosen]
    of_plane = no_slip.functions(np.zeros(1))[0]
    certainty = np.where(found, np.minimum(1.0, 2.0 * steepness_there / of_plane), 0.0)
    window = no_slip.find_window(node)
    areas, of_edges, edges = find_areas(no_slip, contains, place[chosen], normal, lower, cell, active)
    edge = of_edges / np.where(areas > 0.0, areas, 1.0)
    curvature = no_slip.curvatures_of(window, node, normal, certainty, distance, edge > 0.0)
    surface = Surface(distance, normal, certainty, curvature)
    # a face that the surface meets cuts off a part of the area of a node; a face behind the surface does not
    of_grid = np.prod(1.0 + (no_slip.shares_along(node) - 1.0) * (1.0 - normal**2), axis=1)
    area = np.where(wet, areas / cell * grid.cell_volume * of_grid, 0.0)
    walls = Walls(faces, bodies, active, periods, lower, upper, mirrors)
    opposite = walls.find_opposite(on_surface, normal, cell, (no_slip.heights[1] + NEAR_A_WALL * cell))
    facing = np.isfinite(opposite.gap)
    heights = [
        np.where(facing, np.minimum(no_slip.heights[0], 0.5 * opposite.gap), no_slip.heights[0]),
        np.where(facing, opposite.gap, no_slip.heights[1]),
    ]
    places = [on_surface + height[:, None] * normal for height in heights]
    samples, signs = zip(*(_mirrored(at, lower, upper, mirrors) for at in places), strict=True)
    released = held[chosen, None] & wanted[chosen] & own[chosen]
    neighbours = _neighbours(no_slip, node, active)
    stopped = held[chosen] | (found & (distance < STOPS_WITHIN * cell))
    across = normal * np.array(maker.axes)
    size = np.linalg.norm(across, axis=1)
    stops = wet & (size >= LEAST_HELD)
    into[~stops] = 0.0
    across[~stopped | (size < LEAST_HELD)] = 0.0
    across /= np.maximum(size, LEAST_HELD)[:, None]
    slip = _find_slip(no_slip, window, node, edges, grid.cell_volume / cell * of_grid * wet)
    state = (node, place[chosen], held[chosen], across, released, surface, filled, of_grid, into, area, edge, slip, window)
    sides = (heights, facing, opposite.velocity, opposite.body, on_surface, found)
    return WallSurface(*state, *sides, list(samples), list(signs), neighbours, cut)


def _find_slip(no_slip: NoSlip, window: Window, node: np.ndarray, edges: Edges, size: np.ndarray) -> Slip:
    """Return the `Slip` at edges. node: sorted node numbers, shape (n,); size: area of the surface at each node for a unit of
    `Edges.area` [m^2], shape (n,)."""
    functions = no_slip.functions_at(window, edges.place)
    box = no_slip.find_in_window(window, node)
    of_wall = functions[:, box]
    total = of_wall.sum(axis=1)
    to_nodes = csr_array(of_wall.multiply(edges.area[:, None]).T.multiply(size[:, None]))
    of_wall = csr_array(of_wall.multiply(1.0 / np.where(total > 0.0, total, 1.0)[:, None]))
    return Slip(functions, of_wall, edges.normal, to_nodes)


def _is_near(
    contains: Inside, inside: np.ndarray, place: np.ndarray, lower: np.ndarray, cell: float, active: ActiveAxes
) -> np.ndarray:
    """Return a mask of the nodes with the surface of a region between them and a node at most two cells away along each active
    axis, shape (n,).

    contains: function that returns which positions lie in the region; inside: its result at the nodes, shape (n,); place:
    positions of all nodes of the grid [m], shape (n, 3); lower: lower corner of the grid [m]; cell: cell size [m].
    """
    margin = np.where(active, 2, 0)
    at = np.where(active, np.rint((place - lower) / cell), 0).astype(int) + margin
    box = np.stack(np.meshgrid(*(np.arange(n) for n in at.max(axis=0) + margin + 1), indexing="ij"), axis=-1)
    around = contains((place[0] + (box - at[0]) * cell).reshape(-1, 3)).reshape(box.shape[:3])
    size = (2 * margin + 1).tolist()
    least, most = ndimage.minimum_filter(around, size=size), ndimage.maximum_filter(around, size=size)
    return np.asarray(np.where(inside, ~least[tuple(at.T)], most[tuple(at.T)]))


class Opposite(NamedTuple):
    """Walls opposite the surface of a wall, for n positions on it."""

    gap: np.ndarray  # (n,) distances [m], infinite if there is none
    velocity: np.ndarray  # (n, 3) velocities of supports [m/s]
    body: np.ndarray  # (n,) index among the bodies that act as walls, else -1


class Walls:
    """All walls of a velocity field on which fluids do not slip: shapes of supports, faces that supports hold, and bodies.

    faces: all supports, split so that each acts on at most one face; bodies: bodies that act as walls; active: axes along which
    the grid is more than one cell thick; periods: of the grid [m]; lower, upper: corners of the grid [m]; mirrors: as in
    `_mirrored`.
    """

    def __init__(
        self,
        faces: "Sequence[Support]",
        bodies: Sequence[WallMaker],
        active: ActiveAxes,
        periods: Vector,
        lower: np.ndarray,
        upper: np.ndarray,
        mirrors: np.ndarray,
    ) -> None:
        self._active, self._periods, self._ends, self._mirrors = active, periods, (lower, upper), mirrors
        whole = [one for one in faces if one.holds_all(active)]
        shapes = [(shape.geometry(), one.velocity) for one in whole if (shape := one.wall_of_fluids()) is not None]
        held = [
            (*face, one.velocity)
            for one in whole
            if (face := one.face()) is not None and one.body is None and one.until is None
        ]
        self._walls: list[tuple[Inside, Vector, int]] = [
            *((self._in_region(region), velocity, -1) for region, velocity in shapes),
            *((self._beyond_face(axis, end), velocity, -1) for axis, end, velocity in held),
            *((self._in_region(body.region), ZERO, number) for number, body in enumerate(bodies)),
        ]

    def find_opposite(self, start: np.ndarray, normal: np.ndarray, cell: float, most: float) -> Opposite:
        """Return the walls that lie opposite the surface of a wall, along its normals, within the distance `most` [m].
        start: positions on the surface [m], shape (n, 3); normal: unit normals, shape (n, 3); cell: cell size [m]."""
        gap, velocity, number = np.full(len(start), np.inf), np.zeros((len(start), 3)), np.full(len(start), -1)
        apart = cell / PER_CELL
        steps = np.arange(round(most / apart))
        at = start + steps[:, None, None] * apart * normal
        nearest = np.full(len(start), len(steps))
        for contains, moving, body in self._walls:
            inside = contains((at + apart * normal).reshape(-1, 3)).reshape(len(steps), -1)
            first = np.where(inside.any(axis=0), inside.argmax(axis=0), len(steps))
            new = np.flatnonzero(first < nearest)
            if not len(new):
                continue
            nearest[new] = first[new]
            beyond = find_distances(contains, at[first[new], new], -normal[new], apart)[0]
            # close to the surface rounding may place the start inside its own wall
            gap[new] = np.where(first[new] > 0, first[new] * apart + beyond, 0.0)
            velocity[new], number[new] = np.asarray(moving, float), body
        return Opposite(np.where(gap > 0.0, gap, np.inf), velocity, number)

    def _in_region(self, region: Space) -> Inside:
        return lambda place: within(region, _mirrored(place, *self._ends, self._mirrors)[0], self._active, self._periods)

    def _beyond_face(self, axis: int, end: int) -> Inside:
        def beyond(place: np.ndarray) -> np.ndarray:
            place = _mirrored(place, *self._ends, self._mirrors)[0]
            return np.asarray(place[:, axis] > self._ends[1][axis] if end else place[:, axis] < self._ends[0][axis])

        return beyond


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


def find_distances(contains: Inside, place: np.ndarray, normal: np.ndarray, most: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the signed distances of the positions `place` [m], shape (n, 3), from the surface of a region along given unit
    normals, shape (n, 3): in metres, positive outside. Also return a mask of the positions that have a surface within the
    distance `most` [m]. contains: function that returns which positions lie in the region."""
    inside = contains(place)
    sign = np.where(inside, 1.0, -1.0)
    low, high = np.zeros(len(place)), np.full(len(place), most)
    found = contains(place + (sign * high)[:, None] * normal) != inside
    for _ in range(PAIRS_OF_BISECTIONS):
        middle = 0.5 * (low + high)
        at = np.stack([0.5 * (low + middle), middle, 0.5 * (middle + high)])
        quarter, half, most_of = contains((place + (sign * at)[:, :, None] * normal).reshape(-1, 3)).reshape(at.shape) == inside
        low, high = (
            np.select([half & most_of, half, quarter], [at[2], middle, at[0]], low),
            np.select([half & most_of, half, quarter], [high, at[2], middle], at[0]),
        )
    return -sign * 0.5 * (low + high), found
