"""The affine velocity fields of APIC points, with the kinetic energy that these have and that the transfers lose.

A point has the velocity v + C r at r from it, and with that the kinetic energy m/2 (|v|² + Σ N |C r|²). Mapping it to the nodes
loses m/2 Σ N |v + C r - v_I|², mapping the nodes' velocities back m/2 Σ N |v_I - v - C r|² with the new v and C. Between two
steps the point moves among the nodes, and Σ N |C r|² changes with N and r: what it loses by that is negative half of the time.
"""

from typing import Any

from numpy import uintp

from pellucid.approximants.axis import affine_weights
from pellucid.grid.blocks import about_lanes, about_point, add_columns, fetch, keep, run_end
from pellucid.grid.points import FIELD_ENERGY
from pellucid.grid.stencil import Stencil, gather_gradient, node_at
from pellucid.grid.velocity_transfer import HEAT, MASS, NEW, OLD, Apic, Blend, Flip
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.columns import WIDTH, put, take_lanes
from pellucid.jit.vector import LANES, nothing
from pellucid.tensors import IDENTITY, ZERO_VECTOR

FIELD = IDENTITY, 0.0  # of a point, with its energy
# columns of a block: fields and their energies before the step and after, weights of four nodes along each axis, m times energy
BEFORE, AFTER, WEIGHTS, OF_POINTS, COUNT = 0, 10, 20, 32, 33


@generic
def renew_affine(
    transfer: Any, mapped: Any, start: int, n: int, found: Any, first_node: Any, c: Any, fields: Any, energies: Any
) -> None:
    """Of APIC: the new affine fields of the n points of a block, and HEAT of its columns `c`, from OLD, NEW and MASS.

    fields: scratch of COUNT columns; energies: a vector to which the kinetic energies of the new fields [J] are added.
    """


@point_function(renew_affine, Flip)
@point_function(renew_affine, Blend)
def _no_fields(transfer, mapped, start, n, found, first_node, c, fields, energies):
    pass


@point_function(renew_affine, Apic)
def _renew(transfer, mapped, start, n, found, first_node, c, fields, energies):
    functions, affine, index = mapped.functions, mapped.affine, mapped.index
    fetch(index, FIELD, affine, start, n, fields, BEFORE * WIDTH)
    for q in range(n):
        put(fields, q + WEIGHTS * WIDTH, _weights(functions, about_point(functions, found, first_node, q)))
    a = 0
    while a < n:
        end = run_end(first_node, a, n)
        while a < end:
            weights = take_lanes(_weights(functions, about_point(functions, found, first_node, 0)), fields, a + WEIGHTS * WIDTH)
            _renew_lanes(mapped, about_lanes(functions, found, first_node, a), weights, a, c, fields)
            a += LANES
        a = end
    keep(index, FIELD, affine, start, n, fields, AFTER * WIDTH)
    for q in range(n):
        fields[uintp(q + OF_POINTS * WIDTH)] = c[uintp(q + MASS * WIDTH)] * fields[uintp(q + (AFTER + FIELD_ENERGY) * WIDTH)]
    add_columns(fields, OF_POINTS, n, energies, 0, 1)


@pointwise
def _weights(functions, about):
    return (
        affine_weights(functions[0], about.offset[0], about.wx, about.gx),
        affine_weights(functions[1], about.offset[1], about.wy, about.gy),
        affine_weights(functions[2], about.offset[2], about.wz, about.gz),
    )


@pointwise
def _renew_lanes(mapped, about, weights, a, c, fields):
    """The fields and the heat of the points from a on that share their nodes with it."""
    lattice, nodes, wx, wy, wz, offset = mapped.lattice, mapped.nodes, about.wx, about.wy, about.wz, about.offset
    before, kept = take_lanes(FIELD, fields, a + BEFORE * WIDTH)
    v, new = take_lanes(ZERO_VECTOR, c, a + OLD * WIDTH), take_lanes(ZERO_VECTOR, c, a + NEW * WIDTH)
    # linear functions spread by nothing at a node: their affine field is a gradient, which light nodes must not spoil
    velocity = nodes.strain_velocity if max(len(wx), len(wy), len(wz)) == 2 else nodes.velocity
    about_field = Stencil(about.start, offset, wx, wy, wz, weights[0], weights[1], weights[2])
    after = gather_gradient(about_field, lattice, velocity)
    spread = _spread(offset[0], wx), _spread(offset[1], wy), _spread(offset[2], wz)
    reached = _energy(after, spread, lattice.cell)
    heat = _lost(about, lattice, nodes, v, new, before) + kept - reached  # the energy of the field before is in both
    put(fields, a + AFTER * WIDTH, (after, reached))
    put(c, a + HEAT * WIDTH, (heat,))


@pointwise
def _spread(offset, w):
    """Σ w r² along an axis, in cells squared."""
    total = nothing(offset)
    for a in range(len(w)):
        r = offset + float(a)
        total += w[a] * r * r
    return total


@pointwise
def _energy(C, spread, cell):
    """Σ N ½ |C r|² [J/kg]: Σ N r r is diagonal, since Σ w r is zero along each axis; along one of a single cell C is zero."""
    x = C[0] * C[0] + C[3] * C[3] + C[6] * C[6]
    y = C[1] * C[1] + C[4] * C[4] + C[7] * C[7]
    z = C[2] * C[2] + C[5] * C[5] + C[8] * C[8]
    return 0.5 * cell * cell * (x * spread[0] + y * spread[1] + z * spread[2])


@pointwise
def _lost(about, lattice, nodes, v, new, C):
    """What the transfers of the step lose of unit mass, without the energies of both fields [J/kg].

    With d = v_I - Δv_I - v', by which v' lies below the nodal velocity before the step, the two losses are ½ |v - v'|² and
    Σ N (d·(v_I - v - C r) + ½ |Δv_I|²), since Σ N r is zero; the last is `increment_energy`, which light nodes do without.
    """
    wx, wy, wz, offset, h = about.wx, about.wy, about.wz, about.offset, lattice.cell
    velocity, increment, squares = nodes.velocity, nodes.velocity_increment, nodes.increment_energy
    total = nothing(v[0])
    for d in range(3):
        total += 0.5 * (v[d] - new[d]) * (v[d] - new[d])
    for a in range(len(wx)):
        rx = h * (offset[0] + float(a))
        for b in range(len(wy)):
            ry = h * (offset[1] + float(b))
            x = v[0] + C[0] * rx + C[1] * ry
            y = v[1] + C[3] * rx + C[4] * ry
            z = v[2] + C[6] * rx + C[7] * ry
            line = nothing(v[0])
            for c in range(len(wz)):
                I = node_at(about, lattice, a, b, c)
                rz = h * (offset[2] + float(c))
                at_node = _below(velocity[I, 0], increment[I, 0], new[0], x + C[2] * rz) + squares[I]
                at_node += _below(velocity[I, 1], increment[I, 1], new[1], y + C[5] * rz)
                at_node += _below(velocity[I, 2], increment[I, 2], new[2], z + C[8] * rz)
                line += wz[c] * at_node
            total += wx[a] * wy[b] * line
    return total


@pointwise
def _below(velocity, increment, new, there):
    return ((velocity - increment) - new) * (velocity - there)
