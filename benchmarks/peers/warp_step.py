"""The material point step of `pellucid bench`, written in Warp. Run: python warp_step.py --help

On a CPU, Warp (1.19) runs a kernel on one core, whatever --threads says; the result reports one thread.
"""

import numpy as np
import warp as wp
from block import CELL, DENSITY, GAMMA, LAME_LAMBDA, LAME_MU, LINEAR, PRESSURE, QUADRATIC, make_block, measure, options

arguments = options(__doc__)
arguments.threads = 1
block = make_block(arguments.points, arguments.law)
wp.config.quiet = True
wp.init()

n, nodes = len(block.position), block.nodes
is_musl = arguments.scheme == "musl"
dt, mass = wp.constant(wp.float64(block.step)), wp.constant(wp.float64(block.mass))
last = wp.constant(nodes - 1)
cell, inverse_cell = wp.constant(wp.float64(CELL)), wp.constant(wp.float64(1.0 / CELL))
lame_lambda, lame_mu = wp.constant(wp.float64(LAME_LAMBDA)), wp.constant(wp.float64(LAME_MU))
gamma, quadratic, linear = (wp.constant(wp.float64(value)) for value in (GAMMA, QUADRATIC, LINEAR))
zero, half, one = (wp.constant(wp.float64(value)) for value in (0.0, 0.5, 1.0))
least_mass = wp.constant(wp.float64(1e-9 * block.mass))
vec3, mat33 = wp.vec3d, wp.mat33d


@wp.func
def weight(i: int, f: wp.float64):
    return wp.where(i == 0, one - f, f)


@wp.func
def slope(i: int):
    return wp.where(i == 0, -inverse_cell, inverse_cell)


@wp.func
def gradient(i: int, j: int, k: int, f: vec3):
    wx, wy, wz = weight(i, f[0]), weight(j, f[1]), weight(k, f[2])
    return vec3(slope(i) * wy * wz, wx * slope(j) * wz, wx * wy * slope(k))


@wp.func
def base_of(x: vec3):
    return wp.vec3i(int(wp.floor(x[0] * inverse_cell)), int(wp.floor(x[1] * inverse_cell)), int(wp.floor(x[2] * inverse_cell)))


@wp.func
def fraction(x: vec3, base: wp.vec3i):
    return x * inverse_cell - vec3(wp.float64(base[0]), wp.float64(base[1]), wp.float64(base[2]))


@wp.func
def hold_walls(value: vec3, i: int, j: int, k: int):
    return vec3(
        wp.where(i == 0 or i == last, zero, value[0]),
        wp.where(j == 0 or j == last, zero, value[1]),
        wp.where(k == 0 or k == last, zero, value[2]),
    )


@wp.func
def hypoelastic(p: int, L: mat33, stress: wp.array(dtype=mat33), density: wp.array(dtype=wp.float64)):
    D = half * (L + wp.transpose(L))
    W = half * (L - wp.transpose(L))
    s = stress[p]
    rate = lame_lambda * wp.trace(D) * wp.identity(3, wp.float64) + wp.float64(2.0) * lame_mu * D + W * s - s * W
    stress[p] = s + dt * rate
    density[p] = density[p] / (one + dt * wp.trace(D))


@wp.func
def ideal_gas(
    p: int,
    L: mat33,
    stress: wp.array(dtype=mat33),
    density: wp.array(dtype=wp.float64),
    energy: wp.array(dtype=wp.float64),
):
    divergence = wp.trace(L)
    rho = density[p] / (one + dt * divergence)
    q = zero
    if divergence < zero:
        sound = wp.sqrt(gamma * (gamma - one) * energy[p])
        q = rho * cell * (quadratic * cell * divergence * divergence - linear * sound * divergence)
    e = (energy[p] - dt * q * divergence / rho) / (one + dt * (gamma - one) * divergence)
    density[p] = rho
    energy[p] = e
    stress[p] = -((gamma - one) * rho * e + q) * wp.identity(3, wp.float64)


law = ideal_gas if arguments.law == "ideal-gas" else hypoelastic
needs_energy = arguments.law == "ideal-gas"


@wp.kernel
def scatter(
    x: wp.array(dtype=vec3),
    v: wp.array(dtype=vec3),
    stress: wp.array(dtype=mat33),
    density: wp.array(dtype=wp.float64),
    grid_mass: wp.array3d(dtype=wp.float64),
    grid_velocity: wp.array3d(dtype=vec3),
    grid_change: wp.array3d(dtype=vec3),
):
    p = wp.tid()
    base = base_of(x[p])
    f = fraction(x[p], base)
    momentum = mass * v[p]
    force = -(mass / density[p]) * stress[p]
    for i in range(2):
        for j in range(2):
            for k in range(2):
                N = weight(i, f[0]) * weight(j, f[1]) * weight(k, f[2])
                wp.atomic_add(grid_mass, base[0] + i, base[1] + j, base[2] + k, N * mass)
                wp.atomic_add(grid_velocity, base[0] + i, base[1] + j, base[2] + k, N * momentum)
                wp.atomic_add(grid_change, base[0] + i, base[1] + j, base[2] + k, force * gradient(i, j, k, f))


