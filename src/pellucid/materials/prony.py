"""Finite linear viscoelasticity with a Prony series: overstresses that follow changes of the isochoric stress and decay.

The material consists of a hyperelastic solid with a decoupled energy, which carries the load at rest, and of branches k in
parallel, each with a share β_k of the isochoric response and a relaxation time τ_k. In the reference configuration the
overstress Q_k of a branch obeys Q̇_k + Q_k/τ_k = β_k Ṡ, where S is the isochoric second Piola-Kirchhoff stress by F̄; at
constant strain it decays as exp(-t/τ_k). Source: Simo 1987, Comput. Methods Appl. Mech. Eng. 60, 153; Holzapfel 2000,
Nonlinear Solid Mechanics, section 6.10. A step is exact if S is linear in time: Q ← e^(-x) Q + β (1 - e^(-x))/x ΔS, x =
Δt/τ (Taylor, Pister & Goudreau 1970, Int. J. Numer. Methods Eng. 2, 45).

Points store q = F̄ Q F̄ᵀ, which is transformed with each step; the stress is σ = σ(F) + 1/J Σ dev q_k.

Energy: Q = β (S - S̃), where S̃ is the mean of S over the past with the weight e^(-t/τ)/τ. With the same mean of W(C̄) -
W(C̄_s) - ½ S_s : (C̄ - C̄_s) over past states s, β times this mean is an energy Υ with the derivative Q, and Υ̇ = work rate
of Q - Υ/τ. Υ is the energy stored in a branch and Υ/τ its dissipation; neither is negative if W is convex in C̄. It is the
energy of a network whose links break at the rate 1/τ and form again without stress (Green & Tobolsky 1946, J. Chem. Phys.
14, 80). A spring and a dashpot in series would store q:q/(4βμ) at small strains, which equals Υ for a fast load and is less
for a slow one.
"""

from math import sqrt
from typing import Annotated, Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.jit.elementary import power
from pellucid.materials.contract import MATERIALS
from pellucid.materials.decoupled import DecoupledMaterial, dilatational_stiffness
from pellucid.materials.hyperelastic import HyperelasticMaterial, finite_strain
from pellucid.materials.law import (
    Law,
    dissipated_energy,
    energy,
    isochoric_stiffness,
    isochoric_stress,
    signal_speed,
    stored_energy,
    update,
)
from pellucid.materials.point_state import PointState
from pellucid.materials.prony_states import MOST, STATES, branch_energy, overstress, relaxed
from pellucid.materials.viscoelastic import ELASTIC, ViscoelasticMaterial, lost_so_far
from pellucid.model import Model, parameter
from pellucid.registry import OneOf
from pellucid.tensors import (
    IDENTITY,
    NO_STRESS,
    add,
    deformed,
    determinant,
    double_dot,
    multiply,
    rotate,
    scale,
    symmetric_part,
    trace,
)


@finite_strain
class Prony(NamedTuple):
    """Parameters of finite linear viscoelasticity with a Prony series: law of the hyperelastic solid, shares and relaxation
    times [s] of the branches, initial density [kg/m³]."""

    elastic: Law
    shares: tuple[float, ...]
    times: tuple[float, ...]
    rho0: float


class PronyBranch(Model):
    """A branch of the material, i.e. a term of its Prony series: share and relaxation time."""

    share: float = parameter(
        "", "β: initial overstress after a sudden strain, relative to the isochoric equilibrium stress", gt=0
    )
    relaxation_time: float = parameter("s", "relaxation time τ, in which the stress falls to 1/e", gt=0)


class PronyMaterial(ViscoelasticMaterial):
    """Viscoelastic solid whose isochoric stress relaxes by a Prony series (finite linear viscoelasticity). After a sudden
    strain the isochoric stress is 1 + Σβ times its equilibrium value in the hyperelastic solid, with the shares β of the
    branches."""

    kind: Literal["prony"] = "prony"
    elastic: Annotated[DecoupledMaterial, OneOf(MATERIALS, DecoupledMaterial)] = parameter(
        "", f"{ELASTIC}; its energy must have separate isochoric and volumetric parts"
    )
    branches: tuple[PronyBranch, ...] = parameter("", "terms of the series", min_length=1, max_length=MOST)

    def hyperelastic(self) -> HyperelasticMaterial:
        return self.elastic

    def law(self) -> Prony:
        shares = tuple(branch.share for branch in self.branches)
        times = tuple(branch.relaxation_time for branch in self.branches)
        return Prony(self.elastic.law(), shares, times, self.density)

    def initial_state(self) -> PointState:
        n = len(self.branches)
        state: PointState = STATES[n](NO_STRESS, IDENTITY, 0.0, *[0.0] * n, *[NO_STRESS] * n)
        return state

    def wave_speeds(self) -> tuple[float, float]:
        sudden = 1.0 + sum(branch.share for branch in self.branches)
        stiffness = self.elastic.moduli()[1] + sudden * isochoric_stiffness(self.elastic.law(), IDENTITY)
        return sqrt(stiffness / self.density), sqrt(sudden * self.elastic.moduli()[0] / self.density)


@point_function(update, Prony)
def _update(law, state, density, L, dt, length):
    F0 = state.deformation_gradient
    F, f = deformed(L, dt, F0), deformed(L, dt, IDENTITY)
    r = power(determinant(f), -1.0 / 3.0)
    carry = (r * f[0], r * f[1], r * f[2], r * f[3], r * f[4], r * f[5], r * f[6], r * f[7], r * f[8])
    old = rotate(carry, isochoric_stress(law.elastic, F0))
    new = isochoric_stress(law.elastic, F)
    change = add(new, scale(-1.0, old))
    # F is linear in time: its velocity gradient at the end is L (I + dt L)⁻¹
    D = symmetric_part(L)
    end = add(D, scale(-dt, symmetric_part(multiply(L, L))))
    return relaxed(state, law, F, new, (carry, change, D, end, dt))


@point_function(signal_speed, Prony)
def _signal_speed(law, state, density, L, length):
    # what the branches remember, F̄ (β S - Q) F̄ᵀ, resists as a stress S̃ that stays: ½ S̃:C̄ has no more than this stiffness
    F = state.deformation_gradient
    J, share = determinant(F), 0.0
    for k in range(len(law.shares)):
        share += law.shares[k]
    past = add(scale(share, isochoric_stress(law.elastic, F)), scale(-1.0, overstress(state)))
    kept = 7.0 / 3.0 * sqrt(double_dot(past, past)) + 5.0 / 9.0 * abs(trace(past))
    return sqrt(
        (dilatational_stiffness(law.elastic, J) + (1.0 + share) * isochoric_stiffness(law.elastic, F) + kept) / law.rho0
    )


@point_function(stored_energy, Prony)
def _stored_energy(law, state, density):
    return energy(law.elastic, state.deformation_gradient) / law.rho0 + branch_energy(state)


point_function(dissipated_energy, Prony)(lost_so_far)
