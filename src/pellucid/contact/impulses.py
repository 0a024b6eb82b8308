"""Kernels for contact impulses at the nodes shared by two velocity fields, which are equal and opposite, and for their
work.

If two bodies touch and approach, an impulse stops the approach. With friction it also has a tangential component, at most μ
times the normal one. Source: Lian, Liu & Zhang 2014, eqs. 52-58, with misprints corrected: f = (m_a p_b - m_b p_a)/((m_a +
m_b) dt) on a, friction only under compression. Constrained nodes have zero mobility 1/m.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.energy import CONTACT, FIRST_LOAD, MOTION, SUPPORT
from pellucid.grid.lattice import Nodes
from pellucid.grid.nodal_conditions import FULL_DRIVE_FRACTION, ExternalAction
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_loop

STICK, SLIP = 0, 1
"""Kinds of contact under compression: no sliding, or sliding with or without friction."""
CHUNK = 1024  # number of nodes per chunk of the sums


class Friction(NamedTuple):
    """Friction between two velocity fields."""

    kind: int  # STICK or SLIP
    coefficient: float = 0.0  # coefficient of friction μ


class Side(NamedTuple):
    """One of two velocity fields in contact, as an argument of kernels: its nodal arrays."""

    nodes: Nodes  # nodal mass, momentum and velocities
    external: ExternalAction  # loads and prescribed motions of the nodes
    moves_points: bool  # True if the grid moves the points


class ContactNodes(NamedTuple):
    """Nodes shared by two velocity fields in a step; n is their number."""

    node: np.ndarray  # (n,) node numbers
    normal: np.ndarray  # (n, 3) unit normals from the first to the second side, zero without contact
    mobility: np.ndarray  # (2, n, 3) 1/m of both sides along each axis [1/kg], 0 where a node is constrained
    edges: np.ndarray  # ends of the chunks of nodes, see `pellucid.grid.chunks`


@kernel(inner=True)
def _mobility_of(side, first, end, node, mobility):
    mass, constrained, driven_mass = side.nodes.mass, side.nodes.constrained, side.external.driven_mass
    for e in range(first, end):
        I = node[e]
        m = mass[I]
        for d in range(3):
            firm = constrained[I, d] > 0 or (len(driven_mass) > 0 and driven_mass[I, d] >= FULL_DRIVE_FRACTION * m)
            mobility[e, d] = 0.0 if firm else 1.0 / m


@parallel_loop()
def measure_mobility(chunk, one, other, at):
    """Compute the nodal mobility 1/m along each axis [1/kg] of both sides (`one`, `other`) and write the values to
    `at.mobility`. The mobility is zero where supports or driven points constrain the node fully. at: a `ContactNodes`."""
    first, end = at.edges[chunk], at.edges[chunk + 1]
    _mobility_of(one, first, end, at.node, at.mobility[0])
    _mobility_of(other, first, end, at.node, at.mobility[1])


@pointwise
def _impulse(friction, n, u, w):
    """Return the impulse on the first side [N s] that stops its approach to the second side, with friction at most at the limit
    of Coulomb.

    n: unit normal. u: velocity of the first side relative to the second [m/s]. w: sum of both mobilities along each axis
    [1/kg].
    """
    approach = u[0] * n[0] + u[1] * n[1] + u[2] * n[2]
    if not approach > 0.0:
        return 0.0, 0.0, 0.0
    jx = -u[0] / w[0] if w[0] > 0.0 else 0.0
    jy = -u[1] / w[1] if w[1] > 0.0 else 0.0
    jz = -u[2] / w[2] if w[2] > 0.0 else 0.0
    if friction.kind != SLIP:
        return jx, jy, jz
    give = w[0] * n[0] * n[0] + w[1] * n[1] * n[1] + w[2] * n[2] * n[2]
    if not give > 0.0:
        return 0.0, 0.0, 0.0
    press = approach / give
    # the rest of the impulse that would stop all slip: it does not act on the approach, also where axes are constrained
    tx, ty, tz = jx + press * n[0], jy + press * n[1], jz + press * n[2]
    along = tx * n[0] + ty * n[1] + tz * n[2]
    size = sqrt((tx - along * n[0]) ** 2 + (ty - along * n[1]) ** 2 + (tz - along * n[2]) ** 2)
    most = size + friction.coefficient * along  # share * size <= coefficient * (press - share * along)
    share = min(1.0, friction.coefficient * press / most) if most > 0.0 else 1.0
    return share * tx - press * n[0], share * ty - press * n[1], share * tz - press * n[2]


@pointwise
def _impulse_at(friction, at, e, allowed, one, other, given):
    """Return the impulse on the first side [N s] that reduces the approach velocity at shared node e to `allowed` [m/s].

    at: a `ContactNodes`. one, other: velocities of all grid nodes of the first and of the second side [m/s]. given: impulse
    included in these velocities, whose effect is subtracted first [N s].
    """
    I, first, second = at.node[e], at.mobility[0], at.mobility[1]
    n = (at.normal[e, 0], at.normal[e, 1], at.normal[e, 2])
    w = (first[e, 0] + second[e, 0], first[e, 1] + second[e, 1], first[e, 2] + second[e, 2])
    ux = one[I, 0] - other[I, 0] - w[0] * given[0] - allowed * n[0]
    uy = one[I, 1] - other[I, 1] - w[1] * given[1] - allowed * n[1]
    uz = one[I, 2] - other[I, 2] - w[2] * given[2] - allowed * n[2]
    return _impulse(friction, n, (ux, uy, uz), w)


@pointwise
def _any(impulse):
    """Return True if any component of an impulse is not zero."""
    return impulse[0] != 0.0 or impulse[1] != 0.0 or impulse[2] != 0.0


@kernel(inline=True)
def _add_to_node(nodes, I, d, more):
    if nodes.strain_velocity[I, d] == nodes.velocity[I, d]:  # else a light node, whose forces must not strain points
        nodes.strain_velocity[I, d] += more
    nodes.velocity[I, d] += more
    nodes.velocity_increment[I, d] += more


@parallel_loop()
def resolve(chunk, friction, anew, one, other, at, allowed, total):
    """Apply to the nodes of both sides (`one`, `other`) the impulses that stop their approach; add them to `total` [N s], shape
    (n, 3).

    friction: a `Friction`. anew: True to recompute all impulses of this step, so that earlier impulses may be partly removed.
    at: a `ContactNodes`. allowed: approach velocity that remains at each node [m/s], shape (n,).
    """
    first, second, share = one.nodes, other.nodes, 1.0 if anew else 0.0
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = at.node[e]
        given = (share * total[e, 0], share * total[e, 1], share * total[e, 2])
        impulse = _impulse_at(friction, at, e, allowed[e], first.velocity, second.velocity, given)
        more = impulse[0] - given[0], impulse[1] - given[1], impulse[2] - given[2]
        if not _any(more):
            continue
        for d in range(3):
            _add_to_node(first, I, d, at.mobility[0, e, d] * more[d])
            _add_to_node(second, I, d, -at.mobility[1, e, d] * more[d])
            total[e, d] += more[d]


@parallel_loop()
def apply(chunk, one, other, at, impulse, total):
    """Apply impulses [N s], shape (n, 3), to the nodes `at` of the first side (`one`) and their opposites to the second
    side (`other`); add them to `total`, shape (n, 3)."""
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = at.node[e]
        for d in range(3):
            _add_to_node(one.nodes, I, d, at.mobility[0, e, d] * impulse[e, d])
            _add_to_node(other.nodes, I, d, -at.mobility[1, e, d] * impulse[e, d])
            total[e, d] += impulse[e, d]


@parallel_loop()
def stop_straining(chunk, friction, one, other, at, total):
    """Stop the approach of the strain velocities of both sides (nodal velocities, mapped from the points again, that strain
    the points); add the required impulses on the first side to `total` [N s], shape (n, 3).

    friction: a `Friction`. one, other: nodes of both sides. at: a `ContactNodes`.
    """
    first, second = one.nodes.strain_velocity, other.nodes.strain_velocity
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = at.node[e]
        impulse = _impulse_at(friction, at, e, 0.0, first, second, (0.0, 0.0, 0.0))
        if not _any(impulse):
            continue
        for d in range(3):
            first[I, d] += at.mobility[0, e, d] * impulse[d]
            second[I, d] -= at.mobility[1, e, d] * impulse[d]
            total[e, d] += impulse[d]


@pointwise
def _velocity_at_start(nodes, mobility, e, I, d):
    return nodes.momentum[I, d] / nodes.mass[I] if mobility[e, d] > 0.0 else nodes.velocity[I, d]


@parallel_loop()
def measure_parting(chunk, one, other, at, allowed):
    """Compute the speed at which both sides (`one`, `other`) separate along the normal at the start of the step [m/s]; write it
    to `allowed`, shape (n,).

    The value is 0 at nodes where the sides approach each other. at: a `ContactNodes`.
    """
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I, parting = at.node[e], 0.0
        for d in range(3):
            v = _velocity_at_start(one.nodes, at.mobility[0], e, I, d)
            parting += (_velocity_at_start(other.nodes, at.mobility[1], e, I, d) - v) * at.normal[e, d]
        allowed[e] = max(0.0, parting)


@kernel(inner=True)
def _sum_side(chunk, side, at, mobility, sign, impulse, works):
    nodes, external, moved_by_grid, node = side.nodes, side.external, side.moves_points, at.node
    velocity, mean_velocity, constrained = nodes.velocity, nodes.mean_velocity, nodes.constrained
    driven_mass, driven_impulse = external.driven_mass, external.impulse
    contact = support = moved = 0.0
    first = FIRST_LOAD + len(external.loads) + 1  # of the impulses
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = node[e]
        for d in range(3):
            j, new = sign * impulse[e, d], velocity[I, d]
            if mobility[e, d] > 0.0:
                mean = mean_velocity[I, d]
                if len(driven_mass) > 0 and driven_mass[I, d] > 0.0:  # of forces, but not of impulses after them
                    mean = new - 0.5 * nodes.velocity_increment[I, d]
                contact += j * mean if moved_by_grid else 0.0
                continue
            contact += j * new
            if constrained[I, d] > 0:
                works[chunk, first + 3 * (constrained[I, d] - 1) + d] -= j
                support -= j * new
            else:
                driven_impulse[I, d] -= j / driven_mass[I, d]
                moved -= j * new
    works[chunk, CONTACT] += contact
    works[chunk, SUPPORT] += support
    works[chunk, MOTION] += moved


@parallel_loop()
def sum_works(chunk, one, other, at, impulse, works):
    """Add the work [J] of the contact impulses on both sides (`one`, `other`), and of the resulting reactions of supports
    and prescribed motions, to `works`.

    at: a `ContactNodes`. impulse: impulses on the first side [N s], shape (n, 3). works: one row for each chunk of nodes,
    see `pellucid.energy`. Call when the mean velocities of the nodes over the step are known. On a side whose nodes do not
    move the points (`Side.moves_points`), only work on constrained nodes counts, because the body itself computes the rest.
    """
    _sum_side(chunk, one, at, at.mobility[0], 1.0, impulse, works)
    _sum_side(chunk, other, at, at.mobility[1], -1.0, impulse, works)


@parallel_loop()
def sum_lag_works(chunk, side, number, at, impulse, small, sums):
    """Compute the lag work of impulses on one side for each chunk of nodes; write it to `sums`, shape (chunks, 1) [J].

    The lag work is the work along the mean nodal velocity minus the work along the mean of the velocities mapped from the
    points before and after the step. number: 0 for the first side, 1 for the second. impulse: impulses on the first side [N s],
    shape (n, 3). Call after the momentum of the points was mapped to the nodes again. Nodes with a mass of at most `small` [kg]
    have no velocity before the step.
    """
    nodes, driven_mass, mobility, work = side.nodes, side.external.driven_mass, at.mobility[number], 0.0
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = at.node[e]
        for d in range(3):
            led = len(driven_mass) > 0 and driven_mass[I, d] > 0.0  # such points do not follow the node
            if led or not mobility[e, d] > 0.0:
                continue
            old = mean = nodes.mean_velocity[I, d]
            if nodes.mass[I] > small:
                old = nodes.velocity[I, d] - nodes.velocity_increment[I, d]
            work += impulse[e, d] * (mean - 0.5 * (old + nodes.strain_velocity[I, d]))
    sums[chunk, 0] = work
