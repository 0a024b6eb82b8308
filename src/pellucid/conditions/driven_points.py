"""Driven points: material points with prescribed velocity and position. They also constrain the grid nodes to which they
contribute.

The arguments of the kernels are: mapped, the bundle (arrays as the compiled code receives them) of a body's
`MappedPoints`; drive, the bundle of a `DrivenPoints`; nodes, the bundle of the `DrivenNodes` of `pellucid.grid.actions`. A
*slab* is a set of points that one thread updates, in *blocks* of up to BLOCK points. A *group* is a sequence of points of
a block with the same nodes and the same motion.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.folding import add_to_component
from pellucid.grid.lattice import LARGEST_STENCIL
from pellucid.grid.passes.blocks import about_lanes, fetch, find_functions, functions_like
from pellucid.grid.passes.moving import displacement
from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_shares, component_of, node_at, number_at
from pellucid.jit import generic, kernel, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.columns import BLOCK, WIDTH, size
from pellucid.jit.loops import joint_by_colour, joint_region, parallel_by_colour
from pellucid.jit.memory import indices, numbers, zeros
from pellucid.jit.vector import LANES, load, splat, store, total
from pellucid.tensors import ZERO_VECTOR

WORK, LOSS, IMPULSE = range(3)  # columns of `taken`; from IMPULSE on: impulses x, y, z of each motion
SHARES = LARGEST_STENCIL**3 * LANES  # length of the vectors with the shares of nodes in the mass of a group


class DrivenPoints(NamedTuple):
    """Points of a body that follow prescribed motions, the motions, and the works and impulses of the motions in this step."""

    driven: np.ndarray  # (n,) 1 + the index of the motion that each point follows, 0 if it is free
    start: np.ndarray  # (n, 3) initial positions [m]
    velocity: np.ndarray  # (motions, 3) mean velocity of each motion over this step [m/s]
    displacement: np.ndarray  # (motions, 3) displacement of each motion at the end of this step [m]
    axes: np.ndarray  # (motions, 3) 1 for each axis that the motion prescribes
    taken: np.ndarray  # (slabs, IMPULSE + 3 motions) work of the motions and lost energy [J], impulses of the motions [N s]


@pointwise
def _run_end(first_node, motion, q, n):
    """Return the index after the last point of the group that starts at point q of a block; a group is a sequence of points
    with the same nodes and the same motion. first_node: first node of each point; motion: number of the motion of each
    point; n: number of points of the block."""
    end, node, number = q + 1, first_node[q], motion[q]
    while end < n and first_node[end] == node and motion[end] == number:
        end += 1
    return end


@pointwise
def _add_run(functions, found, first_node, index, mass, start, q, end, m, shares):
    """Distribute the masses of the points q to `end` - 1, which form a group (they have the same nodes and motion), to its
    nodes: add them to `shares`, the mass of the group at each node [kg]; return the nodes with their weights (stencil).

    functions, found, first_node: shape functions of the grid and their values at the points of the block; index, mass:
    storage indices and masses [kg] of the body's points; start: first point of the block; m: scratch array for the masses
    of the points; set to zero after the end of the group, so that whole vectors can be read.

    """
    for r in range(q, end):
        m[uintp(r)] = mass[place_of(index, start + r)]
    for r in range(end, end + LANES):
        m[uintp(r)] = 0.0
    about = about_lanes(functions, found, first_node, q)
    for r in range(q, end, LANES):
        add_shares(about_lanes(functions, found, first_node, r), load(m, r), shares)
    return about


@pointwise
def _take_share(shares, number):
    """Return the part of a group's mass that the node with index `number` in the stencil carries [kg], the sum over the
    LANES entries of `shares` for this node, and reset these entries to zero."""
    share = total(load(shares, number * LANES))
    store(shares, number * LANES, splat(0.0))
    return share


class Constrain(NamedTuple):
    """Value of the argument `task` of `at_run`: its type selects the pass that adds the mass and the prescribed momentum of
    a group of points to the nodes."""


class Prescribe(NamedTuple):
    """Value of the argument `task` of `at_run`: its type selects the pass that sets the prescribed velocities of a group of
    points, and sums the work and impulses of the motions."""


class Run(NamedTuple):
    """Group of points of a block that have the same nodes and the same motion, and follow each other in the arrays."""

    first: int  # index in the block of the first point of the group
    end: int  # index in the block after the last point of the group
    motion: Any  # index of the motion, as in the rows of `DrivenPoints.velocity`
    about: Any  # stencil: the nodes to which the points contribute, and their weights


@generic
def at_run(task: Any, s: int, mapped: Any, drive: Any, nodes: Any, start: int, run: Any, m: Any, shares: Any) -> None:
    """Apply a pass (`task`: `Constrain` or `Prescribe`) to a group of points (`run`) of slab s. mapped, drive, nodes: as in
    `constrain_nodes`; start: first point of the block of the group; m: masses of the points [kg]; shares: part of the
    group's mass that each node carries [kg]."""


@point_function(at_run, Constrain)
def _constrain_nodes(task, s, mapped, drive, nodes, start, run, m, shares):
    about, k, number = run.about, run.motion, 0
    for a in range(len(about.wx)):
        for b in range(len(about.wy)):
            for c in range(len(about.wz)):
                I, beyond = node_at(about, mapped.lattice, a, b, c), number_at(about, mapped.lattice, a, b, c)
                w = _take_share(shares, number)
                number += 1
                for d in range(3):
                    if drive.axes[k, d]:
                        nodes.mass[I, d] += w
                        add_to_component(mapped.lattice.folding, nodes.momentum, beyond, d, w * drive.velocity[k, d])


