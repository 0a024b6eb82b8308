"""What every hyperelastic law must do: stress from its energy, objectivity, wave speeds, a rate form that is the same."""

import numpy as np
import pytest
from algebra import matrix, rotation, symmetric, tensor
from samples import HYPERELASTIC, every_hyperelastic

from pellucid.materials.decoupled import DecoupledMaterial
from pellucid.materials.hyperelastic import FiniteStrainState, undefined_strain
from pellucid.materials.law import (
    cauchy_stress,
    energy,
    energy_and_stress,
    first_piola_kirchhoff,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
    volumetric_energy,
    volumetric_stiffness,
    volumetric_stress,
    wave_speed,
)
from pellucid.tensors import IDENTITY, NO_STRESS

every_seed = pytest.mark.parametrize("seed", range(4))


def gradient(seed, size=0.4):
    """A deformation gradient at random."""
    return np.eye(3) + np.random.default_rng(seed).uniform(-size, size, (3, 3))


@every_seed
@every_hyperelastic
def test_energy_and_stress_together_are_those_apart(material, seed):
    law, F = material.law(), tensor(gradient(seed))
    stored, P = energy_and_stress(law, F)
    assert stored == energy(law, F)
    assert first_piola_kirchhoff(law, F) == P


def scale_of(material, F):
    """What rounding and differences are relative to: the modulus, by derivatives that grow as J falls."""
    return material.young_modulus / (1.0 - 2.0 * material.poisson_ratio) * max(1.0, np.linalg.det(F) ** -3)


def derivative(function, F, step):
    """∂f/∂F of a number or an array by central differences; the last two axes are those of F."""
    result = np.zeros((*np.shape(function(F)), 3, 3))
    for i, j in np.ndindex(3, 3):
        dF = np.zeros((3, 3))
        dF[i, j] = step
        result[..., i, j] = (function(F + dF) - function(F - dF)) / (2.0 * step)
    return result


def test_there_is_more_than_one():
    assert {"neo-hookean", "decoupled-neo-hookean", "mooney-rivlin", "ogden", "holzapfel-gasser-ogden"} <= set(HYPERELASTIC)


@every_hyperelastic
def test_at_rest_there_is_neither_energy_nor_stress(material):
    law = material.law()
    assert energy(law, IDENTITY) == 0.0
    assert cauchy_stress(law, IDENTITY) == NO_STRESS
    assert first_piola_kirchhoff(law, IDENTITY) == (0.0,) * 9
    assert material.initial_state() == FiniteStrainState(NO_STRESS, IDENTITY)


@every_hyperelastic
@every_seed
def test_p_is_the_derivative_of_the_energy(material, seed):
    """P = ∂W/∂F."""
    law, F = material.law(), gradient(seed)
    P = derivative(lambda F: energy(law, tensor(F)), F, 1e-5)
    # differences: step² = 1e-10 and rounding/step = 1e-11
    assert matrix(first_piola_kirchhoff(law, tensor(F))) == pytest.approx(P, abs=1e-8 * scale_of(material, F))


@every_hyperelastic
@every_seed
def test_cauchy_stress_is_that_of_p(material, seed):
    """σ = P Fᵀ/J, and P Fᵀ is symmetric."""
    law, F = material.law(), gradient(seed)
    kirchhoff = matrix(first_piola_kirchhoff(law, tensor(F))) @ F.T
    assert kirchhoff == pytest.approx(kirchhoff.T, abs=1e-13 * scale_of(material, F))
    stress = matrix(cauchy_stress(law, tensor(F)))
    assert stress == pytest.approx(kirchhoff / np.linalg.det(F), abs=1e-13 * scale_of(material, F))


@every_hyperelastic
@pytest.mark.parametrize("J", [0.5, 0.95, 1.0, 1.3])
def test_the_volumetric_part(material, J):
    """σ = U'(J) I where all stretches are alike, U' is the slope of U, and both vanish at rest."""
    law, F = material.law(), J ** (1.0 / 3.0) * np.eye(3)
    if isinstance(material, DecoupledMaterial):
        mean = volumetric_stress(law, J)
        # fibres are not strained by a change of volume
        assert cauchy_stress(law, tensor(F)) == pytest.approx((mean, mean, mean, 0, 0, 0), abs=1e-11 * scale_of(material, F))
        assert energy(law, tensor(F)) == pytest.approx(volumetric_energy(law, J), abs=1e-12 * scale_of(material, F))
    slope = (volumetric_energy(law, J + 1e-5) - volumetric_energy(law, J - 1e-5)) / 2e-5
    assert volumetric_stress(law, J) == pytest.approx(slope, abs=1e-8 * scale_of(material, F))
    assert volumetric_energy(law, 1.0) == volumetric_stress(law, 1.0) == 0.0


@every_hyperelastic
@every_seed
def test_objectivity(material, seed):
    """W(QF) = W(F), σ(QF) = Q σ(F) Qᵀ, P(QF) = Q P(F), and waves as fast."""
    law, F, Q = material.law(), gradient(seed), rotation(seed + 20)
    turned, still, scale = tensor(Q @ F), tensor(F), scale_of(material, F)
    assert energy(law, turned) == pytest.approx(energy(law, still), abs=1e-13 * scale)
    stress = symmetric(Q @ matrix(cauchy_stress(law, still)) @ Q.T)
    assert cauchy_stress(law, turned) == pytest.approx(stress, abs=1e-13 * scale)
    P = Q @ matrix(first_piola_kirchhoff(law, still))
    assert matrix(first_piola_kirchhoff(law, turned)) == pytest.approx(P, abs=1e-13 * scale)


