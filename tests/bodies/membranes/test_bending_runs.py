"""Open membranes that bend in runs: clamps by motions and supports, planes of symmetry, hinges, on grids; balance; refusals."""

import numpy as np
import pytest

from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

DROP = 0.49771  # of the heavy elastica with the stretch by its weight, `tests/references/test_elastica.py`
STRIP = """
schema = 1
title = "A strip held like a shelf"
gravity = [0, 0, -1]
[time]
end = 1
[steady]
load_steps = 1
tolerance = 1e-4
[[body]]
name = "strip"
kind = "membrane-elements"
elements = "triangles"
surface = { rectangle = { corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0], second_edge = [0, 0.2, 0], points = [12, 3] } }
thickness = "1 mm"
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0 }
bending = { rigidity = 0.2 }
"""
FROM_ZERO = STRIP.replace(
    "corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0]", "corner = [0, 0, 0], first_edge = [1, 0, 0]"
).replace("points = [12, 3]", "points = [11, 3]")
GRID = """
[grid]
lower = [0, -0.25, -1]
upper = [1.5, 0.5, 0.5]
cell = 0.25
"""
MOTION = """
[[motion]]
name = "clamp"
body = "strip"
part = { box = { lower = [-1, -1, -1], upper = [0.001, 1, 1] } }
hold = ["x", "y", "z"]
"""
SUPPORT = """
[[support]]
body = "strip"
where = { box = { lower = [-1, -1, -1], upper = [0.001, 1, 1] } }
"""
ACROSS = (
    MOTION.replace('["x", "y", "z"]', '["z"]')
    + """
[[support]]
body = "strip"
where = { box = { lower = [-1, -1, -1], upper = [-0.099, 1, 1] } }
"""
)
SYMMETRIC = (
    GRID
    + MOTION.replace('["x", "y", "z"]', '["y", "z"]')
    + """
[[support]]
where = "x-lower"
fix = "normal"
"""
)


def tip(text, x=1.0):
    case = loads(text)
    start = case.body[0].mesh().vertices
    sim = Simulation(case, threads=1)
    for _ in sim:
        pass
    node = np.argmin(np.abs(start - (x, 0.1, 0.0)).sum(axis=1))
    return sim.bodies[0].field("position")[node, 2]


@pytest.mark.parametrize(
    "text",
    [STRIP + MOTION, STRIP + SUPPORT, STRIP + ACROSS, FROM_ZERO + SYMMETRIC],
    ids=["motion", "support", "across alone", "plane of symmetry"],
)
def test_a_clamped_strip_hangs_as_the_heavy_elastica(text):
    """With edges h the moments are summed by the trapezoidal rule: .8 % more with ten edges, as small deflections have h²."""
    assert tip(text) == pytest.approx(-DROP, rel=0.011)


@pytest.mark.slow
def test_its_error_falls_with_the_square_of_the_edges():
    errors = [-tip(STRIP.replace("[12, 3]", points) + MOTION) / DROP - 1.0 for points in ("[12, 3]", "[23, 5]")]
    assert errors[1] < 0.003
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_a_row_of_nodes_is_a_hinge():
    """Between two hinges, under little load: 5 q L⁴/384 D, with ten edges 1 % more."""
    ends = MOTION + MOTION.replace('"clamp"', '"other"').replace(
        "lower = [-1, -1, -1], upper = [0.001, 1, 1]", "lower = [0.999, -1, -1], upper = [2, 1, 1]"
    ).replace('["x", "y", "z"]', '["z"]')
    light = (FROM_ZERO + ends).replace("gravity = [0, 0, -1]", "gravity = [0, 0, -1e-3]")
    assert tip(light, 0.5) == pytest.approx(-5e-3 / (384.0 * 0.2), rel=0.02)


DYNAMIC = STRIP.replace("[steady]\nload_steps = 1\ntolerance = 1e-4\n", "").replace("poisson_ratio = 0", "poisson_ratio = 0.3")


@pytest.mark.parametrize("kind", ["own nodes", "grid", "points"])
def test_the_balance_closes_while_a_strip_swings(kind):
    text = DYNAMIC + MOTION
    if kind != "own nodes":
        text += GRID.replace("lower = [0, -0.25, -1]", "lower = [-0.5, -0.25, -1]")
        stone = """
[[body]]
name = "stone"
shape = { box = { lower = [1.25, 0.25, 0.25], upper = [1.5, 0.5, 0.5] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 100, poisson_ratio = 0.3 }
[[motion]]
name = "stays"
body = "stone"
hold = ["x", "y", "z"]
"""
        points = text.replace('kind = "membrane-elements"\nelements = "triangles"', 'kind = "membrane-points"')
        text = points if kind == "points" else text + stone
    sim = Simulation(loads(text.replace("end = 1", "end = 0.5")), threads=1)
    for state in sim:
        assert abs(state.budget.conservation()["energy"]) < (1e-4 if kind == "own nodes" else 0.01)
    energies, body = sim.budget.energies(), sim.bodies[0]
    assert energies["bending"] == pytest.approx(body.field("bending_energy").sum(), rel=1e-9)
    assert energies["bending"] > 0.1 * energies["kinetic"] > 0.0
    assert np.abs(body.field("curvature")).max() > 0.1


