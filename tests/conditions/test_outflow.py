"""Points leave through faces of the grid, and what they take along is booked."""

import hashlib
import json

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SLIP, SOLID, advance, box, case, to_the_end
from typer.testing import CliRunner

import pellucid
from pellucid.case import Case
from pellucid.cli import app
from pellucid.conditions.loads.contract import PointsView
from pellucid.errors import RunStopped
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

TUBE = [support for support in SLIP if not support["where"].startswith("x")]
MATERIALS = {
    "gas": GAS,
    "gas, midpoint": GAS | {"energy_update": "midpoint"},
    "solid": SOLID,
    "solid in rate form": RATE_SOLID,
}


def jet(material=GAS, faces=("x-upper",), body=(), counts=(10, 2, 1), per_cell=(3, 3, 1), **more):
    """A block at the right end of a tube that moves out of it and swings."""
    speed, wave = (4.0, 0.3) if material["kind"] == "fluid" else (4.0, 0.4)
    wave = {"amplitude": (wave, 0, 0), "wave_vector": (1.5, 0, 0)}
    block = box((4, 0, 0), (9, 2, 1), material, per_cell, name="jet", velocity=(speed, 0, 0), velocity_wave=wave)
    tables = case(block, counts=counts, support=TUBE, **({"end": 1.5} | more)).to_data()
    tables["outflow"] = [{"where": list(faces), "body": list(body)}] if faces else []
    return Case.model_validate(tables)


def test_without_an_outflow_a_point_that_leaves_ends_the_run():
    with pytest.raises(RunStopped, match=r"of body `jet` at .*: it left the grid; .* let it leave through an \[\[outflow\]\]"):
        to_the_end(jet(faces=()))


def test_through_a_closed_face_none_leaves():
    with pytest.raises(RunStopped, match=r"of body `jet` at .*: it left the grid") as caught:
        to_the_end(jet(faces=("x-lower",)))
    assert caught.value.place["state"]["position"][0] > 10.0


@pytest.mark.parametrize("transfer", ["flip", "apic", "blend"])
@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_balances_close_while_points_leave(material, scheme, transfer):
    """To rounding: at each removal neither the error of the energy balance nor its causes change."""
    sim = Simulation(jet(material, scheme=scheme, transfer=transfer, energy={"warn": 9.0, "stop": 10.0}), threads=1)
    body, budget = sim.bodies[0], sim.budget
    errors = []
    while not sim.clock.finished(None) and budget.left_points < 0.9 * body.n_points:
        sim.step()
        errors.append(budget.transfer + budget.time_integration)
        conservation = sim.budget.conservation()
        assert conservation["mass"] < 1e-15
        assert conservation["momentum"] < 1e-14
        unexplained = conservation["energy"] * budget.energy_scale - budget.transfer - budget.time_integration - budget.made
        assert abs(unexplained) < 1e-13 * budget.energy_scale
    assert budget.left_points > 0.5 * body.n_points
    assert body.mass + budget.left_mass == pytest.approx(budget.initial["mass"], rel=1e-15)
    assert budget.sums["outflow_energy"] > 0.5 * budget.initial["kinetic"]


def test_users_see_the_points_that_are_left_in_the_order_of_their_numbers():
    """And their forces, here a drag that differs from point to point, act on these."""
    sim = Simulation(jet(MATERIALS["solid"]), threads=1)
    body = sim.bodies[0]
    start, drag = body.frame()["position"], np.zeros(body.n_points)
    while not 0.3 < sim.budget.left_points / body.n_points < 0.9:
        sim.step()
    points = PointsView(body)
    assert len(points.id) == body.storage.n_present < body.n_points
    assert (np.diff(points.id) > 0).all()
    assert np.linalg.norm((points.position - start[points.id])[:, 1:], axis=1).max() < 0.1, "each in its row of the tube"
    for name in ("position", "velocity", "mass"):
        assert np.array_equal(getattr(points, name), body.field(name)), name
        assert np.array_equal(getattr(points, name), body.frame()[name][points.id]), name
    drag[points.id] = np.sin(points.id)
    stored = points.as_stored(np.sin(points.id)[:, None] * np.ones(3))
    assert np.array_equal(stored[:, 0], drag[body.arrays["id"]])


