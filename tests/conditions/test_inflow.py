"""A fluid comes in through a face of the grid, is led there, and goes out freely, against a pressure, or as it is led."""

import hashlib
import json

import numpy as np
import pytest
from small_cases import GAS, SLIP, advance, box, case, to_the_end

import pellucid
from pellucid.case import Case
from pellucid.case.reading import loads
from pellucid.errors import RunStopped
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

TUBE = [support for support in SLIP if not support["where"].startswith("x")]
WATER = {"kind": "fluid", "density": 1000.0, "pressure": 500.0, "eos": {"kind": "tait", "sound_speed": 20.0, "exponent": 7}}


def plug(material=GAS, speed=2.0, inflow=(), outflow=(), rows=3, support=TUBE, **more):
    """A fluid that fills a tube of ten cells and flows through it evenly."""
    fluid = box((0, 0, 0), (10, rows, 1), material, (2, 2, 1), name="fluid", velocity=(speed, 0, 0))
    tables = case(fluid, counts=(10, rows, 1), support=support, **({"end": 3.0} | more)).to_data()
    tables["inflow"] = [{"where": "x-lower", "body": "fluid", "velocity": speed} | dict(inflow)]
    tables["outflow"] = [{"where": ["x-upper"]} | dict(outflow or {"pressure": material["pressure"]})]
    return Case.model_validate(tables)


@pytest.mark.parametrize(
    ("functions", "more"),
    [
        ("trilinear", {}),
        ("quadratic-bspline", {}),
        ("trilinear", {"transfer": "apic"}),
        ("trilinear", {"scheme": "usl"}),
        ("trilinear", {"scheme": "usf"}),
        ("trilinear", {"outflow": {"velocity": 2.0}}),
        ("trilinear", {"inflow": {"velocity": None, "pressure": 1.0}}),
        (
            "trilinear",
            {"material": WATER, "end": 1.5, "outflow": {"flow_rate": 6.0}, "inflow": {"velocity": None, "flow_rate": 6.0}},
        ),
    ],
)
def test_a_plug_stays_as_it_is(functions, more):
    """Velocities and densities to rounding, points at their distance, in a gas under pressure too."""
    sim = to_the_end(plug(functions=functions, **more))
    body = sim.bodies[0]
    came, left = sim.budget.inflow, sim.budget.outflow
    assert came == left
    assert came["points"] == 6 * round(2.0 * 2.0 * sim.time)
    assert body.storage.n_present == 120
    assert np.abs(body.field("velocity") - [2, 0, 0]).max() < 1e-13
    assert np.ptp(body.field("density")) < 1e-12 * body.field("density").mean()
    assert np.diff(np.unique(body.field("position")[:, 0].round(9))) == pytest.approx(0.5)
    conservation = sim.budget.conservation()
    assert conservation["mass"] < 1e-14
    assert conservation["momentum"] < 1e-13
    assert abs(conservation["energy"]) < 1e-12


def test_the_ledger_has_what_came_in():
    """Kinetic and internal energy of the points, and p V for pushing them in; the same goes out."""
    sim = to_the_end(plug(inflow={"name": "pump"}))
    entries, volume = sim.budget.energies(), 2.0 * 3.0 * 3.0
    assert sim.budget.inflow["mass"] == pytest.approx(volume, rel=1e-13)
    assert entries["inflow_energy"] == pytest.approx(volume * (0.5 * 4.0 + 1.0 / 0.4), rel=1e-12)
    assert entries["inflow_work"] == pytest.approx(volume * 1.0, rel=1e-12)
    assert entries["outflow_energy"] == pytest.approx(entries["inflow_energy"], rel=1e-12)
    assert entries["outflow_work"] == pytest.approx(-volume * 1.0, rel=1e-12)
    assert sim.budget.reactions()["pump"] == pytest.approx([3.0 * 3.0, 0, 0], rel=1e-12, abs=1e-12)


