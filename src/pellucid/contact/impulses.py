"""Contact impulses at the nodes that two velocity fields share, equal and opposite: kernels.

Bodies that touch and approach take an impulse that stops the approach; with friction it has a tangential part too, at most μ
times the normal one. Source: Lian, Liu & Zhang 2014, eqs. 52-58, with the misprints put right: f = (m_a p_b - m_b p_a)/((m_a +
m_b) dt) on a, friction only under compression. Constrained nodes have no mobility 1/m.
"""

from math import sqrt
from typing import NamedTuple

from pellucid.grid.lattice import Nodes
from pellucid.grid.momentum import FULL_DRIVE_FRACTION, ExternalAction
from pellucid.jit import kernel, pointwise
from pellucid.jit.parallel import parallel_for

STICK, SLIP = 0, 1
"""Kinds of contact while bodies press: together, or sliding with friction (or none)."""
CHUNK = 1024  # nodes that are summed together


class Side(NamedTuple):
    """The nodes of one of two velocity fields, as kernels take them."""

    nodes: Nodes
    external: ExternalAction
    moves_points: bool  # whether the grid moves the points


@kernel(inner=True)
def _mobility_of(side, first, end, node, mobility):
    mass, constrained, driven_mass = side.nodes.mass, side.nodes.constrained, side.external.driven_mass
    for e in range(first, end):
        I = node[e]
        m = mass[I]
        for d in range(3):
            firm = constrained[I, d] > 0 or (len(driven_mass) > 0 and driven_mass[I, d] >= FULL_DRIVE_FRACTION * m)
            mobility[e, d] = 0.0 if firm else 1.0 / m


@kernel(inner=True)
def _mobility_chunk(chunk, node, one, other, mobility):
    first, end = CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))
    _mobility_of(one, first, end, node, mobility[0])
    _mobility_of(other, first, end, node, mobility[1])


@kernel()
def measure_mobility(chunks, node, one, other, mobility):
    """1/m of the nodes of both sides along each axis [1/kg], shape (2, n, 3), 0 where they are constrained, by supports or
    wholly by driven points. one, other: bundles of a `Side`."""
    parallel_for(_mobility_chunk, chunks, node, one, other, mobility)


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
    # the rest of the impulse that would stop all slip: it does not act on the approach, also where axes are constrained
    tx, ty, tz = jx + press * n[0], jy + press * n[1], jz + press * n[2]
    along = tx * n[0] + ty * n[1] + tz * n[2]
    size = sqrt((tx - along * n[0]) ** 2 + (ty - along * n[1]) ** 2 + (tz - along * n[2]) ** 2)
    most = size + friction * along  # share * size <= friction * (press - share * along)
    share = min(1.0, friction * press / most) if most > 0.0 else 1.0
    return share * tx - press * n[0], share * ty - press * n[1], share * tz - press * n[2]


@pointwise
def _impulse_at(kind, friction, e, I, touch, one, other, w1, w2, given):
    """The impulse on the first side that stops the approach that both sides have at node I without what was given."""
    normal, closing = touch
    n = (normal[e, 0], normal[e, 1], normal[e, 2])
    w = (w1[e, 0] + w2[e, 0], w1[e, 1] + w2[e, 1], w1[e, 2] + w2[e, 2])
    ux = one[I, 0] - other[I, 0] - w[0] * given[0] - closing[e] * n[0]
    uy = one[I, 1] - other[I, 1] - w[1] * given[1] - closing[e] * n[1]
    uz = one[I, 2] - other[I, 2] - w[2] * given[2] - closing[e] * n[2]
    return _impulse(kind, friction, n, (ux, uy, uz), w)


@pointwise
def _any(impulse):
    """Whether there is an impulse at all: where there is none, its nodes need not come from memory."""
    return impulse[0] != 0.0 or impulse[1] != 0.0 or impulse[2] != 0.0


