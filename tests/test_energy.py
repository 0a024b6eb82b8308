"""The balance of mass, momentum and energy."""

import json
import os
import subprocess
import sys
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from small_cases import GAS, SLIP, SOLID, advance, box, simulation

from pellucid.energy import (
    ABSORBED,
    ABSORBED_ENERGY,
    CONTACT,
    CONTACT_WORK,
    FIRST_JUDGED,
    FIRST_LOAD,
    FIXED_COLUMNS,
    GRAVITY,
    GRAVITY_WORK,
    IMPACT,
    IMPACT_HEAT,
    INTERNAL,
    MOTION,
    MOTION_WORK,
    SUPPORT,
    TRANSFER,
    TRANSFER_HEAT,
    Channel,
    EnergyBudget,
    Totals,
    WorkLayout,
    energy_at_stake,
    no_work,
    row_length,
    step_work,
    total_work,
)

PRESSURE, THRUST = Channel("load_work"), Channel("thrust_work")
BRAKE = Channel("brake_heat", -1.0)
COLUMNS = FIRST_LOAD + 2


def body(kinetic, stored, momentum, mass=2.0, size=1.0, kind="strain", heating=0.0, **parts):
    """Return a body with the attributes that the energy balance reads."""
    totals = Totals()
    totals.kinetic, totals.stored, totals.momentum, totals.momentum_size = kinetic, stored, np.array(momentum), size
    totals.heating, totals.parts = heating, parts
    return SimpleNamespace(totals=totals, mass=mass, energy_kind=kind)


def work(columns=None, mass=0.0, reactions=((0.0, 0.0, 0.0),), impulse=(0.0, 0.0, 0.0), **motions):
    """Return the work of a step with works by column [J] and impulses [N s]; motions: impulses of prescribed motions by
    name."""
    done = no_work(COLUMNS, len(reactions) - 1)
    for column, amount in (columns or {}).items():
        done.works[column] = amount
    done.reactions[:], done.impulse[:] = reactions, impulse
    return done._replace(gravity_mass=mass, motions={name: np.array(given) for name, given in motions.items()})


def record(budget, bodies, *step):
    """Add a step to a balance, with these bodies at its end."""
    budget.bodies = bodies
    budget.record(*step)


def conservation(budget, bodies):
    """Return the relative errors of a balance with these bodies."""
    budget.bodies = bodies
    return budget.conservation()


FALLING = {INTERNAL: -0.7, GRAVITY: 2.0, SUPPORT: 0.5}


def test_what_comes_from_outside_is_no_error():
    budget = EnergyBudget([body(1.0, 0.0, (2.0, 0, 0))], (0.0, 0.0, -10.0))
    # over 0.1 s gravity gives 2 J and -2 N s; a wall 0.5 J and 0.3 N s; internal forces turn 0.7 J into strain
    after = [body(1.0 + 2.0 + 0.5 - 0.7, 0.7, (2.3, 0, -2.0))]
    record(budget, after, work(FALLING, 2.0, [(0.3, 0, 0)]), {}, 0.1)
    errors = conservation(budget, [body(2.8, 0.7, (2.3, 0, -2.0))])
    assert errors["energy"] == pytest.approx(0.0, abs=1e-15)
    assert errors["momentum"] == pytest.approx(0.0, abs=1e-15)
    assert errors["mass"] == 0.0
    assert budget.transfer == pytest.approx(0.0, abs=1e-15)
    assert budget.time_integration == pytest.approx(0.0, abs=1e-15)


