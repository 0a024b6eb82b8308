"""What the points of a block add to their nodes.

Linear functions have the same slopes at all points. So what a run, points with the same nodes, gives is summed first: of
momentum and mass a row for each node; of the stress a row for each line of nodes along an axis, by the products of the weights
across. Nodes are then added to once for the run. With other functions point after point adds.
"""

from typing import Any

from pellucid.approximants.axis import CurvedFunctions, LinearFunctions
from pellucid.grid.blocks import about_point, expect
from pellucid.grid.points import PRESSURE, cell_of, place_of
from pellucid.grid.stencil import add_inertia, add_internal_force, node_behind
from pellucid.grid.velocity_transfer import Apic, Blend, Flip, inertia_rows
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.columns import WIDTH, put, take
from pellucid.jit.point_rows import symmetric_at_point, vector_at_point
from pellucid.jit.products import moved, no_sums, outer, plus
from pellucid.jit.vector import LANES, load, row, store
from pellucid.tensors import NO_STRESS, ZERO_VECTOR

LINES, WEIGHTS = 8, 20
"""Columns of weights: of the nodes, eight at most; from LINES on of the lines of nodes along each axis, four at most."""


@generic
def add_block(functions: Any, mapped: Any, start: int, n: int, found: Any, first_node: Any, w: Any, what: Any) -> None:
    """Add to the nodes what n points give them; w: scratch of WEIGHTS columns.

    what: whether inertia, whether internal forces are added, and how often masses count, 0 or 1.
    """


@generic
def rows_at_nodes(transfer: Any, rows: Any, about: Any, cell: float) -> Any:
    """Of rows as `inertia_rows` gives them, those at the nodes: a row for each, or one for all."""


@pointwise
def _stress_columns(mapped, p):
    """The columns of the stress that acts at point p times -V [J], as rows of four: where cells are full, without the pressure,
    which acts there as a whole."""
    xx, yy, zz = symmetric_at_point(mapped.points.stress, p)
    if len(mapped.cells.found) > 0:
        pressure = mapped.cells.found[cell_of(mapped.lattice, mapped.points.position, p), PRESSURE]
        xx += row(pressure, 0.0, 0.0, 0.0)
        yy += row(0.0, pressure, 0.0, 0.0)
        zz += row(0.0, 0.0, pressure, 0.0)
    V = -mapped.points.volume[p]
    taken = row(V, V, V, 0.0)
    return taken * xx, taken * yy, taken * zz


@pointwise
def _rows_of(transfer, mapped, p, counted):
    v = vector_at_point(mapped.points.velocity, p)
    return inertia_rows(transfer, mapped.points.mass[p], v, mapped.affine, p, counted)


@pointwise
def _ends_run(first_node, q, n):
    """Whether point q of n points is the last of those that share its nodes."""
    return q + 1 == n or first_node[q + 1] != first_node[q]


@point_function(rows_at_nodes, Flip)
@point_function(rows_at_nodes, Blend)
def _one_for_all(transfer, rows, about, cell):
    return rows


@point_function(rows_at_nodes, Apic)
def _by_distance(transfer, rows, about, cell):
    x, y, z = cell * rows[1], cell * rows[2], cell * rows[3]
    first = rows[0] + about.offset[0] * x + about.offset[1] * y + about.offset[2] * z
    return moved(moved(moved((first,), about.wz, z), about.wy, y), about.wx, x)


@point_function(add_block, CurvedFunctions)
def _add_points(functions, mapped, start, n, found, first_node, w, what):
    lattice, nodes, (inertia, force, counted) = mapped.lattice, mapped.nodes, what
    for q in range(n):
        p = place_of(mapped.index, start + q)
        about = about_point(functions, found, first_node, q)
        if inertia:
            add_inertia(about, lattice, nodes.inertia, mapped.transfer, _rows_of(mapped.transfer, mapped, p, counted))
        if force:
            add_internal_force(about, lattice, nodes.forces, _stress_columns(mapped, p))


@point_function(add_block, LinearFunctions)
def _add_runs(functions, mapped, start, n, found, first_node, w, what):
    inertia, force, counted = what
    for q in range(n):
        at = about_point(functions, found, first_node, q)
        across = outer(at.wy, at.wz)
        put(w, q, outer(at.wx, across))
        if force:
            put(w, q + LINES * WIDTH, (across, outer(at.wx, at.wz), outer(at.wx, at.wy)))
    if inertia:
        _add_inertia_of_runs(mapped, start, n, found, first_node, w, counted)
    if force:
        _add_forces_of_runs(mapped, start, n, found, first_node, w)


@pointwise
def _add_inertia_of_runs(mapped, start, n, found, first_node, w, counted):
    """Add momentum and mass of the n points of a block."""
    lattice, inertia = mapped.lattice, mapped.nodes.inertia
    about = about_point(mapped.functions, found, first_node, 0)
    wx, wy, wz = about.wx, about.wy, about.wz
    weights = outer(wx, outer(wy, wz))
    sums = no_sums(weights)
    for q in range(n):
        rows = _rows_of(mapped.transfer, mapped, place_of(mapped.index, start + q), counted)
        at_nodes = rows_at_nodes(mapped.transfer, rows, about_point(mapped.functions, found, first_node, q), lattice.cell)
        sums = plus(sums, take(weights, w, q), at_nodes)
        if q % LANES == 0:
            points = mapped.points
            expect(mapped.index, (ZERO_VECTOR, ZERO_VECTOR, 0.0), (points.position, points.velocity, points.mass), start + q)
        if _ends_run(first_node, q, n):
            for i in range(len(wx)):
                for j in range(len(wy)):
                    for k in range(len(wz)):
                        I = 4 * node_behind(lattice, first_node[q], i, j, k)
                        store(inertia, I, load(inertia, I) + sums[(i * len(wy) + j) * len(wz) + k])
            sums = no_sums(weights)


@pointwise
def _add_forces_of_runs(mapped, start, n, found, first_node, w):
    """Add -Σ V σ ∇N of the n points of a block."""
    lattice, forces = mapped.lattice, mapped.nodes.forces
    about = about_point(mapped.functions, found, first_node, 0)
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    of_x, of_y, of_z = outer(wy, wz), outer(wx, wz), outer(wx, wy)
    x, y, z = no_sums(of_x), no_sums(of_y), no_sums(of_z)
    for q in range(n):
        sx, sy, sz = _stress_columns(mapped, place_of(mapped.index, start + q))
        along_x, along_y, along_z = take((of_x, of_y, of_z), w, q + LINES * WIDTH)
        x, y, z = plus(x, along_x, sx), plus(y, along_y, sy), plus(z, along_z, sz)
        if q % LANES == 0:
            expect(mapped.index, (0.0, NO_STRESS), (mapped.points.volume, mapped.points.stress), start + q)
        if _ends_run(first_node, q, n):
            for i in range(len(wx)):
                for j in range(len(wy)):
                    for k in range(len(wz)):
                        I = 4 * node_behind(lattice, first_node[q], i, j, k)
                        along = gx[i] * x[j * len(wz) + k] + gy[j] * y[i * len(wz) + k] + gz[k] * z[i * len(wy) + j]
                        store(forces, I, load(forces, I) + lattice.inverse_cell * along)
            x, y, z = no_sums(of_x), no_sums(of_y), no_sums(of_z)