def test_a_fluid_at_rest_is_pushed_through_and_balances():
    """A flow that rises from rest and fluctuates: mass to rounding, energy within half a percent."""
    shares = {"times": [0, 1, 2, 3], "shares": [0, 1, 0.2, 1]}
    tables = plug(speed=0.5, inflow={"amplitude": shares}).to_data()
    tables["body"][0]["velocity"] = [0, 0, 0]
    sim = to_the_end(Case.model_validate(tables))
    assert sim.budget.conservation()["mass"] < 1e-14
    assert sim.budget.conservation()["momentum"] < 1e-13
    assert abs(sim.budget.conservation()["energy"]) < 0.005
    assert sim.budget.inflow["mass"] == pytest.approx(3.0 * 0.5 * (0.5 + 0.6 + 0.6), abs=1.5)  # two points deep, and no more


def channel(given, **more):
    """A slit of ten cells, whose walls hold the fluid; it begins as it will be."""
    cell, liquid = 0.1, {"kind": "fluid", "density": 1.0, "pressure": 0.0, "viscosity": 0.1}
    tait = {"kind": "tait", "sound_speed": 30.0, "exponent": 7}
    fluid = box((0, 0, 0), (2, 1, cell), liquid | {"eos": tait}, (2, 2, 1), name="fluid", velocity=(1, 0, 0))
    walls = [{"where": "y-lower"}, {"where": "y-upper"}]
    tables = case(
        fluid, counts=(20, 10, 1), cell=cell, support=walls, thickness=1.0, **({"transfer": "apic", "end": 6.0} | more)
    ).to_data()
    tables["inflow"] = [{"where": "x-lower", "body": "fluid"} | given]
    return Case.model_validate(tables | {"outflow": [{"where": ["x-upper"], "pressure": 0.0}]})


@pytest.mark.parametrize(
    ("given", "error"),
    [({"flow_rate": 1.0, "profile": "parabolic"}, 0.01), ({"pressure": 2.4}, 0.02)],
    ids=["flow", "pressure"],
)
def test_poiseuille_between_an_inflow_and_an_outflow(given, error):
    """Of the mean over some swings of sound: velocity 6 y (1 - y), of the pressure that falls by 12 μ U/H² on unit length."""
    sim, found = Simulation(channel(given), threads=1), []
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > 4.0 and sim.n_steps % 5 == 0:
            x, v, p = (sim.bodies[0].field(name) for name in ("position", "velocity", "pressure"))
            within = (x[:, 0] > 0.6) & (x[:, 0] < 1.6)
            shape = x[within, 1] * (1.0 - x[within, 1])
            fall = np.polyfit(x[within, 0], p[within], 1)[0]
            found.append([float(v[within, 0] @ shape / (shape @ shape)) / 6.0, v[within, 0].mean(), fall])
    shape, mean, fall = np.mean(found, axis=0)
    assert shape == pytest.approx(1.0, abs=error)
    assert mean == pytest.approx(1.0, abs=error)
    assert fall == pytest.approx(-1.2, abs=0.06)
    assert sim.budget.conservation()["mass"] < 1e-14
    assert abs(sim.budget.conservation()["energy"]) < 0.005


def sucked(outflow):
    """Liquid in a bath and in a tube of eight cells across, which leads out of it."""
    cell, liquid = 0.125, {"kind": "fluid", "density": 1.0, "pressure": 0.0, "viscosity": 1.0}
    liquid["eos"] = {"kind": "tait", "sound_speed": 25.0, "exponent": 7, "carries_tension": True}
    bath = box((0.25, 0, 0), (1.5, 3, cell), liquid, (2, 2, 1), name="bath")
    thread = box((1.5, 1, 0), (4, 2, cell), liquid, (2, 2, 1), name="thread")
    walls = [{"where": {"box": {"lower": (1.5, low, 0), "upper": (4, low + 1, cell)}}} for low in (0, 2)]
    sides = [{"where": face, "fix": "normal"} for face in ("y-lower", "y-upper")]
    tables = case(
        bath, thread, counts=(32, 24, 1), cell=cell, support=[*sides, *walls], thickness=1.0, transfer="apic", end=0.8
    ).to_data()
    return Case.model_validate(tables | {"outflow": [{"where": ["x-upper"], "rise": 0.1} | outflow]})