def test_every_condition_has_its_channel():
    """2 J of a pressure, 3 J of a motion of which 0.4 + 0.1 J are lost in impact, 0.5 J absorbed, 0.3 J lost in contact: 3.7 J
    of motion are left."""
    channels = WorkLayout((PRESSURE,), (ABSORBED_ENERGY, MOTION_WORK, IMPACT_HEAT, CONTACT_WORK)).channels
    budget = EnergyBudget([body(1.0, 0.0, (0, 0, 0))], (0, 0, 0), channels)
    columns = {FIRST_LOAD: 2.0, ABSORBED: 0.5, MOTION: 1.0, IMPACT: 0.4}
    nodes = work(columns, reactions=[(0, 0, 0.5), (0, 0, 0)], impulse=(0.1, 0.2, 0))
    driven = work({MOTION: 2.0, IMPACT: 0.1}, reactions=np.zeros((2, 3)), tip=(0, 1.0, 0))
    # within the bodies: one takes from another, so that no momentum comes in
    touching, named = work({CONTACT: -0.3}, reactions=np.zeros((2, 3))), {"rub": np.array([0, 0, 0.7])}
    for _ in range(2):
        record(budget, [body(1.0 + 3.7, 0.0, (0.1, 1.2, 0.5))], total_work([nodes, driven, touching], COLUMNS), named, 0.1)
    energies = budget.energies()
    expected = {"load_work": 4.0, "absorbed_energy": 1.0, "motion_work": 6.0, "impact_heat": 1.0, "contact_work": -0.6}
    assert {name: energies[name] for name in expected} == pytest.approx(expected)
    assert budget.transfer == pytest.approx(-3.7), "the second step brought 3.7 J that the points do not show"
    assert conservation(budget, [body(9.0, 0.0, (0.2, 2.4, 1.0))])["momentum"] == pytest.approx(0.0, abs=1e-15)
    reactions = {name: impulse.tolist() for name, impulse in budget.reactions().items()}
    assert reactions == {"tip": [0, 2.0, 0], "rub": [0, 0, 1.4]}


def test_the_error_of_momentum_is_judged_by_all_that_went_in_and_out():
    """25 N s pass through a body at rest into its support, 50 N s in all: 5e-13 N s that are missing are 1e-14 of that."""
    budget = EnergyBudget([body(0.0, 0.0, (0, 0, 0), size=0.0)], (0, 0, 0))
    for _ in range(5):
        record(budget, [body(0.0, 0.0, (0, 0, 0), size=1e-3)], work(reactions=[(0, 0, 5.0)], push=(0, 0, -5.0)), {}, 0.1)
    assert conservation(budget, [body(0.0, 0.0, (0, 0, 5e-13), size=1e-3)])["momentum"] == pytest.approx(1e-14)
    again = EnergyBudget([body(0.0, 0.0, (0, 0, 0), size=0.0)], (0, 0, 0))
    again.restore(budget.state_numbers())
    record(budget, [body(0.0, 0.0, (0, 0, 0))], work(impulse=(0.0, 0.0, 50.0)), {}, 0.1)
    record(again, [body(0.0, 0.0, (0, 0, 0))], work(impulse=(0.0, 0.0, 50.0)), {}, 0.1)
    lost = body(0.0, 0.0, (0, 0, 0), size=1e-3)
    assert conservation(budget, [lost])["momentum"] == conservation(again, [lost])["momentum"] == pytest.approx(0.5)


def test_loads_of_two_channels_are_kept_apart_and_both_explain_the_energy():
    budget = EnergyBudget([body(1.0, 0.0, (0, 0, 0))], (0, 0, 0), WorkLayout((PRESSURE, THRUST)).channels)
    for kinetic in (3.5, 6.0):
        record(budget, [body(kinetic, 0.0, (0, 0, 0))], work({FIRST_LOAD: 4.0, FIRST_LOAD + 1: -1.5}), {}, 0.1)
    energies = budget.energies()
    assert (energies["load_work"], energies["thrust_work"]) == (8.0, -3.0)
    assert list(energies)[3:7] == ["gravity_work", "support_work", "load_work", "thrust_work"]
    assert budget.energy_error() == pytest.approx(0.0, abs=1e-15)
    assert budget.transfer == pytest.approx(0.0, abs=1e-15)
    # 6 J of motion, and what moved through the channels: 8 + 3 J
    assert budget.energy_scale == pytest.approx(17.0)
    record(budget, [body(6.0, 0.0, (0, 0, 0))], work({FIRST_LOAD + 1: 1.7}), {}, 0.1)
    assert budget.energy_error() == pytest.approx(-1.7 / budget.energy_scale), "what the bodies do not show is missed"


def test_a_channel_that_a_run_does_not_have_explains_nothing():
    budget = EnergyBudget([body(1.0, 0.0, (0, 0, 0))], (0, 0, 0), WorkLayout((PRESSURE,)).channels)
    record(budget, [body(2.0, 0.0, (0, 0, 0))], work({FIRST_LOAD + 1: 1.0}), {}, 0.1)
    assert budget.energy_error() == pytest.approx(1.0 / 2.0)
    assert "thrust_work" not in budget.energies()


