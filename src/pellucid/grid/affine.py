"""Affine velocity fields of APIC points, their kinetic energy, and the energy lost by the transfers.

At the distance r from an APIC point of mass m the velocity field is v + C r. Its kinetic energy is m/2 (|v|² + Σ N |C r|²),
summed over the nodes with the shape functions N at the distances r. Mapping the field to nodes with the velocities v_I
loses m/2 Σ N |v + C r - v_I|²; mapping the nodal velocities back loses m/2 Σ N |v_I - v - C r|² with the new v and C.
Between two steps the point moves relative to the nodes, so N, r and therefore Σ N |C r|² change; this loss is negative half
of the time.
"""

from typing import Any

from pellucid.approximants import GridFunctions
from pellucid.approximants.grid_functions import affine_weights
from pellucid.grid.points import FIELD_ENERGY
from pellucid.grid.stencil import Stencil, gather_gradient, node_at
from pellucid.grid.transfer_heat import renewed
from pellucid.grid.velocity_transfer import Apic, Blend, Flip, VelocityTransfer
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.vector import nothing


@generic
def affine_functions(transfer: Any, functions: Any, about: Any) -> Any:
    """Return for APIC the factors of `affine_weights` along each axis, which replace derivatives of the shape functions in the
    affine field of a point; () for other transfers.

    functions: shape functions along x, y, z; about: stencil of the point.
    """


@generic
def affine_energy(transfer: Any, m: float, affine: Any) -> Any:
    """Return the kinetic energy of the affine field of a point of mass m [J]; affine: field [1/s] and its energy per unit mass
    [J/kg]. () if the transfer has no affine fields."""


@point_function(affine_functions, Flip)
@point_function(affine_functions, Blend)
def _no_functions(transfer, functions, about):
    return ()


@point_function(affine_functions, Apic)
def _functions(transfer, functions, about):
    return (
        affine_weights(functions[0], about.offset[0], about.wx, about.gx),
        affine_weights(functions[1], about.offset[1], about.wy, about.gy),
        affine_weights(functions[2], about.offset[2], about.wz, about.gz),
    )


@point_function(affine_energy, Flip)
@point_function(affine_energy, Blend)
def _no_energy(transfer, m, affine):
    return ()


@point_function(affine_energy, Apic)
def _energy_of_field(transfer, m, affine):
    return m * affine[1]


def affine_functions_like(transfer: VelocityTransfer, functions: GridFunctions) -> Any:
    """Return a result of `affine_functions` filled with zeros, from which kernels take its type.

    functions: shape functions along x, y, z.
    """
    return tuple((0.0,) * function.stencil for function in functions) if isinstance(transfer, Apic) else ()


@point_function(renewed, Apic)
def _renew(transfer, about, lattice, nodes, p, known, new, mapped, change, lumping):
    wx, wy, wz, offset = about.wx, about.wy, about.wz, about.offset
    # linear functions spread by nothing at a node: their affine field is a gradient, which light nodes must not spoil
    velocity = nodes.strain_velocity if max(len(wx), len(wy), len(wz)) == 2 else nodes.velocity
    about_field = Stencil(about.start, offset, wx, wy, wz, known[0], known[1], known[2])
    after = gather_gradient(about_field, lattice, velocity)
    spread = spread_along(offset[0], wx), spread_along(offset[1], wy), spread_along(offset[2], wz)
    reached = _energy(after, spread, lattice.cell)
    kept = p.affine[FIELD_ENERGY]
    heat = _lost(about, lattice, nodes, p.velocity, new, p.affine) + kept - reached  # the energy of the field before is in both
    return (after, reached), heat


@pointwise
def spread_along(offset, w):
    """Return Σ w r² over the nodes along an axis [cells²]; w: values of their shape functions at a point, r: their distances
    from the point, which begin with `offset` [cells]."""
    total = nothing(offset)
    for a in range(len(w)):
        r = offset + float(a)
        total += w[a] * r * r
    return total


@pointwise
def _energy(C, spread, cell):
    """Return the kinetic energy of the affine field C [1/s] of a point per unit mass, Σ N ½ |C r|² over the nodes at distances
    r [J/kg].

    spread: results of `spread_along` for x, y, z; cell: edge of a cell [m]. Σ N r r is diagonal since Σ w r is zero along
    each axis; C is zero along an axis of a single cell.
    """
    x = C[0] * C[0] + C[3] * C[3] + C[6] * C[6]
    y = C[1] * C[1] + C[4] * C[4] + C[7] * C[7]
    z = C[2] * C[2] + C[5] * C[5] + C[8] * C[8]
    return 0.5 * cell * cell * (x * spread[0] + y * spread[1] + z * spread[2])


@pointwise
def _lost(about, lattice, nodes, v, new, C):
    """Return the kinetic energy per unit mass that both transfers of a step (points to nodes and back) lose at a point [J/kg],
    without the energies of the affine fields.

    about: stencil of the point; v, new: its velocity before and after the step [m/s]; C: its affine field before the step
    [1/s]. With the velocity v' of the point after the step and the difference d = v_I - Δv_I - v' between the nodal velocity
    before the step and v', the two losses are ½ |v - v'|² and Σ N (d·(v_I - v - C r) + ½ |Δv_I|²), since Σ N r is zero; the
    last term is `increment_energy`, which light nodes omit.
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
