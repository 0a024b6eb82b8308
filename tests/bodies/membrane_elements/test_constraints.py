"""Springs that keep area and volume of a membrane, and inflation at the start."""

import re

import numpy as np
import pytest

from pellucid.bodies.membrane_elements.constraints import Kept
from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

CELL = """
schema = 1
title = "A cell that is blown up, and kept"
[time]
end = 0.3
courant = 0.4
[[body]]
name = "cell"
kind = "membrane-elements"
elements = "triangles"
surface = { ellipsoid = { centre = [0, 0, 0], radii = [1.2, 1, 0.8], refinements = 2 } }
thickness = 0.01
material = { kind = "surface-neo-hookean-membrane", density = 100, shear_modulus = 0.5 }
area_stiffness = 40
volume_stiffness = 60
initial = [{ kind = "velocity-gradient", x = [0.6, 0, 0], y = [0, 0.3, 0], z = [0, 0, 0.1] }]
"""


def test_forces_are_the_slope_of_the_energy():
    body = Simulation(loads(CELL), threads=1).bodies[0]
    surface, kept = body.surface, body.surface.constraints
    rng = np.random.default_rng(2)
    x = surface.vertices * [1.1, 1.0, 1.2] + 0.02 * rng.normal(size=surface.vertices.shape)
    way, forces = rng.normal(size=x.shape), np.zeros_like(x)
    kept.add_forces(surface, x, forces)
    forth, back = (kept.energy_and_swings(surface, x + size * way)[0] for size in (1e-6, -1e-6))
    slope = (forth - back) / 2e-6
    assert -np.sum(forces * way) == pytest.approx(slope, rel=1e-8)
    assert np.abs(forces.sum(axis=0)).max() < 1e-12 * np.abs(forces).max() * len(x)
    assert kept.energy_and_swings(surface, surface.vertices)[0] == pytest.approx(0.0, abs=1e-24)


def test_the_balance_closes_and_stiffer_springs_keep_better():
    drifts = []
    for factor in (1.0, 16.0):
        stiff = {"body.cell.area_stiffness": 40 * factor, "body.cell.volume_stiffness": 60 * factor}
        sim = Simulation(loads(CELL).with_settings(stiff), threads=1)
        worst = 0.0
        for state in sim:
            assert abs(state.budget.conservation()["energy"]) < 5e-3
            worst = max(worst, abs(state.bodies[0].facts()["volume_drift"]))
        assert sim.budget.energies()["constraint"] > 0.0
        drifts.append(worst)
    assert drifts[1] < 0.4 * drifts[0]  # the frequency grows by 4, and with it the amplitude falls


def test_normals_may_point_inwards():
    outwards, inwards = Kept(2.0, 3.0), Kept(2.0, -3.0)
    assert inwards.energy(-3.3) == outwards.energy(3.3) > 0.0
    assert inwards.force(-3.3) == -outwards.force(3.3)
    slope, mass = np.ones((4, 3)), np.ones(4)
    assert inwards.eigenvalue(slope, mass) == outwards.eigenvalue(-slope, mass) > 0.0


BALL = """
schema = 1
title = "A ball that springs keep"
[time]
end = 0.1
[[body]]
name = "ball"
kind = "membrane-elements"
elements = "triangles"
surface = { icosphere = { centre = [0, 0, 0], radius = 1, refinements = 2 } }
thickness = 0.01
material = { kind = "surface-neo-hookean-membrane", density = 100, shear_modulus = 3 }
"""
ALONE_IN_GRID = "[grid]\nlower = [-2, -2, -2]\nupper = [2, 2, 2]\ncell = 0.4\n"
SPRINGS = {
    "volume": (
        "area_stiffness = 1e2\nvolume_stiffness = 1e4",
        r"\(spring\): it oscillates on its volume penalty, which limits the step to .* smaller volume_stiffness allows longer",
    ),
    "area": (
        "area_stiffness = 1e4",
        r"\(spring\): it oscillates on its area penalty, which limits the step to .* a smaller area_stiffness allows longer",
    ),
    "none": ("area_stiffness = 1e-3", r"\(membrane\): in-plane wave speed"),
}


