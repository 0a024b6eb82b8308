"""What fields do to each other where they meet: impulses at the nodes, equal and opposite.

Bodies that touch and approach take an impulse that stops the approach; with friction it has a tangential part too, at most μ
times the normal one. Source: Lian, Liu & Zhang 2014, eqs. 52-58, with the misprints put right: f = (m_a p_b - m_b p_a)/((m_a +
m_b) dt) on a, friction only under compression. Nodes that are held or gripped are as heavy as need be.
"""

from collections.abc import Iterator, Sequence
from itertools import chain
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import prange

from pellucid.contact.detection import ContactDetection
from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import FIRM, ExternalAction, StepWork, no_work
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.reductions import ordered_sum

STICK, SLIP = 0, 1
"""Kinds of contact while bodies press: together, or sliding with friction (or none)."""
SWEEPS = 4  # where several pairs meet, one disturbs the other
WORK, INTERNAL, GRAVITY, LOAD, SUPPORT, GRIP, COLUMNS = range(7)  # columns of a pair's works
SIGNS = 1.0, -1.0  # of the impulses on the first side and on the second
CHUNK = 1024  # nodes booked together


class ContactWork(NamedTuple):
    """What all pairs did over a step."""

    work: float  # on the bodies [J]; when impulses are resolved only that on held nodes, by the end of the step all
    impulses: dict[str, np.ndarray]  # on the first of a pair, by the name of the contact, shape (3,) [N s]
    nodes: StepWork  # what the nodes' own works lack: other works for other velocities, supports and motions that took impulses


@kernel(parallel=True)
def _measure_mobility(node, mass, constrained, driven_mass, mobility):
    """1/m of the nodes along each axis [1/kg], 0 where they are held or firmly gripped."""
    for e in prange(len(node)):
        I = node[e]
        m = mass[I]
        for d in range(3):
            firm = constrained[I, d] > 0 or (len(driven_mass) > 0 and driven_mass[I, d] >= FIRM * m)
            mobility[e, d] = 0.0 if firm else 1.0 / m


@pointwise
def _impulse(kind, friction, n, u, w):
    """The impulse on the first side, from the normal, the relative velocity (first minus second) and the sum of mobilities."""
    approach = u[0] * n[0] + u[1] * n[1] + u[2] * n[2]
    if not approach > 0.0:
        return 0.0, 0.0, 0.0
    jx = -u[0] / w[0] if w[0] > 0.0 else 0.0
    jy = -u[1] / w[1] if w[1] > 0.0 else 0.0
    jz = -u[2] / w[2] if w[2] > 0.0 else 0.0
    if kind != SLIP:
        return jx, jy, jz
    give = w[0] * n[0] * n[0] + w[1] * n[1] * n[1] + w[2] * n[2] * n[2]
    if not give > 0.0:
        return 0.0, 0.0, 0.0
    press = approach / give
    # what is left of the impulse that would stop all slip: it does not act on the approach, also where some axes are held
    tx, ty, tz = jx + press * n[0], jy + press * n[1], jz + press * n[2]
    along = tx * n[0] + ty * n[1] + tz * n[2]
    size = sqrt((tx - along * n[0]) ** 2 + (ty - along * n[1]) ** 2 + (tz - along * n[2]) ** 2)
    most = size + friction * along  # share * size <= friction * (press - share * along)
    share = min(1.0, friction * press / most) if most > 0.0 else 1.0
    return share * tx - press * n[0], share * ty - press * n[1], share * tz - press * n[2]


@pointwise
def _impulse_at(kind, friction, e, I, normal, one, other, w1, w2):
    """The impulse on the first side that the velocities of both at node I ask for."""
    n = (normal[e, 0], normal[e, 1], normal[e, 2])
    u = (one[I, 0] - other[I, 0], one[I, 1] - other[I, 1], one[I, 2] - other[I, 2])
    w = (w1[e, 0] + w2[e, 0], w1[e, 1] + w2[e, 1], w1[e, 2] + w2[e, 2])
    return _impulse(kind, friction, n, u, w)


@kernel(parallel=True)
def _stop_approach(kind, friction, node, normal, one, other, w1, w2):
    """Give two sides the impulses that their velocities ask for."""
    for e in prange(len(node)):
        I = node[e]
        impulse = _impulse_at(kind, friction, e, I, normal, one, other, w1, w2)
        for d in range(3):
            one[I, d] += w1[e, d] * impulse[d]
            other[I, d] -= w2[e, d] * impulse[d]


