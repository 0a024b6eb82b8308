"""Equilibria of membranes of triangles with a factored stiffness: exact solutions, the equilibria of the relaxation, works of
pressures, buckling, walls, checkpoints, and what has no equilibrium."""

import numpy as np
import pytest
from membranes import SURFACE_LAWS
from scipy.optimize import brentq

from pellucid.case import Case, loads
from pellucid.errors import RunStopped
from pellucid.materials.membrane import plane_response, shape_of
from pellucid.running.launch import resume_case, run_case
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

RADIUS, THICKNESS, E, NU = 0.1, 1e-3, 1e6, 0.49
BALLOON = f"""
schema = 1
title = "A balloon"
[time]
end = 1
[steady]
tolerance = 1e-8
[[body]]
name = "skin"
kind = "membrane-elements"
elements = "triangles"
surface = {{ sphere = {{ centre = [0, 0, 0], radius = {RADIUS}, divisions = 4 }} }}
thickness = {THICKNESS}
material = {{ kind = "neo-hookean-membrane", density = 1000, young_modulus = {E}, poisson_ratio = {NU} }}
[[pressure]]
body = "skin"
value = 3000
rise = 1
"""
STRIP = """
schema = 1
title = "A strip that is clamped at one end"
[time]
end = 1
[steady]
tolerance = 1e-7
[[body]]
name = "strip"
kind = "membrane-elements"
elements = "triangles"
surface = { rectangle = { corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0], second_edge = [0, 0.2, 0], points = [12, 3] } }
thickness = "1 mm"
material = { kind = "neo-hookean-membrane", density = 1000, young_modulus = 1e6, poisson_ratio = 0 }
bending = { rigidity = 0.2 }
[[motion]]
name = "clamp"
body = "strip"
part = { box = { lower = [-1, -1, -1], upper = [0.001, 1, 1] } }
hold = ["x", "y", "z"]
"""
GRAVITY = "gravity = [0, 0, -1]\n[time]"
DISC = """
schema = 1
title = "A round sheet that is held at its edge, under pressure"
[time]
end = 1
[steady]
[[body]]
name = "sheet"
kind = "membrane-elements"
elements = "triangles"
surface = { disc = { centre = [0, 0, 0], normal = [0, 0, 1], radius = 1, rings = 12 } }
thickness = "1 mm"
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e9, poisson_ratio = 0.3 }
[[support]]
body = "sheet"
where = "boundary"
[[pressure]]
body = "sheet"
value = 100
"""


def finished(text, threads=1, **settings):
    changes = {key.replace("__", "."): value for key, value in settings.items()}
    simulation = Simulation(loads(text).with_settings(changes), threads=threads)
    while not simulation.clock.finished(None):
        simulation.step()
    return simulation


def steady(simulation):
    return simulation.facts()["steady"]


def displacement(simulation):
    body = simulation.bodies[0]
    return body.arrays["position"] - body.surface.vertices


def assert_is_that_of_the_relaxation(text, near, **settings):
    found = finished(text, **settings)
    relaxed = finished(text, steady__method="relaxation", **settings)
    assert steady(found)["method"] == "factored"
    assert steady(found)["relaxed_load_steps"] == []
    assert abs(displacement(found) - displacement(relaxed)).max() < near * abs(displacement(relaxed)).max()
    return found, relaxed


# exact solutions


def test_a_balloon_has_the_radius_of_a_thin_sphere():
    law = Simulation(loads(BALLOON), threads=1).bodies[0].surface.law

    def excess(stretch, pressure):
        s11, _, _, ratio = plane_response(law, shape_of(law, (1.0, 1.0, 0.0), stretch, stretch))
        return 2.0 * s11 * ratio * THICKNESS / (stretch * RADIUS) - pressure

    exact, errors = brentq(excess, 1.0, 1.3, args=(3000.0,)), []
    for divisions in (4, 8):
        found = finished(BALLOON, body__skin__surface__sphere__divisions=divisions)
        body = found.bodies[0]
        volumes = [np.sum(x * body.surface.vector_areas(x)) for x in (body.arrays["position"], body.surface.vertices)]
        errors.append(abs((volumes[0] / volumes[1]) ** (1.0 / 3.0) - exact))
    assert errors[1] < 2e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3), "flat triangles are of second order"


