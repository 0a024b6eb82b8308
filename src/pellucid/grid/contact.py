"""What fields do to each other where they meet: impulses at the nodes, equal and opposite.

Bodies that touch and approach take an impulse that stops the approach; with friction it has a tangential part too, at most μ
times the normal one. Source: Lian, Liu & Zhang 2014, eqs. 52-58, with the misprints put right: f = (m_a p_b - m_b p_a)/((m_a +
m_b) dt) on a, friction only under compression. Nodes that are held or gripped are as heavy as need be.
"""

from collections.abc import Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.bundle import Bundle
from pellucid.grid.grid import Grid
from pellucid.grid.meeting import Meeting
from pellucid.grid.motion import FIRM, Outside, StepWork, no_work
from pellucid.jit import kernel, pointwise

TIE, STICK, SLIP = 0, 1, 2
"""Kinds of contact: together always, together while they press, sliding with friction (or none)."""
SWEEPS = 4  # where several pairs meet, one disturbs the other
IMPULSE, WORK, INTERNAL, GRAVITY, LOAD, SUPPORT, GRIP, BOOKS = 0, 3, 4, 5, 6, 7, 8, 9  # columns of a pair's books


class ContactWork(NamedTuple):
    """What all pairs did over a step."""

    work: float  # on the bodies together [J]
    impulses: dict[str, np.ndarray]  # on the first of a pair, by the name of the contact, shape (3,) [N s]
    nodes: StepWork  # what the nodes' own books lack: other works for other velocities, supports and motions that took impulses


@pointwise
def _mobility(nodes, outside, I, d):
    """1/m of a node along axis d, 0 where it is held or firmly gripped."""
    m = nodes.mass[I]
    if nodes.hold[I, d] > 0 or (len(outside.driven_mass) > 0 and outside.driven_mass[I, d] >= FIRM * m):
        return 0.0
    return 1.0 / m


@pointwise
def _impulse(kind, friction, n, u, w):
    """The impulse on the first side, from the normal, the relative velocity (first minus second) and the sum of mobilities."""
    approach = u[0] * n[0] + u[1] * n[1] + u[2] * n[2]
    if kind != TIE and not approach > 0.0:
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
def _push(nodes, outside, own, I, d, j):
    """Give a node the impulse j along axis d; nodes that are held do not move."""
    w = _mobility(nodes, outside, I, d)
    if nodes.deforming[I, d] == nodes.velocity[I, d]:  # else a light node, whose forces must not strain points
        nodes.deforming[I, d] += w * j
    nodes.velocity[I, d] += w * j
    nodes.change[I, d] += w * j
    if own:
        nodes.contact[I, d] += w * j


@pointwise
def _relative(first, second, outside_one, outside_two, I, one, two):
    u = (one[I, 0] - two[I, 0], one[I, 1] - two[I, 1], one[I, 2] - two[I, 2])
    w = (
        _mobility(first, outside_one, I, 0) + _mobility(second, outside_two, I, 0),
        _mobility(first, outside_one, I, 1) + _mobility(second, outside_two, I, 1),
        _mobility(first, outside_one, I, 2) + _mobility(second, outside_two, I, 2),
    )
    return u, w


@kernel()
def _resolve(pair, node, normal, impulse):
    first, second, outside_one, outside_two, own, kind, friction = pair.content
    for e in range(len(node)):
        I = node[e]
        n = (normal[e, 0], normal[e, 1], normal[e, 2])
        u, w = _relative(first, second, outside_one, outside_two, I, first.velocity, second.velocity)
        j = _impulse(kind, friction, n, u, w)
        for d in range(3):
            if j[d] != 0.0:
                impulse[e, d] += j[d]
                _push(first, outside_one, own[0], I, d, j[d])
                _push(second, outside_two, own[1], I, d, -j[d])


@pointwise
def _book_side(nodes, outside, own, I, d, j, g, dt, held, books):
    """Book the impulse j on a node by its mean velocity over the step; supports and grips give back what they take."""
    w = _mobility(nodes, outside, I, d)
    new = nodes.velocity[I, d]
    if w > 0.0:
        books[WORK] += j * (new - 0.5 * nodes.change[I, d])
        if own == 0:  # the nodes' books were made for velocities without contact
            books[INTERNAL] += 0.5 * dt * nodes.force[I, d] * w * j
            books[GRAVITY] += 0.5 * dt * g * j
            if len(outside.load) > 0:
                books[LOAD] += 0.5 * dt * outside.load[I, d] * w * j
        return
    books[WORK] += j * new
    if nodes.hold[I, d] > 0:
        held[nodes.hold[I, d] - 1, d] -= j
        books[SUPPORT] -= j * new
    else:
        outside.grip[I, d] -= j / outside.driven_mass[I, d]
        books[GRIP] -= j * new


