"""Works of contact impulses: kernels. Sides and nodes are as in `pellucid.contact.impulses`."""

from pellucid.energy import CONTACT, FIRST_LOAD, MOTION, SUPPORT
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop


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
                if len(driven_mass) > 0 and driven_mass[I, d] > 0.0:  # along which forces work, but not what came after
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
    """Works of impulses, shape (n, 3), on the nodes of the first side and against the second, whose mean velocities are known;
    what supports and prescribed motions take is their reaction.

    works: rows as `pellucid.energy` has them. A body with its own nodes counts its own.
    """
    _sum_side(chunk, one, at, at.mobility[0], 1.0, impulse, works)
    _sum_side(chunk, other, at, at.mobility[1], -1.0, impulse, works)


@parallel_loop()
def sum_lag_works(chunk, side, number, at, impulse, small, sums):
    """How much more work impulses, shape (n, 3), do along the mean velocity of the nodes of a side, number 0 or 1, than along
    the mean of the velocities that the points give to these before and after the step; sums, shape (chunks, 1) [J].

    Nodes of no more than the mass `small` have no velocity before. When the momentum was mapped again.
    """
    nodes, driven_mass, mobility, work = side.nodes, side.external.driven_mass, at.mobility[number], 0.0
    for e in range(at.edges[chunk], at.edges[chunk + 1]):
        I = at.node[e]
        for d in range(3):
            led = len(driven_mass) > 0 and driven_mass[I, d] > 0.0  # such points do not take what the node got
            if led or not mobility[e, d] > 0.0:
                continue
            old = mean = nodes.mean_velocity[I, d]
            if nodes.mass[I] > small:
                old = nodes.velocity[I, d] - nodes.velocity_increment[I, d]
            work += impulse[e, d] * (mean - 0.5 * (old + nodes.strain_velocity[I, d]))
    sums[chunk, 0] = work
