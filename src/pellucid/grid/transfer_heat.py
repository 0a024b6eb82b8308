"""Kinetic energy lost at a point by the transfers between points and nodes, and the affine velocity fields of APIC points.

Forces on nodes of mass m_I with the velocity v_I before a step and its increment Δv_I do the work Σ m_I Δv_I·(v_I + Δv_I/2)
(`NodalMomentum.works`). The kinetic energy of FLIP points changes by this work less ½ m (Σ N |Δv|² - |Σ N Δv|²) for each
point of mass m. This is the loss by mass lumping; by Jensen's inequality it is not negative if the shape functions N are
not negative. Other transfers lose more. All expressions contain differences of velocities only, so they do not depend on
the observer.

At the distance r from an APIC point of mass m the velocity field is v + C r. Its kinetic energy is m/2 (|v|² + Σ N |C r|²),
summed over the nodes with the shape functions N at the distances r. Mapping the field to nodes with the velocities v_I
loses m/2 Σ N |v + C r - v_I|²; mapping the nodal velocities back loses m/2 Σ N |v_I - v - C r|² with the new v and C.
Between two steps the point moves relative to the nodes, so N, r and therefore Σ N |C r|² change; this loss is negative half
of the time. With AFLIP the point has the velocity U + f D instead of the interpolated nodal velocity U; D = v + Σ N Δv - U and
the share f of FLIP. It loses less: m (f D·U + ½ f² |D|²). The first term is replaced by a term with the same sum over all
points, m f Σ N (v_I - U)·(v_I° - U° - C r), with the nodal velocities v_I°, U° before the step.
"""

from typing import Any

from pellucid.approximants import GridFunctions
from pellucid.approximants.grid_functions import affine_weights
from pellucid.grid.lattice import Lattice, Nodes
from pellucid.grid.points import FIELD_ENERGY
from pellucid.grid.stencil import Stencil, component_of, gather_gradient, node_at
from pellucid.grid.velocity_transfer import Apic, Blend, Flip, VelocityTransfer
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.vector import nothing


@pointwise
def lumping_heat(energy, change):
    """Return the kinetic energy per unit mass that a point loses by mass lumping [J/kg].

    change: velocity increment of the nodes, interpolated to the point [m/s]; energy: half the squares of the nodal
    increments, interpolated to the point [J/kg].
    """
    return energy - 0.5 * (change[0] * change[0] + change[1] * change[1] + change[2] * change[2])


@generic
def renewed(
    transfer: Any,
    about: Stencil,
    lattice: Lattice,
    nodes: Nodes,
    p: Any,
    known: Any,
    new: Any,
    mapped: Any,
    change: Any,
    lumping: Any,
) -> Any:
    """Return the new affine field of a point and its energy (APIC, AFLIP, else ()), and the kinetic energy per unit mass
    that the transfer turns into heat [J/kg].

    about: stencil of the point; p: its input values, see `velocities.Read`; known: result of `affine_functions`; new:
    velocity of the point after the step; mapped, change: nodal velocity after the step and its increment, interpolated to
    the point [m/s]; lumping: result of `lumping_heat`.
    """


@generic
def kept_heat(transfer: Any, heat: float) -> float:
    """Return the part of the kinetic energy lost by the transfer, `heat` [J/kg], that a point keeps as heat: positive losses
    only, but with APIC every value, since its sign depends on the path of the point."""


@point_function(renewed, Flip)
def _flip(transfer, about, lattice, nodes, p, known, new, mapped, change, lumping):
    return (), lumping


@point_function(kept_heat, Flip)
@point_function(kept_heat, Blend)
def _losses(transfer, heat):
    return heat if heat > 0.0 else 0.0


@point_function(kept_heat, Apic)
def _all(transfer, heat):
    return heat


@point_function(renewed, Blend)
def _blend(transfer, about, lattice, nodes, p, known, new, mapped, change, lumping):
    return (), lumping + _filtered(transfer, about, lattice, nodes, p.velocity, mapped, change)