@kernel(inner=True)
def _stop_approach_chunk(chunk, kind, friction, node, touch, one, other, w1, w2, total):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        impulse = _impulse_at(kind, friction, e, I, touch, one, other, w1, w2, (0.0, 0.0, 0.0))
        if not _any(impulse):
            continue
        for d in range(3):
            one[I, d] += w1[e, d] * impulse[d]
            other[I, d] -= w2[e, d] * impulse[d]
            total[e, d] += impulse[d]


@kernel()
def stop_approach(chunks, kind, friction, node, touch, one, other, w1, w2, total):
    """Change the velocities of two sides by the impulses that stop their approach; these add up. touch: as for `resolve`."""
    parallel_for(_stop_approach_chunk, chunks, kind, friction, node, touch, one, other, w1, w2, total)


@kernel(inline=True)
def _add_to_node(I, d, more, velocity, velocity_increment, strain_velocity):
    if strain_velocity[I, d] == velocity[I, d]:  # else a light node, whose forces must not strain points
        strain_velocity[I, d] += more
    velocity[I, d] += more
    velocity_increment[I, d] += more


@kernel(inner=True)
def _resolve_chunk(chunk, kind, friction, anew, node, touch, one, other, w1, w2, total):
    v1, increment1, strain_velocity1 = one
    v2, increment2, strain_velocity2 = other
    share = 1.0 if anew else 0.0
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        given = (share * total[e, 0], share * total[e, 1], share * total[e, 2])
        impulse = _impulse_at(kind, friction, e, I, touch, v1, v2, w1, w2, given)
        more = impulse[0] - given[0], impulse[1] - given[1], impulse[2] - given[2]
        if not _any(more):
            continue
        for d in range(3):
            _add_to_node(I, d, w1[e, d] * more[d], v1, increment1, strain_velocity1)
            _add_to_node(I, d, -w2[e, d] * more[d], v2, increment2, strain_velocity2)
            total[e, d] += more[d]


@kernel()
def resolve(chunks, kind, friction, anew, node, touch, one, other, w1, w2, total):
    """Give the nodes of two sides the impulses that stop their approach, and add these up; constrained nodes do not move.

    anew: whether all that was given in this step is found anew, so that a part may be taken back, or this is added to it.
    touch: normals, shape (n, 3), and the speeds at which both may still approach [m/s], shape (n,).
    """
    parallel_for(_resolve_chunk, chunks, kind, friction, anew, node, touch, one, other, w1, w2, total)


@kernel(inner=True)
def _give_chunk(chunk, node, impulse, one, other, w1, w2, total):
    v1, increment1, strain_velocity1 = one
    v2, increment2, strain_velocity2 = other
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I = node[e]
        for d in range(3):
            _add_to_node(I, d, w1[e, d] * impulse[e, d], v1, increment1, strain_velocity1)
            _add_to_node(I, d, -w2[e, d] * impulse[e, d], v2, increment2, strain_velocity2)
            total[e, d] += impulse[e, d]


@kernel()
def give(chunks, node, impulse, one, other, w1, w2, total):
    """Give the nodes of two sides these impulses [N s], shape (n, 3), on the first side, and add them up."""
    parallel_for(_give_chunk, chunks, node, impulse, one, other, w1, w2, total)


@pointwise
def _velocity_at_start(nodes, mobility, e, I, d):
    return nodes.momentum[I, d] / nodes.mass[I] if mobility[e, d] > 0.0 else nodes.velocity[I, d]


@kernel(inner=True)
def _parting_chunk(chunk, one, other, node, mobility, normal, least, closing):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(node))):
        I, parting = node[e], 0.0
        for d in range(3):
            v = _velocity_at_start(one.nodes, mobility[0], e, I, d)
            parting += (_velocity_at_start(other.nodes, mobility[1], e, I, d) - v) * normal[e, d]
        closing[e] = max(least[e], parting)


@kernel()
def measure_parting(chunks, one, other, node, mobility, normal, least, closing):
    """The speed at which two sides part along the normal as the step begins, and at least `least` [m/s], shape (n,).

    Where they have no mobility, (2, n, 3), nodes have one velocity.
    """
    parallel_for(_parting_chunk, chunks, one, other, node, mobility, normal, least, closing)
