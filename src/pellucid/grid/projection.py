"""Nodal velocities, which strain the points, from the momentum mapped to the nodes, with supports and driven points."""

from pellucid.grid.momentum import MASS_EPS, apply_prescribed_velocity, is_unconstrained
from pellucid.grid.supports import meet_walls
from pellucid.jit import kernel, pointwise
from pellucid.jit.vector import load, store


@pointwise
def constrained_velocity(nodes, supports, external, I, d, m, v):
    """Return the velocity of node I of mass m [kg] along axis d [m/s]: v, replaced by that of a support, or corrected by driven
    points (points with a prescribed motion).

    nodes, supports, external: see `AdvancedNodes`.
    """
    s = nodes.constrained[I, d]
    if s == 0 and len(supports.walls.stuck) > 0:
        s = supports.walls.stuck[I, d]
    if s > 0:
        return supports.velocity[s - 1, d]
    return apply_prescribed_velocity(external, I, d, m, v)


@pointwise
def project_node(nodes, supports, external, I):
    """Compute `strain_velocity` of node I: the velocity p/m from the momentum p mapped to the node and its mass m, with the
    constraints of the node.

    nodes, supports, external: see `AdvancedNodes`.
    """
    m = nodes.mass[I]
    over_m = 1.0 / m if m >= MASS_EPS else 0.0
    if is_unconstrained(nodes, external, I):
        store(nodes.strain_velocities, 4 * I, over_m * load(nodes.inertia, 4 * I))
    else:
        for d in range(3):
            v = nodes.momentum[I, d] * over_m
            nodes.strain_velocity[I, d] = constrained_velocity(nodes, supports, external, I, d, m, v)


@kernel(inner=True)
def _meet_chunk(chunk, field):
    """Constrain or release the nodes of a chunk at walls that have friction or open (see `meet_walls`), if their momentum
    has not been advanced yet; field: see `AdvancedNodes`."""
    nodes = field.nodes
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        if nodes.has_mass[I] == 0 and nodes.mass[I] >= MASS_EPS:
            meet_walls(nodes, field.supports, I)


@kernel(inner=True)
def project_chunk(chunk, field, advanced):
    """Compute `strain_velocity` (see `project_node`) of those nodes of a chunk that have mass; field: see `AdvancedNodes`;
    advanced: True if the momentum of the nodes has been advanced in this step."""
    nodes = field.nodes
    if not advanced and len(field.supports.walls.held) > 0:
        _meet_chunk(chunk, field)
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        if nodes.has_mass[I] or (not advanced and nodes.mass[I] >= MASS_EPS):
            project_node(nodes, field.supports, field.external, I)
