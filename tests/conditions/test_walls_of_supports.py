"""Walls made of several supports whose shapes touch: they act as the union of the shapes."""

import numpy as np
import pytest
from small_cases import advance, assert_resumes, box, case

from pellucid.conditions.no_slip_walls import NoSlipWall
from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0}
OIL |= {"eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}
HOW = {"functions": "quadratic-bspline", "transfer": "apic", "energy": {"warn": 0.5, "stop": 10.0}, "end": 100.0}
ROUNDING = 1e-12  # of velocities near 1: the surfaces are found from the same samples, so only sums may differ
LOWER, UPPER = ((-10, -10), (30, 2.3)), ((-10, 7.8), (30, 30))


def support(corners, name=None, depth=(0, 0), **more):
    """A support with a box in the plane, from `corners`."""
    (a, b), (c, d) = corners
    named = {} if name is None else {"name": name}
    return named | {"where": {"box": {"lower": [a, b, depth[0]], "upper": [c, d, depth[1]]}}} | more


def channel(*supports, material=None, **more):
    """Oil between walls at y = 2.3 and y = 7.8, driven along x, on a grid that is periodic along x."""
    oil = box((0, 2.3, 0), (8, 7.8, 0), OIL | (material or {}), (2, 2, 1), name="oil", velocity=(0.5, 0.0, 0.0))
    push = {"gravity": (0.2, 0.0, 0.0), "counts": (8, 11, 1), "periodic": ["x"]}
    return Simulation(case(oil, support=supports, **(HOW | push | more)), threads=1)


def walls_of(sim):
    return sim.parts.of(NoSlipWall)


def velocities(sim, steps=25):
    advance(sim, steps)
    return sim.bodies[0].frame()["velocity"]


def assert_same_flow(one, other, tolerance=ROUNDING):
    assert np.abs(velocities(one) - velocities(other)).max() < tolerance


HALVES = [support(((a, low), (b, high))) for low, high in ((-10, 2.3), (7.8, 30)) for a, b in ((0, 4), (4, 8))]
OVERLAPPING = [support(((a, low), (b, high))) for low, high in ((-10, 2.3), (7.8, 30)) for a, b in ((-1, 5), (3, 9))]
TWICE = 2 * [support(LOWER), support(UPPER)]
HIDDEN = [support(LOWER), support(UPPER), support(((-10, -10), (30, 1.8))), support(((-10, 8.3), (30, 30)))]
UNLIKE = [HALVES[0] | {"fix": ["x", "y"]}, *HALVES[1:]]  # alike in the plane
SHIFTED = [support(((a, low), (a + 8, high))) for low, high in ((-10, 2.3), (7.8, 30)) for a in (-8, 0, 8)]


@pytest.mark.parametrize("parts", [HALVES, OVERLAPPING, TWICE, HIDDEN, SHIFTED, UNLIKE])
@pytest.mark.parametrize("more", [{}, {"material": {"implicit_pressure": True}, "scheme": "usl"}, {"fix": "normal"}])
def test_a_channel_of_several_boxes_is_that_of_one_box_on_each_side(parts, more):
    """With every box as a wall of its own, the mean velocity was 10 to 60 % too small."""
    fix = {"fix": more["fix"]} if "fix" in more else {}
    how = {key: value for key, value in more.items() if key != "fix"}
    one = channel(support(LOWER, **fix), support(UPPER, **fix), **how)
    several = channel(*(part | fix for part in parts), **how)
    assert len(walls_of(several)) == len(walls_of(one)) == 2
    assert_same_flow(one, several)


def test_reactions_of_the_parts_sum_to_that_of_one_box():
    names = ["left", "right", "left-top", "right-top"]
    one = channel(support(LOWER, "bottom"), support(UPPER, "top"))
    several = channel(*(part | {"name": name} for part, name in zip(HALVES, names, strict=True)))
    advance(one, 25), advance(several, 25)
    whole, parts = one.budget.reactions(), several.budget.reactions()
    assert parts["left"] + parts["right"] == pytest.approx(whole["bottom"], abs=1e-12)
    assert parts["left-top"] + parts["right-top"] == pytest.approx(whole["top"], abs=1e-12)
    assert parts["left"][0] == pytest.approx(parts["right"][0], rel=1e-9)  # the flow is uniform along the walls
    assert several.budget.conservation()["momentum"] < 1e-12


def cup(*supports):
    """Oil that moves along x in a basin between x = 2.3 and x = 8.6, over a floor at y = 2.4."""
    oil = box((2.3, 2.4, 0), (8.6, 9, 0), OIL, (3, 3, 1), name="oil", velocity=(0.5, 0.0, 0.0))
    return Simulation(case(oil, counts=(11, 12, 1), support=supports, **HOW), threads=1)


WIDE_FLOOR = [((-10, -10), (20, 2.4)), ((-10, 2.4), (2.3, 20)), ((8.6, 2.4), (20, 20))]
NARROW_FLOOR = [((2.3, -10), (8.6, 2.4)), ((-10, -10), (2.3, 20)), ((8.6, -10), (20, 20))]
OVERLAP = [((-10, -10), (20, 2.4)), ((-10, -10), (2.3, 20)), ((8.6, -10), (20, 20))]


def test_a_basin_of_three_boxes_does_not_depend_on_its_seams():
    """The re-entrant corners of a U are seams."""
    cups = [cup(*(support(corners) for corners in boxes)) for boxes in (WIDE_FLOOR, NARROW_FLOOR, OVERLAP)]
    assert [len(walls_of(sim)) for sim in cups] == [1, 1, 1]
    wide, narrow, overlap = (velocities(sim) for sim in cups)
    assert np.abs(wide - narrow).max() < ROUNDING
    assert np.abs(wide - overlap).max() < ROUNDING


def duct(*supports):
    oil = box((0, 2.3, 2.4), (4, 6.3, 6.6), OIL, (2, 2, 2), name="oil", velocity=(0.5, 0.1, 0.0))
    return Simulation(case(oil, counts=(4, 9, 9), periodic=["x"], support=supports, **HOW), threads=1)


def test_a_duct_of_four_boxes_is_that_outside_a_closed_surface():
    """Upper sides of the closed surface are found 3e-8 m inside of it, where the velocity differs by up to half as much."""
    whole = {"surface": {"box": {"lower": [-9, 2.3, 2.4], "upper": [20, 6.3, 6.6], "points": [2, 2, 2]}}}
    sides = [support(((-9, a), (20, b)), depth=(-9, 20)) for a, b in ((-9, 2.3), (6.3, 20))]
    ends = [support(((-9, 2.3), (20, 6.3)), depth=depth) for depth in ((-9, 2.4), (6.6, 20))]
    assert_same_flow(duct({"where": {"outside": whole}}), duct(*sides, *ends), tolerance=1.5e-8)


LID = {"velocity": [1.0, 0.0, 0.0]}


def test_a_lid_that_moves_on_a_basin_at_rest():
    """Shapes with different velocities make one wall as well, and each moves the oil at its own surface, wherever the seams
    lie. Where shapes overlap, the later one counts."""
    sides = [support(corners) for corners in OVERLAP]
    lids = {
        "between": [((2.3, 9.0), (8.6, 20))],
        "over": [((-10, 9.0), (20, 20))],
        "of two parts": [((2.3, 9.0), (5.0, 20)), ((5.0, 9.0), (8.6, 20))],
    }
    sims = [cup(*(support(corners, "lid", **LID) for corners in lid), *sides) for lid in lids.values()]
    flows = [velocities(sim) for sim in sims]
    for sim, flow in zip(sims, flows, strict=True):
        assert len(walls_of(sim)) == 1
        assert np.abs(flow - flows[0]).max() < ROUNDING
        assert sim.budget.reactions()["lid"] == pytest.approx(sims[0].budget.reactions()["lid"], abs=1e-12)
        assert sim.budget.conservation()["momentum"] < 1e-12
        assert abs(sim.budget.conservation()["energy"]) < 1e-10


def test_a_hidden_support_with_another_velocity_does_not_act():
    hidden = [support(((-10, -10), (30, 1.8)), **LID), support(((-10, 8.3), (30, 30)), **LID)]
    assert_same_flow(channel(support(LOWER), support(UPPER)), channel(*hidden, support(LOWER), support(UPPER)))


def test_fluids_slip_on_a_shape_that_hides_a_wall_without_slip():
    """Walls that act differently remain apart, but have no surface inside each other."""
    hidden = [support(((-10, -10), (30, 1.8))), support(((-10, 8.3), (30, 30)))]
    slip = [support(corners, fix="normal") for corners in (LOWER, UPPER)]
    assert_same_flow(channel(*slip), channel(*hidden, *slip))


def test_walls_that_do_not_touch_remain_apart():
    bottom, far, near = (
        support(((-10, -10), (20, 2.4)), "bottom"),
        *(support(((4, y), (6, y + 2)), "top") for y in (3.2, 2.5)),
    )
    assert [wall.name for wall in walls_of(cup(bottom, far))] == ["the support `bottom`", "the support `top`"]
    assert [wall.name for wall in walls_of(cup(bottom, near))] == ["the supports `bottom`, `top`"]


def test_the_same_bits_after_a_checkpoint():
    corners = [*WIDE_FLOOR, ((2.3, 9.0), (8.6, 20))]
    names = ["floor", "left", "right", "lid"]
    one, again = (
        cup(*(support(where, name) | (LID if name == "lid" else {}) for where, name in zip(corners, names, strict=True)))
        for _ in range(2)
    )
    assert_resumes(one, again, 10, 10)
    for name in names:
        assert np.array_equal(one.budget.reactions()[name], again.budget.reactions()[name])