def test_a_flat_sheet_bulges_as_henckys():
    """Hencky 1915, Z. Math. Phys. 63, 311: w = 0.653 (p a⁴/E h)^⅓ in the middle, with ν = 0.3. The sheet has no stiffness
    across at the start. Flat triangles are of second order: 1 % with 12 rings."""
    found = finished(DISC)
    assert steady(found)["relaxed_load_steps"] == []
    assert displacement(found)[0, 2] == pytest.approx(0.653 * (100.0 / 1e6) ** (1.0 / 3.0), rel=0.01)


# the relaxation


def test_a_balloon_is_that_of_the_relaxation_and_neither_turns_nor_drifts():
    found, relaxed = assert_is_that_of_the_relaxation(BALLOON, 1e-6)
    assert found.budget.stored == pytest.approx(relaxed.budget.stored, rel=1e-5), "that of the state, and sums over steps"
    assert found.budget.conservation()["momentum"] < 1e-12


@pytest.mark.parametrize("law", ["linear-membrane", "neo-hookean-membrane"])
def test_a_plate_bends_under_its_weight_as_in_the_relaxation(law):
    text = STRIP.replace("[time]", GRAVITY).replace("neo-hookean-membrane", law).replace("1e6", "1e5")
    assert_is_that_of_the_relaxation(text, 1e-5)


PULLED = (
    BALLOON.split("[[pressure]]")[0].replace("1e-8", "1e-6")
    + """bending = { rigidity = 1e-3 }
volume_stiffness = 1e5
area_stiffness = 100
[[load]]
kind = "point-load"
body = "skin"
where = { box = { lower = [0.09, -1, -1], upper = [1, 1, 1] } }
force = [2, 0, 0]
rise = 1
[[load]]
kind = "point-load"
body = "skin"
where = { box = { lower = [-1, -1, -1], upper = [-0.09, 1, 1] } }
force = [-2, 0, 0]
rise = 1
"""
)


def test_area_and_volume_are_kept_as_in_the_relaxation():
    found, relaxed = assert_is_that_of_the_relaxation(PULLED, 3e-5)
    drifts = [simulation.bodies[0].facts() for simulation in (found, relaxed)]
    for name in ("area_drift", "volume_drift"):
        assert drifts[0][name] == pytest.approx(drifts[1][name], rel=1e-3)


# works


def test_works_of_a_pressure_are_of_fourth_order_in_the_load_step():
    errors = [abs(finished(BALLOON, steady__load_steps=number).budget.energy_error()) for number in (2, 4, 8)]
    assert errors[0] < 1e-2
    assert np.log2(errors[1] / errors[2]) > 3.0


# stability, walls, supports that end


PUSH = """
[[load]]
kind = "point-load"
body = "strip"
where = { box = { lower = [0.999, -1, -1], upper = [2, 1, 1] } }
force = [-0.1184, 0, 0]
rise = 1
"""


def test_a_strip_leaves_its_straight_equilibrium_beyond_eulers_load():
    """Euler: π² D/4 L² per width, 0.493 N/m; the load is a fifth larger."""
    found = finished(STRIP + PUSH, steady__load_steps=2)
    assert steady(found)["unstable_load_steps"] == [2]
    assert abs(displacement(found)[:, 2]).max() > 0.3


def pushed_cantilever(push):
    """ω L² √(ρh/D) of a cantilever under a push P [D/L²] at its tip, from D d⁴w/dx⁴ + P d²w/dx² = ρh ω² w with neither moment
    nor force across the first direction at the tip."""

    def unfulfilled(omega):
        root = np.sqrt(0.25 * push**2 + omega**2)
        a, b = np.sqrt(root + 0.5 * push), np.sqrt(root - 0.5 * push)
        shapes = [  # moment and force at the tip, of cos - cosh and of sin/a - sinh/b
            (-a * a * np.cos(a) - b * b * np.cosh(b), a * (a * a - push) * np.sin(a) - b * (b * b + push) * np.sinh(b)),
            (-a * np.sin(a) - b * np.sinh(b), -(a * a - push) * np.cos(a) - (b * b + push) * np.cosh(b)),
        ]
        return np.linalg.det(shapes)

    return brentq(unfulfilled, 0.5, 4.0)


