"""Motion of points with the nodal velocity, velocity increments of points, sums of momentum and energy over points,
and transfer of other vectors, such as forces, from points to nodes and from nodes to points.

The kernels receive a body as a bundle of `MappedPoints`.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.passes.moving import displacement
from pellucid.grid.points import KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, SPEED, place_of
from pellucid.grid.stencil import add_numbers, add_vector, gather, gather_gradient, halfway, stencil
from pellucid.grid.transfer_heat import spread_along
from pellucid.jit import kernel, point_function
from pellucid.jit.loops import joint_by_colour, parallel_loop, parallel_loop_by_colour


class ByNodes(NamedTuple):
    """Rule for `move_points`: each point moves by the nodal velocity interpolated to the point, times the step."""

    velocity: np.ndarray  # (nodes, 3) nodal velocity [m/s]
    curving: float  # 1 if points move along curved paths, see `pellucid.grid.straining`, else 0


@point_function(displacement, ByNodes)
def _with_nodes(rule, mapped, p, dt):
    about = stencil(mapped.functions, mapped.lattice, mapped.points.position, p)
    v = gather(about, mapped.lattice, rule.velocity)
    if rule.curving > 0.0:
        v = halfway(0.5 * dt, gather_gradient(about, mapped.lattice, rule.velocity), v)
    return dt * v[0], dt * v[1], dt * v[2]


@kernel(inner=True)
def _sum_slab(s, mapped):
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    v = points.velocity
    kinetic = px = py = pz = speed = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        m = points.mass[p]
        vv = v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2]
        kinetic += 0.5 * m * vv
        px += m * v[p, 0]
        py += m * v[p, 1]
        pz += m * v[p, 2]
        speed += m * sqrt(vv)
    slabs.sums[s, KINETIC] = kinetic
    slabs.sums[s, MOMENTUM_X] = px
    slabs.sums[s, MOMENTUM_Y] = py
    slabs.sums[s, MOMENTUM_Z] = pz
    slabs.sums[s, SPEED] = speed


@parallel_loop()
def add_increments(s, mapped, increment, reached):
    """Interpolate velocity increments of nodes [m/s], shape (nodes, 3), to the points of slab s (a block of grid cells),
    add them to the velocities of the points, and update kinetic energy and momentum of the slab, if `reached`, shape
    (slabs,), is True for s; mapped: the points (`MappedPoints`); increment: the increments."""
    if not reached[s]:
        return
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    v = points.velocity
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        change = gather(stencil(functions, lattice, points.position, p), lattice, increment)
        for d in range(3):
            v[p, d] += change[d]
    _sum_slab(s, mapped)


@kernel()
def sum_momentum(n, mapped):
    """Compute kinetic energy and momentum of the points of each of n slabs, in `Slabs.sums`, after velocities changed; mapped:
    the points (`MappedPoints`)."""
    joint_by_colour(_sum_slab, n, mapped.slabs.across, mapped)


@parallel_loop()
def sum_angular_momentum(s, mapped, affine, about, sums):
    """Compute the angular momentum Σ m (x - a) × v of the points of slab s (a block of grid cells) about a position a [m],
    `about`, shape (3,), and the magnitude Σ m |x - a| |v| [N m s].

    affine: APIC fields, shape (points, 10), which add Σ m N r × C r over the nodes at the distance r from the point;
    without rows for other transfers. Fills row s of `sums`, shape (slabs, 4). mapped: the points (`MappedPoints`).
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, v, slabs = mapped.points.position, mapped.points.velocity, mapped.slabs
    hx = hy = hz = size = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        m = mapped.points.mass[p]
        rx, ry, rz = x[p, 0] - about[0], x[p, 1] - about[1], x[p, 2] - about[2]
        hx += m * (ry * v[p, 2] - rz * v[p, 1])
        hy += m * (rz * v[p, 0] - rx * v[p, 2])
        hz += m * (rx * v[p, 1] - ry * v[p, 0])
        vv = v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2]
        size += m * sqrt((rx * rx + ry * ry + rz * rz) * vv)
        if len(affine) > 0:
            near, C = stencil(functions, lattice, x, p), affine[p]
            m *= lattice.cell * lattice.cell
            # Σ N r r is diagonal, since Σ w r is zero along each axis
            dx, dy = m * spread_along(near.offset[0], near.wx), m * spread_along(near.offset[1], near.wy)
            dz = m * spread_along(near.offset[2], near.wz)
            hx += dy * C[7] - dz * C[5]
            hy += dz * C[2] - dx * C[6]
            hz += dx * C[3] - dy * C[1]
    sums[s, 0], sums[s, 1], sums[s, 2], sums[s, 3] = hx, hy, hz, size


