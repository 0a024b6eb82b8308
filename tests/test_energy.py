"""The books of mass, momentum and energy."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import GAS, SLIP, SOLID, advance, box, simulation

from pellucid.conditions.prescribed import ConstraintWork
from pellucid.contact.pairs import ContactWork
from pellucid.energy import EnergyBudget
from pellucid.grid.momentum import StepWork, no_work


def body(kinetic, stored, momentum, mass=2.0, speed=1.0, kind="strain", heating=0.0):
    """What the ledger asks of a body."""
    sums = {"kinetic": kinetic, "stored": stored, "speed": speed, "heating": heating}
    points = SimpleNamespace(mass=np.array([mass]))
    return SimpleNamespace(sums=sums, points=points, energy_kind=kind, momentum=lambda: np.array(momentum))


def work(internal=0.0, gravity=0.0, support=0.0, mass=2.0, impulses=((0.0, 0.0, 0.0),), **more):
    """What the nodes did; `more` are works of other conditions."""
    books = {"load": 0.0, "absorbed": 0.0, "grip": 0.0, "grip_loss": 0.0} | more
    zero = {"absorbed_impulse": np.zeros(3), "load_impulse": np.zeros(3)}
    return StepWork(
        internal=internal, gravity=gravity, support=support, mass=mass, impulses=np.array(impulses), **(zero | books)
    )


FREE = ConstraintWork(0.0, 0.0, {})
APART = ContactWork(0.0, {}, no_work(1))


def test_what_comes_from_outside_is_no_error():
    ledger = EnergyBudget([body(1.0, 0.0, (2.0, 0, 0))], (0.0, 0.0, -10.0))
    # over 0.1 s gravity gives 2 J and -2 N s; a wall 0.5 J and 0.3 N s; internal forces turn 0.7 J into strain
    ledger.record(
        [body(1.0 + 2.0 + 0.5 - 0.7, 0.7, (2.3, 0, -2.0))], work(-0.7, 2.0, 0.5, impulses=[(0.3, 0, 0)]), FREE, APART, 0.1
    )
    conservation = ledger.conservation([body(2.8, 0.7, (2.3, 0, -2.0))])
    assert conservation["energy"] == pytest.approx(0.0, abs=1e-15)
    assert conservation["momentum"] == pytest.approx(0.0, abs=1e-15)
    assert conservation["mass"] == 0.0
    assert ledger.sums["transfer"] == pytest.approx(0.0, abs=1e-15)
    assert ledger.sums["time_integration"] == pytest.approx(0.0, abs=1e-15)


def test_every_condition_has_its_book():
    """2 J of a pressure, 3 J of a motion of which 0.4 + 0.1 J are lost in impact, 0.5 J absorbed, 0.3 J lost in contact: 3.7 J
    of motion are left."""
    ledger = EnergyBudget([body(1.0, 0.0, (0, 0, 0))], (0, 0, 0), ("load", "absorbed", "motion", "impact_heat", "contact"))
    impulses = {"absorbed_impulse": np.array([0.1, 0, 0]), "load_impulse": np.array([0, 0.2, 0])}
    nodes = work(load=2.0, absorbed=0.5, grip=1.0, grip_loss=0.4, impulses=[(0, 0, 0.5), (0, 0, 0)], **impulses)
    driven = ConstraintWork(2.0, 0.1, {"tip": np.array([0, 1.0, 0])})
    # within the bodies: one takes from another, so that no momentum comes in
    touching = ContactWork(-0.3, {"rub": np.array([0, 0, 0.7])}, no_work(2))
    for _ in range(2):
        ledger.record([body(1.0 + 3.7, 0.0, (0.1, 1.2, 0.5))], nodes, driven, touching, 0.1)
    energies = ledger.energies([body(4.7, 0.0, (0, 0, 0))])
    expected = {"load_work": 4.0, "absorbed_energy": 1.0, "motion_work": 6.0, "impact_heat": 1.0, "contact_work": -0.6}
    assert {name: energies[name] for name in expected} == pytest.approx(expected)
    assert ledger.sums["transfer"] == pytest.approx(-3.7), "the second step brought 3.7 J that the points do not show"
    assert ledger.conservation([body(9.0, 0.0, (0.2, 2.4, 1.0))])["momentum"] == pytest.approx(0.0, abs=1e-15)
    reactions = ledger.reactions(["floor", None])
    assert {name: impulse.tolist() for name, impulse in reactions.items()} == {
        "tip": [0, 2.0, 0],
        "rub": [0, 0, 1.4],
        "floor": [0, 0, 1.0],
    }
    assert ledger.reactions(["floor", "floor"])["floor"].tolist() == [0, 0, 1.0], "supports of one name add up"


def test_the_two_errors_are_kept_apart():
    ledger = EnergyBudget([body(10.0, 0.0, (0, 0, 0))], (0, 0, 0))
    ledger.record([body(8.5, 1.2, (0, 0, 0))], work(internal=-1.0), FREE, APART, 0.1)
    assert ledger.sums["transfer"] == pytest.approx(-0.5)  # the points lost 1.5 J, the grid 1.0
    assert ledger.sums["time_integration"] == pytest.approx(0.2)  # the points store 1.2 J of these 1.0
    assert ledger.energy_error() == pytest.approx((-0.5 + 0.2) / 10.0)


def test_lost_momentum_and_mass_are_seen():
    ledger = EnergyBudget([body(1.0, 0.0, (1.0, 0, 0), speed=4.0)], (0, 0, 0))
    conservation = ledger.conservation([body(1.0, 0.0, (0.9, 0, 0), mass=1.5)])
    assert conservation["momentum"] == pytest.approx(0.1 / 4.0)
    assert conservation["mass"] == pytest.approx(0.25)


def test_nothing_moved_is_no_error():
    ledger = EnergyBudget([body(0.0, 0.0, (0, 0, 0), speed=0.0)], (0, 0, 0))
    assert ledger.conservation([body(0.0, 0.0, (0, 0, 0))]) == {"mass": 0.0, "momentum": 0.0, "energy": 0.0}


def test_the_ledger_survives_json():
    one = EnergyBudget([body(1.0, 0.5, (2.0, 0, 0))], (0.0, 0.0, -10.0))
    one.record([body(0.9, 0.7, (2.3, 0, -2.0))], work(-0.7, 2.0, 0.5, impulses=[(1 / 3, 0, 0)]), FREE, APART, 0.1)
    other = EnergyBudget([body(7.0, 7.0, (7, 7, 7))], (0.0, 0.0, -10.0))
    other.restore(json.loads(json.dumps(one.state_numbers())))
    for ledger in (one, other):
        ledger.record([body(0.8, 0.8, (2.3, 0, -3.0))], work(-0.1, 0.2), FREE, APART, 0.1)
    assert json.dumps(one.state_numbers()) == json.dumps(other.state_numbers())


# in runs


def squeezed(**more):
    """Gas that is thrown against a wall, with artificial viscosity."""
    gas = GAS | {"artificial_viscosity": {"quadratic": 2.0, "linear": 1.0}}
    return simulation(
        box((0, 0, 0), (20, 1, 1), gas, (4, 1, 1), velocity=(-1.0, 0, 0)), counts=(24, 1, 1), support=SLIP[:2], end=50.0, **more
    )


def test_the_errors_explain_the_whole_difference():
    scene = advance(squeezed(), 60)
    ledger, energies = scene.ledger, scene.energies()
    change = energies["kinetic"] + energies["internal"] - ledger.initial["kinetic"] - ledger.initial["stored"]
    explained = energies["transfer_error"] + energies["time_integration_error"]
    # sixty additions
    assert change == pytest.approx(explained, abs=1e-12 * ledger.energy_scale)
    assert scene.conservation()["energy"] == pytest.approx(explained / ledger.energy_scale, abs=1e-12)
    assert energies["strain"] == 0.0


def test_artificial_viscosity_heats_by_a_part_of_what_is_braked():
    scene = squeezed()
    assert scene.energies()["artificial_heat"] == 0.0
    energies = advance(scene, 60).energies()
    braked = scene.ledger.initial["kinetic"] - energies["kinetic"]
    assert 0.1 * braked < energies["artificial_heat"] < braked


def test_solid_and_fluid_are_booked_apart():
    gas = box((0, 0, 0), (2, 2, 2), GAS, name="gas")
    solid = box((2, 0, 0), (4, 2, 2), SOLID, name="solid", velocity=(-0.2, 0, 0))
    energies = advance(simulation(gas, solid, counts=(4, 2, 2), support=SLIP, end=10.0), 20).energies()
    assert energies["internal"] > 0.0
    assert energies["strain"] > 0.0
    outside, errors = {"gravity_work", "support_work"}, {"transfer_error", "time_integration_error"}
    assert set(energies) == {"kinetic", "internal", "strain", "artificial_heat"} | outside | errors
