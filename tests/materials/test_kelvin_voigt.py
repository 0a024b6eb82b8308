"""Kelvin-Voigt solids: steady shear, creep, and what they dissipate, against the formulas of rheology."""

import numpy as np
import pytest
from algebra import matrix
from pydantic import ValidationError
from samples import DECOUPLED, SOFT, TISSUE, material_of

from pellucid.materials.law import (
    cauchy_stress,
    diffusivity,
    dissipated_energy,
    signal_speed,
    stored_energy,
    update,
    wave_speed,
)
from pellucid.tensors import IDENTITY

G, ETA = 17.9e3 / 2.9, 10.0
MATERIAL = material_of(
    "kelvin-voigt", {"density": 1100.0, "viscosity": ETA, "elastic": {k: v for k, v in DECOUPLED.items() if k != "density"}}
)


def simple_shear(rate):
    return (0.0, rate, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_a_steady_simple_shear():
    """τ = G γ + η γ' at any γ, and η γ'² of unit volume and time is lost."""
    law, state, rate, dt = MATERIAL.law(), MATERIAL.initial_state(), 3.0, 1e-3
    for step in range(1, 501):
        state = update(law, state, 1100.0, simple_shear(rate), dt, 0.01)
        assert state.stress[5] == pytest.approx(G * rate * dt * step + ETA * rate, rel=1e-12)
    assert dissipated_energy(law, state, 1100.0) == pytest.approx(ETA * rate**2 * 0.5 / 1100.0, rel=1e-12)
    assert stored_energy(law, state, 1100.0) == pytest.approx(0.5 * G * 1.5**2 / 1100.0, rel=1e-12)
    still = update(law, state, 1100.0, simple_shear(0.0), dt, 0.01)
    assert still.stress == cauchy_stress(law.elastic, still.deformation_gradient)
    assert still.dissipated_energy == state.dissipated_energy


def test_creep():
    """Under a constant shear stress τ₀ it follows γ = τ₀/G (1 - exp(-G t/η)); half of the work is lost at last."""
    law, state, stress = MATERIAL.law(), MATERIAL.initial_state(), 2e3
    tau = ETA / G
    dt = 1e-3 * tau
    time = dt * np.arange(10_001)
    strain = stress / G * -np.expm1(-time / tau)
    for rate in np.diff(strain) / dt:
        state = update(law, state, 1100.0, simple_shear(rate), dt, 0.01)
        # the strain at the end of a step, its rate in the middle
        assert state.stress[5] == pytest.approx(stress, rel=0.51 * dt / tau)
    work = stress * strain[-1] / 1100.0
    assert dissipated_energy(law, state, 1100.0) == pytest.approx(0.5 * work, rel=1e-3)
    assert stored_energy(law, state, 1100.0) == pytest.approx(0.5 * work, rel=1e-3)


def test_a_change_of_volume_is_elastic():
    law, swell = MATERIAL.law(), (2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0)
    state = update(law, MATERIAL.initial_state(), 1100.0, swell, 1e-3, 0.01)
    assert state.stress == cauchy_stress(law.elastic, state.deformation_gradient)
    assert state.dissipated_energy == 0.0


def test_waves_and_diffusion_bound_the_step():
    law = MATERIAL.law()
    assert signal_speed(law, MATERIAL.initial_state(), 1100.0, IDENTITY, 0.01) == wave_speed(law.elastic, IDENTITY)
    assert diffusivity(law, 1100.0) == pytest.approx(4.0 / 3.0 * ETA / 1100.0, rel=1e-15)
    assert MATERIAL.wave_speeds() == MATERIAL.elastic.wave_speeds()


def test_around_any_hyperelastic_solid():
    """Also around fibres: beside the elastic stress there is 2η dev D, symmetric and without trace."""
    material = material_of("kelvin-voigt", {"density": 1100.0, "viscosity": ETA, "elastic": TISSUE})
    law, L = material.law(), (0.0, 3.0, 1.0, -2.0, 5.0, 0.0, 0.5, 0.0, 1.0)
    state = update(law, material.initial_state(), 1100.0, L, 1e-2, 0.01)
    D = 0.5 * (matrix(L) + matrix(L).T)
    viscous = matrix(state.stress) - matrix(cauchy_stress(law.elastic, state.deformation_gradient))
    assert viscous == pytest.approx(2.0 * ETA * (D - np.trace(D) / 3.0 * np.eye(3)), abs=1e-10)


ELASTIC = SOFT | {"kind": "neo-hookean"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"viscosity": -1.0}, "greater than or equal to 0"),
        ({"elastic": SOFT | {"kind": "linear-elastic"}}, "'linear-elastic'.*expected.*'neo-hookean', 'decoupled-neo-hookean'"),
        ({"elastic": {"kind": "kelvin-voigt"}}, "'kelvin-voigt'.*expected"),
        ({"elastic": ELASTIC | {"density": 900.0}}, r"elastic.density = 900 kg/m\^3 differs from density = 1100 kg/m\^3"),
        ({"elastic": ELASTIC | {"poisson_ratio": 0.5}}, r"less than 0\.5"),
    ],
)
def test_impossible_parameters(changes, words):
    with pytest.raises(ValidationError, match=words):
        material_of("kelvin-voigt", {"density": 1100.0, "viscosity": ETA, "elastic": ELASTIC} | changes)


def test_a_density_is_given_once():
    """With any unit; a material that was written out reads as it was."""
    inside = {k: v for k, v in ELASTIC.items() if k != "density"}
    material = material_of("kelvin-voigt", {"density": "1.1 g/cm^3", "viscosity": ETA, "elastic": inside})
    assert material.density == material.elastic.density == pytest.approx(1100.0, rel=1e-15)
    assert material_of("kelvin-voigt", material.model_dump()) == material
