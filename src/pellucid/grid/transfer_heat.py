"""Kinetic energy lost at a point by the transfers between points and nodes.

Forces on nodes of mass m_I with the velocity v_I before a step and its increment Δv_I do the work Σ m_I Δv_I·(v_I + Δv_I/2)
(`NodalMomentum.works`). The kinetic energy of FLIP points changes by this work less ½ m (Σ N |Δv|² - |Σ N Δv|²) for each
point of mass m. This is the loss by mass lumping; by Jensen's inequality it is not negative if the shape functions N are
not negative. Other transfers lose more. All expressions contain differences of velocities only, so they do not depend on
the observer.
"""

from typing import Any

from pellucid.grid.lattice import Lattice, Nodes
from pellucid.grid.stencil import Stencil, node_at
from pellucid.grid.velocity_transfer import Apic, Blend, Flip
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
    """Return the new affine field of a point and its energy (APIC, else ()), and the kinetic energy per unit mass that the
    transfer turns into heat [J/kg].

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
                I = node_at(about, lattice, a, b, c)
                apart = nothing(v[0])
                for d in range(3):
                    apart += (velocity[I, d] - mapped[d]) * (velocity[I, d] - increment[I, d] - old[d])
                filtered += wx[a] * wy[b] * wz[c] * apart
    return share * (filtered + (1.0 - 0.5 * share) * (dx * dx + dy * dy + dz * dz))