@pytest.mark.parametrize("kind", ["membrane-elements", "membrane-points"])
def test_a_resumed_run_goes_on_bit_for_bit(kind):
    text = DYNAMIC + MOTION + GRID.replace("lower = [0, -0.25, -1]", "lower = [-0.5, -0.25, -1]")
    if kind == "membrane-points":
        text = text.replace('kind = "membrane-elements"\nelements = "triangles"', 'kind = "membrane-points"')
    one, other = Simulation(loads(text), threads=1), Simulation(loads(text), threads=2)
    for _ in range(10):
        one.step()
    other.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for name in ("bending_energy", "curvature"):
        assert np.array_equal(one.bodies[0].field(name), other.bodies[0].field(name))
    for sim in (one, other):
        for _ in range(3):
            sim.step()
    assert all(np.array_equal(array, other.state_arrays()[name]) for name, array in one.state_arrays().items())


def test_a_clamp_that_lets_go_clamps_no_more():
    """The strip then falls freely: it bends no more than it did, and turns as it likes."""
    text = DYNAMIC + SUPPORT + "until = 0.1\n"
    sim = Simulation(loads(text.replace("end = 1", "end = 0.3")), threads=1)
    bending = sim.bodies[0].surface.bending
    assert bending.supports.led.sum() == 4
    for state in sim:
        if state.time > 0.11:
            assert not bending.supports.led.any()
            assert not bending.supports.fixed.any()
    first = sim.bodies[0].arrays["position"][:, 2]
    assert first.max() < -0.01


@pytest.mark.parametrize("kind", ["membrane-elements", "membrane-points"])
@pytest.mark.parametrize(("height", "images"), [(0.1, 0), (0.5, 0), (3.5, 2)], ids=["flat", "steep", "upright"])
def test_only_what_leaves_a_plane_of_symmetry_has_an_image_beyond(kind, height, images):
    """A sheet with an edge on a smooth floor that rises from it at less than 30 degrees touches the floor; one that is all led
    has no hinge."""
    text = DYNAMIC + GRID.replace("lower = [0, -0.25, -1]", "lower = [-0.5, -0.25, 0]").replace("0.5]\ncell", "4]\ncell")
    text = (
        text.replace("first_edge = [1.1, 0, 0]", f"first_edge = [1.1, 0, {height}]")
        + """
[[support]]
where = "z-lower"
fix = "normal"
"""
    )
    if kind == "membrane-points":
        points = "points = [23, 3]" if height > 2 else "points = [12, 3]"
        text = text.replace('kind = "membrane-elements"\nelements = "triangles"', 'kind = "membrane-points"')
        text = text.replace("points = [12, 3]", points)
    found = []
    for more in ("", MOTION.replace("[0.001, 1, 1]", "[2, 1, 9]")):
        sim = Simulation(loads(text + more), threads=1)
        sim.step()
        body = sim.bodies[0]
        bending = body.bending if kind == "membrane-points" else body.surface.bending
        found.append(np.count_nonzero(bending._operators.mirror >= 0))
    assert found == [images, 0]
    assert len(bending._operators.corners) == 0
    assert np.abs(body.field("bending_energy")).max() == 0.0


def test_the_step_of_a_free_strip_is_foretold():
    case = loads(DYNAMIC)
    ahead, sim = of_case(case), Simulation(case, threads=1)
    assert ahead.step == pytest.approx(case.time.courant / sim.bodies[0].totals.rate, rel=1e-9)


def test_the_ratio_is_that_of_the_material_if_none_is_given():
    def ratio(text):
        return Simulation(loads(text), threads=1).bodies[0].surface.bending.poisson_ratio

    linear = 'linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0 '
    assert ratio(STRIP.replace("poisson_ratio = 0 ", "poisson_ratio = 0.3 ")) == 0.3
    assert ratio(STRIP.replace("rigidity = 0.2", "rigidity = 0.2, poisson_ratio = -0.5")) == -0.5
    skalak = 'skalak-membrane", density = 1000, shear_modulus = 10, area_coefficient = 1 '
    assert ratio(STRIP.replace(linear, skalak)) == pytest.approx(0.5)  # K = 3 G
    sheet = 'evans-skalak-membrane", density = 1000, area_modulus = 10, shear_modulus = 0 '
    with pytest.raises(CaseError, match=r"has no shear stiffness(?s:.*)set `poisson_ratio`, for example to 0\.5"):
        loads(STRIP.replace(linear, sheet))
    ball = "surface = { icosphere = { centre = [0, 0, 0], radius = 1, refinements = 1 } }\nthickness"
    closed = STRIP.partition("surface =")[0] + ball + STRIP.partition("thickness")[2]
    loads(closed)
    with pytest.raises(CaseError, match="no effect on a closed surface"):
        loads(closed.replace("rigidity = 0.2", "rigidity = 0.2, poisson_ratio = 0.3"))
    with pytest.raises(CaseError, match=r"bending\.poisson_ratio"):
        loads(STRIP.replace("rigidity = 0.2", "rigidity = 0.2, poisson_ratio = 1"))


def test_points_with_damage_do_not_bend():
    torn = "poisson_ratio = 0, damage = { elastic_limit = 0.05, stiffness_loss = 10, rate = 10, failure_strain = 0.06 } "
    text = (DYNAMIC + GRID.replace("[0, -0.25, -1]", "[-0.5, -0.25, -1]")).replace("poisson_ratio = 0.3 ", torn)
    with pytest.raises(CaseError, match="failed points would still resist bending"):
        loads(text.replace('kind = "membrane-elements"\nelements = "triangles"', 'kind = "membrane-points"'))
