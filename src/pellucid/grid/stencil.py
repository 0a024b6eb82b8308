"""Nodes around a point, their shape functions and derivatives at the point, and sums over these nodes.

Functions named `gather...` sum nodal values at a point; functions named `add...` add values of a point to its nodes. Sums
over tensor products are evaluated line by line (along z) where this halves the work of the plain triple loop. Indices are
unsigned, so numba need not check for negative indices.
"""

from typing import Any, NamedTuple

from pellucid.approximants.grid_functions import axis_numbers, axis_values
from pellucid.grid.folded_rows import row_at
from pellucid.grid.folding import add_to_component, component_at, real_node
from pellucid.jit import pointwise
from pellucid.jit.vector import LANES, load, nothing, splat, store


class Stencil(NamedTuple):
    """Nodes whose shape functions are not zero at a point, and these functions; indices along the axes count from the first
    node."""

    start: int  # number of the first node, see `number_behind`
    offset: Any  # vector from the point to the first node [cells]
    wx: Any  # values of the shape functions along x, a tuple
    wy: Any  # along y
    wz: Any  # along z
    gx: Any  # derivatives of the shape functions along x, per cell
    gy: Any  # along y
    gz: Any  # along z


@pointwise
def functions_at(functions, lattice, place):
    """Return the number of the first node around a position [m] (see `number_behind`), and for each axis the numbers from
    which `stencil_of` computes the shape functions there; functions: shape functions along x, y, z."""
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    i, x = axis_numbers(functions[0], (place[0] - low[0]) * h, n[0])
    j, y = axis_numbers(functions[1], (place[1] - low[1]) * h, n[1])
    k, z = axis_numbers(functions[2], (place[2] - low[2]) * h, n[2])
    return int(i * stride[0] + j * stride[1] + k * stride[2]), (x, y, z)


@pointwise
def stencil_of(functions, start, numbers):
    """Return the stencil of a point from the results of `functions_at`: index of the first node and numbers; if `numbers` are
    vectors, the common stencil of several points that share their nodes; functions: shape functions along x, y, z."""
    ox, wx, gx = axis_values(functions[0], numbers[0])
    oy, wy, gy = axis_values(functions[1], numbers[1])
    oz, wz, gz = axis_values(functions[2], numbers[2])
    return Stencil(start, (ox, oy, oz), wx, wy, wz, gx, gy, gz)


@pointwise
def stencil(functions, lattice, position, p):
    """Return the stencil of point p of `position` [m], shape (points, 3); functions: shape functions along x, y, z."""
    start, numbers = functions_at(functions, lattice, (position[p, 0], position[p, 1], position[p, 2]))
    return stencil_of(functions, start, numbers)


@pointwise
def number_behind(lattice, first, a, b, c):
    """Return the number of the node that lies a, b, c nodes after the node with the number `first` along x, y, z: its storage
    index if it lies within the grid, else see `pellucid.grid.folding`."""
    stride = lattice.strides
    return first + a * stride[0] + b * stride[1] + c * stride[2]


@pointwise
def number_at(about, lattice, a, b, c):
    """Return the number of node (a, b, c) of the stencil `about`, counted from its first node along x, y, z, see
    `number_behind`."""
    return number_behind(lattice, about.start, a, b, c)


@pointwise
def node_behind(lattice, first, a, b, c):
    """Return the storage index of the node that lies a, b, c nodes after the node with the number `first` along x, y, z."""
    return real_node(lattice.folding, number_behind(lattice, first, a, b, c))


@pointwise
def node_at(about, lattice, a, b, c):
    """Return the storage index of node (a, b, c) of the stencil `about`, counted from its first node along x, y, z."""
    return node_behind(lattice, about.start, a, b, c)


@pointwise
def component_of(about, lattice, field, a, b, c, d):
    """Return component d of a nodal vector field, shape (nodes, 3), at node (a, b, c) of the stencil `about`, counted from its
    first node along x, y, z."""
    return component_at(lattice.folding, field, number_at(about, lattice, a, b, c), d)


@pointwise
def _gather_of(about, lattice, field, d):
    """Return Σ N_I field_I for component d of a nodal vector field, shape (nodes, 3), interpolated to the point with the
    stencil `about`."""
    wx, wy, wz = about.wx, about.wy, about.wz
    total = nothing(wx[0] * wy[0] * wz[0])
    for a in range(len(wx)):
        for b in range(len(wy)):
            line = wz[0] * component_of(about, lattice, field, a, b, 0, d)
            for c in range(1, len(wz)):
                line += wz[c] * component_of(about, lattice, field, a, b, c, d)
            total += wx[a] * wy[b] * line
    return total


@pointwise
def gather(about, lattice, field):
    """Return Σ N_I field_I, a 3-tuple: a nodal vector field, shape (nodes, 3), interpolated to the point with the stencil
    `about`."""
    x, y = _gather_of(about, lattice, field, 0), _gather_of(about, lattice, field, 1)
    return x, y, _gather_of(about, lattice, field, 2)


@pointwise
def gather_scalar(about, lattice, field):
    """Return Σ N_I field_I: a nodal scalar field, shape (nodes,), interpolated to the point with the stencil `about`."""
    wx, wy, wz = about.wx, about.wy, about.wz
    total = nothing(wx[0] * wy[0] * wz[0])
    for a in range(len(wx)):
        for b in range(len(wy)):
            line = wz[0] * field[node_at(about, lattice, a, b, 0)]
            for c in range(1, len(wz)):
                line += wz[c] * field[node_at(about, lattice, a, b, c)]
            total += wx[a] * wy[b] * line
    return total


