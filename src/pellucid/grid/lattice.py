"""The Eulerian grid: the places of its nodes, and the nodal arrays of one velocity field."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.approximants import GRID_FUNCTIONS
from pellucid.grid.model import GridCase
from pellucid.grid.nodal_fields import FOUND, REMAP, RUN, STEP, SUM, VECTOR, NodalField, View, allocate, rows

PAD = 2  # one node more than cells, and one beyond the upper wall that spline stencils name with weight zero
LARGEST_STENCIL = 4
MOST_ROWS = 64  # of slabs


def row_edges(layers: int, stencil: int, most: int) -> np.ndarray:
    """Where rows of slabs begin and the last ends, of so many layers of cells along an axis, shape (rows + 1,): as narrow as
    two colours allow, see `pellucid.grid.sorting.slabs_of`."""
    n = max(min(most, layers // (3 if stencil == 2 else 5)), 1)
    return -(-np.arange(n + 1) * layers // n)  # from a wide one on: threads end together then


class Lattice(NamedTuple):
    """The uniform grid as kernels take it. Node (i, j, k) is stored at i*strides[0] + j*strides[1] + k*strides[2]."""

    lower: tuple[float, float, float]
    cell: float
    inverse_cell: float
    counts: tuple[int, int, int]
    strides: tuple[int, int, int]
    slab_axis: int  # the slowest axis in memory; kernels share the work by slabs along it,
    cut_axis: int  # and cut these along the longest of the others


class Nodes(NamedTuple):
    """Nodal arrays of one velocity field; n nodes. A number of rows that no view shows has no meaning."""

    inertia: Annotated[np.ndarray, rows(SUM, STEP, "kg m/s, kg", "momentum and mass of the points")]
    forces: Annotated[np.ndarray, rows(SUM, STEP, "N", "internal forces of the points")]
    velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "at the end of the step")]
    increments: Annotated[np.ndarray, rows(FOUND, RUN, "m/s, J/kg", "of velocities and of what they are worth")]
    strain_velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "that strain the points")]
    mean_velocities: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "before and after the step")]
    mass: Annotated[np.ndarray, View("inertia", 3, "kg", "lumped mass $m_I$")]
    momentum: Annotated[np.ndarray, View("inertia", VECTOR, "kg m/s", "$\\mathbf p_I$, mapped from the points", REMAP)]
    force: Annotated[np.ndarray, View("forces", VECTOR, "N", "internal force $\\mathbf f_I$")]
    velocity: Annotated[np.ndarray, View("velocities", VECTOR, "m/s", "it moves the points")]
    velocity_increment: Annotated[
        np.ndarray, View("increments", VECTOR, "m/s", "over the step; of a body with its own nodes, by contact alone")
    ]
    strain_velocity: Annotated[np.ndarray, View("strain_velocities", VECTOR, "m/s", "its gradient strains the points")]
    mean_velocity: Annotated[np.ndarray, View("mean_velocities", VECTOR, "m/s", "along which forces do work over the step")]
    increment_energy: Annotated[np.ndarray, View("increments", 3, "J/kg", "half the square of the velocity increment")]
    has_mass: Annotated[
        np.ndarray,
        NodalField(
            1, FOUND, RUN, "", "of nodes that move points: 0 where there was no mass when momentum was advanced last", np.uint8
        ),
    ]  # the rows of velocities and increments are zero there
    constrained: Annotated[
        np.ndarray,
        NodalField(3, FOUND, RUN, "", "0 where free, else 1 + the number of the support along this axis", np.int16),
    ]


class Grid:
    """A uniform grid and its nodal arrays in one velocity field."""

    def __init__(self, case: GridCase) -> None:
        counts, thin = case.counts(), case.thin()
        slab_axis = int(np.argmax(counts))
        order = [slab_axis] + [axis for axis in range(3) if axis != slab_axis]
        strides = [0, 0, 0]
        n = 1
        for axis in reversed(order):
            strides[axis] = n
            n *= 1 if thin[axis] else max(counts[axis] + PAD, LARGEST_STENCIL)
        lower = tuple(float(value) for value in case.lower)
        self.lattice = Lattice(
            (lower[0], lower[1], lower[2]),
            case.cell,
            1.0 / case.cell,
            counts,
            (strides[0], strides[1], strides[2]),
            slab_axis,
            max(order[1:], key=lambda axis: counts[axis]),
        )
        self.thin = thin
        self.slice_thickness = case.slice_thickness()
        self.n_nodes = n
        self.cell_volume = case.cell ** (3 - sum(thin)) * self.slice_thickness ** sum(thin)
        self.volume = self.cell_volume * float(np.prod(counts))
        """Of the cells [m³], those of the slice where axes are thin."""
        self.nodes = allocate(Nodes, n)
        layer, last = strides[slab_axis], n // strides[slab_axis]
        rows = row_edges(counts[slab_axis], GRID_FUNCTIONS[case.functions](1).stencil, MOST_ROWS)
        self.rows = layer * np.append(rows[:-1], last)
        """The first node of each row of slabs, and behind the last."""

    def where(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of the nodes within the walls, shape (m,), and their positions [m], shape (m, 3).

        A thin axis has one node, which stands at its lower end.
        """
        nodes = tuple(1 if thin else n + 1 for n, thin in zip(self.lattice.counts, self.thin, strict=True))
        i, j, k = (axis.ravel() for axis in np.indices(nodes))
        s = self.lattice.strides
        position = np.stack((i, j, k), axis=1) * self.lattice.cell + np.array(self.lattice.lower)
        return i * s[0] + j * s[1] + k * s[2], position