def test_the_lowest_frequency_is_that_of_a_cantilever_that_is_pushed():
    assert pushed_cantilever(0.0) == pytest.approx(1.8751**2, rel=1e-4)
    unit = np.sqrt(0.2 / (1000.0 * 1e-3)) / (2.0 * np.pi)
    for push in (0.0, 0.25 * np.pi**2 / 2.0):  # half of Euler's load
        loaded = STRIP + PUSH.replace("-0.1184", f"{-0.2 * 0.2 * push}")
        found = steady(finished(loaded))["lowest_frequencies"]
        assert found == pytest.approx([unit * pushed_cantilever(push)], rel=0.01), "ten elements, of second order"
    assert steady(finished(BALLOON))["lowest_frequencies"] == [None], "it can move as a whole"


def test_a_strip_that_would_fall_through_a_wall_is_relaxed_and_rests_on_it():
    grid = "[grid]\nlower = [-0.25, -0.25, -0.25]\nupper = [1.25, 0.5, 0.75]\ncell = 0.25\n[[body]]"
    floor = '[[support]]\nname = "floor"\nwhere = "z-lower"\nfix = "normal"\n'
    text = STRIP.replace("[time]", GRAVITY).replace("[[body]]", grid, 1).replace("1e-7", "1e-3") + floor
    with pytest.warns(UserWarning, match="would pass a face of the grid normal to z"):
        found = finished(text)
    assert steady(found)["relaxed_load_steps"] == [1]
    lowest = found.bodies[0].arrays["position"][:, 2].min()
    assert lowest == pytest.approx(-0.25, abs=1e-6)


def test_a_clamp_that_ends_bends_other_triangles():
    text = STRIP.replace("[time]", GRAVITY).replace("1e6", "1e5") + (
        '[[support]]\nname = "until"\nbody = "strip"\n'
        "where = { box = { lower = [0.899, -1, -1], upper = [2, 1, 1] } }\nuntil = 0.5\n"
    )
    found = finished(text, steady__load_steps=4)
    free = finished(text.split("[[support]]")[0], steady__load_steps=4)
    assert abs(displacement(found) - displacement(free)).max() < 1e-5


# runs


def test_results_do_not_depend_on_threads():
    places = [finished(PULLED, threads=threads).bodies[0].arrays["position"] for threads in (1, 2)]
    assert np.array_equal(*places)


@pytest.mark.parametrize("text", [BALLOON, PULLED], ids=["pressure", "point loads"])
def test_a_run_goes_on_bit_for_bit(text, tmp_path):
    case = loads(text).with_settings({"steady.load_steps": 4, "output.frames": 0.25})
    run_case(case, tmp_path / "whole", report=False)
    run_case(case, tmp_path / "part", report=False, until=0.5)
    resume_case(tmp_path / "part", report=False)
    one, other = ((tmp_path / name / "history.csv").read_bytes() for name in ("part", "whole"))
    assert one == other


def test_a_pressure_above_the_limit_gives_no_false_equilibrium():
    """The limit is some 0.52 E h/R = 5 200 Pa for ν near ½."""
    with pytest.warns(UserWarning, match="no equilibrium was found"), pytest.raises(RunStopped):
        finished(BALLOON, pressure__0__value=8000.0, steady__most_steps=3000, steady__tolerance=1e-4)


def test_a_free_body_under_a_resultant_force_has_no_equilibrium():
    simulation = Simulation(loads(BALLOON.replace("[time]", "gravity = [0, 0, -1]\n[time]")), threads=1)
    with pytest.warns(UserWarning, match="no equilibrium was found"):
        simulation.step()
    assert steady(simulation)["relaxed_load_steps"] == [1]


def test_an_unstable_equilibrium_that_is_kept_is_told():
    """Without an energy at large strains the search does not leave the straight strip, which is far stiffer along than
    across."""
    stiff = STRIP.replace("neo-hookean-membrane", "linear-membrane").replace("1e6", "5e7")
    with pytest.warns(UserWarning, match="the equilibrium is unstable"):
        found = finished(stiff + PUSH)
    assert steady(found)["kept_unstable_load_steps"] == [1]
    assert steady(found)["lowest_frequencies"] == [None]


def test_the_size_of_the_stiffness_is_foretold():
    assert "with a factored stiffness of 294 unknowns" in of_case(loads(BALLOON)).why


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("poisson_ratio = 0.49", "poisson_ratio = 0.49, wrinkling = true", "body skin wrinkles"),
        ('elements = "triangles"', 'elements = "quads"', "body skin has quadrilaterals"),
    ],
)
def test_what_the_stiffness_lacks_is_refused_or_relaxed(old, new, words):
    text = BALLOON.replace(old, new)
    assert "at most" in of_case(loads(text)).why
    with pytest.raises(Exception, match=words):
        loads(text.replace("[steady]", '[steady]\nmethod = "factored"'))