@pytest.mark.parametrize("outflow", [{"pressure": -6.0}, {"flow_rate": 0.18, "profile": "parabolic"}], ids=["pressure", "flow"])
def test_a_pipette_sucks_by_poiseuilles_law(outflow):
    """By its pressure or its flow: dp/dx = 12 μ U/H² in the tube, and the given one at its end."""
    sim, found = Simulation(sucked(outflow), threads=1), []
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > 0.4:
            x, v, p = (sim.bodies[1].field(name) for name in ("position", "velocity", "pressure"))
            within = (x[:, 0] > 2.0) & (x[:, 0] < 3.5)
            line = np.polyfit(x[within, 0], p[within], 1)
            found.append([v[within, 0].mean(), line[0], np.polyval(line, 4.0)])
    mean, fall, at_end = np.mean(found, axis=0)
    assert -fall == pytest.approx(12.0 * mean, rel=0.05)
    assert sim.budget.outflow["points"] > 0
    if "pressure" in outflow:
        assert at_end == pytest.approx(-6.0, rel=0.05)
    else:
        assert mean == pytest.approx(0.18, rel=0.04)
    assert sim.budget.conservation()["mass"] < 1e-14
    assert abs(sim.budget.conservation()["energy"]) < 0.005


def fingerprint(sim):
    digest = hashlib.sha256()
    for name, array in sorted(sim.state_arrays().items()):
        digest.update(name.encode() + array.tobytes())
    return digest.hexdigest() + json.dumps([sim.state_numbers(), sim.budget.energies(), sim.budget.conservation()])


HALF = [TUBE[0], {"where": "y-upper"}, *TUBE[2:]]  # of a channel: below is a plane of symmetry
UNEVEN = {"support": HALF, "rows": 30, "speed": 1.3, "inflow": {"profile": "parabolic"}, "outflow": {"pressure": 0.9}}


def test_threads_do_not_change_a_bit():
    one, two = (advance(Simulation(plug(**UNEVEN), threads=n), 25) for n in (1, 2))
    assert one.budget.entered_points > 0
    assert fingerprint(one) == fingerprint(two)


@pytest.mark.parametrize("inflow", [UNEVEN["inflow"], {"velocity": None, "pressure": 1.4}], ids=["velocity", "pressure"])
def test_a_checkpoint_goes_on_bit_for_bit(inflow):
    """With the part of a layer that has come in, from wherever points that left have given rows to others."""
    tables = plug(**UNEVEN | {"inflow": inflow})
    straight = advance(Simulation(tables, threads=1), 22)
    assert straight.budget.left_points > 0
    arrays = {name: array.copy() for name, array in straight.state_arrays().items()}
    numbers = json.loads(json.dumps(straight.state_numbers()))
    other = Simulation(tables, threads=1)
    other.restore(arrays, numbers)
    assert fingerprint(advance(other, 15)) == fingerprint(advance(straight, 15))


def test_a_run_goes_on_and_on_beyond_its_end(tmp_path):
    """Its files are those of one that had the later end from the start; frames show what is there alone."""
    probe = [{"name": "mass", "body": "fluid", "quantity": "mass", "reduce": "sum"}]
    long = pellucid.run(plug(probe=probe, output={"history": 0.25, "frames": 0.5}), out=tmp_path / "long")
    pellucid.run(plug(probe=probe, output={"history": 0.25, "frames": 0.5}), out=tmp_path / "half", until=1.6)
    whole = resume_case(tmp_path / "half", report=False)
    assert (tmp_path / "half/history.csv").read_bytes() == (tmp_path / "long/history.csv").read_bytes()
    history, last = whole.history, whole.fields("fluid")
    assert history["inflow_points"][-1] == whole.summary["inflow"]["points"] == 72
    assert history["mass"] + history["outflow_mass"] - history["inflow_mass"] == pytest.approx(30.0, rel=1e-13)
    assert whole.summary["inflow"]["momentum"] == pytest.approx([2.0 * whole.summary["inflow"]["mass"], 0, 0])
    assert whole.summary["outflow"]["momentum"] == pytest.approx([2.0 * whole.summary["outflow"]["mass"], 0, 0])
    assert np.count_nonzero(last["mass"]) == 120
    assert last["mass"].sum() == pytest.approx(30.0)
    assert np.isfinite(last["density"]).all()
    assert np.array_equal(last["position"], long.fields("fluid")["position"])
    resume_case(tmp_path / "half", settings={"time.end": 3.5}, report=False)