def test_conditions_come_first_in_a_history_loads_before_others():
    others = (IMPACT_HEAT, BRAKE, ABSORBED_ENERGY, MOTION_WORK, PRESSURE, CONTACT_WORK)
    layout = WorkLayout((PRESSURE, THRUST, PRESSURE), others, n_supports=3)
    names = ["gravity_work", "support_work", "load_work", "thrust_work", "brake_heat"]
    names += ["motion_work", "contact_work", "absorbed_energy", "impact_heat"]
    assert [channel.name for channel in layout.channels] == names
    own = [layout.column(channel) for channel in (PRESSURE, THRUST, BRAKE)]
    assert own == [FIRST_LOAD, FIRST_LOAD + 1, FIRST_LOAD + 2]
    assert (layout.n_loads, layout.n_columns) == (2, FIRST_LOAD + 3)
    assert layout.no_work().works.shape == (FIRST_LOAD + 3,)
    assert layout.no_work().reactions.shape == (4, 3)


@pytest.mark.parametrize(
    ("loads", "others"), [((), (Channel("impact_heat"),)), ((PRESSURE,), (Channel("load_work", -1.0),)), ((GRAVITY_WORK,), ())]
)
def test_a_name_belongs_to_one_channel(loads, others):
    with pytest.raises(ValueError, match=f"two channels of the energy balance have the name {[*loads, *others][-1].name}"):
        WorkLayout(loads, others)


def test_every_column_has_one_owner():
    own = (INTERNAL, *FIXED_COLUMNS.values())
    assert sorted((*own, FIRST_LOAD)) == list(range(FIRST_LOAD + 1))
    assert (FIXED_COLUMNS[MOTION_WORK], FIXED_COLUMNS[CONTACT_WORK]) == (MOTION, CONTACT)
    assert (FIXED_COLUMNS[ABSORBED_ENERGY], FIXED_COLUMNS[IMPACT_HEAT]) == (ABSORBED, IMPACT)


def test_rows_without_the_last_columns_did_nothing_in_them():
    short, long = (np.arange(1.0, n) for n in (4, 6))
    parts = [no_work(len(works), 0)._replace(works=works) for works in (short, long, short)]
    assert total_work(parts, 6).works.tolist() == [3.0, 6.0, 9.0, 4.0, 5.0, 0.0]
    assert short.tolist() == [1.0, 2.0, 3.0]


def test_what_a_kernel_sums_is_read_as_it_is_laid_out():
    """Two supports, thin axes and other impulses behind the works of two loads and the mass."""
    row = np.arange(1.0, 1.0 + row_length(COLUMNS, 4))
    done = step_work(row, COLUMNS)
    assert done.works.tolist() == row[:COLUMNS].tolist()
    assert done.gravity_mass == row[COLUMNS]
    assert done.reactions.tolist() == row[COLUMNS + 1 : COLUMNS + 10].reshape(3, 3).tolist()
    assert done.impulse.tolist() == row[-3:].tolist()
    assert done.motions == {}


def test_what_several_parts_did_is_added():
    parts = [
        work({INTERNAL: 1.0, FIRST_LOAD: 2.0}, 3.0, [(1, 0, 0), (0, 1, 0)], (0, 0, 1), one=(1, 2, 3), both=(1, 1, 1)),
        work({INTERNAL: -3.0, IMPACT: 0.5}, 4.0, [(0, 0, 2), (0, 0, 0)], (0, 5, 0), both=(0, 0, 4)),
    ]
    total = total_work(parts, COLUMNS)
    assert total.works[[INTERNAL, FIRST_LOAD, IMPACT]].tolist() == [-2.0, 2.0, 0.5]
    assert total.gravity_mass == 7.0
    assert total.reactions.tolist() == [[1, 0, 2], [0, 1, 0]]
    assert total.impulse.tolist() == [0, 5, 1]
    assert {name: impulse.tolist() for name, impulse in total.motions.items()} == {"one": [1, 2, 3], "both": [1, 1, 5]}
    assert parts[0].works[INTERNAL] == 1.0, "the parts are left as they were"
    assert parts[0].motions["both"].tolist() == [1, 1, 1]


def test_parts_of_what_a_body_stores_have_entries_of_their_own():
    bodies = [body(0.0, 5.0, (0, 0, 0), hourglass=1.0), body(0.0, 3.0, (0, 0, 0), hourglass=0.5, dissipated=2.0)]
    energies = EnergyBudget([*bodies, body(0.0, 7.0, (0, 0, 0), kind="internal")], (0, 0, 0)).energies()
    assert (energies["strain"], energies["hourglass"], energies["dissipated"], energies["internal"]) == (4.5, 1.5, 2.0, 7.0)