@kernel(inline=True)
def _add_to_node(I, d, more, velocity, velocity_increment, strain_velocity, contact):
    if strain_velocity[I, d] == velocity[I, d]:  # else a light node, whose forces must not strain points
        strain_velocity[I, d] += more
    velocity[I, d] += more
    velocity_increment[I, d] += more
    if len(contact) > 0:
        contact[I, d] += more


@kernel(parallel=True)
def _resolve(kind, friction, node, normal, one, other, w1, w2, total):
    """Give the nodes of two sides the impulses that their velocities ask for, and add these up; what is held does not move."""
    v1, increment1, strain_velocity1, contact1 = one
    v2, increment2, strain_velocity2, contact2 = other
    for e in prange(len(node)):
        I = node[e]
        impulse = _impulse_at(kind, friction, e, I, normal, v1, v2, w1, w2)
        for d in range(3):
            _add_to_node(I, d, w1[e, d] * impulse[d], v1, increment1, strain_velocity1, contact1)
            _add_to_node(I, d, -w2[e, d] * impulse[d], v2, increment2, strain_velocity2, contact2)
            total[e, d] += impulse[d]


@kernel()
def _sum_works_chunk(side, node, mobility, impulse, sign, gravity, dt, works, chunk):
    nodes, outside = side.content
    velocity, force, constrained, own = nodes.velocity, nodes.force, nodes.constrained, len(nodes.contact) > 0
    load, driven_mass, grip = outside.load, outside.driven_mass, outside.impulse
    loaded = len(load) > 0
    work = internal = fall = lifted = support = gripped = 0.0
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        for d in range(3):
            j, w, new = sign * impulse[e, d], mobility[e, d], velocity[I, d]
            if w > 0.0:
                if not own:  # the nodes' works were made for velocities without contact
                    internal += 0.5 * dt * force[I, d] * w * j
                    fall += 0.5 * dt * gravity[d] * j
                    lifted += 0.5 * dt * load[I, d] * w * j if loaded else 0.0
                continue
            work += j * new
            if constrained[I, d] > 0:
                works[chunk, COLUMNS + 3 * (constrained[I, d] - 1) + d] -= j
                support -= j * new
            else:
                grip[I, d] -= j / driven_mass[I, d]
                gripped -= j * new
    works[chunk, WORK] += work
    works[chunk, INTERNAL] += internal
    works[chunk, GRAVITY] += fall
    works[chunk, LOAD] += lifted
    works[chunk, SUPPORT] += support
    works[chunk, GRIP] += gripped


@kernel(parallel=True)
def _sum_works(chunks, side, node, mobility, impulse, sign, gravity, dt, works):
    """Book what impulses change in the works of other forces; supports and grips give back what they take."""
    for chunk in prange(chunks):
        _sum_works_chunk(side, node, mobility, impulse, sign, gravity, dt, works, chunk)


@kernel()
def _work_chunk(node, mobility, impulse, sign, mass, momentum, velocity, velocity_increment, work, chunk):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        for d in range(3):
            if mobility[e, d] > 0.0:
                work[chunk, 0] += (
                    0.5 * sign * impulse[e, d] * (velocity[I, d] - velocity_increment[I, d] + momentum[I, d] / mass[I])
                )


@kernel(parallel=True)
def _work(chunks, node, mobility, impulse, sign, mass, momentum, velocity, velocity_increment, work):
    """Work of impulses on the points that they reach, from the momentum that these have before and after the step."""
    for chunk in prange(chunks):
        _work_chunk(node, mobility, impulse, sign, mass, momentum, velocity, velocity_increment, work, chunk)