@point_function(at_run, Prescribe)
def _prescribe_velocities(task, s, mapped, drive, nodes, start, run, m, shares):
    v, taken, k = mapped.points.velocity, drive.taken, run.motion
    on_nodes = _impulse_on_nodes(run.about, mapped.lattice, nodes.impulse, shares)
    for d in range(3):
        if drive.axes[k, d]:
            goal, work, loss, impulse = drive.velocity[k, d], 0.0, 0.0, on_nodes[d]
            for r in range(run.first, run.end):
                p = place_of(mapped.index, start + r)
                apart = goal - v[p, d]
                change = m[uintp(r)] * apart
                work += change * goal
                loss += 0.5 * change * apart
                impulse += change
                v[p, d] = goal
            taken[s, WORK] += work
            taken[s, LOSS] += loss
            taken[s, IMPULSE + 3 * k + d] += impulse


@pointwise
def _impulse_on_nodes(about, lattice, nodal_impulse, shares):
    """Return the impulse on the nodes of a group of points along x, y and z [N s]: the sum over the nodes of `nodal_impulse`
    (impulse per unit mass [m/s], shape (nodes, 3)) times the part of the group's mass that the node carries (`shares`
    [kg]). Sets the shares to zero. about: stencil of the group; lattice: layout of the grid nodes."""
    x = y = z = 0.0
    number = 0
    for a in range(len(about.wx)):
        for b in range(len(about.wy)):
            for c in range(len(about.wz)):
                w = _take_share(shares, number)
                number += 1
                x += w * component_of(about, lattice, nodal_impulse, a, b, c, 0)
                y += w * component_of(about, lattice, nodal_impulse, a, b, c, 1)
                z += w * component_of(about, lattice, nodal_impulse, a, b, c, 2)
    return x, y, z


@kernel(inner=True)
def _slab(s, mapped, drive, nodes, task):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    if slabs.first[s] == slabs.first[s + 1]:
        return
    found, first_node = zeros(WIDTH * size(functions_like(functions))), indices(BLOCK)
    place, motion, m, shares = numbers(WIDTH * size(ZERO_VECTOR)), indices(BLOCK), numbers(WIDTH), zeros(SHARES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, ZERO_VECTOR, points.position, start, n, place, 0)
        find_functions(functions, lattice, n, place, 0, found, first_node)
        for q in range(n):
            motion[q] = drive.driven[place_of(index, start + q)]
        end = 0
        while end < n:
            q = end
            end = _run_end(first_node, motion, q, n)
            if motion[q] > 0:
                about = _add_run(functions, found, first_node, index, points.mass, start, q, end, m, shares)
                at_run(task, s, mapped, drive, nodes, start, Run(q, end, uintp(motion[q] - 1), about), m, shares)


@kernel()
def _constrain_nodes_of(n, mapped, drive, nodes):
    parallel_by_colour(_slab, n, mapped.slabs.across, mapped, drive, nodes, Constrain())


def constrain_nodes(n: int, mapped: Bundle, drive: Bundle, nodes: Bundle) -> None:
    """Add the mass and the prescribed momentum of the driven points in n slabs (sets of points, each updated by one thread)
    to `nodes.mass` and `nodes.momentum`. mapped, drive, nodes: bundles (arrays as the compiled code receives them) of the
    body's `MappedPoints`, of its `DrivenPoints` and of the `DrivenNodes` of its grid."""
    joint_region.give_at_once(lambda: _constrain_nodes_of(n, mapped, drive, nodes), lambda: [nodes.mass, nodes.momentum])


@kernel()
def prescribe_velocities(n, mapped, drive, nodes):
    """Set the prescribed velocities of the driven points in n slabs. Add the work of the motions, the kinetic energy lost,
    and the impulses on points and nodes to `drive.taken`. mapped, drive, nodes: bundles (arrays as the compiled code
    receives them) of the body's `MappedPoints`, of its `DrivenPoints` and of the `DrivenNodes` of its grid."""
    joint_by_colour(_slab, n, mapped.slabs.across, mapped, drive, nodes, Prescribe())


@point_function(displacement, DrivenPoints)
def _prescribed(rule, mapped, p, dt):
    k, x, start = uintp(rule.driven[p] - 1), mapped.points.position, rule.start
    if rule.driven[p] == 0:
        return 0.0, 0.0, 0.0
    dx = start[p, 0] + rule.displacement[k, 0] - x[p, 0] if rule.axes[k, 0] else 0.0
    dy = start[p, 1] + rule.displacement[k, 1] - x[p, 1] if rule.axes[k, 1] else 0.0
    dz = start[p, 2] + rule.displacement[k, 2] - x[p, 2] if rule.axes[k, 2] else 0.0
    return dx, dy, dz


class To(NamedTuple):
    """Rule by which the pass `pellucid.grid.passes.moving` displaces points in a step: each point is moved to a given
    target position."""

    target: np.ndarray  # (n, 3) target positions [m]


@point_function(displacement, To)
def _to_place(rule, mapped, p, dt):
    x, target = mapped.points.position, rule.target
    return target[p, 0] - x[p, 0], target[p, 1] - x[p, 1], target[p, 2] - x[p, 2]