def test_a_closed_grid_fills_up():
    tables = plug(material=WATER, end=20.0, energy={"warn": 9.0, "stop": 10.0}).to_data() | {"outflow": []}
    tables["support"] = [*tables["support"], {"where": "x-upper", "fix": "normal"}]
    tables["body"][0]["shape"]["box"]["upper"] = [1, 3, 1]
    words = r"the grid is full: no points can be added to the 180 points of body `fluid`; add an \[\[outflow\]\]"
    with pytest.raises(RunStopped, match=words):
        to_the_end(Case.model_validate(tables))


def test_a_fast_flow_is_told_as_what_bounds_the_step():
    sim = Simulation(plug(inflow={"velocity": None, "flow_rate": 3.0 * 50.0}), threads=1)
    limit, name = sim.step_limit()
    assert (limit.cause, name) == ("motion", "")
    assert limit.step == pytest.approx(1.0 / 50.0)
    assert limit.reason == "the flow through the face x-lower moves at 50 m/s through cells of 1 m"


@pytest.mark.parametrize("inflow", [{"velocity": None, "flow_rate": 3.0 * 50.0}, {}])
def test_a_resumed_run_has_the_same_limit(inflow):
    """The velocity of the flow in the last step is part of the checkpoint, also that of a prescribed outflow."""
    tables = plug(inflow=inflow, outflow={"velocity": 49.0}, end=1.0, energy={"warn": 9.0, "stop": 10.0})
    straight, other = advance(Simulation(tables, threads=1), 3), Simulation(tables, threads=1)
    other.restore(straight.state_arrays(), json.loads(json.dumps(straight.state_numbers())))
    assert straight.parts.step_limit().cause == "motion"
    assert other.parts.step_limit() == straight.parts.step_limit()
    assert other.clock.next_step(other.bodies) == straight.clock.next_step(straight.bodies)


def slit(support, pressure, end, *, top="", body="", **material):
    """A fluid that is led through a slit of 20 x 10 cells, against a pressure."""
    keys = "\n".join(f"{key} = {value}" for key, value in material.items())
    return f"""
schema = 1
title = "a liquid is led through a slit"
{top}
[grid]
lower = [0, 0, 0]
upper = [2, 1, 0]
cell = 0.1
[time]
end = {end}
transfer = "apic"
[[body]]
name = "liquid"
shape = {{ box = {{ lower = [0, 0, 0], upper = [2, 1, 0] }} }}
velocity = [1, 0, 0]
{body}
[body.material]
kind = "fluid"
{keys}
{support}
[[inflow]]
where = "x-lower"
body = "liquid"
velocity = 1
profile = "parabolic"
[[outflow]]
where = "x-upper"
pressure = {pressure}
"""


SLIT = slit(
    '[[support]]\nwhere = ["y-lower", "y-upper"]',
    0,
    1.5,
    density=0.1,
    viscosity=1,
    implicit_viscosity="true",
    eos='{ kind = "tait", sound_speed = 150, carries_tension = true }',
)


