"""Kinetic energy lost in the transfers between points and nodes in a step: the part kept by bodies as heat, and the rest.

With FLIP, impulses J_I on the nodes change the nodal velocities by Δv_I = J_I/m_I, and the points gain the kinetic energy
Σ_I J_I·v̄_I - L, with v̄ = v + Δv/2. The loss by mass lumping is

    L = Σ_p h_p = ½ Σ_I J_I·(v_I + Δv_I - v'_I),    v'_I = v_I + Σ_J M_IJ Δv_J / m_I,    M_IJ = Σ_p m_p N_Ip N_Jp,

where v and v' are the nodal velocities from the points before and after the step, N_Ip is the function of node I at point p,
and h_p the loss of point p. Each impulse has done the work J_I·(v_I + v'_I)/2 on the points. (Lumped and consistent masses in
FLIP: Burgess, Sulsky & Brackbill 1992, J. Comput. Phys. 103, 1.)

- Fluids with the conservative update receive the work of their stress along v̄, and h_p point by point: no energy is lost.
- Other bodies are strained along v' with MUSL. Their stress works along (v + v')/2, as their forces do on the points. Their
  part of L, ½ Δt Σ f_I·(v_I + Δv_I - v'_I) with their internal forces f_I, is therefore no loss; it is subtracted from the
  work of internal forces along v̄.
- The contact part of L, of impulses and of forces between surfaces, is likewise subtracted from the work of contact. Second
  impulses of contact Q_I change the velocities of the points once more, after the forces, and the points are strained along
  q_I = Q_I/m_I in the same step: ½ Δt Σ f_I·q_I is moved from contact to the work of internal forces. If no impulse removes
  the approach that contact removes from the straining velocities, this is an error; the same amount is in the error of time
  integration.
- The rest of L belongs to supports, loads and driven points. It is counted as heat of the transfers, `transfer_heat`,
  together with all losses of a blend with PIC or APIC.
"""

from collections.abc import Iterable, Mapping, Sequence

from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.energy import CONTACT, DAMPING, INTERNAL, TRANSFER, StepWork, no_work, total_work
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.capabilities import KeepsHeat
from pellucid.parts.families import GridBody
from pellucid.step.part import StepPart, StepParts


def separate_force_buffers(bodies: Iterable[Sequence[GridBody]]) -> None:
    """Provide separate arrays of nodal forces for bodies that keep heat (whose internal energy contains the losses of the
    transfers), in velocity fields with other bodies that do not. bodies: the bodies of each velocity field.
    """
    for together in bodies:
        if not all(body.keeps_heat for body in together):
            for body in together:
                if body.keeps_heat and isinstance(body, KeepsHeat):
                    body.use_separate_force_buffer()


class TransferHeat(StepPart):
    """Energy that the transfers between points and nodes lose in each step, as heat of the transfers, and the corresponding
    corrections of other works; see `pellucid.bodies.transfer_loss`.

    on_grid: bodies on the grid, by velocity field. parts: parts of the step, among them contact. strained_last: True with MUSL
    and USL, where `NodalMomentum.strain_lag_work` computes the part of L of the bodies that keep no heat. With USL these
    bodies are strained along v + Δv, so this part is zero and all of L is heat. With USF v' is unknown before the next step,
    so this part, and the `lag_work` of contact that follows in the next step, count as work of internal forces; the part of L
    due to other impulses is then in `time_integration_error`.
    """

    def __init__(
        self,
        on_grid: Mapping[VelocityField, Sequence[GridBody]],
        parts: StepParts,
        strained_last: bool,
    ) -> None:
        self._on_grid, self._strained_last = on_grid, strained_last
        contacts: list[ContactPairs | SurfacePairs] = [*parts.of(ContactPairs), *parts.of(SurfacePairs)]
        self._contacts = [contact for contact in contacts if contact]
        self._done = no_work(TRANSFER + 1, 0)

    def end(self, dt: float) -> None:
        lost = [self._loss(field, bodies, dt) for field, bodies in self._on_grid.items()]
        for contact in self._contacts:
            lost.append(no_work(TRANSFER + 1, 0))
            lost[-1].works[CONTACT] = -contact.lag_work
            column, sign = (TRANSFER, -1.0) if self._strained_last else (INTERNAL, 1.0)
            lost[-1].works[column] = sign * contact.lag_work
        won = -sum(float(work.works[TRANSFER]) for work in lost)
        if won > 0.0:
            lost.append(self._return_heat(won))
        self._done = total_work(lost, TRANSFER + 1)

    def work(self) -> StepWork:
        return self._done

    def _loss(self, field: VelocityField, bodies: Sequence[GridBody], dt: float) -> StepWork:
        """Return the energy lost by P2G and G2P in one velocity field over a step dt [s], as work of the transfers, and the
        correction of the work of internal forces. bodies: the bodies of the field.

        A drag changes the velocities of points before the step, and so their lead over the stresses, ±½ Δt f·v
        (`EnergyBudget`). This change is also work of the drag, in addition to the kinetic energy that the drag removes from
        the points.
        """
        others = [body.transfer_loss for body in bodies if not body.keeps_heat]
        keeping = [body.transfer_loss for body in bodies if body.keeps_heat]
        taken, kept = sum(loss.total for loss in (*others, *keeping)), sum(loss.kept for loss in keeping)
        of_stress, ahead = sum(loss.lumping for loss in others), 0.0
        if self._strained_last and others:
            ahead = field.second.work(field.momentum, dt)
            of_stress = field.momentum.strain_lag_work(dt) + ahead
        done = no_work(TRANSFER + 1, 0)
        if others:
            done.works[DAMPING] = field.drag_work(dt) if self._strained_last else -field.drag_work(dt)
        done.works[CONTACT] = -ahead
        done.works[INTERNAL] = done.works[DAMPING] + ahead - of_stress - kept
        done.works[TRANSFER] = taken - of_stress - kept
        return done

    def _return_heat(self, won: float) -> StepWork:
        """Remove from the heat kept by fluids the energy `won` [J] that the transfers gained in a step, and return the
        corresponding corrections of the works.

        Such a gain is possible if a fluid shares its velocity field with other bodies. The fluid keeps the losses of its own
        points, which are due to the forces of all bodies; the other bodies get the part of the losses of all points that
        belongs to their forces. The sum may exceed the loss of all points.
        """
        keeping = [body for bodies in self._on_grid.values() for body in bodies if body.keeps_heat]
        done, kept = no_work(TRANSFER + 1, 0), sum(body.transfer_loss.kept for body in keeping)
        if kept > 0.0:
            share = min(won / kept, 1.0)
            for body in keeping:
                if isinstance(body, KeepsHeat):
                    body.return_heat(share)
            done.works[[INTERNAL, TRANSFER]] = share * kept
        return done