@pytest.mark.parametrize("grid", ["", ALONE_IN_GRID], ids=["no grid", "grid"])
@pytest.mark.parametrize("springs", SPRINGS)
def test_the_step_on_springs_is_foretold_with_their_name(grid, springs):
    keys, words = SPRINGS[springs]
    read = loads(BALL + keys + "\n" + grid)
    ahead, sim = of_case(read), Simulation(read, threads=1)
    assert ahead.step == pytest.approx(0.4 / sim.bodies[0].totals.rate, rel=1e-9)
    assert re.search(words, ahead.why), ahead.why
    limit, name = sim.step_limit()
    assert name == "ball"
    assert re.search(words, f"({limit.cause}): {limit.reason}")


def test_a_fixed_step_above_that_of_springs_is_refused():
    fixed = (
        BALL.replace("end = 0.1", "end = 0.1\nstep = 0.02") + "area_stiffness = 1e3\nvolume_stiffness = 1e4\n" + ALONE_IN_GRID
    )
    text = "the largest stable step at the start, of body ball: it oscillates on its volume penalty"
    with pytest.raises(CaseError, match=text):
        loads(fixed)


TENSIONS = {  # T/G at a stretch of 1.05 along both directions, from the energies
    "surface-neo-hookean-membrane": 0.25378,
    "skalak-membrane": 0.34010,
}


@pytest.mark.parametrize("kind", TENSIONS)
@pytest.mark.parametrize("body", ["membrane-elements", "membrane-points"])
def test_an_inflated_sphere_bears_the_tension_of_its_law(kind, body):
    more = ", area_coefficient = 1" if kind == "skalak-membrane" else ""
    text = f"""
schema = 1
title = "An inflated sphere"
[grid]
lower = [-2, -2, -2]
upper = [2, 2, 2]
cell = 0.5
[time]
end = 1.0
[[body]]
name = "cell"
kind = "{body}"
surface = {{ icosphere = {{ centre = [0, 0, 0], radius = 1, refinements = 3 }} }}
thickness = 0.01
inflation = 0.05
material = {{ kind = "{kind}", density = 100, shear_modulus = 3.0{more} }}
"""
    found = Simulation(loads(text), threads=1).bodies[0]
    stress = found.field("plane_stress")[:, :2] if body == "membrane-points" else found.surface.arrays["plane_stress"][:, :2]
    if body == "membrane-elements":
        tension = found.field("tension")
        assert tension == pytest.approx(3.0 * TENSIONS[kind] * np.ones_like(tension), rel=2e-3)  # of nodes, of flat triangles
    if body == "membrane-elements":  # the second Piola-Kirchhoff stress of triangles: T/λ over the thickness at rest, times λ
        rest = found.surface.thickness
        assert stress * rest == pytest.approx(3.0 * TENSIONS[kind] * np.ones_like(stress), rel=1e-4)
    else:
        assert stress * 0.01 == pytest.approx(3.0 * TENSIONS[kind] * np.ones_like(stress), rel=1e-4)


BAD = {
    "both": ("area_stiffness = 40", "tension = 1.0\ninflation = 0.05", "`tension` already defines"),
    "negative": ("area_stiffness = 40", "area_stiffness = -1", "area_stiffness"),
    "open": (
        "ellipsoid = { centre = [0, 0, 0], radii = [1.2, 1, 0.8], refinements = 2 }",
        "disc = { centre = [0, 0, 0], radius = 1, normal = [0, 0, 1], rings = 4 }",
        "this surface is open and encloses no volume",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_kept_is_refused(name):
    old, new, words = BAD[name]
    with pytest.raises(CaseError, match=words):
        loads(CELL.replace(old, new))