def test_the_two_errors_are_kept_apart():
    budget = EnergyBudget([body(10.0, 0.0, (0, 0, 0))], (0, 0, 0))
    record(budget, [body(8.5, 1.2, (0, 0, 0))], work({INTERNAL: -1.0}), {}, 0.1)
    assert budget.transfer == pytest.approx(-0.5)  # the points lost 1.5 J, the grid 1.0
    assert budget.time_integration == pytest.approx(0.2)  # the points store 1.2 J of these 1.0
    assert budget.energy_error() == pytest.approx((-0.5 + 0.2) / 10.0)


def test_lost_momentum_and_mass_are_seen():
    budget = EnergyBudget([body(1.0, 0.0, (1.0, 0, 0), size=4.0)], (0, 0, 0))
    errors = conservation(budget, [body(1.0, 0.0, (0.9, 0, 0), mass=1.5)])
    assert errors["momentum"] == pytest.approx(0.1 / 4.0)
    assert errors["mass"] == pytest.approx(0.25)


def test_nothing_moved_is_no_error():
    budget = EnergyBudget([body(0.0, 0.0, (0, 0, 0), size=0.0)], (0, 0, 0))
    assert conservation(budget, [body(0.0, 0.0, (0, 0, 0))]) == {"mass": 0.0, "momentum": 0.0, "energy": 0.0}


def test_the_balance_survives_json():
    channels = WorkLayout((PRESSURE,), (MOTION_WORK,)).channels
    one = EnergyBudget([body(1.0, 0.5, (2.0, 0, 0))], (0.0, 0.0, -10.0), channels)
    done = work(FALLING | {FIRST_LOAD: 0.1, MOTION: 0.3}, 2.0, [(1 / 3, 0, 0)], tip=(1 / 7, 0, 0))
    record(one, [body(0.9, 0.7, (2.3, 0, -2.0))], done, {"rub": np.array([0, 0, 1 / 3])}, 0.1)
    other = EnergyBudget([body(7.0, 7.0, (7, 7, 7))], (0.0, 0.0, -10.0), channels)
    other.restore(json.loads(json.dumps(one.state_numbers())))
    for budget in (one, other):
        record(budget, [body(0.8, 0.8, (2.3, 0, -3.0))], work({INTERNAL: -0.1, GRAVITY: 0.2}, 2.0), {}, 0.1)
    assert json.dumps(one.state_numbers()) == json.dumps(other.state_numbers())
    assert one.reactions()["tip"].tolist() == other.reactions()["tip"].tolist() == [1 / 7, 0, 0]


def test_a_kept_balance_is_left_alone_by_what_follows():
    """Two runs go on from it in one process: neither counts for the other."""
    channels, still = WorkLayout((PRESSURE,), (MOTION_WORK,)).channels, [body(1.0, 0.5, (2.0, 0, 0))]
    done = work({FIRST_LOAD: 0.1, MOTION: 0.3}, reactions=[(1.0, 0, 0)], tip=(0.5, 0, 0))
    one, other, late = (EnergyBudget(still, (0.0, 0.0, 0.0), channels) for _ in range(3))
    record(one, still, done, {}, 0.1)
    kept = one.state_numbers()
    before = json.dumps(kept)
    other.restore(kept)
    record(one, still, done, {"rub": np.array([0, 0, 0.25])}, 0.1)
    record(other, still, done, {}, 0.1)
    late.restore(kept)
    assert json.dumps(kept) == json.dumps(late.state_numbers()) == before
    assert one.impulse.tolist() == other.impulse.tolist() == [3.0, 0, 0]
    assert one.sums == other.sums == {"gravity_work": 0.0, "support_work": 0.0, "load_work": 0.2, "motion_work": 0.6}
    assert set(one.reactions()) - set(other.reactions()) == {"rub"}
    assert other.reactions()["tip"].tolist() == [1.0, 0, 0]


def test_totals_survive_json():
    one, other = body(1 / 3, 0.2, (1 / 7, 2.0, 3.0), heating=0.1, hourglass=0.3).totals, Totals()
    one.rate = 1 / 11
    other.restore(json.loads(json.dumps(one.to_data())))
    assert other.to_data() == one.to_data()
    other.momentum += 1.0
    other.parts["hourglass"] = 9.0
    assert one.momentum[1] == 2.0
    assert one.parts == {"hourglass": 0.3}