@pointwise
def _filtered(transfer, about, lattice, nodes, v, mapped, change):
    """Return the kinetic energy per unit mass that the PIC share of a blend removes from a point [J/kg]. A part of it has the
    right sum over all points, but not the value at each point (see below).

    about: stencil of the point; v: velocity of the point before the step; mapped, change: nodal velocity after the step and
    its increment, interpolated to the point [m/s].
    With the velocity u by FLIP, the nodal velocities v_I, d = u - Σ N v_I and the share a of PIC, u - a d has ½ a (2 - a)
    |d|² + a d·Σ N v_I less energy than u. The last term is replaced by a term with the same sum over all points, m a
    (Σ N v_I·v_I° - Σ N v_I · Σ N v_I°), with the nodal velocities v_I° before the step.
    """
    share = 1.0 - transfer.flip
    dx, dy, dz = v[0] + change[0] - mapped[0], v[1] + change[1] - mapped[1], v[2] + change[2] - mapped[2]
    old = (mapped[0] - change[0], mapped[1] - change[1], mapped[2] - change[2])
    velocity, increment = nodes.velocity, nodes.velocity_increment
    wx, wy, wz = about.wx, about.wy, about.wz
    filtered = nothing(v[0])
    for a in range(len(wx)):
        for b in range(len(wy)):
            for c in range(len(wz)):
                apart = nothing(v[0])
                for d in range(3):
                    new = component_of(about, lattice, velocity, a, b, c, d)
                    apart += (new - mapped[d]) * (new - component_of(about, lattice, increment, a, b, c, d) - old[d])
                filtered += wx[a] * wy[b] * wz[c] * apart
    return share * (filtered + (1.0 - 0.5 * share) * (dx * dx + dy * dy + dz * dz))


@generic
def affine_functions(transfer: Any, functions: Any, about: Any) -> Any:
    """Return the factors with which the affine field of a point is computed from the velocities of its nodes: for x, y and z a
    tuple with one factor [1/cell] for each node along the axis, see `affine_weights`. Return () for transfers without affine
    fields.

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
    kept = p.affine[FIELD_ENERGY]  # also in the loss
    heat = _lost(about, lattice, nodes, p.velocity, mapped, p.affine) + kept - reached
    if transfer.flip > 0.0:
        heat -= _kept_by_flip(transfer.flip, about, lattice, nodes, p.velocity, mapped, change, p.affine)
    return (after, reached), heat


@pointwise
def _kept_by_flip(flip, about, lattice, nodes, v, mapped, change, C):
    """Return the kinetic energy per unit mass that a point loses less with AFLIP than with APIC [J/kg]: f Σ N (v_I - U)·(v_I° -
    U° - C r) + ½ f² |D|², see above.

    flip: f; about: stencil of the point; v: velocity of the point before the step; mapped, change: nodal velocity U after the
    step and its increment, interpolated to the point [m/s]; C: its affine field before the step [1/s].
    """
    wx, wy, wz, offset, h = about.wx, about.wy, about.wz, about.offset, lattice.cell
    velocity, increment = nodes.velocity, nodes.velocity_increment
    total = nothing(v[0])
    for d in range(3):
        apart = v[d] + change[d] - mapped[d]
        total += 0.5 * flip * apart * apart
    for a in range(len(wx)):
        rx = h * (offset[0] + float(a))
        for b in range(len(wy)):
            ry = h * (offset[1] + float(b))
            x = (mapped[0] - change[0]) + C[0] * rx + C[1] * ry
            y = (mapped[1] - change[1]) + C[3] * rx + C[4] * ry
            z = (mapped[2] - change[2]) + C[6] * rx + C[7] * ry
            line = nothing(v[0])
            for c in range(len(wz)):
                vx, vy, vz = _nodal_vector(about, lattice, velocity, a, b, c)
                dx, dy, dz = _nodal_vector(about, lattice, increment, a, b, c)
                rz = h * (offset[2] + float(c))
                at_node = (vx - mapped[0]) * ((vx - dx) - (x + C[2] * rz))
                at_node += (vy - mapped[1]) * ((vy - dy) - (y + C[5] * rz))
                at_node += (vz - mapped[2]) * ((vz - dz) - (z + C[8] * rz))
                line += wz[c] * at_node
            total += wx[a] * wy[b] * line
    return flip * total


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
                vx, vy, vz = _nodal_vector(about, lattice, velocity, a, b, c)
                dx, dy, dz = _nodal_vector(about, lattice, increment, a, b, c)
                rz = h * (offset[2] + float(c))
                at_node = _below(vx, dx, new[0], x + C[2] * rz) + squares[node_at(about, lattice, a, b, c)]
                at_node += _below(vy, dy, new[1], y + C[5] * rz)
                at_node += _below(vz, dz, new[2], z + C[8] * rz)
                line += wz[c] * at_node
            total += wx[a] * wy[b] * line
    return total


@pointwise
def _nodal_vector(about, lattice, field, a, b, c):
    """Return the vector of a nodal field, shape (nodes, 3), at node (a, b, c) of the stencil `about`."""
    x, y = component_of(about, lattice, field, a, b, c, 0), component_of(about, lattice, field, a, b, c, 1)
    return x, y, component_of(about, lattice, field, a, b, c, 2)


@pointwise
def _below(velocity, increment, new, there):
    return ((velocity - increment) - new) * (velocity - there)
