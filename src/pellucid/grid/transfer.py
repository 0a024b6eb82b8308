"""Transfers between points and nodes: scatter and gather, generic in shape functions, transfer and law.

Work is shared by slabs of cells. Slabs of one colour never reach the same node, so no scatter needs atomics, and every nodal
sum is added in the order of the points: the same bits on any number of threads. Sums over tensor products are factored line by
line (along z), which halves the work of the plain triple loop.

The kernels take a body as a bundle: `mapped` is (functions, transfer, lattice, nodes, points, slabs, affine), `strained` is
(functions, lattice, nodes, points, slabs, law, state arrays). Flags are integers 0 or 1. Indices are unsigned, which spares
numba's question whether they count from the end.
"""

from math import inf, sqrt

from numba import prange
from numpy import uintp

from pellucid.approximants.axis import affine_weights, axis_weights
from pellucid.grid.points import (
    HEATING,
    INVERTED,
    KINETIC,
    LOST,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    NOT_FINITE,
    OK,
    RATE,
    SPEED,
    STORED,
)
from pellucid.grid.velocity_transfer import affine_of, affine_velocity, new_velocity
from pellucid.jit import kernel, pointwise
from pellucid.materials.law import artificial_heating, diffusivity, signal_speed, stored_energy, update, volume_growth
from pellucid.materials.point_state import load, store


@kernel()
def _scatter_slab(mapped, s, inertia, force):
    fn, transfer, lattice, nodes, points, slabs, affine = mapped.content
    first, last = slabs.first[s], slabs.first[s + 1]
    x, v, sig = points.position, points.velocity, points.stress
    mass, momentum, f = nodes.mass, nodes.momentum, nodes.force
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(first, last):
        p = uintp(signed)
        X = (x[p, 0] - low[0]) * h
        Y = (x[p, 1] - low[1]) * h
        Z = (x[p, 2] - low[2]) * h
        i, wx, gx = axis_weights(fn[0], X, n[0])
        j, wy, gy = axis_weights(fn[1], Y, n[1])
        k, wz, gz = axis_weights(fn[2], Z, n[2])
        start = i * stride[0] + j * stride[1] + k * stride[2]
        if inertia:
            C = affine_of(transfer, affine, p)
            m = points.mass[p]
            for a in range(len(wx)):
                dx = (i + a - X) * lattice.cell
                for b in range(len(wy)):
                    dy = (j + b - Y) * lattice.cell
                    row = start + a * stride[0] + b * stride[1]
                    wm = wx[a] * wy[b] * m
                    for c in range(len(wz)):
                        dz = (k + c - Z) * lattice.cell
                        I = uintp(row + c * stride[2])
                        w = wm * wz[c]
                        mass[I] += w
                        momentum[I, 0] += w * affine_velocity(transfer, v[p, 0], C[0], C[1], C[2], dx, dy, dz)
                        momentum[I, 1] += w * affine_velocity(transfer, v[p, 1], C[3], C[4], C[5], dx, dy, dz)
                        momentum[I, 2] += w * affine_velocity(transfer, v[p, 2], C[6], C[7], C[8], dx, dy, dz)
        if force:
            V = -points.volume[p] * h
            sxx, syy, szz = V * sig[p, 0], V * sig[p, 1], V * sig[p, 2]
            syz, sxz, sxy = V * sig[p, 3], V * sig[p, 4], V * sig[p, 5]
            for a in range(len(wx)):
                for b in range(len(wy)):
                    row = start + a * stride[0] + b * stride[1]
                    w, dx, dy = wx[a] * wy[b], gx[a] * wy[b], wx[a] * gy[b]
                    tx, ty, tz = sxx * dx + sxy * dy, sxy * dx + syy * dy, sxz * dx + syz * dy
                    ux, uy, uz = sxz * w, syz * w, szz * w
                    for c in range(len(wz)):
                        I = uintp(row + c * stride[2])
                        f[I, 0] += tx * wz[c] + ux * gz[c]
                        f[I, 1] += ty * wz[c] + uy * gz[c]
                        f[I, 2] += tz * wz[c] + uz * gz[c]


