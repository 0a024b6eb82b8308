"""Momentum equation of the nodes with the consistent mass matrix, approximated by one iteration.

The points move with the velocity Σ_I N_I v_I and have the kinetic energy ½ Σ_IJ v_I M_IJ v_J, with the consistent mass matrix
M_IJ = Σ_p m_p N_I N_J. The lumped masses m_I = Σ_J M_IJ count more energy, ½ Σ_I m_I v_I²: by the factor 1 + k²h²/4 in a wave
with the wave number k on cells of the size h, if the functions are quadratic B-splines. So waves of some cells are too heavy,
and layers of vorticity that are thinner than a cell move too much fluid with them.

The series m⁻¹ (1 + (1 - S) + (1 - S)² + ...), S = m⁻¹ M, is the inverse of M. Its first two terms change the velocity
increment Δv of the lumped masses to (2 - S) Δv, with an error (1 - S)² of fourth order in k h; S Δv is the map of Δv to the
points and back. Along directions in which supports hold a node, Δv is prescribed and remains. The impulses m (1 - S) Δv add
up to zero over all nodes; the supports exert the opposite of those that would act along held directions.

The effective mass m (2 - S)⁻¹ is symmetric and at least half the lumped one, since the eigenvalues of S are between 0 and 1.
Accelerations by given forces are therefore at most doubled, and the limit of stable steps is 1/√2 of that with lumped masses,
or half of it if viscosity limits the step. Free surfaces come close to this bound: the largest squares of frequencies are 5.6
(c/h)² with lumped masses and 10.5 (c/h)² with the consistent matrix, for waves of the speed c; away from surfaces 1.5 and
2.4.

The impulses do the work Σ m (1 - S) Δv·v̄ along the mean velocities v̄ of the nodes, to second order the change of the
difference ½ Σ v m (1 - S) v between both kinetic energies. The points carry this difference in their affine fields.

Transfers with affine fields are required: they map velocities of the points to the nodes with an error of fourth order in k
h, like the series. With FLIP the nodes have velocities S v instead of v, and the velocities that move the points would have
to be corrected too.

Sources: Burgess, Sulsky & Brackbill 1992, J. Comput. Phys. 103, 1 (lumped and consistent masses); Nairn & Hammerquist 2021
and Nairn 2026, arXiv:2604.07307 (the series as FMPM(k), for transfers without affine fields).
"""

from collections.abc import Sequence
from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np

from pellucid.energy import MASS_MATRIX_WORK, StepWork, WorkLayout
from pellucid.grid.folding import Mirrored
from pellucid.grid.nodal_conditions import MASS_EPS
from pellucid.grid.nodal_fields import STEP, SUM, NodalField, allocate
from pellucid.grid.plane_impulses import PlaneImpulses
from pellucid.grid.transfer import apply_mass_matrix
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.step.limit import StepLimit, tightest, with_consistent_mass
from pellucid.step.part import StepPart


class MappedNodes(NamedTuple):
    """Nodal array of the correction to the consistent mass matrix."""

    mapped_momentum: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "kg m/s", "momentum of the velocity increments, mapped to the points and back")
    ]


class Mapped(Protocol):
    """Interface of a body whose points move with the nodes of the grid, as `ConsistentMass` reads it."""

    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`
    transfer: VelocityTransfer  # transfer of velocities between points and grid

    def step_limit(self) -> StepLimit: ...


class ConsistentMass(StepPart):
    """Impulses on the nodes of a velocity field that replace their lumped masses by the consistent mass matrix, see
    `pellucid.grid.consistent_mass`. Acts before the impulses of conditions, which may prescribe velocities.

    field: the velocity field; bodies: all bodies of the field on the grid; layout: order of the works of a step.
    """

    def __init__(self, field: VelocityField, bodies: Sequence[Mapped], layout: WorkLayout) -> None:
        self._field, self._bodies, self._layout = field, bodies, layout
        self._column = layout.column(MASS_MATRIX_WORK)
        mirrored = isinstance(field.grid.lattice.folding, Mirrored)
        self._planes = PlaneImpulses(bodies, layout.n_supports, flip=1.0) if mirrored else None
        self.pushed_fields = [field]
        self._target = allocate(MappedNodes, field.grid.n_nodes).mapped_momentum
        self._done = layout.no_work()

    def act_on_nodes(self, dt: float) -> None:
        nodes, target = self._field.grid.nodes, self._target
        target.fill(0.0)
        for body in self._bodies:
            apply_mass_matrix(body.n_slabs, body.mapped, nodes.velocity_increment, target)
        impulse = nodes.mass[:, None] * nodes.velocity_increment - target
        impulse[nodes.mass < MASS_EPS] = 0.0
        self._done = self._layout.no_work()
        if self._planes is not None:  # what the lumped masses of nodes next to planes count of mirror images
            self._planes.after_momentum()
            self._done.reactions[:] -= self._planes.work().reactions
        self._field.add_impulses(impulse, self._column)
        impulse, support = domain.of_nodes(impulse), domain.of_nodes(nodes.constrained)
        for s in range(1, self._layout.n_supports + 2):
            self._done.reactions[s - 1] -= np.where(support == s, impulse, 0.0).sum(axis=0)
        self._done.impulse[:] -= self._done.reactions.sum(axis=0)  # already in those of the field

    def work(self) -> StepWork:
        return self._done

    def step_limit(self) -> StepLimit:
        return tightest(with_consistent_mass(body.step_limit()) for body in self._bodies)


def consistent_mass(field: VelocityField, bodies: Sequence[Any], layout: WorkLayout) -> list[ConsistentMass]:
    """Return the correction of a velocity field to the consistent mass matrix in a list; arguments: see `ConsistentMass`."""
    return [ConsistentMass(field, bodies, layout)]
