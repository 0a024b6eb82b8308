"""The nodes about a point, with the values and slopes of their shape functions there, and sums over them.

`gather`: a sum over the nodes that reach a point; `add`: what a point adds to each of them. Sums over tensor products are
factored line by line (along z) where that halves the work of the plain triple loop. Indices are unsigned, which spares numba's
question whether they count from the end.
"""

from typing import Any, NamedTuple

from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.grid.velocity_transfer import affine_velocity
from pellucid.jit import pointwise


class Stencil(NamedTuple):
    """The nodes that reach a point; their indices count along the axes from the first one."""

    start: int  # where the first node is stored
    first: tuple[int, int, int]  # its place on the lattice
    place: tuple[float, float, float]  # the point, in cells from the lower corner
    wx: Any  # shape functions along x, a tuple
    wy: Any
    wz: Any
    gx: Any  # their derivatives by the place in cells
    gy: Any
    gz: Any


@pointwise
def stencil(functions, lattice, position, p):
    """The nodes about point p of `position` [m], shape (points, 3)."""
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    X = (position[p, 0] - low[0]) * h
    Y = (position[p, 1] - low[1]) * h
    Z = (position[p, 2] - low[2]) * h
    i, wx, gx = axis_weights(functions[0], X, n[0])
    j, wy, gy = axis_weights(functions[1], Y, n[1])
    k, wz, gz = axis_weights(functions[2], Z, n[2])
    start = i * stride[0] + j * stride[1] + k * stride[2]
    return Stencil(start, (i, j, k), (X, Y, Z), wx, wy, wz, gx, gy, gz)


@pointwise
def node_at(about, lattice, a, b, c):
    """Index of the node (a, b, c) of a stencil."""
    stride = lattice.strides
    return uintp(about.start + a * stride[0] + b * stride[1] + c * stride[2])


@pointwise
def gather(about, lattice, field):
    """Σ N_I field_I of a vector field, shape (nodes, 3)."""
    wx, wy, wz = about.wx, about.wy, about.wz
    fx = fy = fz = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            w = wx[a] * wy[b]
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                W = w * wz[c]
                fx += W * field[I, 0]
                fy += W * field[I, 1]
                fz += W * field[I, 2]
    return fx, fy, fz


@pointwise
def gather_increments(about, lattice, velocity, increment, energy):
    """Σ N_I of the nodal velocity and its increment, shape (nodes, 3), and of the energy of the latter, shape (nodes,)."""
    wx, wy, wz = about.wx, about.wy, about.wz
    vx = vy = vz = dx = dy = dz = e = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            w = wx[a] * wy[b]
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                W = w * wz[c]
                vx += W * velocity[I, 0]
                vy += W * velocity[I, 1]
                vz += W * velocity[I, 2]
                dx += W * increment[I, 0]
                dy += W * increment[I, 1]
                dz += W * increment[I, 2]
                e += W * energy[I]
    return (vx, vy, vz), (dx, dy, dz), e


@pointwise
def gather_gradient(about, lattice, velocity):
    """Gradient of the nodal velocity `velocity` [1/s], a 9-tuple."""
    h = lattice.inverse_cell
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    xx = xy = xz = yx = yy = yz = zx = zy = zz = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            lx = ly = lz = dx = dy = dz = 0.0
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                lx += wz[c] * velocity[I, 0]
                ly += wz[c] * velocity[I, 1]
                lz += wz[c] * velocity[I, 2]
                dx += gz[c] * velocity[I, 0]
                dy += gz[c] * velocity[I, 1]
                dz += gz[c] * velocity[I, 2]
            w, gX, gY = wx[a] * wy[b], gx[a] * wy[b], wx[a] * gy[b]
            xx += gX * lx
            xy += gY * lx
            xz += w * dx
            yx += gX * ly
            yy += gY * ly
            yz += w * dy
            zx += gX * lz
            zy += gY * lz
            zz += w * dz
    return (h * xx, h * xy, h * xz, h * yx, h * yy, h * yz, h * zx, h * zy, h * zz)


