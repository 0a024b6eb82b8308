"""Clamps of membranes that bend and that the nodes of a grid move: as with nodes of their own, wherever the grid lies.

The moments of the folds are summed by the trapezoidal rule: strips of ten edges deflect 1 % more than they should, and the
error falls with the square of the edges, `test_bending_runs`.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pellucid.case import loads
from pellucid.errors import CaseError
from pellucid.references.solids import heavy_elastica
from pellucid.simulation.simulation import Simulation

SHELF = """
schema = 1
title = "A strip held like a shelf"
gravity = [0, 0, -1]
[time]
end = 12
[grid]
lower = [{0}, -0.4, {1}]
upper = [{2}, 0.6, {3}]
cell = 0.2
[[body]]
name = "strip"
kind = "membrane-points"
surface = {{ rectangle = {{ corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0], second_edge = [0, 0.2, 0], points = [12, 3] }} }}
thickness = "1 mm"
damping = 3
material = {{ kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0 }}
bending = {{ rigidity = 0.2 }}
"""
BOX = "{ box = { lower = [-2, -1, -1], upper = [0.001, 1, 1] } }"
SUPPORT = '[[support]]\nname = "clamp"\nwhere = '
MOTION = '[[motion]]\nname = "clamp"\nbody = "strip"\nhold = ["x", "y", "z"]\npart = '


def shelf(clamp, along=0.0, across=0.0):
    return SHELF.format(-0.6 + along, -1.0 + across, 1.4 + along, 0.4 + across) + clamp + BOX + "\n"


def at_rest(text, place=None):
    """Run a case to its end: the positions of its points, or that of the one that starts nearest to a place."""
    case = loads(text)
    sim = Simulation(case, threads=1)
    for _ in sim:
        pass
    found = sim.bodies[0].field("position")
    if place is None:
        return found
    start = case.body[0].surface.mesh("triangles").vertices
    return found[np.argmin(np.linalg.norm(start - place, axis=1))]


@pytest.mark.parametrize("clamp", [SUPPORT, MOTION], ids=["support", "motion"])
@pytest.mark.parametrize(("along", "across"), [(0.0, 0.0), (0.06, 0.1), (0.14, 0.04)])
def test_a_strip_of_points_hangs_as_the_heavy_elastica(clamp, along, across):
    """In cells of a fifth of its length; with a hinge on the nearest nodes of the grid it hung 10 % off."""
    tip = at_rest(shelf(clamp, along, across), (1.0, 0.1, 0.0))
    _, drop = heavy_elastica(np.array([1.0]), 1.0, 0.2, 1.0, 100.0)
    assert -tip[2] == pytest.approx(drop[0], rel=0.011)


@pytest.mark.slow
@pytest.mark.parametrize("clamp", [SUPPORT, MOTION], ids=["support", "motion"])
def test_its_error_falls_with_the_square_of_the_edges(clamp):
    """24 x 6 points: the last row that is held lies 1/230 before the edge of the region. With half the edges .21 %."""
    text = shelf(clamp).replace("[12, 3]", "[24, 6]").replace("cell = 0.2", "cell = 0.1")
    tip = at_rest(text, (1.0, 0.1, 0.0))
    length = 1.0 + 0.1 / 23.0
    _, drop = heavy_elastica(np.array([length]), length, 0.2, 1.0, 100.0)
    assert -tip[2] == pytest.approx(drop[0], rel=0.003)


def strip(turn, points="membrane-points"):
    """A strip in any direction, its clamp, and a load across it so small that its deflection is that of a beam."""
    matrix = turn.as_matrix()
    corner, first, second = (matrix @ np.array(way) for way in ((-0.2, -0.1, 0.0), (1.2, 0.0, 0.0), (0.0, 0.2, 0.0)))
    vector = turn.as_rotvec(degrees=True)
    angle = np.linalg.norm(vector)
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    rotate = f"rotate = {{ axis = {axis.tolist()}, angle = {angle}, centre = [0, 0, 0] }} }}"
    load = matrix @ np.array((0.0, 0.0, -0.01))
    sides = f"corner = {corner.tolist()}, first_edge = {first.tolist()}, second_edge = {second.tolist()}, points = [13, 3]"
    text = SHELF.format(-1.2, -1.2, 1.2, 1.2).replace(", -0.4, ", ", -1.2, ").replace(", 0.6, ", ", 1.2, ")
    text = text.replace("gravity = [0, 0, -1]", f"gravity = {load.tolist()}").replace("end = 12", "end = 9")
    text = text.replace("corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0], second_edge = [0, 0.2, 0], points = [12, 3]", sides)
    if points == "membrane-elements":
        stone = """
