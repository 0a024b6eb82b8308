"""The Eulerian grid: the places of its nodes, and the nodal arrays of one velocity field."""

from typing import NamedTuple

import numpy as np

from pellucid.grid.model import GridCase
from pellucid.jit.kernels import LINE

PAD = 2  # one node more than cells, and one beyond the upper wall that spline stencils name with weight zero
LARGEST_STENCIL = 4


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
    """Nodal arrays of one velocity field; n nodes."""

    inertia: np.ndarray  # (4 n,) rows of momentum x, y, z and mass, as points give them to the nodes
    forces: np.ndarray  # (4 n,) rows of internal force x, y, z and nothing
    velocities: np.ndarray  # (4 n,) rows of `velocity` and a number without meaning,
    increments: np.ndarray  # (4 n,) of `velocity_increment` and `increment_energy`,
    strain_velocities: np.ndarray  # (4 n,) of `strain_velocity` and
    mean_velocities: np.ndarray  # (4 n,) `mean_velocity`, each with a number without meaning
    mass: np.ndarray  # (n,) [kg]; this and the next seven are views of the rows
    momentum: np.ndarray  # (n, 3) mapped from the points [kg m/s]
    force: np.ndarray  # (n, 3) internal force [N]
    velocity: np.ndarray  # (n, 3) at the end of the step; it moves the points [m/s]
    velocity_increment: np.ndarray  # (n, 3) over the step [m/s]; of a body with its own nodes, by contact alone
    strain_velocity: np.ndarray  # (n, 3) velocity whose gradient strains the points [m/s]
    mean_velocity: np.ndarray  # (n, 3) along which forces do work over the step [m/s]
    increment_energy: np.ndarray  # (n,) half the square of the velocity increment [J/kg]
    has_mass: np.ndarray  # (n,) of nodes that move points: 0 where there was none when the momentum was advanced last; the
    # rows of velocities and increments are zero there
    constrained: np.ndarray  # (n, 3) 0 where free, else 1 + the number of the support that constrains this direction


def aligned_rows(n: int) -> np.ndarray:
    """Rows of zeros, shape (n, 4), two to a line of the cache: a row that lies in two lines takes longer to add to."""
    row = 4 * np.dtype(float).itemsize
    memory = np.zeros(n * row + LINE, np.uint8)
    start = -memory.ctypes.data % LINE
    return memory[start : start + n * row].view(float).reshape(n, 4)


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
        inertia, forces, velocities, increments, strain_velocities, mean_velocities = (aligned_rows(n) for _ in range(6))
        self.nodes = Nodes(
            inertia=inertia.reshape(-1),
            forces=forces.reshape(-1),
            velocities=velocities.reshape(-1),
            increments=increments.reshape(-1),
            strain_velocities=strain_velocities.reshape(-1),
            mean_velocities=mean_velocities.reshape(-1),
            mass=inertia[:, 3],
            momentum=inertia[:, :3],
            force=forces[:, :3],
            velocity=velocities[:, :3],
            velocity_increment=increments[:, :3],
            strain_velocity=strain_velocities[:, :3],
            mean_velocity=mean_velocities[:, :3],
            increment_energy=increments[:, 3],
            has_mass=np.zeros(n, np.uint8),
            constrained=np.zeros((n, 3), np.int16),
        )

    def where(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of the nodes within the walls, shape (m,), and their positions [m], shape (m, 3).

        A thin axis has one node, which stands at its lower end.
        """
        nodes = tuple(1 if thin else n + 1 for n, thin in zip(self.lattice.counts, self.thin, strict=True))
        i, j, k = (axis.ravel() for axis in np.indices(nodes))
        s = self.lattice.strides
        position = np.stack((i, j, k), axis=1) * self.lattice.cell + np.array(self.lattice.lower)
        return i * s[0] + j * s[1] + k * s[2], position