@pytest.mark.parametrize(("functions", "error"), [("trilinear", 0.05), ("quadratic-bspline", 0.1)])
def test_a_liquid_comes_in_at_the_pressure_inside(functions, error):
    """12 μUL/H² = 24 Pa at the inlet, of which a twentieth falls over a cell: means over half a cell across the slit and some
    instants err by one of these with linear functions and by two with splines, to whose strip half a cell more belongs. Points
    that come in at another pressure, be it that of the cell behind, leave twice as much in stripes of two cells, points of no
    pressure .6. In the last cells pressures are the outlet's.
    """
    sim = Simulation(loads(SLIT.replace("cell = 0.1", f'cell = 0.1\nfunctions = "{functions}"')))
    starts, means = np.arange(0.0, 18.0, 0.5), []
    while sim.time < 1.5 - 1e-9:
        sim.step()
        if sim.time > 1.2 and sim.n_steps % 100 == 0:
            x, pressure = sim.bodies[0].field("position")[:, 0] / 0.1, sim.bodies[0].field("pressure")
            means.append([pressure[(x >= start) & (x < start + 0.5)].mean() for start in starts])
    exact = 1.2 * (20.0 - 0.25 - starts)
    assert len(means) > 5
    assert np.abs(np.mean(means, axis=0) - exact).max() < error * 24.0
    assert sim.budget.conservation()["mass"] < 1e-14
    assert abs(sim.budget.conservation()["energy"]) < 1e-12


HEAVY = slit(
    '[[support]]\nwhere = "y-lower"\nfix = "normal"\n[[support]]\nwhere = "y-upper"',
    5000,
    0.3,
    top="gravity = [0, -10, 0]",
    body="hydrostatic = {}",
    density=1000,
    viscosity=100,
    eos='{ kind = "tait", sound_speed = 40, carries_tension = true }',
)


def test_columns_keep_what_they_differ_by_at_the_start():
    """Those at one height come in together: each at its own pressure, above that of the next by 10 kPa/m. Swings of the start
    make a tenth of the slope; with the same pressure for whatever comes in at once it is half as large.
    """
    sim = to_the_end(loads(HEAVY))
    position, pressure = sim.bodies[0].field("position"), sim.bodies[0].field("pressure")
    new = position[:, 0] < 0.1
    assert np.polyfit(position[new, 1], pressure[new], 1)[0] == pytest.approx(-1e4, rel=0.2)


TUBE_CASE = """\
schema = 1
title = "a jet through a round opening"
[grid]
lower = [0, 0, 0]
upper = [6, 8, 8]
cell = 1
[time]
end = 3.0
[[body]]
name = "jet"
shape = { cylinder = { centre = [1, 4, 4], radius = 2.3, axis = "x", height = 2 } }
material = { kind = "fluid", density = 1000, pressure = 0, eos = { kind = "tait", sound_speed = 20, exponent = 7 } }
velocity = [1, 0, 0]
[[inflow]]
where = "x-lower"
body = "jet"
flow_rate = 10.0
profile = "parabolic"
[[outflow]]
where = "x-upper"
"""


def test_a_given_flow_rate_comes_in_through_a_round_opening():
    """Within the layer of points of each column that is on its way: half of it on the mean."""
    sim = to_the_end(loads(TUBE_CASE))
    x, v = (sim.bodies[0].field(name) for name in ("position", "velocity"))
    assert sim.budget.inflow["mass"] == pytest.approx(1000.0 * 10.0 * 3.0, rel=0.04)
    near = x[:, 0] < 1.0
    radius = np.hypot(*(x[near, 1:] - 4.0).T)
    assert np.corrcoef(v[near, 0], 1.0 - (radius / 2.3) ** 2)[0, 1] > 0.9
    assert np.abs(v[near, 1:]).max() < 0.05
    assert sim.budget.conservation()["mass"] < 1e-14
    assert np.hypot(*(x[:, 1:] - 4.0).T).max() < 3.0


def test_a_jet_that_has_passed_leaves_a_dry_outlet():
    """A drop that leaves through an outlet with a pressure leaves it dry, and the run goes on."""
    drop = box((8, 0, 0), (10, 3, 1), GAS, (2, 2, 1), name="fluid", velocity=(4, 0, 0))
    tables = case(drop, counts=(10, 3, 1), support=TUBE, end=4.0, energy={"warn": 9.0, "stop": 10.0}).to_data()
    sim = to_the_end(Case.model_validate(tables | {"outflow": [{"where": ["x-upper"], "pressure": 1e-3}]}))
    assert sim.budget.outflow["points"] > 20
    assert sim.time == 4.0