@pointwise
def _gradient_of(about, lattice, velocity, d):
    """Return the derivatives [m/s per cell] along x, y, z of component d of a nodal velocity, shape (nodes, 3), at the point
    with the stencil `about`."""
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    one = wx[0] * wy[0] * wz[0]
    x, y, z = nothing(one), nothing(one), nothing(one)  # one apiece: without the compiler, += changes an array in place
    for a in range(len(wx)):
        for b in range(len(wy)):
            v = component_of(about, lattice, velocity, a, b, 0, d)
            line, slope = wz[0] * v, gz[0] * v
            for c in range(1, len(wz)):
                v = component_of(about, lattice, velocity, a, b, c, d)
                line += wz[c] * v
                slope += gz[c] * v
            x += gx[a] * wy[b] * line
            y += wx[a] * gy[b] * line
            z += wx[a] * wy[b] * slope
    return x, y, z


@pointwise
def gather_gradient(about, lattice, velocity):
    """Return the gradient [1/s] of a nodal velocity, shape (nodes, 3), at the point with the stencil `about`, a 9-tuple row by
    row."""
    h = lattice.inverse_cell
    xx, xy, xz = _gradient_of(about, lattice, velocity, 0)
    yx, yy, yz = _gradient_of(about, lattice, velocity, 1)
    zx, zy, zz = _gradient_of(about, lattice, velocity, 2)
    return (xx * h, xy * h, xz * h, yx * h, yy * h, yz * h, zx * h, zy * h, zz * h)


@pointwise
def halfway(half, L, u):
    """Return the velocity u + Δt/2 L u [m/s] of a steady flow at a point half a step later; half: Δt/2 [s]; L: gradient of the
    velocity [1/s], a 9-tuple row by row; u: velocity [m/s]."""
    x, y, z = u
    return (
        x + half * (L[0] * x + L[1] * y + L[2] * z),
        y + half * (L[3] * x + L[4] * y + L[5] * z),
        z + half * (L[6] * x + L[7] * y + L[8] * z),
    )


@pointwise
def gather_affine(about, lattice, rows, found):
    """Write the nodal velocity at the point with the stencil `about` [m/s] and its derivatives along x, y and z [1/s] to
    `found`, shape (16,): four rows of three components and an unused number. rows: nodal velocities, a row of four numbers
    per node, shape (4 nodes,)."""
    wx, wy, wz, gx, gy, gz, h = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz, lattice.inverse_cell
    v, along_x, along_y, along_z = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for a in range(len(wx)):
        for b in range(len(wy)):
            velocity = row_at(lattice.folding, rows, number_at(about, lattice, a, b, 0))
            line, slope = wz[0] * velocity, gz[0] * velocity
            for c in range(1, len(wz)):
                velocity = row_at(lattice.folding, rows, number_at(about, lattice, a, b, c))
                line, slope = line + wz[c] * velocity, slope + gz[c] * velocity
            v, along_z = v + wx[a] * wy[b] * line, along_z + wx[a] * wy[b] * slope
            along_x, along_y = along_x + gx[a] * wy[b] * line, along_y + wx[a] * gy[b] * line
    store(found, 0, v)
    store(found, 4, h * along_x)
    store(found, 8, h * along_y)
    store(found, 12, h * along_z)


@pointwise
def add_vector(about, lattice, target, vector):
    """Add N_I times a vector to row I of `target`, shape (nodes, 3), for each node I of the stencil `about` of a point."""
    wx, wy, wz = about.wx, about.wy, about.wz
    for a in range(len(wx)):
        for b in range(len(wy)):
            for c in range(len(wz)):
                I = number_at(about, lattice, a, b, c)
                w = wx[a] * wy[b] * wz[c]
                for d in range(3):
                    add_to_component(lattice.folding, target, I, d, w * vector[d])


@pointwise
def add_numbers(about, lattice, target, numbers):
    """Add N_I times three numbers that are no components of a vector, such as masses, to row I of `target`, shape (nodes, 3),
    for each node I of the stencil `about` of a point: at planes of symmetry they do not change their sign."""
    wx, wy, wz = about.wx, about.wy, about.wz
    for a in range(len(wx)):
        for b in range(len(wy)):
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                w = wx[a] * wy[b] * wz[c]
                for d in range(3):
                    target[I, d] += w * numbers[d]


@pointwise
def add_affine(about, lattice, target, vector, offset):
    """Add (N_I + offset·∇N_I) times a vector to row I of `target`, shape (nodes, 3), for each node I of the stencil `about` of
    a point: N_I is extrapolated linearly to a position at the distance `offset` [m] from the point."""
    wx, wy, wz, gx, gy, gz, h = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz, lattice.inverse_cell
    ox, oy, oz = h * offset[0], h * offset[1], h * offset[2]
    for a in range(len(wx)):
        for b in range(len(wy)):
            line = wx[a] * wy[b] + ox * gx[a] * wy[b] + oy * wx[a] * gy[b]
            slope = oz * wx[a] * wy[b]
            for c in range(len(wz)):
                I = number_at(about, lattice, a, b, c)
                w = line * wz[c] + slope * gz[c]
                for d in range(3):
                    add_to_component(lattice.folding, target, I, d, w * vector[d])


@pointwise
def add_shares(about, value, shares):
    """Add N_I times the values of several points that share their nodes to `shares`, which has one vector (an entry per point)
    for each node of the stencil `about`, in the order of the node indices; value: vector of the values."""
    wx, wy, wz = about.wx, about.wy, about.wz
    k = 0
    for a in range(len(wx)):
        for b in range(len(wy)):
            line = wx[a] * wy[b] * value
            for c in range(len(wz)):
                store(shares, k, load(shares, k) + line * wz[c])
                k += LANES