@wp.kernel
def advance(
    grid_mass: wp.array3d(dtype=wp.float64), grid_velocity: wp.array3d(dtype=vec3), grid_change: wp.array3d(dtype=vec3)
):
    i, j, k = wp.tid()
    m = grid_mass[i, j, k]
    if m > least_mass:
        change = (dt / m) * grid_change[i, j, k]
        grid_velocity[i, j, k] = hold_walls(grid_velocity[i, j, k] / m + change, i, j, k)
        grid_change[i, j, k] = hold_walls(change, i, j, k)


@wp.kernel
def to_velocity(grid_mass: wp.array3d(dtype=wp.float64), grid_velocity: wp.array3d(dtype=vec3)):
    i, j, k = wp.tid()
    m = grid_mass[i, j, k]
    if m > least_mass:
        grid_velocity[i, j, k] = hold_walls(grid_velocity[i, j, k] / m, i, j, k)


@wp.kernel
def gather(
    x: wp.array(dtype=vec3),
    v: wp.array(dtype=vec3),
    stress: wp.array(dtype=mat33),
    density: wp.array(dtype=wp.float64),
    energy: wp.array(dtype=wp.float64),
    grid_velocity: wp.array3d(dtype=vec3),
    grid_change: wp.array3d(dtype=vec3),
):
    """Move the points and update their stresses with the gradient of the new nodal velocity (USL)."""
    p = wp.tid()
    base = base_of(x[p])
    f = fraction(x[p], base)
    moved = vec3()
    change = vec3()
    L = mat33()
    for i in range(2):
        for j in range(2):
            for k in range(2):
                N = weight(i, f[0]) * weight(j, f[1]) * weight(k, f[2])
                velocity = grid_velocity[base[0] + i, base[1] + j, base[2] + k]
                moved += N * velocity
                change += N * grid_change[base[0] + i, base[1] + j, base[2] + k]
                if wp.static(not is_musl):
                    L += wp.outer(velocity, gradient(i, j, k, f))
    x[p] = x[p] + dt * moved
    v[p] = v[p] + change
    if wp.static(not is_musl):
        if wp.static(needs_energy):
            law(p, L, stress, density, energy)
        else:
            law(p, L, stress, density)


@wp.kernel
def map_momentum_again(x: wp.array(dtype=vec3), v: wp.array(dtype=vec3), grid_velocity: wp.array3d(dtype=vec3)):
    p = wp.tid()
    base = base_of(x[p])
    f = fraction(x[p], base)
    momentum = mass * v[p]
    for i in range(2):
        for j in range(2):
            for k in range(2):
                N = weight(i, f[0]) * weight(j, f[1]) * weight(k, f[2])
                wp.atomic_add(grid_velocity, base[0] + i, base[1] + j, base[2] + k, N * momentum)


@wp.kernel
def strain(
    x: wp.array(dtype=vec3),
    stress: wp.array(dtype=mat33),
    density: wp.array(dtype=wp.float64),
    energy: wp.array(dtype=wp.float64),
    grid_velocity: wp.array3d(dtype=vec3),
):
    p = wp.tid()
    base = base_of(x[p])
    f = fraction(x[p], base)
    L = mat33()
    for i in range(2):
        for j in range(2):
            for k in range(2):
                L += wp.outer(grid_velocity[base[0] + i, base[1] + j, base[2] + k], gradient(i, j, k, f))
    if wp.static(needs_energy):
        law(p, L, stress, density, energy)
    else:
        law(p, L, stress, density)


with wp.ScopedDevice("cpu"):
    x = wp.array(block.position, dtype=vec3)
    x_old = wp.empty_like(x)
    v = wp.array(block.velocity, dtype=vec3)
    pressure = PRESSURE if needs_energy else 0.0
    stress = wp.array(np.broadcast_to(-pressure * np.eye(3), (n, 3, 3)), dtype=mat33)
    density = wp.full(n, DENSITY, dtype=wp.float64)
    energy = wp.full(n, PRESSURE / ((GAMMA - 1.0) * DENSITY), dtype=wp.float64)
    shape = (nodes, nodes, nodes)
    grid_mass = wp.zeros(shape, dtype=wp.float64)
    grid_velocity = wp.zeros(shape, dtype=vec3)
    grid_change = wp.zeros(shape, dtype=vec3)


def step() -> None:
    with wp.ScopedDevice("cpu"):
        grid_mass.zero_()
        grid_velocity.zero_()
        grid_change.zero_()
        wp.launch(scatter, n, [x, v, stress, density, grid_mass, grid_velocity, grid_change])
        wp.launch(advance, shape, [grid_mass, grid_velocity, grid_change])
        if is_musl:
            wp.copy(x_old, x)
        wp.launch(gather, n, [x, v, stress, density, energy, grid_velocity, grid_change])
        if is_musl:
            grid_velocity.zero_()
            wp.launch(map_momentum_again, n, [x_old, v, grid_velocity])
            wp.launch(to_velocity, shape, [grid_mass, grid_velocity])
            wp.launch(strain, n, [x_old, stress, density, energy, grid_velocity])


def state() -> np.ndarray:
    return v.numpy()


measure("warp", arguments, block, step, state)
