"""Damping by contact of the velocities of membrane nodes within a cell, which the grid does not resolve.

Contact on the grid ends the approach of the mean velocity about a node of the grid, by Δv along n. The nodes of a membrane
about it move against that mean, along n by σ in the mean square, and strike one by one. An impact on which a node does not
rebound stops Δv + σ, so for their impulses to add up to that of contact, the share Δv/(Δv + σ) of them strikes within a step.
They lose what they have against the mean; hence the law: contact takes the share Δv/(Δv + σ) of the energy of that motion
along n, the direction of the whole impulse. Where Δv « σ, what it takes over a time does not depend on the number of steps.
"""

from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, REMAP, RUN, SUM, NodalField
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour

CHUNK = 1024  # nodes of the grid that a thread takes at a time


class SubcellMotion(NamedTuple):
    """Of the nodes of a membrane about those of the grid; cleared where they reach it."""

    mean: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "m²/s²", "mean velocity along Δv of contact, times this")]
    fluctuation: Annotated[
        np.ndarray, NodalField(1, SUM, REMAP, "kg m⁴/s⁴", "square of what nodes have against it; then the part that is taken")
    ]


@pointwise
def part_taken(fluctuation, push):
    """Part of the velocities against the mean that contact takes, from their mean square [m²/s²] and its Δv [m/s].

    What is left of the energy is the share of nodes that do not strike, σ/(σ + Δv).
    """
    return 1.0 - sqrt(sqrt(fluctuation) / (sqrt(fluctuation) + push))


@kernel(inline=True)
def _against_mean(v, contact, mean, I):
    """Velocity against the mean, times the impulse's direction and size."""
    return v[0] * contact[I, 0] + v[1] * contact[I, 1] + v[2] * contact[I, 2] - mean[I]


@parallel_loop()
def _find_means(chunk, mapped, reached, motion):
    contact, momentum, mass = mapped.nodes.velocity_increment, mapped.nodes.momentum, mapped.nodes.mass
    mean, fluctuation = motion.mean, motion.fluctuation
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(reached))):
        I = reached[e]
        c0, c1, c2 = contact[I, 0], contact[I, 1], contact[I, 2]
        fluctuation[I] = mean[I] = 0.0
        if mass[I] > 0.0 and (c0 != 0.0 or c1 != 0.0 or c2 != 0.0):
            mean[I] = (momentum[I, 0] * c0 + momentum[I, 1] * c1 + momentum[I, 2] * c2) / mass[I]


@parallel_loop()
def _find_parts(chunk, reached, contact, mass, fluctuation):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(reached))):
        I = reached[e]
        if fluctuation[I] > 0.0:
            square = contact[I, 0] ** 2 + contact[I, 1] ** 2 + contact[I, 2] ** 2
            fluctuation[I] = part_taken(fluctuation[I] / (mass[I] * square), sqrt(square)) / square


@parallel_loop_by_colour(gives="motion.fluctuation")
def _measure(s, mapped, motion):
    functions, lattice, contact, index = mapped.functions, mapped.lattice, mapped.nodes.velocity_increment, mapped.index
    points, slabs = mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        m, v = points.mass[p], (points.velocity[p, 0], points.velocity[p, 1], points.velocity[p, 2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    along = _against_mean(v, contact, motion.mean, I)  # 0 where contact does not press: cheaper than a branch
                    motion.fluctuation[I] += wx[a] * wy[b] * wz[c] * m * along * along


@parallel_loop()
def _find_losses(s, mapped, mean, taken, loss):
    functions, lattice, contact, index = mapped.functions, mapped.lattice, mapped.nodes.velocity_increment, mapped.index
    points, slabs, velocity = mapped.points, mapped.slabs, mapped.points.velocity
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        v = (velocity[p, 0], velocity[p, 1], velocity[p, 2])
        lx = ly = lz = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    part = wx[a] * wy[b] * wz[c] * taken[I] * _against_mean(v, contact, mean, I)
                    lx += part * contact[I, 0]
                    ly += part * contact[I, 1]
                    lz += part * contact[I, 2]
        loss[p, 0], loss[p, 1], loss[p, 2] = lx, ly, lz


def damp_subcell_velocities(n: int, mapped: Bundle, reached: np.ndarray, motion: Bundle, loss: np.ndarray) -> None:
    """The velocities against the mean that contact takes from the nodes of n slabs [m/s], into loss, shape (n, 3).

    Σ_I N_I β_I n_I n_I·(v_K - p_I/m_I), with what the nodes of the grid have: velocity increments by contact [m/s], and
    momentum [kg m/s] and mass [kg] as the nodes of the membrane gave them last. As Σ_K m_K N_I (v_K - p_I/m_I) = 0, momentum
    stays as it was, and as Σ_I N_I = 1, kinetic energy does not grow (Jensen). reached: the nodes of the grid that those of the
    membrane reach, shape (m,); motion: a bundle of `SubcellMotion`.
    """
    chunks, nodes = (len(reached) + CHUNK - 1) // CHUNK, mapped.nodes
    _find_means(chunks, mapped, reached, motion)
    _measure(n, mapped, motion)
    _find_parts(chunks, reached, nodes.velocity_increment, nodes.mass, motion.fluctuation)
    _find_losses(n, mapped, motion.mean, motion.fluctuation, loss)