@parallel_loop_by_colour(gives="target")
def scatter_vectors(s, mapped, values, target):
    """Map vectors of points to nodes: add Σ N times the vectors of the points of slab s (see `Slabs`) to `target`, shape
    (nodes, 3).

    mapped: the points (`MappedPoints`); values: vectors of all points, shape (points, 3).
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = (values[p, 0], values[p, 1], values[p, 2])
        add_vector(stencil(functions, lattice, x, p), lattice, target, vector)


@parallel_loop_by_colour(gives="target")
def apply_mass_matrix(s, mapped, velocity, target):
    """Add Σ_J M_IJ v_J of the points of slab s (see `Slabs`), M_IJ = Σ_p m_p N_I N_J, to row I of `target` [kg m/s], shape
    (nodes, 3).

    mapped: the points (`MappedPoints`); velocity: velocities v of the nodes [m/s], shape (nodes, 3).
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about, m = stencil(functions, lattice, x, p), mapped.points.mass[p]
        v = gather(about, lattice, velocity)
        add_vector(about, lattice, target, (m * v[0], m * v[1], m * v[2]))


@parallel_loop_by_colour(gives="target")
def scatter_numbers(s, mapped, values, target):
    """As `scatter_vectors`, for three numbers of each point that are no components of a vector, such as masses."""
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        numbers = (values[p, 0], values[p, 1], values[p, 2])
        add_numbers(stencil(functions, lattice, x, p), lattice, target, numbers)


@kernel()
def scatter_listed_numbers(mapped, position, listed, values, target):
    """As `scatter_listed`, for three numbers of each point that are no components of a vector, such as masses."""
    functions, lattice = mapped.functions, mapped.lattice
    for e in range(len(listed)):
        numbers = (values[e, 0], values[e, 1], values[e, 2])
        add_numbers(stencil(functions, lattice, position, uintp(listed[e])), lattice, target, numbers)


@kernel()
def scatter_listed(mapped, position, listed, values, target):
    """Map vectors of m listed points to nodes: add Σ N times the vectors to `target`, shape (nodes, 3).

    mapped: grid and shape functions (`MappedPoints`); position: positions of all points [m], shape (points, 3); listed:
    numbers of the points, shape (m,); values: vectors of the listed points, shape (m, 3).
    """
    functions, lattice = mapped.functions, mapped.lattice
    for e in range(len(listed)):
        vector = (values[e, 0], values[e, 1], values[e, 2])
        add_vector(stencil(functions, lattice, position, uintp(listed[e])), lattice, target, vector)


@kernel()
def gather_listed(mapped, position, listed, nodal, target):
    """Interpolate nodal vectors, shape (nodes, 3), to m listed points, into `target`, shape (m, 3).

    mapped: grid and shape functions (`MappedPoints`); position: positions of all points [m], shape (points, 3); listed:
    numbers of the points, shape (m,).
    """
    for e in range(len(listed)):
        vector = gather(stencil(mapped.functions, mapped.lattice, position, uintp(listed[e])), mapped.lattice, nodal)
        for d in range(3):
            target[e, d] = vector[d]


@parallel_loop()
def gather_vectors(s, mapped, nodal, target):
    """Interpolate nodal vectors, shape (nodes, 3), to the points of slab s (see `Slabs`), into `target`, shape (points, 3);
    mapped: the points (`MappedPoints`)."""
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = gather(stencil(functions, lattice, x, p), lattice, nodal)
        for d in range(3):
            target[p, d] = vector[d]
