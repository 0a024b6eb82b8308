"""Kinetic energy that the transfers between points and nodes take in a step: what bodies keep as heat, and what leaves.

With FLIP, impulses J_I on the nodes change these by Δv_I = J_I/m_I, and the points gain the kinetic energy
Σ_I J_I·v̄_I - L. Here v̄ = v + Δv/2, and lumping of the mass takes

    L = Σ_p h_p = ½ Σ_I J_I·(v_I + Δv_I - v'_I),    v'_I = v_I + Σ_J M_IJ Δv_J / m_I,    M_IJ = Σ_p m_p N_Ip N_Jp,

where v and v' are the velocities that the points give to the nodes before and after the step. So each impulse has done the
work J_I·(v_I + v'_I)/2 on the points. (Of lumped against consistent masses in FLIP: Burgess, Sulsky & Brackbill 1992,
J. Comput. Phys. 103, 1.)

- Fluids with the conservative update take up the work of their stress along v̄, and h_p point by point: no energy leaves.
- Other bodies are strained along v' with MUSL, so that their stress works along (v + v')/2, as their forces do on the points:
  ½ Δt Σ f_I·(v_I + Δv_I - v'_I), their part of L, is no loss. It is taken off the work of internal forces along v̄.
- The part of contact is likewise taken off the work of contact. By its second impulses points change their velocities once
  more, after the forces, and are strained along q_I = Q_I/m_I in this step already: ½ Δt Σ f_I·q_I goes from contact to the
  work of internal forces. Where no impulse takes the approach that contact takes from the velocities which strain the points,
  this is an error, and as much in the error of time integration.
- What is left of L is that of supports, loads and driven points, which is booked as heat of the transfers, `transfer_heat`,
  as all is that a blend with PIC or APIC takes besides.
"""

from collections.abc import Iterable, Sequence

from pellucid.contact.pairs import ContactPairs
from pellucid.energy import CONTACT, DAMPING, INTERNAL, TRANSFER, StepWork, no_work
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.capabilities import KeepsHeat
from pellucid.parts.families import GridBody


def separate_force_buffers(bodies: Iterable[Sequence[GridBody]]) -> None:
    """Give bodies that keep heat their own nodal forces, in velocity fields where others do not keep heat."""
    for together in bodies:
        if not all(body.keeps_heat for body in together):
            for body in together:
                if body.keeps_heat and isinstance(body, KeepsHeat):
                    body.use_separate_force_buffer()


def transfer_work(field: VelocityField, bodies: Sequence[GridBody], dt: float, strained_last: bool) -> StepWork:
    """Return the energy lost by P2G and G2P in one velocity field over a step dt [s], and the correction of the work of
    internal forces.

    strained_last: with MUSL and USL, `NodalMomentum.strain_lag_work` computes the part of L of the bodies that keep no
    heat. With USL these are strained along v + Δv, so this part is zero and all of L is heat. With USF v' is unknown before
    the next step, so their L counts as work of internal forces; the part of other impulses is then in
    `time_integration_error`.

    A drag changes the velocities of points before the step, and so their lead over the stresses, ±½ Δt f·v
    (`EnergyBudget`). That is also its work, in addition to the kinetic energy that it removes from the points.
    """
    others = [body.transfer_loss for body in bodies if not body.keeps_heat]
    keeping = [body.transfer_loss for body in bodies if body.keeps_heat]
    taken, kept = sum(loss.total for loss in (*others, *keeping)), sum(loss.kept for loss in keeping)
    of_stress, ahead = sum(loss.lumping for loss in others), 0.0
    if strained_last and others:
        ahead = field.second_work(dt)
        of_stress = field.strain_lag_work(dt) + ahead
    done = no_work(TRANSFER + 1, 0)
    if others:
        done.works[DAMPING] = field.drag_work(dt) if strained_last else -field.drag_work(dt)
    done.works[CONTACT] = -ahead
    done.works[INTERNAL] = done.works[DAMPING] + ahead - of_stress - kept
    done.works[TRANSFER] = taken - of_stress - kept
    return done


def contact_lag_work(pairs: ContactPairs) -> StepWork:
    """The part of L of contact, which comes off its work along v̄ and off the heat of the transfers."""
    done = no_work(TRANSFER + 1, 0)
    done.works[[CONTACT, TRANSFER]] = -pairs.lag_work
    return done


def return_heat(bodies: Iterable[GridBody], won: float) -> list[StepWork]:
    """Remove energy [J] that the transfers gained in a step from the heat that fluids kept in it.

    This happens if a fluid shares its velocity field with others: it keeps h_p of its points, a part of L of the forces of
    all, and the others get the part of their forces in L of all points. The sum may exceed L.
    """
    keeping = [body for body in bodies if body.keeps_heat]
    kept = sum(body.transfer_loss.kept for body in keeping)
    if kept <= 0.0:
        return []
    done, share = no_work(TRANSFER + 1, 0), min(won / kept, 1.0)
    for body in keeping:
        if isinstance(body, KeepsHeat):
            body.return_heat(share)
    done.works[[INTERNAL, TRANSFER]] = share * kept
    return [done]
