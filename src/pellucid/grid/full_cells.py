"""Mean pressure of cells that are full of fluid, integrated over the cell instead of summed over its points.

After points p with the volumes V_p at x_p have moved, Σ_p V_p ∇N_I(x_p) differs from zero at nodes where the integral of the
shape function, ∫∇N_I dV, is zero. In a fluid under an ambient pressure this error causes eddies of a few cells: the spurious
forces are the pressure times this sum, and the volumes of the points, which grow by Σ_p V_p ∇·v(x_p) with the velocity v,
drift from the volumes of their cells (on such errors: Steffen, Kirby & Berzins 2008, Int. J. Numer. Methods Eng. 76, 922;
Baumgarten & Kamrin 2023, Int. J. Numer. Methods Eng. 124, 2589). Therefore, in a full cell c, with the pressures p_p and
stresses σ_p of its points and the sum Q_c of their volumes, the mean pressure p_c and the forces f_I of its nodes are

    p_c = Σ V_p p_p / Q_c,    f_I = -Σ_p V_p (σ_p + p_c I)·∇N_I(x_p) + p_c ∫_c ∇N_I dV,

and, by virtual work, the relative volume growth rate of each of its points is shifted by κ_c = (D_c - Σ V_p ∇·v(x_p))/Q_c
with D_c = Σ_I v_I·∫_c ∇N_I dV, so that the volume of the points grows with the cell. Then the work of the pressures of the
points on their volumes equals the work of the forces. Forces keep momentum, since Σ_I ∇N_I = 0; a uniform pressure causes
no force within the fluid, and the correct force at its edge, where cells are partly filled and points are summed as usual.
D_c and κ_c use the mean velocity of the step, along which forces do work. USF strains the points before this velocity is
known, so volumes are not shifted with USF.

Implicit pressure (`pellucid.grid.implicit_viscosity`). In long steps single points with their own ∇·v(x_p) would integrate
divergences that the nodes do not resist. Therefore all points of a full cell grow at the rate D_c/W_c of the cell and of its
holes, with their volume W_c, and their pressure changes by -K_c Δt D_c/W_c, where K_c is the mean of ρc² over their volumes.
(W_c instead of Q_c: a single point in a cell of strong flow would grow many times too fast.) The forces of this change are
its integral over the cell, as those of p_c. The points exert no other pressures: forces of p_p - p_c would do work along
divergences that change no volume, and stir a liquid under gravity. This is the projected divergence of finite elements (B-bar:
Hughes 1980, Int. J. Numer. Methods Eng. 15, 1413), with one value in each cell.

A cell is full if it contains points and each cell around it contains points or is a hole. A hole is a cell without points
whose face neighbours all have points; in 2-D and 3-D one face neighbour may be empty. A hole belongs to the face neighbour
with the largest volume of points and has its pressure. A cell is identified by the storage index of its first node.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from pellucid.approximants import GridFunctions, PeriodicAxis
from pellucid.approximants.grid_functions import axis_weights
from pellucid.grid.clearing import Clearing
from pellucid.grid.folding import add_to_number, cell_in_period, cells_beyond, component_at
from pellucid.grid.lattice import Grid, Lattice
from pellucid.grid.nodal_fields import STEP, allocate
from pellucid.grid.points import (
    GAINED,
    GROWTH,
    PRESSURE,
    PRESSURE_CHANGE,
    PRESSURES,
    RATES,
    SHIFT,
    STIFFNESSES,
    VOLUMES,
    FullCells,
    GrowingCells,
    cell_of,
    place_of,
    pressure_of,
)
from pellucid.grid.stencil import number_behind
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_by_colour, parallel_loop, parallel_loop_by_colour
from pellucid.materials.contract import ImplicitStress
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import StepPart

PARTS = 120  # a multiple of 2, 3, 4 and 5: functions averaged over such a fraction of a cell have kinks at ends of parts only
"""Number of parts of a cell for the integration, each by two-point Gauss quadrature (exact for cubics)."""
NEAR = 5  # distance from a wall [cells], beyond which the integrals are the same in all cells


class AxisIntegrals(NamedTuple):
    """Values and derivatives of the shape functions along an axis, integrated over each of its n cells in the coordinate u
    [cells]; w nodes have functions that are not zero in a cell."""

    first: np.ndarray  # (n,) first node whose function is not zero in each cell; -1 beyond a plane of symmetry
    value: np.ndarray  # (n, w) ∫ N du
    slope: np.ndarray  # (n, w) ∫ N' du


def axis_integrals(function: Any, n: int) -> AxisIntegrals:
    """Compute the integrals of a shape function along an axis, and of its derivative, over each of its n cells; function: see
    `pellucid.approximants.grid_functions.GridFunction`."""
    if isinstance(function, PeriodicAxis):
        far = axis_integrals(function.function, 2 * NEAR + 1)  # of which the middle knows of no wall
        starts = (np.arange(n) + far.first[NEAR] - NEAR) % n
        return AxisIntegrals(starts, *(np.tile(of[NEAR], (n, 1)) for of in (far.value, far.slope)))
    cells = min(n, 2 * NEAR + 1)
    value, slope = np.zeros((2, cells, cells + 5))  # the first column is of a node beyond a plane of symmetry
    gauss = (0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)) / PARTS
    for cell in range(cells):
        for u in (cell + np.arange(PARTS)[:, None] / PARTS + gauss).ravel():
            first, w, _ = axis_weights(function, u, cells)
            value[cell, first + 1 : first + 1 + len(w)] += 0.5 / PARTS * np.array(w)
        for u, sign in ((float(cell), -1.0), (cell + 1.0, 1.0)):
            first, w, _ = axis_weights(function, u, cells)
            slope[cell, first + 1 : first + 1 + len(w)] += sign * np.array(w)
    reached = (value != 0.0) | (slope != 0.0)
    start = reached.argmax(axis=1)
    width = max(np.flatnonzero(row)[-1] + 1 - at for row, at in zip(reached, start, strict=True))
    columns = start[:, None] + np.arange(width)
    number = np.arange(n)
    like = np.where(number < n - NEAR, np.minimum(number, NEAR), number - n + cells) if n > cells else number
    value, slope = (np.take_along_axis(table, columns, axis=1)[like] for table in (value, slope))
    return AxisIntegrals(start[like] - 1 + number - like, value, slope)


LAYERS = 6  # layers of cells in a chunk: a cell with its holes exerts forces on nodes up to three nodes beyond it


class CellGrid(NamedTuple):
    """Arguments of the kernels that average the pressure in full cells (cells that a fluid fills): the cells, with the sums
    over their points, and the nodes of the grid."""

    lattice: Lattice  # geometry of the grid
    cells: FullCells  # sums and mean values of each cell
    along: tuple[AxisIntegrals, AxisIntegrals, AxisIntegrals]  # integrals of the shape functions over cells
    volume: float  # volume of a cell [m³]; for thin axes with the slice thickness
    edges: np.ndarray  # (chunks + 1,) first layer of each chunk, and the end of the last


@parallel_loop_by_colour(gives="sums")
def sum_cells(s, mapped, stiffness, sums):
    """Add the volume of each point of slab s (see `Slabs`), and its pressure and the stiffness ρc² of an implicit pressure
    [Pa], both times volume, to the sums of the grid cell that contains it.

    mapped: the points (`MappedPoints`); sums: sums over the points of each cell, see `FullCells.sums`.
    """
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        cell, V = cell_of(mapped.lattice, points.position, p), points.volume[p]
        sums[cell, VOLUMES] += V
        sums[cell, PRESSURES] += V * pressure_of(points.stress, p)
        sums[cell, STIFFNESSES] += V * stiffness


@parallel_loop()
def apply_volume_correction(s, mapped, found, column, energy, dt):
    """Correct the specific internal energy `energy` [J/kg], shape (points,), of the points of slab s (a block of grid
    cells): subtract the work of each point's pressure on the volume growth over the step dt [s] that the point lacks
    compared with its full cell (a cell that the fluid fills). Stores the energy gained by the slab in the column GAINED of
    `Slabs.sums` [J].

    mapped: the points (`MappedPoints`); found: values of each cell, see `FullCells.found`.
    """
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    gained = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        shift = found[cell_of(mapped.lattice, points.position, p), column]
        more = -dt * points.volume[p] * pressure_of(points.stress, p) * shift
        energy[p] += more / points.mass[p]
        gained += more
    slabs.sums[s, GAINED] = gained


@pointwise
def _cells_of(chunk, grid):
    """Return the number of cells in a chunk (a range of layers of cells, see `CellGrid.edges`); grid: `CellGrid`."""
    n, axis = grid.lattice.counts, grid.lattice.slab_axis
    return (grid.edges[chunk + 1] - grid.edges[chunk]) * (n[0] * n[1] * n[2] // n[axis])


@pointwise
def _cell_at(chunk, number, grid):
    """Return the indices i, j, k and the storage index of the cell with this number within a chunk (counted layer by layer);
    grid: `CellGrid`."""
    n, stride, axis = grid.lattice.counts, grid.lattice.strides, grid.lattice.slab_axis
    second, third = (1 if axis == 0 else 0), (1 if axis == 2 else 2)
    layer, rest = grid.edges[chunk] + number // (n[second] * n[third]), number % (n[second] * n[third])
    l, m = rest // n[third], rest % n[third]
    i, j, k = (layer, l, m) if axis == 0 else ((l, layer, m) if axis == 1 else (l, m, layer))
    return i, j, k, i * stride[0] + j * stride[1] + k * stride[2]


@pointwise
def _volume(grid, i, j, k):
    """Return the volume of the points in the cell (i, j, k) [m³]; -1 beyond the walls; grid: `CellGrid`."""
    n, stride = grid.lattice.counts, grid.lattice.strides
    i, j, k = _in_grid(grid, i, j, k)
    if i < 0 or j < 0 or k < 0 or i >= n[0] or j >= n[1] or k >= n[2]:
        return -1.0
    return grid.cells.sums[i * stride[0] + j * stride[1] + k * stride[2], VOLUMES]


@pointwise
def _beside(grid, i, j, k, face):
    """Return the indices of the neighbour of cell (i, j, k) across a face: 0, 1 at the lower and upper end along x, 2, 3 along
    y, 4, 5 along z."""
    step = 1 if face % 2 == 1 else -1
    axis = face // 2
    return i + (step if axis == 0 else 0), j + (step if axis == 1 else 0), k + (step if axis == 2 else 0)


@pointwise
def _is_hole(grid, i, j, k):
    """Return True if the empty cell (i, j, k) is a hole inside the fluid, i.e. at most one of its face neighbours is empty
    (none in 1-D); grid: `CellGrid`."""
    n, empty = grid.lattice.counts, 0
    for face in range(6):
        a, b, c = _beside(grid, i, j, k, face)
        empty += 1 if _volume(grid, a, b, c) == 0.0 else 0
    longest = max(n[0], n[1], n[2])
    return empty == 0 or (empty == 1 and n[0] * n[1] * n[2] > longest)


@pointwise
def _owner(grid, i, j, k):
    """Return the face, 0 to 5, of the hole (i, j, k) beyond which the neighbour with the largest volume of points lies; if
    several are equal, the first; grid: `CellGrid`."""
    most, owner = 0.0, 0
    for face in range(6):
        a, b, c = _beside(grid, i, j, k, face)
        volume = _volume(grid, a, b, c)
        if volume > most:
            most, owner = volume, face
    return owner


@pointwise
def _owns(grid, i, j, k, face):
    """Return True if the neighbour of cell (i, j, k) across a face, 0 to 5, is a hole (an empty cell inside the fluid) that
    belongs to this cell; grid: `CellGrid`."""
    a, b, c = _beside(grid, i, j, k, face)
    if _volume(grid, a, b, c) != 0.0 or not _is_hole(grid, a, b, c):
        return False
    return _owner(grid, a, b, c) == (face + 1 if face % 2 == 0 else face - 1)


@pointwise
def _is_full(grid, i, j, k):
    """Return True if the cell (i, j, k), which contains points, is full: every cell around it contains points or is a hole (an
    empty cell inside the fluid). grid: `CellGrid`."""
    n, folding = grid.lattice.counts, grid.lattice.folding
    x, y, z = cells_beyond(folding, 0), cells_beyond(folding, 1), cells_beyond(folding, 2)
    for a in range(max(i - 1, -x), min(i + 2, n[0] + x)):
        for b in range(max(j - 1, -y), min(j + 2, n[1] + y)):
            for c in range(max(k - 1, -z), min(k + 2, n[2] + z)):
                if _volume(grid, a, b, c) == 0.0 and not _is_hole(grid, a, b, c):
                    return False
    return True


@pointwise
def _in_grid(grid, i, j, k):
    """Return the indices of cell (i, j, k), folded into the box along periodic axes; grid: `CellGrid`."""
    folding = grid.lattice.folding
    return cell_in_period(folding, 0, i), cell_in_period(folding, 1, j), cell_in_period(folding, 2, k)


@pointwise
def _first_node(grid, i, j, k):
    """Return the storage index of the lowest node whose shape function is not zero in the cell (i, j, k); grid: `CellGrid`."""
    (x, y, z), stride = grid.along, grid.lattice.strides
    return x.first[i] * stride[0] + y.first[j] * stride[1] + z.first[k] * stride[2]


@pointwise
def _add_force(grid, i, j, k, pressure, forces):
    """Add the force of a pressure [Pa] in the cell (i, j, k), the pressure times ∫∇N dV, to the forces of its nodes [N], shape
    (4 nodes,); grid: `CellGrid`."""
    (x, y, z), folding, scale = grid.along, grid.lattice.folding, grid.volume * grid.lattice.inverse_cell * pressure
    i, j, k = _in_grid(grid, i, j, k)
    first = _first_node(grid, i, j, k)
    for a in range(x.value.shape[1]):
        for b in range(y.value.shape[1]):
            in_x, in_y = scale * x.slope[i, a] * y.value[j, b], scale * x.value[i, a] * y.slope[j, b]
            in_z = scale * x.value[i, a] * y.value[j, b]
            for c in range(z.value.shape[1]):
                I = number_behind(grid.lattice, first, a, b, c)
                add_to_number(folding, forces, I, 0, in_x * z.value[k, c])
                add_to_number(folding, forces, I, 1, in_y * z.value[k, c])
                add_to_number(folding, forces, I, 2, in_z * z.slope[k, c])


@pointwise
def _flow(grid, i, j, k, v):
    """Return ∫∇·v dV over the cell (i, j, k) [m³/s] for nodal velocities v [m/s], shape (nodes, 3) or with more columns; grid:
    `CellGrid`."""
    (x, y, z), total, folding = grid.along, 0.0, grid.lattice.folding
    i, j, k = _in_grid(grid, i, j, k)
    first = _first_node(grid, i, j, k)
    for a in range(x.value.shape[1]):
        for b in range(y.value.shape[1]):
            in_x, in_y = x.slope[i, a] * y.value[j, b], x.value[i, a] * y.slope[j, b]
            in_z = x.value[i, a] * y.value[j, b]
            for c in range(z.value.shape[1]):
                I = number_behind(grid.lattice, first, a, b, c)
                across = in_x * component_at(folding, v, I, 0) + in_y * component_at(folding, v, I, 1)
                total += z.value[k, c] * across + z.slope[k, c] * in_z * component_at(folding, v, I, 2)
    return grid.volume * grid.lattice.inverse_cell * total


@pointwise
def _push(grid, i, j, k, pressure, forces):
    """Add the forces of a pressure [Pa] in the full cell (a cell that the fluid fills) with the indices i, j, k, and in the
    holes (empty cells inside the fluid) that belong to it, to the forces of the nodes [N], shape (4 nodes,); grid:
    `CellGrid`."""
    _add_force(grid, i, j, k, pressure, forces)
    for face in range(6):
        if _owns(grid, i, j, k, face):
            a, b, c = _beside(grid, i, j, k, face)
            _add_force(grid, a, b, c, pressure, forces)


@pointwise
def _outflow(grid, i, j, k, v):
    """Return ∫∇·v dV [m³/s] over the full cell (a cell that the fluid fills) with the indices i, j, k and over the holes (empty
    cells inside the fluid) that belong to it, and the volume of all [m³]; v: nodal velocities [m/s], shape (nodes, 3) or with
    more columns; grid: `CellGrid`."""
    flow, whole = _flow(grid, i, j, k, v), grid.volume
    for face in range(6):
        if _owns(grid, i, j, k, face):
            a, b, c = _beside(grid, i, j, k, face)
            flow += _flow(grid, a, b, c, v)
            whole += grid.volume
    return flow, whole


@kernel(inner=True)
def _push_chunk(chunk, grid, forces):
    cells = grid.cells
    for number in range(_cells_of(chunk, grid)):
        i, j, k, cell = _cell_at(chunk, number, grid)
        cells.full[cell] = cells.sums[cell, VOLUMES] > 0.0 and _is_full(grid, i, j, k)
        if cells.full[cell]:
            pressure = cells.sums[cell, PRESSURES] / cells.sums[cell, VOLUMES]
            cells.found[cell, PRESSURE] = pressure
            _push(grid, i, j, k, pressure, forces)


@kernel()
def _find_and_push_cells(chunks, grid, forces):
    """Find the full cells (cells that a fluid fills) and add the forces of their mean pressures to the nodal forces [N], shape
    (4 nodes,), before P2G of internal forces.

    chunks: number of chunks (ranges of layers of cells); grid: `CellGrid`.
    """
    parallel_by_colour(_push_chunk, chunks, 1, grid, forces)


@parallel_loop()
def _grow_cells(chunk, grid, v, as_space):
    """Compute the relative volume growth rates [1/s] of the full cells (cells that a fluid fills) of a chunk from nodal
    velocities v [m/s], shape (nodes, 3): of their space if `as_space`, else of the volume of their points. grid: `CellGrid`."""
    cells = grid.cells
    for number in range(_cells_of(chunk, grid)):
        i, j, k, cell = _cell_at(chunk, number, grid)
        if cells.full[cell]:
            flow, whole = _outflow(grid, i, j, k, v)
            cells.found[cell, GROWTH] = flow / (whole if as_space else cells.sums[cell, VOLUMES])


@kernel(inner=True)
def _press_chunk(chunk, grid, v, dt, forces, powers):
    cells, power = grid.cells, 0.0
    for number in range(_cells_of(chunk, grid)):
        i, j, k, cell = _cell_at(chunk, number, grid)
        if cells.full[cell]:
            flow, whole = _outflow(grid, i, j, k, v)
            change = -dt * cells.sums[cell, STIFFNESSES] / cells.sums[cell, VOLUMES] * flow / whole
            cells.found[cell, PRESSURE_CHANGE] = change
            power -= change * flow
            _push(grid, i, j, k, change, forces)
    powers[chunk, 0] = power


@kernel()
def _press_cells(chunks, grid, v, dt, forces, powers):
    """Compute the change of the implicit pressure in full cells (cells that a fluid fills) over a time dt [s], for nodal
    velocities v [m/s], shape (nodes, 4), and add its forces to nodal forces [N], shape (4 nodes,). powers: power [W] that the
    change takes from the nodes, in each chunk, shape (chunks, 1).

    chunks: number of chunks (ranges of layers of cells); grid: `CellGrid`.
    """
    parallel_by_colour(_press_chunk, chunks, 1, grid, v, dt, forces, powers)


def _chunk_edges(grid: Grid) -> np.ndarray:
    """Return the first layer of each chunk of cells along the axis of the slabs (blocks of grid cells), and the end of the
    last. On a periodic axis the first chunk follows the last across the seam, so the number of chunks is even or 1."""
    axis = grid.lattice.slab_axis
    n = grid.lattice.counts[axis]
    if not grid.periodic[axis]:
        return np.append(np.arange(0, n, LAYERS), n)
    chunks = max(n // LAYERS, 1)
    chunks -= chunks % 2 if chunks > 1 else 0
    return np.arange(chunks + 1) * n // chunks


class Filling(Protocol):
    """Interface of a fluid body whose points get the mean pressure of their full cell (a cell that the fluid fills);
    `CellPressure` reads these members and calls these methods."""

    functions: GridFunctions  # shape functions along x, y, z
    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`

    @property
    def fills_cells(self) -> bool:
        """True if the points get the mean pressure of their full cell."""

    @property
    def implicit_stress(self) -> ImplicitStress:
        """Parameters of the stress that is solved for; all zero without such a stress."""

    @property
    def nodal_forces(self) -> np.ndarray: ...
    def share_cells(self, cells: FullCells | GrowingCells) -> None: ...
    def apply_volume_correction(self, dt: float) -> None: ...


class CellPressure(StepPart):
    """Computes, for the fluid bodies of one velocity field, the mean pressures of full cells (cells that the fluid fills),
    their forces on the nodes, and the volume growth of the points in these cells; see `pellucid.grid.full_cells`."""

    def __init__(self, grid: Grid, bodies: Sequence[Filling]) -> None:
        functions = bodies[0].functions
        self.cells = allocate(FullCells, grid.n_nodes)
        self._clear = Clearing(STEP, grid.rows, self.cells)
        x, y, z = (axis_integrals(fn, count) for fn, count in zip(functions, grid.lattice.counts, strict=True))
        edges = _chunk_edges(grid)
        self._grid = Bundle(CellGrid(grid.lattice, self.cells, (x, y, z), grid.cell_volume, edges))
        self._nodes, self._powers, self._bodies = grid.nodes, np.zeros((len(edges) - 1, 1)), bodies
        self._implicit = any(body.implicit_stress.stiffness > 0.0 for body in bodies)
        for body in bodies:
            body.share_cells(GrowingCells(self.cells) if self._implicit else self.cells)

    def clear_nodes(self) -> None:
        """Reset the sums over the points of each cell (volume, pressure times volume, growth rate of the volume) to zero
        before a step."""
        self._clear()

    def before_forces(self) -> None:
        """Find full cells (cells that the fluid fills), compute their mean pressures [Pa], and add the forces of these
        pressures to the nodes."""
        for body in self._bodies:
            sum_cells(body.n_slabs, body.mapped, body.implicit_stress.stiffness, self.cells.sums)
        domain.spread(self.cells.sums)  # cells push nodes that their points do not reach
        _find_and_push_cells(len(self._powers), self._grid, self._bodies[0].nodal_forces)

    def after_momentum(self) -> None:
        """Compute the relative volume growth rates [1/s] of full cells (cells that the fluid fills) from the mean nodal
        velocities."""
        self._grow(self._nodes.mean_velocity, as_space=False)

    def _grow(self, velocity: np.ndarray, as_space: bool) -> None:
        domain.spread(velocity)
        _grow_cells(len(self._powers), self._grid, velocity, as_space)

    def press(self, velocity: np.ndarray, dt: float, forces: np.ndarray) -> float:
        """Compute the change of the implicit pressure in full cells (cells that the fluid fills) over a time dt [s], and add
        its forces to nodal forces [N], shape (4 nodes,); return the power [W] that it takes from the nodes.

        velocity: nodal velocities [m/s], in rows of four numbers, shape (4 nodes,).
        """
        rows = velocity.reshape(-1, 4)
        domain.spread(rows)
        _press_cells(len(self._powers), self._grid, rows, dt, forces, self._powers)
        return float(ordered_sum(self._powers)[0])

    def before_stress(self, dt: float) -> None:
        """Compute the relative volume growth rate [1/s] that the points of each full cell (a cell that the fluid fills)
        lack compared with the cell, in the column SHIFT of `FullCells.found`, and add the work of this growth over the step
        dt [s] to the energy of the points. Called after the growth rates of the points are summed."""
        if not self._implicit:
            sums, found, full = self.cells.sums, self.cells.found, self.cells.full
            np.divide(sums[:, RATES], sums[:, VOLUMES], out=found[:, SHIFT], where=full)
            np.subtract(found[:, GROWTH], found[:, SHIFT], out=found[:, SHIFT])
        for body in self._bodies:
            body.apply_volume_correction(dt)
        if self._implicit:
            self._grow(self._nodes.strain_velocity, as_space=True)


def cell_pressures(field: VelocityField, bodies: Iterable[Any]) -> list[CellPressure]:
    """Return the parts that compute mean pressures of full cells (cells that a fluid fills) in a velocity field; one part
    serves all fluids with the same nodal forces and shape functions. bodies: all bodies of the field on the grid."""
    groups: dict[tuple[GridFunctions, int], list[Filling]] = {}
    for fluid in bodies:
        if getattr(fluid, "fills_cells", False):
            groups.setdefault((fluid.functions, fluid.nodal_forces.ctypes.data), []).append(fluid)
    return [CellPressure(field.grid, fluids) for fluids in groups.values()]