# in runs


def squeezed(**more):
    """Return the simulation of a gas with artificial viscosity that moves against a wall."""
    gas = GAS | {"artificial_viscosity": {"quadratic": 2.0, "linear": 1.0}}
    return simulation(
        box((0, 0, 0), (20, 1, 1), gas, (4, 1, 1), velocity=(-1.0, 0, 0)), counts=(24, 1, 1), support=SLIP[:2], end=50.0, **more
    )


def test_the_errors_explain_the_whole_difference():
    sim = advance(squeezed(), 60)
    budget, energies = sim.budget, sim.budget.energies()
    change = energies["kinetic"] + energies["internal"] - budget.initial["kinetic"] - budget.initial["stored"]
    explained = energies["transfer_error"] + energies["time_integration_error"]
    # sixty additions
    assert change == pytest.approx(explained, abs=1e-12 * budget.energy_scale)
    assert sim.budget.conservation()["energy"] == pytest.approx(explained / budget.energy_scale, abs=1e-12)
    assert energies["strain"] == 0.0


def test_artificial_viscosity_heats_by_a_part_of_what_is_braked():
    sim = squeezed()
    assert sim.budget.energies()["artificial_heat"] == 0.0
    energies = advance(sim, 60).budget.energies()
    braked = sim.budget.initial["kinetic"] - energies["kinetic"]
    assert 0.1 * braked < energies["artificial_heat"] < braked


def test_solid_and_fluid_are_counted_apart():
    gas = box((0, 0, 0), (2, 2, 2), GAS, name="gas")
    solid = box((2, 0, 0), (4, 2, 2), SOLID, name="solid", velocity=(-0.2, 0, 0))
    energies = advance(simulation(gas, solid, counts=(4, 2, 2), support=SLIP, end=10.0), 20).budget.energies()
    assert energies["internal"] > 0.0
    assert energies["strain"] > 0.0
    outside, errors = {"gravity_work", "support_work", "transfer_heat"}, {"transfer_error", "time_integration_error"}
    assert set(energies) == {"kinetic", "internal", "strain", "staggering", "artificial_heat"} | outside | errors


def test_what_is_at_stake_is_strain_the_potential_of_gravity_and_little_of_internal_energy():
    solid, gas = body(0.0, 3.0, (0, 0, 0)), body(0.0, 5e8, (0, 0, 0), kind="internal")
    solid.stored_field = {"mass": np.array([2.0, 1.0]), "position": np.array([[0, 0, 7.0], [0, 0, 4.0]])}.get
    gas.stored_field = {"mass": np.array([4.0]), "position": np.array([[1.0, 0, 5.0]])}.get
    speeds = [10.0, 300.0]
    assert energy_at_stake([solid, gas], (0.0, 0.0, 0.0), speeds) == pytest.approx(3.0 + 5.0)
    # 2 kg 3 m and 4 kg 1 m above the lowest point
    assert energy_at_stake([solid, gas], (0.0, 0.0, -10.0), speeds) == pytest.approx(8.0 + 100.0)


AT_STAKE = """
from types import SimpleNamespace
import numpy as np
from pellucid.energy import energy_at_stake

numbers = np.random.default_rng(1).random((60_000, 4))
arrays = {"mass": numbers[:, 0].copy(), "position": numbers[:, 1:].copy()}
body = SimpleNamespace(stored_field=arrays.get, totals=SimpleNamespace(stored=0.0), energy_kind="strain")
print(energy_at_stake([body], (0.3, 0.0, -9.81), [0.0]).hex())
"""


def test_what_is_at_stake_does_not_depend_on_the_threads_of_matrix_products():
    """Numpy shares these among the cores of a machine, and adds up what each of them found."""
    environments = [os.environ | {"OPENBLAS_NUM_THREADS": threads} for threads in ("1", "2")]
    one, two = (subprocess.check_output([sys.executable, "-c", AT_STAKE], env=environment) for environment in environments)
    assert one == two


def test_what_a_small_strain_of_solids_would_store_is_at_stake():
    """Of 3 kg with waves of 20 m/s: half of 1200 J times the square of 1e-7."""
    solid, film = body(0.0, 0.0, (0, 0, 0)), body(0.0, 0.0, (0, 0, 0))
    solid.stored_field = {"mass": np.array([2.0, 1.0]), "position": np.zeros((2, 3))}.get
    film.stored_field = {"mass": np.array([1e9]), "position": np.zeros((1, 3))}.get
    assert energy_at_stake([solid, film], (0.0, 0.0, 0.0), [20.0, 0.0]) == pytest.approx(0.5 * 1200.0 * 1e-14, rel=1e-12)