@kernel(parallel=True)
def scatter(n, mapped, inertia, force):
    """Map mass and momentum (where `inertia`) and internal forces -Σ V σ ∇N (where `force`) of n slabs to the nodes."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _scatter_slab(mapped, 2 * half + colour, inertia, force)


@pointwise
def placed(lattice, x, p, dx, dy, dz, lowest, highest):
    """Move point p; what is wrong with its new place, and 1 where it lies outside the layers lowest to highest of its slab."""
    h, low, n = lattice.inverse_cell, lattice.lower, lattice.counts
    x[p, 0] += dx
    x[p, 1] += dy
    x[p, 2] += dz
    X, Y, Z = (x[p, 0] - low[0]) * h, (x[p, 1] - low[1]) * h, (x[p, 2] - low[2]) * h
    along = X if lattice.slab_axis == 0 else (Y if lattice.slab_axis == 1 else Z)
    beyond = 1 if along < lowest or along >= highest else 0
    if X >= 0.0 and n[0] >= X and Y >= 0.0 and n[1] >= Y and Z >= 0.0 and n[2] >= Z:
        return OK, beyond
    return (LOST if abs(X + Y + Z) < inf else NOT_FINITE), beyond


@kernel()
def _update_velocities_slab(mapped, s, remap):
    fn, transfer, lattice, nodes, points, slabs, affine = mapped.content
    x, v = points.position, points.velocity
    momentum, new, dv = nodes.momentum, nodes.velocity, nodes.velocity_increment
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    kinetic = px = py = pz = speed = 0.0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        X = (x[p, 0] - low[0]) * h
        Y = (x[p, 1] - low[1]) * h
        Z = (x[p, 2] - low[2]) * h
        i, wx, _ = axis_weights(fn[0], X, n[0])
        j, wy, _ = axis_weights(fn[1], Y, n[1])
        k, wz, _ = axis_weights(fn[2], Z, n[2])
        start = i * stride[0] + j * stride[1] + k * stride[2]
        nx = ny = nz = cx = cy = cz = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = start + a * stride[0] + b * stride[1]
                w = wx[a] * wy[b]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    W = w * wz[c]
                    nx += W * new[I, 0]
                    ny += W * new[I, 1]
                    nz += W * new[I, 2]
                    cx += W * dv[I, 0]
                    cy += W * dv[I, 1]
                    cz += W * dv[I, 2]
        vx = new_velocity(transfer, v[p, 0], nx, cx)
        vy = new_velocity(transfer, v[p, 1], ny, cy)
        vz = new_velocity(transfer, v[p, 2], nz, cz)
        v[p, 0] = vx
        v[p, 1] = vy
        v[p, 2] = vz
        m = points.mass[p]
        vv = vx * vx + vy * vy + vz * vz
        kinetic += 0.5 * m * vv
        px += m * vx
        py += m * vy
        pz += m * vz
        speed += m * sqrt(vv)
        if remap:
            C = affine_of(transfer, affine, p)
            for a in range(len(wx)):
                dx = (i + a - X) * lattice.cell
                for b in range(len(wy)):
                    dy = (j + b - Y) * lattice.cell
                    row = start + a * stride[0] + b * stride[1]
                    wm = wx[a] * wy[b] * m
                    for c in range(len(wz)):
                        dz = (k + c - Z) * lattice.cell
                        I = uintp(row + c * stride[2])
                        w = wm * wz[c]
                        momentum[I, 0] += w * affine_velocity(transfer, vx, C[0], C[1], C[2], dx, dy, dz)
                        momentum[I, 1] += w * affine_velocity(transfer, vy, C[3], C[4], C[5], dx, dy, dz)
                        momentum[I, 2] += w * affine_velocity(transfer, vz, C[6], C[7], C[8], dx, dy, dz)
    slabs.sums[s, KINETIC] = kinetic
    slabs.sums[s, MOMENTUM_X] = px
    slabs.sums[s, MOMENTUM_Y] = py
    slabs.sums[s, MOMENTUM_Z] = pz
    slabs.sums[s, SPEED] = speed


@kernel(parallel=True)
def update_velocities(n, mapped, remap):
    """New velocities of the points; where `remap` (MUSL) their momentum on the nodes anew."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _update_velocities_slab(mapped, 2 * half + colour, remap)