@kernel()
def _book(pair, node, impulse, gravity, dt, held, books):
    first, second, outside_one, outside_two, own, _, _ = pair.content
    for e in range(len(node)):
        for d in range(3):
            j = impulse[e, d]
            if j != 0.0:
                books[IMPULSE + d] += j
                _book_side(first, outside_one, own[0], node[e], d, j, gravity[d], dt, held, books)
                _book_side(second, outside_two, own[1], node[e], d, -j, gravity[d], dt, held, books)


@kernel()
def _project(pair, node, normal):
    first, second, outside_one, outside_two, _, kind, friction = pair.content
    for e in range(len(node)):
        I = node[e]
        n = (normal[e, 0], normal[e, 1], normal[e, 2])
        u, w = _relative(first, second, outside_one, outside_two, I, first.deforming, second.deforming)
        j = _impulse(kind, friction, n, u, w)
        for d in range(3):
            first.deforming[I, d] += _mobility(first, outside_one, I, d) * j[d]
            second.deforming[I, d] -= _mobility(second, outside_two, I, d) * j[d]


class Pair:
    """Two fields and how they meet; `name`: what a probe calls the impulse on the first of them."""

    def __init__(
        self,
        grids: tuple[Grid, Grid],
        bodies: tuple[Sequence[Any], Sequence[Any]],
        outsides: tuple[Outside, Outside],
        kind: int,
        friction: float = 0.0,
        name: str | None = None,
    ) -> None:
        self.name, self.kind = name, kind
        self.meeting = Meeting(grids, bodies, kind == TIE)
        own = tuple(int(len(grid.nodes.contact) > 0) for grid in grids)
        self._pair = Bundle(grids[0].nodes, grids[1].nodes, *outsides, own, kind, friction)
        self._impulse = np.zeros((0, 3))

    def find(self) -> None:
        """Find where the fields meet, after the bodies gave their mass to the nodes."""
        self.meeting.find()
        self._impulse = np.zeros((len(self.meeting.node), 3))

    def resolve(self) -> None:
        """Impulses on the nodes after they moved."""
        _resolve(self._pair, self.meeting.node, self.meeting.normal, self._impulse)

    def project(self) -> None:
        """The same for the velocities that strain the points, which books nothing."""
        _project(self._pair, self.meeting.node, self.meeting.normal)

    def book(self, gravity: tuple[float, float, float], dt: float, held: np.ndarray) -> np.ndarray:
        """What the impulses of this step did, shape (BOOKS,); those that supports took are added to `held`, (supports, 3)."""
        books = np.zeros(BOOKS)
        _book(self._pair, self.meeting.node, self._impulse, gravity, dt, held, books)
        return books


class Encounters:
    """All pairs of fields of a simulation. Contacts come before ties, which then hold exactly."""

    def __init__(self, pairs: Sequence[Pair], n_supports: int) -> None:
        self._pairs = sorted(pairs, key=lambda pair: pair.kind == TIE)
        self._sweeps = 1 if len(pairs) == 1 else SWEEPS
        self._n_supports = n_supports

    def __len__(self) -> int:
        return len(self._pairs)

    def find(self) -> None:
        """Find where fields meet, after the bodies gave their mass to the nodes."""
        for pair in self._pairs:
            pair.find()

    def resolve(self, gravity: tuple[float, float, float], dt: float) -> ContactWork:
        """Impulses on the nodes after they moved, and what these did.

        Works are those of the mean velocities over the step: then what lasting contact takes from its forces is no loss.
        """
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.resolve()
        held, total, impulses = np.zeros((self._n_supports, 3)), np.zeros(BOOKS), {}
        for pair in self._pairs:
            books = pair.book(gravity, dt, held)
            total += books
            if pair.name is not None:
                impulses[pair.name] = books[IMPULSE : IMPULSE + 3]
        nodes = no_work(self._n_supports)._replace(
            internal=float(total[INTERNAL]),
            gravity=float(total[GRAVITY]),
            load=float(total[LOAD]),
            support=float(total[SUPPORT]),
            grip=float(total[GRIP]),
            impulses=held,
        )
        return ContactWork(float(total[WORK]), impulses, nodes)

    def project(self) -> None:
        """Let no field strain its points by an approach that contact does not allow."""
        for _ in range(self._sweeps):
            for pair in self._pairs:
                pair.project()
