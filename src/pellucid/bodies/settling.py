"""What contact does to the motion of membrane nodes within a cell, which the grid does not see.

Contact on the grid ends the approach of the mean velocity about a node of the grid, by Δv along n. The nodes of a membrane
about it move against that mean, along n by σ in the mean square, and strike one by one. An impact on which a node does not
rebound stops Δv + σ, so for their impulses to add up to that of contact, the share Δv/(Δv + σ) of them strikes within a step.
They lose what they have against the mean; hence the law: contact takes the share Δv/(Δv + σ) of the energy of that motion
along n. What it takes over a time does not depend on the number of steps in it.
"""

from math import sqrt

from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.bodies.element_nodes import CONTACT, EXTRA_ROWS, SUPPORT, WORKS
from pellucid.jit import kernel, pointwise


@pointwise
def part_taken(jitter, push):
    """Part of the velocities against the mean that contact takes, from their mean square [m²/s²] and its Δv [m/s].

    What is left of the energy is the share of nodes that do not strike, σ/(σ + Δv).
    """
    return 1.0 - sqrt(sqrt(jitter) / (sqrt(jitter) + push))


@kernel()
def _measure_slab(mapped, jitter, s):
    fn, _, lattice, nodes, points, slabs, _ = mapped.content
    x, v, contact, momentum, mass = points.position, points.velocity, nodes.contact, nodes.momentum, nodes.mass
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    cx, cy, cz = contact[I, 0], contact[I, 1], contact[I, 2]
                    push = sqrt(cx * cx + cy * cy + cz * cz)
                    if push > 0.0:
                        m = mass[I]
                        ux, uy, uz = v[p, 0] - momentum[I, 0] / m, v[p, 1] - momentum[I, 1] / m, v[p, 2] - momentum[I, 2] / m
                        along = (ux * cx + uy * cy + uz * cz) / push
                        jitter[I] += wx[a] * wy[b] * wz[c] * points.mass[p] / m * along * along


@kernel()
def _settle_slab(mapped, acting, jitter, s):
    fn, _, lattice, nodes, points, slabs, _ = mapped.content
    _, _, prescribed, _, _, work = acting.content[0]
    x, v, contact, momentum, mass = points.position, points.velocity, nodes.contact, nodes.momentum, nodes.mass
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    row_of_rows = WORKS + 3 * EXTRA_ROWS
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        lx = ly = lz = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    cx, cy, cz = contact[I, 0], contact[I, 1], contact[I, 2]
                    push = sqrt(cx * cx + cy * cy + cz * cz)
                    if push > 0.0:
                        m = mass[I]
                        nx, ny, nz = cx / push, cy / push, cz / push
                        ux, uy, uz = v[p, 0] - momentum[I, 0] / m, v[p, 1] - momentum[I, 1] / m, v[p, 2] - momentum[I, 2] / m
                        part = wx[a] * wy[b] * wz[c] * part_taken(jitter[I], push) * (ux * nx + uy * ny + uz * nz)
                        lx += part * nx
                        ly += part * ny
                        lz += part * nz
        m, loss = points.mass[p], (lx, ly, lz)
        for d in range(3):
            held = prescribed[p, d]  # what holds it takes the impulse too
            if held > 0:
                work[s, row_of_rows + 3 * (held - 1) + d] += m * loss[d]
                work[s, SUPPORT] += m * loss[d] * v[p, d]
                work[s, CONTACT] -= m * loss[d] * v[p, d]
            elif loss[d] != 0.0:
                work[s, CONTACT] += m * loss[d] * (0.5 * loss[d] - v[p, d])
                v[p, d] -= loss[d]


@kernel(parallel=True)
def settle(n, mapped, acting, jitter):
    """Take from the nodes of n slabs what contact takes of their velocities against the mean about them.

    v_K - Σ_I N_I β_I n_I n_I·(v_K - p_I/m_I) with their momentum p on the grid; jitter: zeros, one for each node of the grid.
    As Σ_K m_K N_I (v_K - p_I/m_I) = 0, momentum stays as it was, and as Σ_I N_I = 1, kinetic energy does not grow (Jensen).
    """
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _measure_slab(mapped, jitter, 2 * half + colour)
    for s in prange(n):
        _settle_slab(mapped, acting, jitter, s)