@kernel()
def _gather_affine_slab(mapped, new, s):
    fn, _, lattice, _, points, slabs, affine = mapped.content
    first, last = slabs.first[s], slabs.first[s + 1]
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(first, last):
        p = uintp(signed)
        X = (x[p, 0] - low[0]) * h
        Y = (x[p, 1] - low[1]) * h
        Z = (x[p, 2] - low[2]) * h
        i, wx, gx = axis_weights(fn[0], X, n[0])
        j, wy, gy = axis_weights(fn[1], Y, n[1])
        k, wz, gz = axis_weights(fn[2], Z, n[2])
        bx = affine_weights(fn[0], i - X, wx, gx)
        by = affine_weights(fn[1], j - Y, wy, gy)
        bz = affine_weights(fn[2], k - Z, wz, gz)
        affine[p, :] = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = i * stride[0] + j * stride[1] + k * stride[2] + a * stride[0] + b * stride[1]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    for d in range(3):
                        affine[p, 3 * d] += h * bx[a] * wy[b] * wz[c] * new[I, d]
                        affine[p, 3 * d + 1] += h * wx[a] * by[b] * wz[c] * new[I, d]
                        affine[p, 3 * d + 2] += h * wx[a] * wy[b] * bz[c] * new[I, d]


@kernel(parallel=True)
def gather_affine(n, mapped, new):
    """The affine field of the nodal velocity `new` [m/s], shape (nodes, 3), about each point, for APIC."""
    for s in prange(n):
        _gather_affine_slab(mapped, new, s)


@pointwise
def gathered(fn, lattice, strain_velocity, new, X, Y, Z):
    """Gradient of the nodal `strain_velocity` [1/s], a 9-tuple, and the velocity `new` [m/s] at (X, Y, Z), in cells."""
    h, n, stride = lattice.inverse_cell, lattice.counts, lattice.strides
    i, wx, gx = axis_weights(fn[0], X, n[0])
    j, wy, gy = axis_weights(fn[1], Y, n[1])
    k, wz, gz = axis_weights(fn[2], Z, n[2])
    start = i * stride[0] + j * stride[1] + k * stride[2]
    xx = xy = xz = yx = yy = yz = zx = zy = zz = nx = ny = nz = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            row = start + a * stride[0] + b * stride[1]
            lx = ly = lz = dx = dy = dz = mx = my = mz = 0.0
            for c in range(len(wz)):
                I = uintp(row + c * stride[2])
                lx += wz[c] * strain_velocity[I, 0]
                ly += wz[c] * strain_velocity[I, 1]
                lz += wz[c] * strain_velocity[I, 2]
                dx += gz[c] * strain_velocity[I, 0]
                dy += gz[c] * strain_velocity[I, 1]
                dz += gz[c] * strain_velocity[I, 2]
                mx += wz[c] * new[I, 0]
                my += wz[c] * new[I, 1]
                mz += wz[c] * new[I, 2]
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
    return L, nx, ny, nz


@kernel()
def _update_stress_slab(strained, s, dt, move):
    fn, lattice, nodes, points, slabs, law, state_arrays = strained.content
    x, v = points.position, points.velocity
    mass, volume = points.mass, points.volume
    new, strain_velocity = nodes.velocity, nodes.strain_velocity
    h, low = lattice.inverse_cell, lattice.lower
    stored = heating = rate = 0.0
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        X = (x[p, 0] - low[0]) * h
        Y = (x[p, 1] - low[1]) * h
        Z = (x[p, 2] - low[2]) * h
        L, nx, ny, nz = gathered(fn, lattice, strain_velocity, new, X, Y, Z)
        fault = OK
        if move:
            fault, beyond = placed(lattice, x, p, dt * nx, dt * ny, dt * nz, lowest, highest)
            left_slab |= beyond
        growth = volume_growth(law, L, dt)
        if growth > 0.0:
            volume[p] *= growth
            m = mass[p]
            density = m / volume[p]
            state = update(law, load(state_arrays, p), density, L, dt, lattice.cell)
            store(state_arrays, p, state)
            energy = stored_energy(law, state, density)
            c = signal_speed(law, state, density, L, lattice.cell)
            speed = sqrt(v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2])
            stored += m * energy
            heating += m * artificial_heating(law, state, density, L, lattice.cell)
            rate = max(rate, h * (c + speed), 2.0 * h * h * diffusivity(law, density))
            if not abs(energy + state.stress[0] + state.stress[1] + state.stress[2] + speed + c) < inf:
                fault = NOT_FINITE
        else:
            fault = INVERTED if growth <= 0.0 else NOT_FINITE
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = signed
    slabs.left_slab[s] = left_slab
    slabs.fault[s, 0] = first_fault
    slabs.fault[s, 1] = at_fault
    slabs.sums[s, STORED] = stored
    slabs.sums[s, HEATING] = heating
    slabs.sums[s, RATE] = rate


