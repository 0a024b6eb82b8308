"""Initial stress of solids: rest between walls, energy, and the wave that a free end sends out."""

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SLIP, SOLID, advance, box, case, simulation

from pellucid.materials.hyperelastic import stretch_under
from pellucid.materials.law import cauchy_stress, energy
from pellucid.materials.neo_hookean import NeoHookeanMaterial

STRESS = (-300.0, 200.0, 50.0, 30.0, 0.0, -20.0)
AXIAL = (-10.0, 0.0, 0.0, 0.0, 0.0, 0.0)
VISCOUS = {"kind": "kelvin-voigt", "density": 1000.0, "elastic": SOLID, "viscosity": 1.0}
SOLIDS = {"rate form": RATE_SOLID, "neo-Hookean": SOLID}


@pytest.mark.parametrize("solid", SOLIDS)
def test_a_stressed_block_between_walls_stays_at_rest(solid):
    block = box((0, 0, 0), (4, 4, 4), SOLIDS[solid]) | {"initial_stress": (-300.0, -200.0, -50.0, 0, 0, 0)}
    sim = advance(simulation(block, support=SLIP), 50)
    assert np.abs(sim.bodies[0].arrays["velocity"]).max() < 1e-12
    assert sim.bodies[0].field("stress") == pytest.approx(np.tile((-300.0, -200.0, -50.0, 0, 0, 0), (512, 1)), abs=1e-5)


def test_a_bar_that_is_let_go_expands_with_the_speed_of_its_wave():
    """From a free end a wave at c frees the stress: behind it v = -σ/(ρ c), and the momentum grows as -σ A t."""
    solid = RATE_SOLID | {"poisson_ratio": 0.0}
    bar = box((0, 0, 0), (32, 1, 0), solid, (2, 1, 1)) | {"initial_stress": AXIAL}
    support = [wall for wall in SLIP[:4] if wall["where"] != "x-upper"]
    sim = simulation(
        bar, counts=(40, 1, 1), functions="quadratic-bspline", thickness=1.0, support=support, end=100.0, courant=0.2
    )
    speed = np.sqrt(1e4 / 1000.0)
    while sim.time < 16.0 / speed:  # half of the bar is free
        sim.step()
    arrays = sim.bodies[0].arrays
    behind = arrays["position"][:, 0] > 24.0
    # the front rings over some cells, of which the mean is taken over eight
    assert arrays["velocity"][behind, 0].mean() == pytest.approx(10.0 / (1000.0 * speed), rel=0.03)
    assert sim.momentum()[0] == pytest.approx(10.0 * sim.time, rel=0.01)
    assert abs(sim.budget.conservation()["energy"]) < 0.01
    assert np.abs(arrays["stress"][arrays["position"][:, 0] < 8.0, 0] + 10.0).max() < 0.2, "the wave is not there yet"


def test_energy_of_the_rate_form_is_that_of_linear_elasticity():
    block = box((0, 0, 0), (4, 4, 4), RATE_SOLID) | {"initial_stress": AXIAL}
    assert simulation(block, support=SLIP).budget.energies()["strain"] == pytest.approx(64.0 * 10.0**2 / (2 * 1e4))


def test_a_hyperelastic_solid_is_stretched_so_that_it_bears_the_stress():
    law = NeoHookeanMaterial(density=1000.0, young_modulus=1e4, poisson_ratio=0.3).law()
    F = stretch_under(law, STRESS)
    assert cauchy_stress(law, F) == pytest.approx(STRESS, rel=1e-7, abs=1e-6)
    sim = simulation(box((0, 0, 0), (4, 4, 4), SOLID) | {"initial_stress": STRESS}, support=SLIP)
    volume_ratio = np.linalg.det(np.array(F).reshape(3, 3))
    assert sim.bodies[0].mass == pytest.approx(1000.0 * 64.0 / volume_ratio)
    assert sim.budget.energies()["strain"] == pytest.approx(energy(law, F) * 64.0 / volume_ratio)


@pytest.mark.parametrize("component", [0, 3])
@pytest.mark.parametrize("size", [1e9, 1e20, 1e30, 1e300])
def test_a_stress_beyond_every_stretch_is_refused(size, component):
    law = NeoHookeanMaterial(density=1200.0, young_modulus=2e6, poisson_ratio=0.3).law()
    stress = tuple(size if place == component else 0.0 for place in range(6))
    with pytest.raises(ValueError, match="no deformation was found with the stress"):
        stretch_under(law, stress)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (box((0, 0, 0), (4, 4, 4), GAS), "cannot have an initial stress"),
        (box((0, 0, 0), (4, 4, 4), SOLID) | {"rigid": True}, "a rigid body has no stress"),
        (box((0, 0, 0), (4, 4, 4), VISCOUS), "cannot have an initial stress"),
    ],
)
def test_what_bears_no_stress_is_refused(body, message):
    with pytest.raises(ValueError, match=message):
        case(body | {"initial_stress": AXIAL})