class Pair:
    """Two fields and how they meet; `name`: what a probe calls the impulse on the first of them."""

    def __init__(
        self,
        grids: tuple[Grid, Grid],
        bodies: tuple[Sequence[Any], Sequence[Any]],
        outsides: tuple[ExternalAction, ExternalAction],
        kind: int,
        friction: float = 0.0,
        name: str | None = None,
    ) -> None:
        self.name, self._kind = name, kind
        self.detection, self._bodies = ContactDetection(grids, bodies), bodies
        self._nodes = grids[0].nodes, grids[1].nodes
        self._outsides = outsides
        self._sides = [Bundle(*side) for side in zip(self._nodes, outsides, strict=True)]
        self._friction = friction
        self._mobility, self._impulse = np.zeros((2, 0, 3)), np.zeros((0, 3))

    def find(self) -> None:
        """Find where the fields meet, after the bodies gave their mass to the nodes."""
        self.detection.find()
        n = len(self.detection.node)
        self._mobility, self._impulse = np.empty((2, n, 3)), np.zeros((n, 3))
        for mobility, nodes, outside in zip(self._mobility, self._nodes, self._outsides, strict=True):
            _measure_mobility(self.detection.node, nodes.mass, nodes.constrained, outside.driven_mass, mobility)

    def touching(self) -> Iterator[tuple[Any, np.ndarray]]:
        """The bodies of both fields, each with the nodes at which the fields touch, shape (n,)."""
        nodes = self.detection.node[self.detection.normal.any(axis=1)]
        return ((body, nodes) for side in self._bodies for body in side)

    def resolve(self) -> None:
        """Impulses on the nodes after they moved."""
        where, (one, other) = (self.detection.node, self.detection.normal), self._nodes
        moved = (one.velocity, one.velocity_increment, one.strain_velocity, one.contact)
        also = (other.velocity, other.velocity_increment, other.strain_velocity, other.contact)
        _resolve(self._kind, self._friction, *where, moved, also, *self._mobility, self._impulse)

    def project(self) -> None:
        """The same for the velocities that strain the points, which works nothing."""
        where, (one, other) = (self.detection.node, self.detection.normal), self._nodes
        _stop_approach(self._kind, self._friction, *where, one.strain_velocity, other.strain_velocity, *self._mobility)

    def impulse(self) -> np.ndarray:
        """On the first field over this step [N s], shape (3,)."""
        return self._impulse.sum(axis=0)

    def book(self, gravity: tuple[float, float, float], dt: float, n_supports: int) -> np.ndarray:
        """What the impulses of this step did, shape (COLUMNS + 3 n_supports,); behind the works what supports took [N s]."""
        chunks = len(self._impulse) // CHUNK + 1
        works = np.zeros((chunks, COLUMNS + 3 * n_supports))
        for side, mobility, sign in zip(self._sides, self._mobility, SIGNS, strict=True):
            _sum_works(chunks, side, self.detection.node, mobility, self._impulse, sign, gravity, dt, works)
        return ordered_sum(works)

    def work(self) -> float:
        """Work of the impulses of this step on the points of both sides [J], when their momentum is on the nodes anew."""
        chunks = len(self._impulse) // CHUNK + 1
        work = np.zeros((chunks, 1))
        for nodes, mobility, sign in zip(self._nodes, self._mobility, SIGNS, strict=True):
            if not len(nodes.contact):
                moved = nodes.mass, nodes.momentum, nodes.velocity, nodes.velocity_increment
                _work(chunks, self.detection.node, mobility, self._impulse, sign, *moved, work)
        return float(ordered_sum(work)[0])


class ContactPairs:
    """All pairs of fields of a simulation."""

    def __init__(self, pairs: Sequence[Pair], n_supports: int) -> None:
        self._pairs = pairs
        self._sweeps = 1 if len(pairs) == 1 else SWEEPS
        self._n_supports = n_supports

    def __len__(self) -> int:
        return len(self._pairs)

    def find(self) -> None:
        """Find where fields meet, after the bodies gave their mass to the nodes."""
        for pair in self._pairs:
            pair.find()

    def touching(self) -> Iterator[tuple[Any, np.ndarray]]:
        """The bodies of each pair, each with the nodes at which its field touches the other, shape (n,)."""
        return chain.from_iterable(pair.touching() for pair in self._pairs)

    def resolve(self, gravity: tuple[float, float, float], dt: float) -> ContactWork:
        """Impulses on the nodes after they moved, and what these did; of their work only that on nodes that are held."""
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.resolve()
        total = np.zeros(COLUMNS + 3 * self._n_supports)
        for pair in self._pairs:
            total += pair.book(gravity, dt, self._n_supports)
        nodes = no_work(self._n_supports)._replace(
            internal=float(total[INTERNAL]),
            gravity=float(total[GRAVITY]),
            load=float(total[LOAD]),
            support=float(total[SUPPORT]),
            grip=float(total[GRIP]),
            impulses=total[COLUMNS:].reshape(-1, 3),
        )
        impulses = {pair.name: pair.impulse() for pair in self._pairs if pair.name is not None}
        return ContactWork(float(total[WORK]), impulses, nodes)

    def work(self) -> float:
        """Work of the impulses of this step on points [J], when their momentum is on the nodes anew.

        It is that on the points themselves, not on the nodes: what a point takes of an impulse at a node and does not give back
        to it is lost, and this is where.
        """
        return sum(pair.work() for pair in self._pairs)

    def project(self) -> None:
        """Let no field strain its points by an approach that contact does not allow."""
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.project()