@kernel(parallel=True)
def update_stress(n, strained, dt, move):
    """Velocity gradients, new volumes and stresses; where `move` new positions. Fills STORED, HEATING, RATE of the sums."""
    for s in prange(n):
        _update_stress_slab(strained, s, dt, move)


@kernel()
def _update_positions_slab(mapped, velocity, s, dt):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    x = points.position
    h, low = lattice.inverse_cell, lattice.lower
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        X = (x[p, 0] - low[0]) * h
        Y = (x[p, 1] - low[1]) * h
        Z = (x[p, 2] - low[2]) * h
        _, vx, vy, vz = gathered(fn, lattice, velocity, velocity, X, Y, Z)
        fault, beyond = placed(lattice, x, p, dt * vx, dt * vy, dt * vz, lowest, highest)
        left_slab |= beyond
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = signed
    slabs.left_slab[s] = left_slab
    if first_fault != OK:  # what `update_stress` found earlier in the step stays
        slabs.fault[s, 0] = first_fault
        slabs.fault[s, 1] = at_fault


@kernel(parallel=True)
def update_positions(n, mapped, velocity, dt):
    """New positions alone, by nodal velocities [m/s], shape (nodes, 3), for what is strained otherwise or before it moves."""
    for s in prange(n):
        _update_positions_slab(mapped, velocity, s, dt)


@kernel()
def _sum_slab(mapped, s):
    _, _, _, _, points, slabs, _ = mapped.content
    v = points.velocity
    kinetic = px = py = pz = speed = 0.0
    for p in range(slabs.first[s], slabs.first[s + 1]):
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


@kernel(parallel=True)
def sum_motion(n, mapped):
    """Kinetic energy and momentum of the points of n slabs, after their velocities were changed."""
    for s in prange(n):
        _sum_slab(mapped, s)


@kernel()
def _scatter_momentum_slab(mapped, s):
    fn, transfer, lattice, nodes, points, slabs, affine = mapped.content
    x, v, momentum = points.position, points.velocity, nodes.momentum
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        X, Y, Z = (x[p, 0] - low[0]) * h, (x[p, 1] - low[1]) * h, (x[p, 2] - low[2]) * h
        i, wx, _ = axis_weights(fn[0], X, n[0])
        j, wy, _ = axis_weights(fn[1], Y, n[1])
        k, wz, _ = axis_weights(fn[2], Z, n[2])
        C = affine_of(transfer, affine, p)
        for a in range(len(wx)):
            dx = (i + a - X) * lattice.cell
            for b in range(len(wy)):
                dy = (j + b - Y) * lattice.cell
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    dz = (k + c - Z) * lattice.cell
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c] * points.mass[p]
                    momentum[I, 0] += w * affine_velocity(transfer, v[p, 0], C[0], C[1], C[2], dx, dy, dz)
                    momentum[I, 1] += w * affine_velocity(transfer, v[p, 1], C[3], C[4], C[5], dx, dy, dz)
                    momentum[I, 2] += w * affine_velocity(transfer, v[p, 2], C[6], C[7], C[8], dx, dy, dz)


@kernel(parallel=True)
def scatter_momentum(n, mapped):
    """Momentum of the points of n slabs to the nodes, after their velocities were changed (MUSL)."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _scatter_momentum_slab(mapped, 2 * half + colour)
