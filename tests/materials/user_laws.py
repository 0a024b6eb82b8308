"""Laws as users write them, in a file of their own: a hyperelastic one by its energy, two viscoelastic ones with states."""

from math import exp, sqrt
from typing import ClassVar, Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.jit.elementary import expm1, log, log1p
from pellucid.materials.contract import PointMaterial
from pellucid.materials.coupled import CoupledMaterial
from pellucid.materials.decoupled import BulkMaterial, decoupled
from pellucid.materials.elastic import ElasticMaterial, lame
from pellucid.materials.hyperelastic import finite_strain, hyperelastic
from pellucid.materials.law import (
    cauchy_stress,
    coupled_energy,
    diffusivity,
    invariant_energy,
    rate_type,
    signal_speed,
    stored_energy,
    update,
    volumetric_energy,
)
from pellucid.materials.neo_hookean import NeoHookean
from pellucid.materials.point_state import point_state
from pellucid.model import parameter
from pellucid.tensors import (
    IDENTITY,
    NO_STRESS,
    SYMMETRIC_IDENTITY,
    Symmetric,
    Tensor,
    add,
    deformed,
    deviator,
    double_dot,
    rotate,
    scale,
    spin_rotation,
    symmetric_part,
    trace,
)


# Gent 1996, Rubber Chem. Technol. 69, 59: chains that lock where Ī₁ - 3 reaches a limit
@decoupled
class Gent(NamedTuple):
    mu: float
    limit: float
    kappa: float
    rho0: float


class GentMaterial(BulkMaterial):
    kind: Literal["gent"] = "gent"
    shear_modulus: float = parameter("Pa", "shear modulus μ", gt=0)
    limit: float = parameter("", "largest Ī₁ - 3", gt=0)

    def law(self):
        return Gent(self.shear_modulus, self.limit, self.bulk_modulus, self.density)


@point_function(invariant_energy, Gent)
def _gent(law, first, second):
    return -0.5 * law.mu * law.limit * log1p(-first / law.limit)


# Ciarlet 1988, Mathematical Elasticity 1, section 4.10: polyconvex, with any Lamé constants at rest
@hyperelastic
class CiarletGeymonat(NamedTuple):
    c1: float
    c2: float
    lam: float
    rho0: float


class CiarletGeymonatMaterial(CoupledMaterial):
    kind: Literal["ciarlet-geymonat"] = "ciarlet-geymonat"
    c1: float = parameter("Pa", "coefficient of I₁", gt=0)
    c2: float = parameter("Pa", "coefficient of I₂", ge=0)
    lam: float = parameter("Pa", "coefficient of J²", gt=0)

    def law(self):
        return CiarletGeymonat(self.c1, self.c2, self.lam, self.density)


@point_function(coupled_energy, CiarletGeymonat)
def _ciarlet(law, first, second, J):
    by_log = 2.0 * law.c1 + 4.0 * law.c2 + 0.5 * law.lam
    return law.c1 * first + law.c2 * second + 0.25 * law.lam * (J * J - 1.0) - by_log * log(J)


# the shear energy of foamed rubber of Blatz & Ko 1962, Trans. Soc. Rheol. 6, 223, by tr b⁻¹, and the volume's of `neo_hookean`
@hyperelastic
class Foam(NamedTuple):
    mu: float
    lam: float
    rho0: float


class FoamMaterial(CoupledMaterial):
    kind: Literal["foam"] = "foam"
    mu: float = parameter("Pa", "shear modulus μ", gt=0)
    lam: float = parameter("Pa", "Lamé's constant λ", gt=0)

    def law(self):
        return Foam(self.mu, self.lam, self.density)


@point_function(coupled_energy, Foam)
def _foam(law, first, second, J):
    return 0.5 * law.mu * ((second + 3.0) / (J * J) - 3.0) + (law.mu + 0.5 * law.lam * log(J)) * log(J)


# Fung's exponential, with the volumetric energy of Simo & Taylor 1982, Comput. Methods Appl. Mech. Eng. 33, 845
@decoupled
class Fung(NamedTuple):
    mu: float
    b: float
    kappa: float
    rho0: float


class FungMaterial(BulkMaterial):
    kind: Literal["fung"] = "fung"
    shear_modulus: float = parameter("Pa", "shear modulus μ", gt=0)
    stiffening: float = parameter("", "exponent b", gt=0)

    def law(self):
        return Fung(self.shear_modulus, self.stiffening, self.bulk_modulus, self.density)


@point_function(invariant_energy, Fung)
def _fung(law, first, second):
    return 0.5 * law.mu / law.b * expm1(law.b * first)


@point_function(volumetric_energy, Fung)
def _of_volume(law, J):
    return 0.25 * law.kappa * ((J - 1.0) * (J + 1.0) - 2.0 * log(J))


# the first invariant, with a volumetric energy that softens as the volume grows, of Hencky
@decoupled
class Softening(NamedTuple):
    mu: float
    kappa: float
    rho0: float


