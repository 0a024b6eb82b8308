"""The Eulerian grid: positions of its nodes, and the nodal arrays of one velocity field."""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from pellucid.approximants import GRID_FUNCTIONS, NO_ENDS, Ends, GridFunctions, grid_functions
from pellucid.grid.folding import Folded, Mirrored, Walled
from pellucid.grid.model import GridCase
from pellucid.grid.nodal_fields import FOUND, OR, REMAP, RUN, STEP, SUM, VECTOR, NodalField, View, allocate, rows
from pellucid.jit import pointwise

PAD = 2  # nodes minus cells: one node at the end, and one beyond the upper wall, which splines list with weight zero
LARGEST_STENCIL = 4
BEYOND_PERIOD = LARGEST_STENCIL - 1  # stored nodes beyond the last one of a periodic axis, for stencils that cross the seam
MOST_ROWS = 64  # largest number of rows of slabs


def row_edges(layers: int, stencil: int, most: int, periodic: bool = False) -> np.ndarray:
    """Return the edges of rows of slabs (blocks of grid cells) along an axis as numbers of layers of cells, shape (rows +
    1,).

    layers: number of layers of cells along the axis; stencil: nodes of a shape function along the axis; most: largest
    number of rows. Rows are as narrow as possible if every other row is processed at the same time, see
    `pellucid.grid.sorting.slabs_of`. On a periodic axis the first row follows the last across the seam: the number of rows
    is then even, or one.
    """
    n = max(min(most, layers // (3 if stencil == 2 else 5)), 1)
    n -= n % 2 if periodic and n > 1 else 0
    return -(-np.arange(n + 1) * layers // n)  # from a wide one on: threads end together then


def layers_of(count: int, thin: bool, periodic: bool) -> int:
    """Return the number of layers of nodes that are stored along an axis with `count` cells; thin: True for an axis of a single
    cell; periodic: True for a periodic axis."""
    return 1 if thin else count + BEYOND_PERIOD if periodic else max(count + PAD, LARGEST_STENCIL)


def _folding(counts: Sequence[int], periodic: Sequence[bool], layers: Sequence[int], strides: Sequence[int]) -> Walled | Folded:
    """Return the table of the node within the period that is identical to each stored node (`Folded`), or `Walled` without
    periodic axes.

    The arguments have one entry for each axis. counts: number of cells; periodic: True if the axis is periodic; layers:
    number of stored layers of nodes; strides: difference of the storage indices of neighbouring nodes.
    """
    if not any(periodic):
        return Walled()
    along = [np.arange(m) % n if folds else np.arange(m) for m, n, folds in zip(layers, counts, periodic, strict=True)]
    here = [np.arange(m) for m in layers]
    stored, real = (
        np.add.outer(np.add.outer(strides[0] * x, strides[1] * y), strides[2] * z).ravel() for x, y, z in (here, along)
    )
    table = np.empty(len(stored), np.int64)
    table[stored] = real
    x, y, z = (float(n) if folds else np.inf for n, folds in zip(counts, periodic, strict=True))
    a, b, c = (n if folds else 0 for n, folds in zip(counts, periodic, strict=True))
    i, j, k = (n * stride if folds else 0 for n, stride, folds in zip(counts, strides, periodic, strict=True))
    return Folded(table, (x, y, z), (a, b, c), (i, j, k))


def _mirror(
    within: Walled | Folded,
    mirrored: Ends,
    counts: tuple[int, int, int],
    layers: Sequence[int],
    strides: Sequence[int],
    stencil: int,
) -> Mirrored:
    """Return the tables of nodes beyond planes of symmetry and of their mirror images.

    within: tables of the periodic axes; mirrored: ends of the axes that are planes; counts, layers, strides: see `_folding`;
    stencil: number of nodes of a shape function along an axis.
    """
    n, shift = int(np.prod(layers)), sum(stride for stride, (lower, _) in zip(strides, mirrored, strict=True) if lower)
    rows = np.arange(-shift, n)
    real, first = np.maximum(rows, 0), np.maximum(rows, 0)  # rows of numbers that no stencil has are not used
    sign, face = np.ones((len(rows), 4)), np.full((len(rows), 3), -1)
    # of the layers of an axis the last one has the same numbers as the layer beyond the lower face
    at = [np.arange(-1, m - 1) if lower else np.arange(m) for m, (lower, _) in zip(layers, mirrored, strict=True)]
    index = np.meshgrid(*at, indexing="ij")
    image, inner, planes = [], [], []
    for axis, (lower, upper) in enumerate(mirrored):
        i, count = index[axis], counts[axis]
        folded = np.where(lower & (i < 0), -i, i)
        image.append(np.where(upper & (i > count), 2 * count - i, folded))
        inner.append(np.maximum(i, 0))
        planes.append(np.where(i < 0, 0, count))

    def number(of: Sequence[np.ndarray]) -> np.ndarray:
        return np.sum([stride * i for stride, i in zip(strides, of, strict=True)], axis=0).ravel()

    row = number(index) + shift
    to_real = (lambda nodes: nodes) if isinstance(within, Walled) else (lambda nodes: within.real[nodes])
    real[row], first[row] = to_real(number(image)), number(inner)
    for axis in range(3):
        beyond = (image[axis] != index[axis]).ravel()
        at_face = number([planes[other] if other == axis else image[other] for other in range(3)])
        sign[row[beyond], axis], face[row[beyond], axis] = -1.0, to_real(at_face[beyond])
    ends = tuple((int(lower), int(upper)) for lower, upper in mirrored)
    beyond_any = np.asarray(np.any(face >= 0, axis=1), np.uint8)
    reaches, active = beyond_any.copy(), [m > 1 for m in layers]
    for steps in np.ndindex(*np.where(active, stencil, 1)):
        after = int(np.dot(steps, strides))
        reaches[: len(rows) - after] |= beyond_any[after:]
    ends = (ends[0], ends[1], ends[2])
    return Mirrored(within, shift, real, sign.ravel(), face, beyond_any, first, reaches, ends, counts)


class Lattice(NamedTuple):
    """Geometry of the uniform grid for kernels. Node (i, j, k) is stored at i*strides[0] + j*strides[1] + k*strides[2]."""

    lower: tuple[float, float, float]  # lower corner [m]
    cell: float  # edge of a cell [m]
    inverse_cell: float  # [1/m]
    counts: tuple[int, int, int]  # number of cells along x, y, z
    strides: tuple[int, int, int]  # difference of the storage indices of neighbouring nodes along x, y, z
    slab_axis: int  # slowest axis in memory, along which the grid is divided into slabs
    cut_axis: int  # longest other axis, along which slabs are cut
    folding: Any = Walled()  # `Walled`, `Folded` or `Mirrored`: nodes beyond the ends of axes, see `pellucid.grid.folding`


@pointwise
def without_images(lattice):
    """Return the lattice for stencils that contain no node beyond a plane of symmetry; lattice: with a `folding` of the type
    `Mirrored`."""
    of, folding = lattice, lattice.folding.within
    return Lattice(of.lower, of.cell, of.inverse_cell, of.counts, of.strides, of.slab_axis, of.cut_axis, folding)


class Nodes(NamedTuple):
    """Nodal arrays of one velocity field with n nodes: mass, momentum, forces, velocities and constraints. Components of a row
    that do not belong to any view are not used."""

    inertia: Annotated[np.ndarray, rows(SUM, STEP, "kg m/s, kg", "momentum and mass of the points")]
    forces: Annotated[np.ndarray, rows(SUM, STEP, "N", "internal forces of the points")]
    velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "nodal velocities at the end of the step")]
    increments: Annotated[
        np.ndarray, rows(FOUND, RUN, "m/s, J/kg", "velocity increments over the step, and half their squares")
    ]
    strain_velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "velocities whose gradients strain the points")]
    mean_velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "mean of the velocities before and after the step")]
    mass: Annotated[np.ndarray, View("inertia", 3, "kg", "lumped mass $m_I$")]
    momentum: Annotated[np.ndarray, View("inertia", VECTOR, "kg m/s", "momentum $\\mathbf p_I$, mapped from the points", REMAP)]
    force: Annotated[np.ndarray, View("forces", VECTOR, "N", "internal force $\\mathbf f_I$")]
    velocity: Annotated[
        np.ndarray, View("velocities", VECTOR, "m/s", "velocity at the end of the step, which moves the points")
    ]
    velocity_increment: Annotated[
        np.ndarray,
        View("increments", VECTOR, "m/s", "velocity increment over the step; for a body with its own nodes, by contact only"),
    ]
    strain_velocity: Annotated[
        np.ndarray, View("strain_velocities", VECTOR, "m/s", "velocity whose gradient strains the points")
    ]
    mean_velocity: Annotated[
        np.ndarray, View("mean_velocities", VECTOR, "m/s", "mean velocity, with which the work of forces is computed")
    ]
    increment_energy: Annotated[np.ndarray, View("increments", 3, "J/kg", "half the square of the velocity increment")]
    has_mass: Annotated[
        np.ndarray,
        NodalField(
            1,
            FOUND,
            RUN,
            "",
            "1 if the node had mass when momentum was last advanced, else 0; for nodes that move points",
            np.uint8,
        ),
    ]  # the rows of velocities and increments are zero there
    constrained: Annotated[
        np.ndarray,
        NodalField(3, FOUND, RUN, "", "0 if free along this axis, else 1 + the number of the support or of its face", np.int16),
    ]


