"""Bodies cut at faces of the grid: planes of symmetry, and for fluids open faces; remedies that work when they are followed."""

import re

import numpy as np
import pytest

from pellucid.case.reading import loads
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

BALL = """\
schema = 1
title = "A ball of liquid, cut at the floor"
grid = { lower = [-1.5, -1.5, 0], upper = [1.5, 1.5, 2.5], cell = 0.25 }
time = { end = 1, transfer = "apic" }
[[body]]
name = "water"
cut_at = ["z-lower"]
shape = { sphere = { centre = [0, 0, 0.75], radius = 1 } }
material = { kind = "fluid", density = 1000, eos = { kind = "tait", sound_speed = 20, carries_tension = true } }
"""
SYMMETRY = '[[support]]\nwhere = "z-lower"\nfix = "normal"\n'
MOUTH = 'through = { cylinder = { centre = [0, 0, 0], radius = 0.66, axis = "z", height = 1 } }'
IN = f'[[inflow]]\nwhere = "z-lower"\nbody = "water"\nvelocity = 1\n{MOUTH}\n'
OUT = '[[outflow]]\nwhere = "z-lower"\n'
CUT = r"body\.water\.cut_at\.0.*\n.*"


@pytest.mark.parametrize("tables", [SYMMETRY, IN, OUT], ids=["symmetry", "inflow", "outflow"])
def test_a_fluid_is_cut_at_planes_of_symmetry_and_open_faces(tables):
    simulation = Simulation(loads(BALL + tables), threads=1)
    before = simulation.bodies[0].mass
    cap = np.pi * (2.0 - 0.25) ** 2 * (3.0 - 1.75) / 3.0  # the part of the ball above the floor
    assert before == pytest.approx(1000.0 * cap, rel=0.01)
    for _ in range(50):
        simulation.step()
    assert simulation.budget.conservation()["mass"] < 1e-12
    if tables is IN:  # in layers of half a cell
        flow = 1000.0 * np.pi * 0.66**2
        assert simulation.budget.inflow["mass"] == pytest.approx(flow * simulation.time, abs=0.125 * flow)


NEITHER = r"not a plane of symmetry, and no \[\[inflow\]\] or \[\[outflow\]\] opens it\n.*add a \[\[support\]\] with"
BOTH = r"inflow\.0\.where.*\n.*`support\.0\.where` constrains the whole face.*\n.*remove \"z-lower\" from"


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ("", CUT + NEITHER),
        (SYMMETRY + "velocity = [0, 0, 1]\n", CUT + "`support.0` moves the face z-lower"),
        (SYMMETRY + IN, BOTH),
    ],
)
def test_what_fits_together_is_said_in_remedies_that_do_not_contradict(tables, words):
    with pytest.raises(CaseError) as caught:
        loads(BALL + tables)
    assert re.search(words, str(caught.value)), str(caught.value)
    assert len(caught.value.problems) == 1


def test_each_remedy_leads_to_a_case_that_is_accepted():
    """Of the face that is cut to a support or an inflow, of the support beside the inflow to either of the two."""
    for tables in (SYMMETRY, IN, OUT):
        loads(BALL + tables)
    pipe = 'pipe = { centre = [0, 0, 0], inner_radius = 0.66, outer_radius = 3, axis = "z", height = 0.1 }'
    rim = f"[[support]]\nwhere = {{ {pipe} }}\n"
    simulation = Simulation(loads(BALL + rim + IN), threads=1)
    simulation.step()


def test_a_solid_is_cut_at_planes_of_symmetry_alone():
    solid = BALL.replace(
        'kind = "fluid", density = 1000, eos = { kind = "tait", sound_speed = 20, carries_tension = true }',
        'kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3',
    )
    with pytest.raises(CaseError, match="not a plane of symmetry") as caught:
        loads(solid + OUT)
    assert "inflow" not in str(caught.value)


SLIT = """\
schema = 1
title = "A slit whose flow turns back"
grid = { lower = [0, 0, 0], upper = [2, 2, 0], cell = 0.25 }
time = { end = 0.5, transfer = "apic" }
[[body]]
name = "blood"
shape = { box = { lower = [0, 0, 0], upper = [2, 2, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "fluid", density = 1, viscosity = 1, eos = { kind = "tait", sound_speed = 80, carries_tension = true } }
[[support]]
where = ["y-lower", "y-upper"]
"""
SWING = "amplitude = { times = [0, 0.1, 0.3, 0.5], shares = [1, -1, 1, -1] }\n"
ENDS = f"""
[[inflow]]
where = "x-lower"
body = "blood"
pressure = 32
{SWING}
[[outflow]]
where = "x-upper"
pressure = 0
"""
PERIODIC = f"""
[[load]]
kind = "body-force"
body = "blood"
acceleration = [16, 0, 0]
{SWING}
"""


def test_a_flow_that_reverses_between_open_faces_is_that_of_a_force_in_a_periodic_grid():
    """32 Pa over 1 kg/m³ and 2 m are 16 m/s²: momenta within 5 % of the largest."""
    between = momenta_along(SLIT + ENDS)
    along = momenta_along(SLIT.replace("cell = 0.25 }", 'cell = 0.25, periodic = ["x"] }') + PERIODIC)
    times = np.linspace(0.0, 0.5, 51)
    one, other = (np.interp(times, *np.transpose(momenta)) for momenta in (between, along))
    assert one.max() > 0.1
    assert one.min() < -0.1
    assert np.abs(one - other).max() < 0.05 * np.abs(other).max()


def momenta_along(text):
    """Time [s] and momentum along the slit [kg m/s] of each step."""
    simulation = Simulation(loads(text), threads=1)
    return [(step.time, step.momentum()[0]) for step in simulation]