@pytest.mark.parametrize("transfer", ["flip", "apic"])
@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_totals_after_points_left_are_those_of_the_others(material, transfer):
    sim = Simulation(jet(material, transfer=transfer, energy={"warn": 9.0, "stop": 10.0}), threads=1)
    body = sim.bodies[0]
    while sim.budget.left_points == 0:
        sim.step()
    totals = body.totals
    there = body.storage.n_present
    assert there == body.n_points - sim.budget.left_points > 0
    velocity, mass = body.arrays["velocity"][:there], body.arrays["mass"][:there]
    assert totals.momentum == pytest.approx(mass @ velocity, rel=1e-12, abs=1e-12)
    assert totals.momentum_size == pytest.approx(mass @ np.linalg.norm(velocity, axis=1), rel=1e-12)
    assert totals.kinetic - totals.affine == pytest.approx(body.field("kinetic_energy").sum(), rel=1e-12)
    assert totals.stored == pytest.approx(body.field("stored_energy").sum(), rel=1e-9, abs=1e-12)
    assert sim.budget.kinetic == totals.kinetic
    assert sim.budget.half_power == totals.half_power


def test_a_gas_flies_out_as_if_the_grid_went_on():
    """Faster than sound nothing of what is beyond the face comes back: those that are there are where they would be."""
    short, long = (Simulation(jet(counts=(n, 2, 1)), threads=1) for n in (10, 22))
    for _ in range(16):
        short.step()
        long.clock.next_step = lambda bodies, dt=short.dt: dt
        long.step()
    one, other = short.bodies[0], long.bodies[0]
    position = other.places()
    assert one.n_points - one.storage.n_present == np.count_nonzero(position[:, 0] > 10.0) == 66
    assert one.field("position") == pytest.approx(position[one.field("id")], abs=0.025)  # of cells


def test_what_velocities_are_ahead_of_stresses_leaves_with_the_points():
    """Half the power of internal forces, which the kernel sums apart for points that left: all, where all leave at once."""
    wave = {"amplitude": (0.3, 0, 0), "wave_vector": (0, 1.5, 0)}
    column = box((9.7, 0, 0), (10, 2, 1), SOLID, (3, 3, 1), velocity=(4, 0, 0), velocity_wave=wave)
    tables = case(column, counts=(10, 2, 1), support=TUBE, step=0.1, energy={"warn": 9.0, "stop": 10.0}).to_data()
    sim = Simulation(Case.model_validate(tables | {"outflow": [{"where": ["x-upper"]}]}), threads=1)
    gone, let_go = [], sim.budget.let_go
    sim.budget.let_go = lambda left, dt: gone.append(left) or let_go(left, dt)
    sim.step()
    (left,) = gone
    assert left.points == sim.bodies[0].n_points == 6
    assert abs(left.half_power) > 0.5
    assert abs(sim.bodies[0].totals.half_power) < 1e-12 * abs(left.half_power)
    assert abs(sim.budget.staggering) < 1e-12 * abs(left.half_power)
    assert sim.budget.sums["outflow_energy"] == pytest.approx(left.kinetic + left.stored + 0.1 * left.half_power, rel=1e-14)


def test_several_bodies_and_faces():
    """Each loses its own; what is not named keeps its points."""
    blocks = [
        box((1, 0, 0), (3, 2, 1), GAS, (2, 2, 1), name="left", velocity=(-4, 0, 0)),
        box((7, 0, 0), (9, 2, 1), GAS, (2, 2, 1), name="right", velocity=(4, 0, 0)),
    ]
    tables = case(*blocks, counts=(10, 2, 1), support=TUBE, end=0.6).to_data()
    both = tables | {"outflow": [{"where": ["x-lower", "x-upper"]}]}
    sim = to_the_end(Case.model_validate(both))
    assert all(body.storage.n_present < body.n_points for body in sim.bodies)
    assert sim.budget.conservation()["momentum"] < 1e-14
    with pytest.raises(RunStopped, match=r"of body `left` at .*: it left the grid"):
        to_the_end(Case.model_validate(tables | {"outflow": [{"where": ["x-lower", "x-upper"], "body": ["right"]}]}))


def test_when_all_have_left_the_run_goes_to_its_end():
    sim = to_the_end(jet(end=40.0))
    assert sim.bodies[0].storage.n_present == 0
    assert sim.time == 40.0
    assert sim.bodies[0].mass == 0.0
    assert sim.kinetic_energy() == pytest.approx(0.0, abs=1e-9)
    assert sim.budget.conservation()["mass"] < 1e-14
    assert sim.n_steps < 500


def fingerprint(sim):
    digest = hashlib.sha256()
    for name, array in sorted(sim.state_arrays().items()):
        digest.update(name.encode() + array.tobytes())
    return digest.hexdigest() + json.dumps([sim.state_numbers(), sim.budget.energies(), sim.budget.conservation()])


def test_threads_do_not_change_a_bit():
    one, two = (advance(Simulation(jet(counts=(10, 30, 1)), threads=n), 20) for n in (1, 2))
    assert one.budget.left_points > 0
    assert fingerprint(one) == fingerprint(two)


