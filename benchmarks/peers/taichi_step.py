"""The material point step of `pellucid bench`, written in Taichi. Run: python taichi_step.py --help"""

import os

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")  # read by Taichi when it is imported

import numpy as np
import taichi as ti
from block import CELL, DENSITY, GAMMA, LAME_LAMBDA, LAME_MU, LINEAR, PRESSURE, QUADRATIC, make_block, measure, options

arguments = options(__doc__)
block = make_block(arguments.points, arguments.law)
ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=arguments.threads, log_level=ti.ERROR)

n, nodes, dt, mass = len(block.position), block.nodes, block.step, block.mass
inverse_cell = 1.0 / CELL
is_gas = arguments.law == "ideal-gas"
is_musl = arguments.scheme == "musl"

x = ti.Vector.field(3, ti.f64, shape=n)
x_old = ti.Vector.field(3, ti.f64, shape=n if is_musl else 1)
v = ti.Vector.field(3, ti.f64, shape=n)
stress = ti.Matrix.field(3, 3, ti.f64, shape=n)
density = ti.field(ti.f64, shape=n)
energy = ti.field(ti.f64, shape=n)
grid_mass = ti.field(ti.f64, shape=(nodes, nodes, nodes))
grid_velocity = ti.Vector.field(3, ti.f64, shape=(nodes, nodes, nodes))
grid_change = ti.Vector.field(3, ti.f64, shape=(nodes, nodes, nodes))  # force, then the change of velocity in the step


@ti.func
def cell_of(position):
    """Return the lowest node of the cell that contains a position, and the weights of the nodes of the cell along the axes."""
    scaled = position * inverse_cell
    base = ti.floor(scaled).cast(int)
    f = scaled - base
    return base, ti.Matrix.rows([1.0 - f, f])


@ti.func
def node(w: ti.template(), i: ti.template(), j: ti.template(), k: ti.template()):
    """Return the shape function and gradient of one of the eight nodes, given by its offsets i, j, k."""
    gradient = (
        ti.Vector([(2 * i - 1) * w[j, 1] * w[k, 2], w[i, 0] * (2 * j - 1) * w[k, 2], w[i, 0] * w[j, 1] * (2 * k - 1)])
        * inverse_cell
    )
    return w[i, 0] * w[j, 1] * w[k, 2], gradient


@ti.func
def hold_walls(I):
    for axis in ti.static(range(3)):
        if I[axis] == 0 or I[axis] == nodes - 1:
            grid_velocity[I][axis] = 0.0
            grid_change[I][axis] = 0.0


@ti.func
def hypoelastic(p, L):
    D = 0.5 * (L + L.transpose())
    W = 0.5 * (L - L.transpose())
    s = stress[p]
    rate = LAME_LAMBDA * D.trace() * ti.Matrix.identity(ti.f64, 3) + 2.0 * LAME_MU * D + W @ s - s @ W
    stress[p] = s + dt * rate
    density[p] /= 1.0 + dt * D.trace()


@ti.func
def ideal_gas(p, L):
    """Update a point of an ideal gas with velocity gradient L: artificial viscosity, and the energy at the end of the step
    in closed form."""
    divergence = L.trace()
    rho = density[p] / (1.0 + dt * divergence)
    q = 0.0
    if divergence < 0.0:
        sound = ti.sqrt(GAMMA * (GAMMA - 1.0) * energy[p])
        q = rho * CELL * (QUADRATIC * CELL * divergence * divergence - LINEAR * sound * divergence)
    e = (energy[p] - dt * q * divergence / rho) / (1.0 + dt * (GAMMA - 1.0) * divergence)
    density[p] = rho
    energy[p] = e
    stress[p] = -((GAMMA - 1.0) * rho * e + q) * ti.Matrix.identity(ti.f64, 3)


@ti.kernel
def clear():
    for I in ti.grouped(grid_mass):
        grid_mass[I] = 0.0
        grid_velocity[I] = ti.Vector.zero(ti.f64, 3)
        grid_change[I] = ti.Vector.zero(ti.f64, 3)


@ti.kernel
def scatter():
    for p in range(n):
        base, w = cell_of(x[p])
        momentum = mass * v[p]
        force = -(mass / density[p]) * stress[p]
        for i, j, k in ti.static(ti.ndrange(2, 2, 2)):
            N, gradient = node(w, i, j, k)
            I = base + ti.Vector([i, j, k])
            grid_mass[I] += N * mass
            grid_velocity[I] += N * momentum
            grid_change[I] += force @ gradient


@ti.kernel
def advance():
    for I in ti.grouped(grid_mass):
        m = grid_mass[I]
        if m > 1e-9 * mass:
            grid_change[I] *= dt / m
            grid_velocity[I] = grid_velocity[I] / m + grid_change[I]
            hold_walls(I)


@ti.kernel
def gather():
    """Move the points and update their stresses with the gradient of the new nodal velocity (USL)."""
    for p in range(n):
        base, w = cell_of(x[p])
        moved = ti.Vector.zero(ti.f64, 3)
        change = ti.Vector.zero(ti.f64, 3)
        L = ti.Matrix.zero(ti.f64, 3, 3)
        for i, j, k in ti.static(ti.ndrange(2, 2, 2)):
            N, gradient = node(w, i, j, k)
            I = base + ti.Vector([i, j, k])
            velocity = grid_velocity[I]
            moved += N * velocity
            change += N * grid_change[I]
            if ti.static(not is_musl):
                L += velocity.outer_product(gradient)
        if ti.static(is_musl):
            x_old[p] = x[p]
        x[p] += dt * moved
        v[p] += change
        if ti.static(not is_musl):
            if ti.static(is_gas):
                ideal_gas(p, L)
            else:
                hypoelastic(p, L)


@ti.kernel
def map_momentum_again():
    for I in ti.grouped(grid_velocity):
        grid_velocity[I] = ti.Vector.zero(ti.f64, 3)
    for p in range(n):
        base, w = cell_of(x_old[p])
        momentum = mass * v[p]
        for i, j, k in ti.static(ti.ndrange(2, 2, 2)):
            grid_velocity[base + ti.Vector([i, j, k])] += (w[i, 0] * w[j, 1] * w[k, 2]) * momentum
    for I in ti.grouped(grid_mass):
        if grid_mass[I] > 1e-9 * mass:
            grid_velocity[I] /= grid_mass[I]
            hold_walls(I)


@ti.kernel
def strain():
    for p in range(n):
        base, w = cell_of(x_old[p])
        L = ti.Matrix.zero(ti.f64, 3, 3)
        for i, j, k in ti.static(ti.ndrange(2, 2, 2)):
            _, gradient = node(w, i, j, k)
            L += grid_velocity[base + ti.Vector([i, j, k])].outer_product(gradient)
        if ti.static(is_gas):
            ideal_gas(p, L)
        else:
            hypoelastic(p, L)


def step() -> None:
    clear()
    scatter()
    advance()
    gather()
    if is_musl:
        map_momentum_again()
        strain()


def state() -> np.ndarray:
    ti.sync()
    return v.to_numpy()


x.from_numpy(block.position)
v.from_numpy(block.velocity)
density.fill(DENSITY)
energy.fill(PRESSURE / ((GAMMA - 1.0) * DENSITY))
if is_gas:
    stress.from_numpy(np.broadcast_to(-PRESSURE * np.eye(3), (n, 3, 3)).copy())
measure("taichi", arguments, block, step, state)
