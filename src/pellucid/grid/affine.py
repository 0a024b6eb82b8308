"""The affine velocity fields of APIC points, with the kinetic energy that these have and that the transfers lose.

A point has the velocity v + C r at r from it, and with that the kinetic energy m/2 (|v|² + Σ N |C r|²). Mapping it to the nodes
loses m/2 Σ N |v + C r - v_I|², mapping the nodes' velocities back m/2 Σ N |v_I - v - C r|² with the new v and C. Between two
steps the point moves among the nodes, and Σ N |C r|² changes with N and r: what it loses by that is negative half of the time.
"""

from pellucid.approximants.axis import affine_weights
from pellucid.grid.points import AFFINE, FIELD_ENERGY, place_of
from pellucid.grid.stencil import gather, node_at, stencil
from pellucid.jit import kernel, pointwise
from pellucid.jit.parallel import parallel_for


@pointwise
def _at(C, row, r):
    return C[row] * r[0] + C[row + 1] * r[1] + C[row + 2] * r[2]


@pointwise
def _row(affine, p):
    C = affine[p]
    return C[0], C[1], C[2], C[3], C[4], C[5], C[6], C[7], C[8]


@pointwise
def _energies(about, lattice, nodes, v, new, before, after):
    """Of unit mass [J/kg]: of the affine fields before and after, and what the transfers of the step lose."""
    wx, wy, wz, offset = about.wx, about.wy, about.wz, about.offset
    velocity, increment, squares = nodes.velocity, nodes.velocity_increment, nodes.increment_energy
    old_field = new_field = lost = 0.0
    for a in range(len(wx)):
        for b in range(len(wy)):
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                N = wx[a] * wy[b] * wz[c]
                r = (
                    (offset[0] + a) * lattice.cell,
                    (offset[1] + b) * lattice.cell,
                    (offset[2] + c) * lattice.cell,
                )
                one = two = loss = 0.0
                for d in range(3):
                    then, now = _at(before, 3 * d, r), _at(after, 3 * d, r)
                    old = velocity[I, d] - increment[I, d]
                    one += 0.5 * then * then
                    two += 0.5 * now * now
                    # ½ |v_I|² from ½ |v_I°|², v_I°·Δv_I and ½ |Δv_I|², which light nodes do without
                    loss += 0.5 * (v[d] + then - old) ** 2 + 0.5 * (old - new[d]) ** 2 + (old - new[d]) * increment[I, d]
                old_field += N * one
                new_field += N * two
                lost += N * (loss + squares[I] - two)
    return old_field, new_field, lost


@kernel(inner=True)
def _gather_affine_slab(s, mapped, gradient):
    functions, lattice, affine, index = mapped.functions, mapped.lattice, mapped.affine, mapped.index
    points, slabs, nodes, h = mapped.points, mapped.slabs, mapped.nodes, mapped.lattice.inverse_cell
    velocity, heat = points.velocity, mapped.heat
    field_energy = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz, offset = about.wx, about.wy, about.wz, about.offset
        bx = affine_weights(functions[0], offset[0], wx, about.gx)
        by = affine_weights(functions[1], offset[1], wy, about.gy)
        bz = affine_weights(functions[2], offset[2], wz, about.gz)
        before, kept = _row(affine, p), affine[p, FIELD_ENERGY]
        affine[p, :] = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    for d in range(3):
                        affine[p, 3 * d] += h * bx[a] * wy[b] * wz[c] * gradient[I, d]
                        affine[p, 3 * d + 1] += h * wx[a] * by[b] * wz[c] * gradient[I, d]
                        affine[p, 3 * d + 2] += h * wx[a] * wy[b] * bz[c] * gradient[I, d]
        v, new = (velocity[p, 0], velocity[p, 1], velocity[p, 2]), gather(about, lattice, nodes.velocity)
        here, reached, lost = _energies(about, lattice, nodes, v, new, before, _row(affine, p))
        heat[p], affine[p, FIELD_ENERGY] = lost + kept - here, reached
        field_energy += points.mass[p] * reached
    slabs.sums[s, AFFINE] = field_energy


@kernel()
def gather_affine(n, mapped, gradient):
    """The affine fields of the nodal velocity `gradient` [m/s], shape (nodes, 3), about the points of n slabs.

    Before the points' velocities are new. Fills `heat` with what the transfers and the way of the points since lose, and AFFINE
    of the sums with the kinetic energy of the new fields [J].
    """
    parallel_for(_gather_affine_slab, n, mapped, gradient)
