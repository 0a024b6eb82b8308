"""What contact between surfaces takes is what springs hold and dampers and friction take; what is not is warned of."""

import json
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from small_cases import RATE_SOLID, box, case

from pellucid.case.spec import EnergyCase
from pellucid.contact.contact_energy import ContactEnergy, Held, taken_by_friction
from pellucid.energy import FIRST_JUDGED
from pellucid.simulation.simulation import Simulation
from pellucid.simulation.watch import Watch


def sliding(friction, gap=0.1, **time):
    """A rigid block falls by a tenth of a cell onto a floor that is held, and slides along it."""
    floor = box((0, 0, 0), (12, 2, 0), RATE_SOLID, (2, 2, 1), name="floor", field="floor")
    block = box(
        (1, 2 + gap, 0), (3, 4 + gap, 0), RATE_SOLID, (2, 2, 1), name="block", field="block", rigid=True, velocity=(3, 0, 0)
    )
    return Simulation(
        case(
            floor,
            block,
            counts=(12, 6, 1),
            thickness=1.0,
            gravity=(0, -10, 0),
            motion=[{"name": "still", "body": "floor", "hold": ["x", "y"]}],
            contact=[{"name": "touch", "between": ["block", "floor"], "kind": "coulomb", "friction": friction}],
            end=0.6,
            **time,
        ),
        threads=1,
    )


def run(sim):
    while not sim.clock.finished(None):
        sim.step()
    return sim.surface_pairs.energy


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_the_work_of_contact_is_held_by_springs_or_taken_by_dampers_and_friction(friction):
    sim = sliding(friction, gap=0.0)
    energy = run(sim)
    assert energy.work < -0.3 * sim.budget.initial["kinetic"]
    assert abs(energy.unexplained) < 0.01 * abs(energy.work)


def test_in_the_longest_step_that_is_allowed_a_rigid_block_hardly_rebounds():
    stable, _ = sliding(0.1).clock.stable_step(sliding(0.1).bodies)
    sim, rising = sliding(0.1, step=stable), 0.0
    while not sim.clock.finished(None):
        sim.step()
        rising = max(rising, float(sim.bodies[1].arrays["velocity"][:, 1].mean()))
    assert rising < 0.1 * (2.0 * 10.0 * 0.1) ** 0.5


@pytest.mark.parametrize("courant", [0.1, 0.9])
def test_in_steps_of_its_own_it_does_not(courant):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(sliding(0.1, courant=courant))


def test_it_goes_on_from_a_checkpoint():
    one, other = ContactEnergy(), ContactEnergy()
    for energy in (one, other):
        energy.begin_step([Held(stored=1.0)])
        energy.add_work(-2.0)
    numbers = json.loads(json.dumps(one.state_numbers()))
    again = ContactEnergy()
    again.restore(numbers)
    for energy in (other, again):
        energy.begin_step([Held(1.5, 0.75), Held(0.25, 0.0, 0.25)])
    assert again.state_numbers() == other.state_numbers()
    assert again.unexplained == -2.0 + 0.75 + 2.0 - 1.0


def test_friction_winds_up_what_sticks_and_takes_what_slides():
    spring, damped, slides = np.array([4.0, 4.0]), np.array([0.25, 9.0]), np.array([False, True])
    before, carried = np.array([[1.0, 0, 0], [2.0, 0, 0]]), np.array([[2.0, 0, 0], [2.0, 0, 0]])
    drag, moved = np.array([[-8.0, 0, 0], [-8.0, 0, 0]]), np.array([[1.0, 0, 0], [0.5, 0, 0]])
    taken = taken_by_friction(spring, before, carried, drag, moved, damped, slides)
    assert taken == pytest.approx(0.5 * 4.0 * (4.0 - 1.0) + 0.25 + 8.0 * 0.5)


def budget(moved):
    return SimpleNamespace(energy_scale=moved)


def clock(n_steps):
    return SimpleNamespace(n_steps=n_steps, time=1.0, finished=lambda until: False)


@pytest.mark.parametrize(("amount", "words"), [(6.0, r"added 6 J \(6 %"), (-7.0, r"removed 7 J \(7 %")])
def test_more_than_five_per_cent_is_warned_of_once(amount, words):
    watch, energy = Watch(EnergyCase(), False, True, "flip"), ContactEnergy()
    energy.unexplained = amount
    with pytest.warns(UserWarning, match=f"contact between surfaces {words}"):
        watch.contact_energy(energy, budget(100.0), clock(FIRST_JUDGED))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        watch.contact_energy(energy, budget(100.0), clock(FIRST_JUDGED + 1))


@pytest.mark.parametrize(("amount", "n_steps"), [(4.9, FIRST_JUDGED), (6.0, FIRST_JUDGED - 1)])
def test_less_and_the_first_steps_are_not(amount, n_steps):
    watch, energy = Watch(EnergyCase(), False, True, "flip"), ContactEnergy()
    energy.unexplained = amount
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        watch.contact_energy(energy, budget(100.0), clock(n_steps))