class SofteningMaterial(BulkMaterial):
    kind: Literal["softening"] = "softening"
    shear_modulus: float = parameter("Pa", "shear modulus μ", gt=0)

    def law(self):
        return Softening(self.shear_modulus, self.bulk_modulus, self.density)


@point_function(invariant_energy, Softening)
def _softening(law, first, second):
    return 0.5 * law.mu * first


@point_function(volumetric_energy, Softening)
def _softening_of_volume(law, J):
    strain = log(J)
    return 0.5 * law.kappa * strain * strain


# Kelvin-Voigt: σ = σ(F) of a neo-Hookean solid + 2 η dev D
@finite_strain
class KelvinVoigt(NamedTuple):
    elastic: NeoHookean
    viscosity: float


@point_state(viscous_work=("J/kg", "work that the viscosity turned into heat"))
class KelvinVoigtState(NamedTuple):
    stress: Symmetric
    deformation_gradient: Tensor
    viscous_work: float


class KelvinVoigtMaterial(ElasticMaterial, PointMaterial):
    kind: Literal["user-kelvin-voigt"] = "user-kelvin-voigt"
    energy_kind: ClassVar[Literal["internal", "strain"]] = "internal"
    viscosity: float = parameter("Pa*s", "shear viscosity η", ge=0)

    def law(self):
        return KelvinVoigt(NeoHookean(*lame(self.young_modulus, self.poisson_ratio), self.density), self.viscosity)

    def initial_state(self):
        return KelvinVoigtState(NO_STRESS, IDENTITY, 0.0)


@point_function(update, KelvinVoigt)
def _update_kelvin_voigt(law, state, density, L, dt, length):
    F, d = deformed(L, dt, state.deformation_gradient), deviator(symmetric_part(L))
    viscous = scale(2.0 * law.viscosity, d)
    heat = dt * double_dot(viscous, d) / density
    return KelvinVoigtState(add(cauchy_stress(law.elastic, F), viscous), F, state.viscous_work + heat)


@point_function(stored_energy, KelvinVoigt)
def _stored_kelvin_voigt(law, state, density):
    return stored_energy(law.elastic, state, density) + state.viscous_work


@point_function(signal_speed, KelvinVoigt)
def _speed_kelvin_voigt(law, state, density, L, length):
    return signal_speed(law.elastic, state, density, L, length)


@point_function(diffusivity, KelvinVoigt)
def _diffusivity_kelvin_voigt(law, density):
    return 4.0 / 3.0 * law.viscosity / density


# The standard linear solid, a Prony series of one term: linear elasticity and a Maxwell branch, q^∇ = 2 μ₁ dev D - q/τ
@rate_type
class StandardLinear(NamedTuple):
    lam: float
    mu: float
    branch: float
    tau: float


@point_state(overstress=("Pa", "stress of the Maxwell branch"))
class StandardLinearState(NamedTuple):
    stress: Symmetric
    internal_energy: float
    overstress: Symmetric


class StandardLinearMaterial(ElasticMaterial, PointMaterial):
    kind: Literal["standard-linear"] = "standard-linear"
    energy_kind: ClassVar[Literal["internal", "strain"]] = "internal"
    branch_modulus: float = parameter("Pa", "shear modulus μ₁ of the Maxwell branch", ge=0)
    relaxation_time: float = parameter("s", "relaxation time τ", gt=0)

    def law(self):
        return StandardLinear(*lame(self.young_modulus, self.poisson_ratio), self.branch_modulus, self.relaxation_time)

    def initial_state(self):
        return StandardLinearState(NO_STRESS, 0.0, NO_STRESS)


@point_function(update, StandardLinear)
def _update_standard_linear(law, state, density, L, dt, length):
    D, Q = symmetric_part(L), spin_rotation(L, dt)
    fade, faded = exp(-dt / law.tau), -expm1(-dt / law.tau)
    s, q = rotate(Q, state.stress), rotate(Q, state.overstress)
    q1 = add(scale(fade, q), scale(2.0 * law.branch * law.tau * faded, deviator(D)))
    elastic = add(scale(2.0 * law.mu * dt, D), scale(law.lam * trace(D) * dt, SYMMETRIC_IDENTITY))
    stress = add(add(s, elastic), add(q1, scale(-1.0, q)))
    power = 0.5 * double_dot(add(s, stress), D) * (1.0 - 0.5 * dt * trace(D))
    return StandardLinearState(stress, state.internal_energy + dt * power / density, q1)


@point_function(stored_energy, StandardLinear)
def _stored_standard_linear(law, state, density):
    return state.internal_energy


@point_function(signal_speed, StandardLinear)
def _speed_standard_linear(law, state, density, L, length):
    return sqrt((law.lam + 2.0 * law.mu + 4.0 / 3.0 * law.branch) / density)