def test_a_checkpoint_goes_on_bit_for_bit():
    straight = advance(Simulation(jet(SOLID), threads=1), 20)
    assert 0 < straight.budget.left_points < straight.bodies[0].n_points
    arrays = {name: array.copy() for name, array in straight.state_arrays().items()}
    numbers = json.loads(json.dumps(straight.state_numbers()))
    other = Simulation(jet(SOLID), threads=1)
    other.restore(arrays, numbers)
    assert fingerprint(advance(other, 15)) == fingerprint(advance(straight, 15))


PROBES = [
    {"name": name, "body": "jet", "quantity": quantity} | more
    for name, quantity, more in [
        ("mass", "mass", {"reduce": "sum"}),
        ("x", "position", {"component": "x", "reduce": "max"}),
        ("first", "position", {"component": "x", "reduce": "point", "at": [9, 1, 0.5]}),
        ("pressure", "pressure", {}),
        ("number", "density", {"reduce": "count"}),
    ]
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("runs") / "jet"


@pytest.fixture(scope="module")
def run(folder):
    return pellucid.run(jet(end=0.9, probe=PROBES), out=folder)


def test_the_history_counts_what_left(run):
    history = run.history
    assert history["outflow_points"][0] == 0.0
    assert history["outflow_points"][-1] == run.summary["outflow"]["points"] > 0
    assert history["outflow_mass"][-1] == run.summary["outflow"]["mass"]
    assert history["mass"] + history["outflow_mass"] == pytest.approx(np.full(len(history["mass"]), 10.0), rel=1e-13)
    assert history["number"] + history["outflow_points"] == pytest.approx(90.0)
    assert (np.diff(history["outflow_mass"]) >= 0.0).all()
    assert history["x"].max() <= 10.0
    assert history["pressure"].min() > 0.0
    assert np.isnan(history["first"][-1])
    assert np.isfinite(history["first"][: np.flatnonzero(history["outflow_points"])[0]]).all()


def test_frames_have_all_points_and_those_that_left_have_no_mass(run):
    first, last = run.fields("jet", 0.0), run.fields("jet")
    left = last["mass"] == 0.0
    assert np.array_equal(first["id"], last["id"])
    assert np.count_nonzero(left) == run.summary["outflow"]["points"]
    assert (first["mass"] > 0.0).all()
    assert last["position"][left, 0] == pytest.approx(10.0, abs=1e-12)
    for name in ("density", "velocity", "pressure", "stress"):
        assert not last[name][left].any()
        assert np.isfinite(last[name]).all()
    assert last["density"][~left].min() > 0.0
    assert last["mass"].sum() + run.summary["outflow"]["mass"] == pytest.approx(10.0)


def test_a_run_that_was_stopped_goes_on_bit_for_bit(run, folder, tmp_path):
    half = pellucid.run(jet(end=0.9, probe=PROBES), out=tmp_path / "half", until=0.5)
    assert half.summary["outflow"]["points"] > 0
    whole = resume_case(tmp_path / "half", report=False)
    assert (tmp_path / "half/history.csv").read_bytes() == (folder / "history.csv").read_bytes()
    for name, values in run.fields("jet").items():
        assert np.array_equal(whole.fields("jet")[name], values), name
    assert whole.summary["conservation"] == run.summary["conservation"]


@pytest.mark.parametrize("when", [{}, {"time": 0.9}], ids=["checkpoint", "frame"])
def test_what_left_stays_away_in_a_run_that_goes_on_from_there(run, folder, when):
    tables = jet(end=0.1).to_data() | {"start": {"path": str(folder), **when}}
    went_on = pellucid.run(Case.model_validate(tables))
    assert went_on.summary["conservation"]["mass"] < 1e-14
    left = run.fields("jet")["mass"] == 0.0
    assert (went_on.fields("jet", 0.0)["mass"] == 0.0)[left].all()


def test_a_run_that_all_have_left_has_its_report(tmp_path):
    table = jet(end=20.0, probe=PROBES, output={"frames": 1.0}).to_data()
    run = pellucid.run(Case.model_validate(table), out=tmp_path / "run", report=True)
    assert run.summary["outflow"]["points"] == 90
    assert (tmp_path / "run/report.html").is_file()
    assert run.history["mass"][-1] == run.history["number"][-1] == 0.0
    assert np.isnan(run.history["pressure"][-1])
    assert not run.fields("jet")["mass"].any()


SUPPORT = '[[support]]\nwhere = "y-lower"\nfix = "normal"\n'
TEXT = f"""\
schema = 1
title = "outflow"
[grid]
lower = [0, 0, 0]
upper = [4, 2, 0]
cell = 0.5
[time]
end = 0.1
[[body]]
name = "jet"
shape = {{ box = {{ lower = [0, 0, 0], upper = [2, 2, 0] }} }}
material = {{ kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }}
[[body]]
name = "stone"
rigid = true
shape = {{ box = {{ lower = [3, 0, 0], upper = [3.5, 2, 0] }} }}
material = {{ kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }}
{SUPPORT}[[outflow]]
where = ["x-upper"]
"""
MOTION = '[[motion]]\nname = "push"\nbody = "jet"\nhold = ["x"]\npart = { box = { lower = [0, 0, 0], upper = [1, 2, 0] } }\n'
MISTAKES = {
    "unknown face": ('["x-upper"]', '["x-uper"]', ["outflow.0.where.0", "did you mean `x-upper`?"]),
    "no face": ('["x-upper"]', "[]", ["outflow.0.where", "at least 1 item"]),
    "twice": (
        '["x-upper"]',
        '["x-upper", "x-upper"]',
        ["outflow.0.where.1", "x-upper is listed twice", "remove one of the two names"],
    ),
    "thin": ('["x-upper"]', '["x-upper", "z-lower"]', ["outflow.0.where.1", "one cell thick along z"]),
    "a wall": ('["x-upper"]', '["x-upper", "y-lower"]', ["outflow.0.where.1", "constrains the whole face y-lower"]),
    "unknown body": ('["x-upper"]', '"x-upper"\nbody = ["jett"]', ["outflow.0.body.0", "did you mean `jet`?"]),
    "a rigid body": ('["x-upper"]', '"x-upper"\nbody = "stone"', ["outflow.0.body", "body stone is rigid"]),
    "a body that is led": (
        SUPPORT,
        SUPPORT + MOTION,
        ["outflow.0", "no body can lose points", "follow no motion", "remove this outflow"],
    ),
    "a body with cell_pressure": (
        '["x-upper"]',
        '"x-upper"\nbody = ["gas"]\n[[body]]\nname = "gas"\nshape = { box = { lower = [0, 0, 0], upper = [1, 2, 0] } }\n'
        'cell_pressure = true\nmaterial = { kind = "fluid", density = 1, pressure = 1, '
        'eos = { kind = "ideal-gas", gamma = 1.4 } }',
        ["outflow.0.body.0", "cell_pressure` of body gas", "faces of the grid as walls"],
    ),
    "a body that is led, named": (
        f'{SUPPORT}[[outflow]]\nwhere = ["x-upper"]\n',
        f'{SUPPORT}{MOTION}[[outflow]]\nwhere = ["x-upper"]\nbody = ["jet"]\n',
        ["outflow.0.body.0", "body jet follows the motion `push`"],
    ),
    "a probe of a column's name": (
        SUPPORT,
        f'{SUPPORT}[[probe]]\nname = "outflow_mass"\nbody = "jet"\nquantity = "mass"\n',
        ["probe.outflow_mass.name", "reserved for a column of the history"],
    ),
    "a membrane": (
        SUPPORT,
        '[[body]]\nname = "sheet"\nkind = "membrane-elements"\nfield = "sheet"\nthickness = 0.01\n'
        "surface = { rectangle = { corner = [2.5, 0, 0], first_edge = [0, 2, 0], second_edge = [0, 0, 0.5], "
        "points = [9, 3] } }\n"
        f'material = {{ kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }}\n{SUPPORT}'
        '[[outflow]]\nwhere = "x-lower"\nbody = ["sheet"]\n',
        ["outflow.0.body.0", "points of body sheet are connected", "use only bodies of kind material-points"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_its_line(mistake, tmp_path):
    before, after, words = MISTAKES[mistake]
    assert before in TEXT
    file = tmp_path / "my.toml"
    file.write_text(TEXT.replace(before, after, 1), encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    for word in (f"{file}:", *words):
        assert word in result.stderr


def test_without_mistakes_it_is_valid(tmp_path):
    file = tmp_path / "my.toml"
    file.write_text(TEXT, encoding="utf-8")
    assert CliRunner().invoke(app, ["validate", str(file)]).exit_code == 0


def test_points_that_left_bear_no_viscous_stress():
    """Where viscosity is solved for, its stress is an array of its own."""
    body = to_the_end(jet(GAS | {"viscosity": 0.1, "implicit_viscosity": True})).bodies[0]
    assert 0 < body.storage.n_present < body.n_points
    assert body.arrays["viscous_stress"][: body.storage.n_present].any()
    assert not body.arrays["viscous_stress"][body.storage.n_present :].any()