[[body]]
name = "stone"
shape = { box = { lower = [0.8, 0.8, -1.2], upper = [1.2, 1.2, -0.8] } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 100, poisson_ratio = 0.3 }
[[motion]]
name = "stays"
body = "stone"
hold = ["x", "y", "z"]
"""
        text = text.replace('"membrane-points"', '"membrane-elements"\nelements = "triangles"') + stone
    return text, BOX.removesuffix(" }") + ", " + rotate + "\n", matrix


@pytest.mark.parametrize(
    ("angles", "clamp", "kind"),
    [
        ((0, 0, 30), SUPPORT, "membrane-points"),
        ((20, -25, 40), SUPPORT, "membrane-points"),
        pytest.param((20, -25, 40), MOTION, "membrane-points", marks=pytest.mark.slow),
        pytest.param((20, -25, 40), SUPPORT, "membrane-elements", marks=pytest.mark.slow),
    ],
)
def test_a_strip_in_any_direction_bends_as_a_clamped_beam(angles, clamp, kind):
    """q L⁴/8 D, with ten edges 1 % more; nodes of the grid, triangles and the edge of the clamp lie as they like."""
    text, region, matrix = strip(Rotation.from_euler("xyz", angles, degrees=True), kind)
    start = matrix @ np.array((1.0, 0.0, 0.0))
    moved = matrix.T @ (at_rest(text + clamp + region, start) - start)
    assert -moved[2] == pytest.approx(0.01 / (8.0 * 0.2), rel=0.013)


def test_a_disc_clamped_along_its_rim_bends_as_a_plate():
    """q R⁴/64 D; ten edges along the radius, of elements on their own nodes too, make some per cent more."""
    text = shelf(SUPPORT).partition("[[body]]")[0].replace("gravity = [0, 0, -1]\n", "").replace("end = 12", "end = 6")
    text = text.replace("[-0.6, -0.4, -1.0]", "[-1.6, -1.6, -0.8]").replace("[1.4, 0.6, 0.4]", "[1.6, 1.6, 0.8]")
    text += """
[[body]]
name = "disc"
kind = "membrane-points"
surface = { disc = { centre = [0.03, 0.05, 0.01], normal = [0, 0, 1], radius = 1.2, rings = 12 } }
thickness = "1 mm"
damping = 8
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e4, poisson_ratio = 0.3 }
bending = { rigidity = 0.2 }
[[pressure]]
body = "disc"
value = 0.0128
[[support]]
where = { pipe = { centre = [0.03, 0.05, 0.01], inner_radius = 0.999, outer_radius = 2, axis = "z", height = 2 } }
"""
    place = at_rest(text)
    assert place[:, 2].max() - 0.01 == pytest.approx(0.0128 / (64.0 * 0.2), rel=0.03)


@pytest.mark.parametrize("clamp", [SUPPORT, MOTION], ids=["support", "motion"])
def test_energy_and_momentum_close_while_a_strip_swings(clamp):
    """The clamp takes the moments and forces that its nodes and points are spared, and does no work."""
    text = shelf(clamp).replace("damping = 3\n", "").replace("end = 12", "end = 2")
    sim = Simulation(loads(text), threads=1)
    for state in sim:
        assert abs(state.budget.conservation()["energy"]) < 0.01
        assert abs(state.budget.conservation()["momentum"]) < 1e-12


def test_a_strip_has_the_same_bits_on_any_number_of_threads():
    text = shelf(SUPPORT).replace("end = 12", "end = 0.3")
    one, other = (Simulation(loads(text), threads=n) for n in (1, 2))
    for sim in (one, other):
        for _ in sim:
            pass
    assert all(np.array_equal(array, other.state_arrays()[name]) for name, array in one.state_arrays().items())


def test_a_clamp_that_lets_go_holds_no_points():
    sim = Simulation(loads((shelf(SUPPORT) + "until = 0.1\n").replace("end = 12", "end = 0.5")), threads=1)
    assert sim.bodies[0].bending.supports.led.any()
    for _ in sim:
        pass
    assert not sim.bodies[0].bending.supports.led.any()
    assert sim.bodies[0].field("position")[:, 2].max() < -0.01


@pytest.mark.parametrize("kind", ["membrane-points", "membrane-elements"])
def test_open_surfaces_do_not_bend_on_trilinear_functions(kind):
    text, region, _ = strip(Rotation.identity(), kind)
    rough = text.replace("cell = 0.2", 'cell = 0.2\nfunctions = "trilinear"') + SUPPORT + region
    with pytest.raises(CaseError, match=r"bending(?s:.*)up to twice as stiff(?s:.*)quadratic-bspline"):
        loads(rough)