@pointwise
def gather_with_gradient(about, lattice, strain_velocity, velocity):
    """Gradient of the nodal velocity `strain_velocity` [1/s], a 9-tuple, and the velocity `velocity` [m/s]."""
    h = lattice.inverse_cell
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    xx = xy = xz = yx = yy = yz = zx = zy = zz = nx = ny = nz = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            lx = ly = lz = dx = dy = dz = mx = my = mz = 0.0
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                lx += wz[c] * strain_velocity[I, 0]
                ly += wz[c] * strain_velocity[I, 1]
                lz += wz[c] * strain_velocity[I, 2]
                dx += gz[c] * strain_velocity[I, 0]
                dy += gz[c] * strain_velocity[I, 1]
                dz += gz[c] * strain_velocity[I, 2]
                mx += wz[c] * velocity[I, 0]
                my += wz[c] * velocity[I, 1]
                mz += wz[c] * velocity[I, 2]
            w, gX, gY = wx[a] * wy[b], gx[a] * wy[b], wx[a] * gy[b]
            xx += gX * lx
            xy += gY * lx
            xz += w * dx
            yx += gX * ly
            yy += gY * ly
            yz += w * dy
            zx += gX * lz
            zy += gY * lz
            zz += w * dz
            nx += w * mx
            ny += w * my
            nz += w * mz
    L = (h * xx, h * xy, h * xz, h * yx, h * yy, h * yz, h * zx, h * zy, h * zz)
    return L, (nx, ny, nz)


@pointwise
def add_vector(about, lattice, target, vector):
    """Add N_I times a vector to each node of `target`, shape (nodes, 3)."""
    wx, wy, wz = about.wx, about.wy, about.wz
    for a in range(len(wx)):
        for b in range(len(wy)):
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                w = wx[a] * wy[b] * wz[c]
                for d in range(3):
                    target[I, d] += w * vector[d]


@pointwise
def add_scalar(about, lattice, target, value):
    """Add N_I times a value to each node of `target`, shape (nodes,)."""
    wx, wy, wz = about.wx, about.wy, about.wz
    for a in range(len(wx)):
        for b in range(len(wy)):
            share = wx[a] * wy[b] * value
            for c in range(len(wz)):
                target[node_at(about, lattice, a, b, c)] += share * wz[c]


@pointwise
def add_momentum(about, lattice, target, transfer, m, v, C):
    """Add N_I m (v + C (x_I - x)) to each node of `target`, shape (nodes, 3); C as `affine_of` gives it."""
    wx, wy, wz = about.wx, about.wy, about.wz
    first, place = about.first, about.place
    for a in range(len(wx)):
        dx = (first[0] + a - place[0]) * lattice.cell
        for b in range(len(wy)):
            dy = (first[1] + b - place[1]) * lattice.cell
            share = wx[a] * wy[b] * m
            for c in range(len(wz)):
                dz = (first[2] + c - place[2]) * lattice.cell
                I = node_at(about, lattice, a, b, c)
                w = share * wz[c]
                target[I, 0] += w * affine_velocity(transfer, v[0], C[0], C[1], C[2], dx, dy, dz)
                target[I, 1] += w * affine_velocity(transfer, v[1], C[3], C[4], C[5], dx, dy, dz)
                target[I, 2] += w * affine_velocity(transfer, v[2], C[6], C[7], C[8], dx, dy, dz)


@pointwise
def add_internal_force(about, lattice, target, volume, stress, p):
    """Add -V σ ∇N_I of point p to each node of `target`, shape (nodes, 3)."""
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    V = -volume[p] * lattice.inverse_cell
    sxx, syy, szz = V * stress[p, 0], V * stress[p, 1], V * stress[p, 2]
    syz, sxz, sxy = V * stress[p, 3], V * stress[p, 4], V * stress[p, 5]
    for a in range(len(wx)):
        for b in range(len(wy)):
            w, dx, dy = wx[a] * wy[b], gx[a] * wy[b], wx[a] * gy[b]
            tx, ty, tz = sxx * dx + sxy * dy, sxy * dx + syy * dy, sxz * dx + syz * dy
            ux, uy, uz = sxz * w, syz * w, szz * w
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                target[I, 0] += tx * wz[c] + ux * gz[c]
                target[I, 1] += ty * wz[c] + uy * gz[c]
                target[I, 2] += tz * wz[c] + uz * gz[c]