# many cases


SHAPES = {
    "sphere": ({"sphere": {"centre": [0, 0, 0], "radius": 0.1, "divisions": 5}}, {}),
    "ellipsoid": (
        {"ellipsoid": {"centre": [0, 0, 0], "radii": [0.12, 0.1, 0.08], "refinements": 2}},
        {"bending": {"rigidity": 1e-3, "spontaneous_curvature": "start"}, "volume_stiffness": 1e5},
    ),
    "sheet": ({"disc": {"centre": [0, 0, 0], "normal": [0, 0, 1], "radius": 0.1, "rings": 6}}, {}),
    "plate": (
        {"disc": {"centre": [0, 0, 0], "normal": [0.1, 0, 1], "radius": 0.1, "rings": 6}},
        {"bending": {"rigidity": 1e-2}},
    ),
}
ELASTIC = {"young_modulus": 1e6, "poisson_ratio": 0.4}
MODULI = {"shear_modulus", "shear_moduli", "area_modulus", "rubber_modulus", "k1"}
LAWS = {"neo-hookean-membrane": ELASTIC, "linear-membrane": ELASTIC} | SURFACE_LAWS


CASES = [(law, shape) for law in LAWS for shape in SHAPES]
CASES.remove(("holzapfel-gasser-ogden-membrane", "sphere"))  # somewhere on it fibres along x would be normal to it


@pytest.mark.slow
@pytest.mark.parametrize(("law", "shape"), CASES)
def test_random_loads_on_every_law(law, shape):
    """Strains of up to about a half: each run ends in an equilibrium without a relaxation."""
    rng = np.random.default_rng([len(law), len(shape)])
    surface, keys = SHAPES[shape]
    material = {"kind": law, "density": 1000.0} | LAWS[law]
    for key in MODULI & LAWS[law].keys():  # of 1 N/m
        material[key] = (1e3 * np.array(LAWS[law][key])).tolist()
    stiffness = 1e3  # about that of all laws [N/m]
    body = {"name": "skin", "kind": "membrane-elements", "elements": "triangles", "thickness": THICKNESS, "material": material}
    held = "boundary" if shape in ("sheet", "plate") else {"box": {"lower": [-1, -1, -1], "upper": [1, 1, -0.06]}}
    force = (0.02 * stiffness * rng.uniform(-1.0, 1.0, 3)).tolist()
    load = {"kind": "point-load", "body": "skin", "where": {"box": {"lower": [0.02, -1, -1], "upper": [0.06, 1, 1]}}}
    table = {
        "schema": 1,
        "title": "a test",
        "time": {"end": 1.0},
        "steady": {"load_steps": int(rng.integers(1, 4)), "tolerance": 1e-5},
        "body": [body | {"surface": surface} | keys],
        "support": [{"body": "skin", "where": held}],
        "pressure": [{"body": "skin", "value": float(0.5 * stiffness / RADIUS * rng.uniform(0.1, 0.5)), "rise": 1.0}],
        "load": [load | {"force": force, "rise": 1.0}],
    }
    simulation = Simulation(Case.model_validate(table), threads=1)
    while not simulation.clock.finished(None):
        simulation.step()
    found = steady(simulation)
    assert found["estimated_error"] <= 1e-5
    assert found["unbalanced_force"] < 1e-4
    assert found["relaxed_load_steps"] == []


def test_a_body_whose_motion_is_prescribed_needs_no_factored_stiffness():
    """A sheet of quadrilaterals, which a factored stiffness does not include, moves as a whole."""
    rectangle = {"corner": [0, 0, 0], "first_edge": [0.1, 0, 0], "second_edge": [0, 0.1, 0], "points": [4, 4]}
    law = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
    sheet = {"name": "sheet", "kind": "membrane-elements", "surface": {"rectangle": rectangle}, "thickness": 1e-3}
    up = {"z": {"kind": "steady", "velocity": 0.01}}
    motion = {"name": "led", "body": "sheet", "hold": ["x", "y"], "displacement": up}
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {}, "motion": [motion]}
    simulation = Simulation(Case.model_validate(table | {"body": [sheet | {"material": law}]}), threads=1)
    while not simulation.clock.finished(None):
        simulation.step()
    assert simulation.bodies[0].field("position")[:, 2] == pytest.approx(0.01)
    assert "method" not in simulation.facts()["steady"]