@pytest.mark.parametrize("share", [1e-14, 1e-11, 1e-8])
def test_a_solid_at_rest_is_not_judged_by_its_rounding(share):
    """It moves by less than its strain energy can show: velocities are this share of the speed of waves."""
    sim = simulation(box((1, 1, 1), (3, 3, 3)), end=1e9)
    arrays = sim.bodies[0].arrays
    waves = sim.case.body[0].material.wave_speeds()[0]
    arrays["velocity"][:] = share * waves * np.sin(0.5 * np.pi * (arrays["position"] - 1.0))
    sim.bodies[0].renew_totals()
    sim.begin_balance()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        errors = [abs(sim.budget.energy_error()) for _ in range(FIRST_JUDGED + 40) if sim.step() is None]
    assert max(errors) < 0.01


def test_an_error_is_judged_by_what_is_at_stake_until_more_has_moved():
    budget = EnergyBudget([body(0.0, 0.0, (0, 0, 0))], (0, 0, 0), at_stake=50.0)
    record(budget, [body(0.1, 0.0, (0, 0, 0))], work(), {}, 0.1)
    assert budget.energy_error() == pytest.approx(0.1 / 50.0)
    record(budget, [body(100.1, 0.0, (0, 0, 0))], work({GRAVITY: 100.0}), {}, 0.1)
    assert budget.energy_error() == pytest.approx(0.1 / 200.1)


def test_what_contact_and_transfers_give_beyond_what_they_took_is_an_error():
    channels = WorkLayout(others=(CONTACT_WORK, TRANSFER_HEAT)).channels
    budget = EnergyBudget([body(10.0, 0.0, (0, 0, 0))], (0, 0, 0), channels)
    record(budget, [body(7.0, 0.0, (0, 0, 0))], work({CONTACT: -2.0, TRANSFER: 1.0}), {}, 0.1)
    record(budget, [body(8.0, 0.0, (0, 0, 0))], work({CONTACT: 1.0}), {}, 0.1)
    assert budget.made == 0.0
    assert budget.energy_error() == pytest.approx(0.0)
    record(budget, [body(11.0, 0.0, (0, 0, 0))], work({CONTACT: 1.5, TRANSFER: -1.5}), {}, 0.1)
    assert budget.made == pytest.approx(0.5 + 0.5)
    assert budget.energy_error() == pytest.approx(1.0 / budget.energy_scale)


def test_stiff_internal_energy_does_not_hide_an_error_of_what_moves():
    """Of a liquid with 1e6 J no more than 0.02 J moves: an error is one of these."""
    liquid = body(0.0, 1e6, (0, 0, 0), kind="internal")
    liquid.stored_field = {"mass": np.array([1.0]), "position": np.zeros((1, 3))}.get
    budget = EnergyBudget([liquid], (0, 0, 0), at_stake=energy_at_stake([liquid], (0, 0, 0), [1500.0]))
    record(budget, [body(0.01, 1e6, (0, 0, 0), kind="internal")], work({GRAVITY: 0.009}), {}, 0.1)
    assert budget.energy_error() == pytest.approx(0.001 / 0.019, rel=1e-6)


def test_entries_that_are_no_numbers_are_named():
    budget = EnergyBudget([body(1.0, 0.0, (0, 0, 0))], (0, 0, 0))
    assert budget.lost_entries() == []
    record(budget, [body(np.nan, 0.0, (0, 0, 0))], work({GRAVITY: np.inf}), {}, 0.1)
    assert budget.lost_entries() == ["kinetic", "gravity_work"]
    assert np.isnan(budget.energy_error())


def test_the_balance_is_that_of_the_last_step_recorded():
    """A step in which a point stops the run changes what bodies store, but has no balance."""
    one = body(1.0, 2.0, (0, 0, 0))
    budget = EnergyBudget([one], (0, 0, 0))
    one.totals.kinetic, one.totals.stored = 1.5, 1.5
    record(budget, [one], work({INTERNAL: 0.5}), {}, 0.1)
    one.totals.stored = 7.0
    energies = budget.energies()
    assert sum(energies[name] for name in ("kinetic", "internal", "strain")) == pytest.approx(3.0)
