"""Cubes of soft tissue and of viscoelastic solids as material points: what they store and lose, and that they go on."""

import json

import pytest
from small_cases import advance, box, simulation

BULK = {"density": 1000.0, "bulk_modulus": 2e4}
DECOUPLED = {"kind": "decoupled-neo-hookean", "young_modulus": 1e4, "poisson_ratio": 0.4}
MOONEY = BULK | {"kind": "mooney-rivlin", "c1": 1e3, "c2": 8e2}
OGDEN = BULK | {"kind": "ogden", "shear_moduli": [3e3, -5e2], "exponents": [1.5, -3.0]}
FIBRES = BULK | {"kind": "holzapfel-gasser-ogden", "shear_modulus": 2e3, "k1": 3e3, "k2": 1.5, "dispersion": 0.1}
FIBRES |= {"fibres": [[1, 0.5, 0], [1, -0.5, 0]]}
ELASTIC = {
    "decoupled-neo-hookean": DECOUPLED | {"density": 1000.0},
    "mooney-rivlin": MOONEY,
    "ogden": OGDEN,
    "holzapfel-gasser-ogden": FIBRES,
}
BRANCHES = [{"share": 1.0, "relaxation_time": 0.3}, {"share": 0.5, "relaxation_time": 0.05}]
VISCOUS = {
    "kelvin-voigt": {"kind": "kelvin-voigt", "density": 1000.0, "elastic": OGDEN, "viscosity": 300.0},
    "prony": {"kind": "prony", "density": 1000.0, "elastic": FIBRES, "branches": BRANCHES},
}


def swinging(material, **more):
    """A cube that starts with a wave of velocities, free in space."""
    wave = {"amplitude": (0.5, 0, 0), "wave_vector": (1.0, 0.5, 0)}
    body = box((1, 1, 1), (3, 3, 3), material, velocity_wave=wave)
    return simulation(body, **({"counts": (4, 4, 4), "end": 100.0, "step": 0.01} | more))


@pytest.mark.parametrize("material", ELASTIC.values(), ids=ELASTIC)
def test_an_elastic_cube_swings_and_loses_nothing(material):
    sim = swinging(material)
    kinetic = sim.bodies[0].totals.kinetic
    body = advance(sim, 60).bodies[0]
    energies = sim.budget.energies()
    assert body.totals.stored > 0.1 * kinetic, "it was strained"
    assert "dissipated" not in energies
    assert abs(sim.budget.energy_error()) < 0.02
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert energies["strain"] == pytest.approx(body.frame()["mass"] @ body.frame()["strain_energy"], rel=1e-12)


@pytest.mark.parametrize("material", VISCOUS.values(), ids=VISCOUS)
def test_a_viscous_cube_loses_energy_which_the_balance_tells_apart(material):
    sim = swinging(material)
    kinetic, before = sim.bodies[0].totals.kinetic, 0.0
    for _ in range(20):
        body = advance(sim, 10).bodies[0]
        lost = sim.budget.energies()["dissipated"]
        assert lost > before
        before = lost
    frame, energies = body.frame(), sim.budget.energies()
    assert 0.3 * kinetic < lost < kinetic
    assert lost == pytest.approx(frame["mass"] @ frame["dissipated_energy"], rel=1e-12)
    assert energies["strain"] == pytest.approx(frame["mass"] @ frame["strain_energy"], rel=1e-12)
    assert energies["kinetic"] + energies["strain"] + lost == pytest.approx(kinetic, rel=0.02)
    assert abs(sim.budget.energy_error()) < 0.02
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert "dissipated_energy" in sim.case.body[0].probed


@pytest.mark.parametrize("material", VISCOUS.values(), ids=VISCOUS)
def test_a_checkpoint_has_the_history_of_the_points(material):
    one, other = swinging(material), swinging(material)
    advance(one, 5)
    arrays = {name: array.copy() for name, array in one.state_arrays().items()}
    numbers = json.dumps(one.state_numbers())
    advance(one, 5)
    other.restore(arrays, json.loads(numbers))
    advance(other, 5)
    for name, array in one.state_arrays().items():
        assert other.state_arrays()[name].tobytes() == array.tobytes(), name
    assert other.budget.energies() == one.budget.energies()
