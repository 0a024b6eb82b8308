"""The nodes' equation of motion, with supports."""

from typing import NamedTuple

import numpy as np
from numba import prange

from pellucid.bundle import Bundle
from pellucid.grid.grid import Nodes
from pellucid.jit import kernel
from pellucid.reductions import ordered_sum

CHUNK = 4096
NOTHING = 1e-290  # kg; a node below this carries no point
INTERNAL, GRAVITY, SUPPORT, MASS, WORKS = range(5)


class Supports(NamedTuple):
    """What holds nodes; `Nodes.hold` counts its rows from 1."""

    velocity: np.ndarray  # (supports, 3) [m/s]
    mirror: np.ndarray  # (supports,) 1 for a wall, beside which a body goes on as its mirror image, 0 for a grip within it


class StepWork(NamedTuple):
    """What the nodes did over a step."""

    internal: float  # dt Σ f·v̄ of the internal forces [J]
    gravity: float  # [J]
    support: float  # work of the supports' reactions on moving supports [J]
    mass: float  # on the nodes [kg]
    impulses: np.ndarray  # (supports, 3) impulses of the reactions [N s]


@kernel()
def _advance_chunk(bundle, chunk, dt, small, flip):
    nodes, walls, mirror, gravity, work = bundle.content
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    change, deforming, hold = nodes.change, nodes.deforming, nodes.hold
    internal = fall = pushed = total = 0.0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        if m < NOTHING:
            for d in range(3):
                velocity[I, d] = change[I, d] = deforming[I, d] = 0.0
            continue
        total += m
        for d in range(3):
            s = hold[I, d]
            mapped = momentum[I, d] / m
            # a wall's nodes have its velocity before the step too: then points beside a wall keep their velocity, as they do
            # beside their mirror image; points in a grip take the velocity of the grip
            v = walls[s - 1, d] if s > 0 and mirror[s - 1] else mapped
            f = force[I, d]
            new = v + dt * (f / m + gravity[d])
            if s > 0:
                wall = walls[s - 1, d]
                impulse = m * (wall - new)
                if mirror[s - 1]:  # FLIP hands on the change of velocity, PIC the velocity itself
                    impulse += m * (1.0 - flip) * (wall - mapped)
                pushed += impulse * wall
                work[chunk, WORKS + 3 * (s - 1) + d] += impulse
                new = wall
            change[I, d] = new - v
            velocity[I, d] = new
            # f/m of a node that hardly any mass reaches has no bound. Points feel it in proportion to their weight, which
            # bounds it by f over their own mass and keeps momentum; gradients do not, so it must not strain them
            deforming[I, d] = new if m > small or s > 0 else v + dt * gravity[d]
            mean = 0.5 * (v + deforming[I, d])
            internal += dt * f * mean
            fall += dt * m * gravity[d] * mean
    work[chunk, INTERNAL] = internal
    work[chunk, GRAVITY] = fall
    work[chunk, SUPPORT] = pushed
    work[chunk, MASS] = total


@kernel(parallel=True)
def _advance(chunks, bundle, dt, small, flip):
    for chunk in prange(chunks):
        _advance_chunk(bundle, chunk, dt, small, flip)


@kernel()
def _project_chunk(bundle, chunk):
    nodes, walls, _, _, _ = bundle.content
    mass, momentum, deforming, hold = nodes.mass, nodes.momentum, nodes.deforming, nodes.hold
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m = mass[I]
        for d in range(3):
            s = hold[I, d]
            if s > 0:
                deforming[I, d] = walls[s - 1, d]
            else:
                deforming[I, d] = momentum[I, d] / m if m >= NOTHING else 0.0


@kernel(parallel=True)
def _project(chunks, bundle):
    for chunk in prange(chunks):
        _project_chunk(bundle, chunk)


class NodalMotion:
    """Moves the nodes of one velocity field.

    supports: their velocities [m/s] are read at every step; small_mass [kg]: nodes with less do not
    strain points by their internal forces; flip: share of FLIP in the transfer to the points.
    """

    def __init__(
        self, nodes: Nodes, supports: Supports, gravity: tuple[float, float, float], small_mass: float, flip: float
    ) -> None:
        self.small_mass = small_mass
        self.flip = flip
        self._chunks = (len(nodes.mass) + CHUNK - 1) // CHUNK
        self._work = np.zeros((self._chunks, WORKS + 3 * len(supports.velocity)))
        self._bundle = Bundle(nodes, supports.velocity, supports.mirror, gravity, self._work)

    def advance(self, dt: float) -> StepWork:
        """p + dt (f + m g) on every node, then the supports; fills velocity, change and deforming."""
        self._work.fill(0.0)
        _advance(self._chunks, self._bundle, dt, self.small_mass, self.flip)
        sums = ordered_sum(self._work)
        internal, gravity, support, mass = (float(sums[column]) for column in range(WORKS))
        return StepWork(internal, gravity, support, mass, sums[WORKS:].reshape(-1, 3))

    def project(self) -> None:
        """Velocities p/m of the mapped momentum, with supports, into `deforming`."""
        _project(self._chunks, self._bundle)