class NodeFlags(NamedTuple):
    """Nodal flags, 0 or 1: nodes that may receive contact impulses, and nodes to which a body with its own nodes
    contributes."""

    awaiting: Annotated[
        np.ndarray, NodalField(1, FOUND, RUN, "", "1 if contact may exert an impulse on the node in this step", np.uint8)
    ]
    reached: Annotated[
        np.ndarray, NodalField(1, OR, STEP, "", "1 if the body with its own nodes contributes to the node", np.uint8)
    ]


class Grid:
    """A uniform grid and its nodal arrays (`nodes`) in one velocity field, built from the table [grid] of a case.

    mirrored: ends of the axes that are planes of symmetry, beyond which shape functions are mirrored.
    """

    def __init__(self, case: GridCase, mirrored: Ends = NO_ENDS) -> None:
        self.case, self.mirrored = case, mirrored
        counts, thin, periodic = case.counts(), case.thin(), case.is_periodic()
        # rows of slabs do not meet across a seam where an axis has walls
        walled = [axis for axis in range(3) if not (thin[axis] or periodic[axis])]
        slab_axis = max(walled or range(3), key=lambda axis: counts[axis])
        order = [slab_axis] + [axis for axis in range(3) if axis != slab_axis]
        strides, layers = [0, 0, 0], [layers_of(*axis) for axis in zip(counts, thin, periodic, strict=True)]
        for axis, (below, _) in enumerate(mirrored):
            layers[axis] += below  # for the numbers of nodes beyond the lower face
        n = 1
        for axis in reversed(order):
            strides[axis] = n
            n *= layers[axis]
        lower = tuple(float(value) for value in case.lower)
        stencil = GRID_FUNCTIONS[case.functions](1).stencil
        folding: Any = _folding(counts, periodic, layers, strides)
        if mirrored != NO_ENDS:
            folding = _mirror(folding, mirrored, counts, layers, strides, stencil)
        self.lattice = Lattice(
            (lower[0], lower[1], lower[2]),
            case.cell,
            1.0 / case.cell,
            counts,
            (strides[0], strides[1], strides[2]),
            slab_axis,
            max(order[1:], key=lambda axis: counts[axis]),
            folding,
        )
        self.layers = tuple(layers)
        """Number of layers of nodes that are stored along x, y, z."""
        self.thin, self.active_axes = thin, case.active_axes()
        self.periodic, self.periods = periodic, case.periods()
        self.slice_thickness = case.slice_thickness()
        self.n_nodes = n
        self.cell_volume = case.cell ** (3 - sum(thin)) * self.slice_thickness ** sum(thin)
        self.volume = self.cell_volume * float(np.prod(counts))
        """Total volume of the cells [m³]; for thin axes with the slice thickness."""
        self.nodes = allocate(Nodes, n)
        layer, last = strides[slab_axis], n // strides[slab_axis]
        rows = row_edges(counts[slab_axis], stencil, MOST_ROWS, periodic[slab_axis])
        self.rows = layer * np.append(rows[:-1], last)
        """First node of each row of slabs, and the end of the last row."""

    def functions(self, per_cell: tuple[int, int, int], name: str | None = None) -> GridFunctions:
        """Return the shape functions of the grid along x, y, z.

        per_cell: number of material points per cell along each axis; name: kind of shape function; default: that of the case.
        """
        return grid_functions(name or self.case.functions, per_cell, self.thin, self.periodic, self.mirrored)

    def real_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Return the storage indices of nodes, shape (m,). Indices beyond the last node of a periodic axis are mapped to the
        identical node."""
        folding = self.lattice.folding
        folding = folding.within if isinstance(folding, Mirrored) else folding
        return nodes if isinstance(folding, Walled) else folding.real[nodes]

    def find_passed_face(self, place: np.ndarray) -> tuple[str, float] | None:
        """Return the name of the face of the grid that a position beyond the face has crossed, and the velocity of the
        nodes of this face out of the grid [m/s].

        None if no support constrains the nodes of the face along its normal where it was crossed. place: position, shape
        (3,) [m].
        """
        cells = (place - np.array(self.lattice.lower)) * self.lattice.inverse_cell
        near = np.clip(np.rint(np.nan_to_num(cells)), 0, np.where(self.thin, 0, self.lattice.counts)).astype(np.int64)
        node = int(near @ np.array(self.lattice.strides))
        for axis, (at, count) in enumerate(zip(cells, self.lattice.counts, strict=True)):
            is_beyond = not (0.0 <= at <= count or self.thin[axis] or self.periodic[axis])
            if is_beyond and self.nodes.constrained[node, axis] > 0:
                velocity = float(self.nodes.velocity[node, axis])
                return (f"{'xyz'[axis]}-lower", -velocity) if at < 0.0 else (f"{'xyz'[axis]}-upper", velocity)
        return None

    def where(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the storage indices of the nodes within the walls, shape (m,), and their positions [m], shape (m, 3).

        A thin axis has a single node, located at its lower end. On a periodic axis the last node is identical to the first
        and omitted.
        """
        beyond = (0 if thin or periodic else 1 for thin, periodic in zip(self.thin, self.periodic, strict=True))
        nodes = tuple(n + more for n, more in zip(self.lattice.counts, beyond, strict=True))
        i, j, k = (axis.ravel() for axis in np.indices(nodes))
        s = self.lattice.strides
        position = np.stack((i, j, k), axis=1) * self.lattice.cell + np.array(self.lattice.lower)
        return i * s[0] + j * s[1] + k * s[2], position

    def find_positions(self, nodes: np.ndarray) -> np.ndarray:
        """Return the positions [m], shape (m, 3), of nodes within the walls from their storage indices, shape (m,)."""
        lattice, place, rest = self.lattice, np.empty((len(nodes), 3)), nodes
        for axis in [lattice.slab_axis, *(axis for axis in range(3) if axis != lattice.slab_axis)]:  # as they are stored
            number, rest = np.divmod(rest, lattice.strides[axis])
            place[:, axis] = number * lattice.cell + lattice.lower[axis]
        return place