def acoustic_speed(law, F, directions):
    """The fastest plane wave along these directions, from differences of P: ρ₀ c² m = (∂P/∂F : m⊗N) N with N = Fᵀn, N not
    normalised."""
    A = derivative(lambda F: matrix(first_piola_kirchhoff(law, tensor(F))), F, 1e-6)
    tensors = [np.einsum("iJkL,J,L->ik", A, F.T @ n, F.T @ n) for n in directions]
    return np.sqrt(max(np.linalg.eigvals(one).real.max() for one in tensors) / law.rho0)


def directions_of(F):
    """Principal directions of b, and 20 others."""
    return [*np.linalg.eigh(F @ F.T)[1].T, *(rotation(k)[0] for k in range(20))]


@pytest.mark.parametrize("name", [name for name, material in HYPERELASTIC.items() if not hasattr(material, "fibres")])
@every_seed
def test_the_wave_speed_at_rest_is_the_acoustic_one(name, seed):
    material = HYPERELASTIC[name]
    speed = acoustic_speed(material.law(), np.eye(3), rotation(seed)[:1])
    assert wave_speed(material.law(), IDENTITY) == pytest.approx(speed, rel=1e-7)
    assert material.wave_speeds()[0] == pytest.approx(speed, rel=1e-7)


@pytest.mark.parametrize("ratio", [0.3, 10.0, 1e4])
@every_hyperelastic
@every_seed
def test_the_wave_speed_is_an_upper_bound_at_any_ratio_of_moduli(material, seed, ratio):
    F, law = gradient(seed, 0.5), material.law()
    modulus = ratio * material.young_modulus / (2.0 + 2.0 * material.poisson_ratio)
    law = law._replace(**{"kappa" if "kappa" in law._fields else "lam": modulus})
    fastest, bound = acoustic_speed(law, F, directions_of(F)), wave_speed(law, tensor(F))
    assert fastest <= bound * (1.0 + 1e-7)
    assert bound < 1.6 * fastest, "a bound so loose would waste steps"


@pytest.mark.parametrize("J", [2.0, 4.0])
def test_the_wave_speed_where_the_volumetric_energy_softens(J):
    """W has U = κ/2 (ln J)², whose second derivative is negative above J = e."""
    material, F = HYPERELASTIC["softening"], J ** (1.0 / 3.0) * np.eye(3)
    assert (volumetric_stiffness(material.law(), J) < 0.0) == (np.e < J)
    fastest, bound = acoustic_speed(material.law(), F, np.eye(3)), wave_speed(material.law(), tensor(F))
    assert fastest <= bound * (1.0 + 1e-7)


def test_the_bulk_modulus_at_rest_is_that_of_the_volumetric_energy():
    for name in ("gent", "fung", "softening"):
        material = HYPERELASTIC[name]
        law = material.law()._replace(kappa=3e4)
        assert volumetric_stiffness(law, 1.0) == pytest.approx(3e4, rel=1e-14)
        assert material.moduli()[1] == pytest.approx(material.bulk_modulus, rel=1e-14)


@pytest.mark.parametrize(("stretch", "factor"), [(1.15, None), (1.3, 1.15), (1.5, 1.0), (float("nan"), None), (1e200, None)])
def test_the_strain_at_which_an_energy_is_no_longer_defined(stretch, factor):
    """The law of Gent with Ī₁ - 3 below 0.2, in isochoric tension along a turned axis: up to the stretch 1.289."""
    law = HYPERELASTIC["gent"].law()._replace(limit=0.2)
    F = rotation(3) @ np.diag([stretch, stretch**-0.5, stretch**-0.5])
    found = undefined_strain(law, tensor(F))
    assert found == factor if factor in (None, 1.0) else 1.0 <= found <= factor


@pytest.mark.parametrize("stretches", [(1.0, 1.0, 2.0), (0.5, 1.0, 1.0), (0.4, 0.5, 0.6), (1.5, 2.0, 2.5), (3.0, 3.0, 4.0)])
def test_the_wave_speed_of_a_neo_hookean_solid_is_exact_where_it_is_stretched_along_the_axes(stretches):
    material, F = HYPERELASTIC["neo-hookean"], np.diag(stretches)
    fastest = acoustic_speed(material.law(), F, np.eye(3))
    assert wave_speed(material.law(), tensor(F)) == pytest.approx(fastest, rel=1e-7)


@every_hyperelastic
@every_seed
def test_the_rate_form_is_the_law_at_the_gradient_that_it_reached(material, seed):
    """After steps with any velocity gradients: the same stress, energy of unit mass and speed, and the volume of det F."""
    law, state, F, volume = material.law(), material.initial_state(), np.eye(3), 1.0
    rates = np.random.default_rng(seed).uniform(-20.0, 20.0, (10, 3, 3))
    for L in rates:
        F = (np.eye(3) + 1e-3 * L) @ F
        volume *= volume_growth(law, tensor(L), 1e-3)
        state = update(law, state, material.density / volume, tensor(L), 1e-3, 0.01)
    # products of ten gradients
    assert matrix(state.deformation_gradient) == pytest.approx(F, abs=1e-14)
    assert volume == pytest.approx(np.linalg.det(F), rel=1e-13)
    reached, density = state.deformation_gradient, material.density / volume
    assert state.stress == cauchy_stress(law, reached)
    assert stored_energy(law, state, density) == energy(law, reached) / material.density
    assert signal_speed(law, state, density, tensor(rates[-1]), 0.01) == wave_speed(law, reached)
