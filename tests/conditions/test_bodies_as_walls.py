"""Bodies whose motion is prescribed as walls of fluids."""

import numpy as np
import pytest
from small_cases import SOLID, advance, assert_resumes, box, case

from pellucid.case import Case
from pellucid.conditions.no_slip_walls import NoSlipWall
from pellucid.set_up.first_look import look
from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1.0, "viscosity": 1.0}
OIL |= {"eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}}
FEW = {"warn": 0.5, "stop": 10.0}
HOW = {"functions": "quadratic-bspline", "transfer": "apic", "energy": FEW, "end": 100.0}
LONG = {"scheme": "usl"}


def with_motions(made, *motions):
    return Simulation(Case.model_validate(made.to_data() | {"motion": list(motions)}), threads=1)


def led(body, velocity=(0.0, 0.0, 0.0)):
    """A motion with this name of a body, along all axes."""
    moved = {axis: {"kind": "steady", "velocity": v} for axis, v in zip("xyz", velocity, strict=True) if v}
    return {"name": body, "body": body, "hold": [axis for axis in "xyz" if axis not in moved], "displacement": moved}


def walls_of(sim):
    return sim.parts.of(NoSlipWall)


def between_plates(low, high, velocity, material=OIL, counts=(4, 12, 1), rise=0.0, developed=True, **more):
    """Oil between two plates of points, of which the upper one moves along x; all of it moves along y at the speed `rise`. The
    flow is developed at the start, or at rest along x."""
    oil = box((0, low, 0), (4, high, 0), material, (3, 3, 1), name="oil", velocity=(0.0, rise, 0.0))
    plates = [
        box((0, low - 2.0, 0), (4, low, 0), SOLID, (2, 2, 1), name="bottom"),
        box((0, high, 0), (4, high + 2.0, 0), SOLID, (2, 2, 1), name="top"),
    ]
    made = case(oil, *plates, counts=counts, periodic=["x"], **(HOW | more))
    sim = with_motions(made, led("bottom", (0.0, rise, 0.0)), led("top", (velocity, rise, 0.0)))
    if developed:
        points = sim.bodies[0].arrays
        points["velocity"][:, 0] = velocity * (points["position"][:, 1] - low) / (high - low)
        points["affine"][:, 1] = velocity / (high - low)
    return sim


def mean_forces(sim, steps, more):
    advance(sim, steps)
    before, since = {name: push.copy() for name, push in sim.budget.reactions().items()}, sim.time
    advance(sim, more)
    return {name: (push - before.get(name, 0.0)) / (sim.time - since) for name, push in sim.budget.reactions().items()}


@pytest.mark.parametrize(
    ("low", "functions", "material", "more"),
    [
        (2.0, "quadratic-bspline", {}, {}),
        (2.3, "quadratic-bspline", {}, {}),
        (2.9, "gimp", {}, {}),
        (2.3, "quadratic-bspline", {"implicit_viscosity": True}, {}),
        (2.3, "quadratic-bspline", {"implicit_pressure": True}, LONG),
    ],
)
def test_the_traction_between_plates_of_points(low, functions, material, more):
    """Couette's flow: μ U / H. The points alone would hold all nodes that they reach, and the gap would be up to 60 %
    narrower."""
    sim = between_plates(low, low + 6.0, 0.1, OIL | material, functions=functions, **more)
    assert len(walls_of(sim)) == 2
    force = mean_forces(sim, 150 if material else 300, 50 if material else 200)
    assert force["top"][0] == pytest.approx(4.0 * 0.1 / 6.0, rel=0.003)
    assert force["bottom"][0] == pytest.approx(-force["top"][0], rel=0.003)


def test_plates_that_cross_cells():
    """Everything rises by one and a half cells: the traction stays that of plates at rest."""
    sim = between_plates(2.3, 8.3, 0.1, counts=(4, 14, 1), rise=0.1)
    while sim.time < 12.0:
        sim.step()
    force = mean_forces(sim, 0, 100)
    assert force["top"][0] == pytest.approx(4.0 * 0.1 / 6.0, rel=0.01)
    assert force["bottom"][0] == pytest.approx(-4.0 * 0.1 / 6.0, rel=0.01)
    place = sim.bodies[0].frame()["position"][:, 1]
    assert place.min() > 2.3 + 0.1 * sim.time - 0.05
    assert place.max() < 8.3 + 0.1 * sim.time + 0.05


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_momentum_and_energy_are_kept(scheme):
    sim = between_plates(2.3, 8.6, 0.5, rise=0.2, counts=(4, 14, 1), scheme=scheme, developed=False)
    advance(sim, 60)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-10
    assert sim.budget.reactions()["top"][0] > 0.0


def test_a_led_body_is_the_wall_that_a_support_of_its_shape_is():
    """Also a thin tube with nothing behind, in a grid that ends close behind it: space that the fluid cannot reach is part of
    the wall."""
    blood = {"name": "blood", "points_per_cell": (2, 2, 2), "material": OIL}
    blood |= {"shape": {"cylinder": {"centre": [2.0, 0.0, 0.0], "radius": 4.0, "axis": "x", "height": 4.0}}}
    tube = {"centre": [2.0, 0.0, 0.0], "inner_radius": 4.0, "outer_radius": 5.0, "axis": "x", "height": 4.0}
    wall = {"name": "tube", "points_per_cell": (2, 2, 2), "material": SOLID, "shape": {"pipe": tube}}
    how = HOW | {"counts": (4, 10, 10), "lower": (0.0, -5.0, -5.0), "functions": "gimp"}
    thick = {"where": {"pipe": tube | {"outer_radius": 20.0, "height": 30.0}}}
    (one,) = walls_of(Simulation(case(blood, support=[thick], **how), threads=1))
    (two,) = walls_of(with_motions(case(blood, wall, **how), led("tube")))
    _, here, there = np.intersect1d(one._wall.node, two._wall.node, return_indices=True)
    assert len(here) == len(one._wall.node)
    for name in ("area", "filled", "across", "facing", "held"):
        assert np.array_equal(getattr(one._wall, name), getattr(two._wall, name)[there])
    assert np.array_equal(one._wall.surface.distance, two._wall.surface.distance[there])
    assert one._wall.surface.curvature == pytest.approx(two._wall.surface.curvature[there], abs=1e-9)
    assert two._wall.area.sum() == pytest.approx(one._wall.area.sum(), rel=1e-12)
    _, here, there = np.intersect1d(one.cut.node, two.cut.node, return_indices=True)
    assert len(here) == len(one.cut.node)
    assert np.array_equal(one.cut.filled, two.cut.filled[there])


def test_a_turning_box_carries_its_liquid():
    """A liquid that turns with a square box goes on turning with it, by an eighth of a turn here; the box exerts no torque."""
    rate, half = 0.1, 5.0
    oil = box((-half, -half, 0), (half, half, 0), OIL, (2, 2, 1), name="oil", angular_velocity=(0.0, 0.0, rate))
    frame = box((-7, -7, 0), (7, 7, 0), SOLID, (2, 2, 1), name="frame", rigid=True, outside=["oil"])
    turn = {"name": "turn", "body": "frame", "hold": ["x", "y"]}
    turn |= {"rotation": {"z": {"kind": "steady", "angular_velocity": rate}}}
    sim = with_motions(case(oil, frame, counts=(22, 22, 1), lower=(-11.0, -11.0, 0.0), **HOW), turn)
    assert len(walls_of(sim)) == 1
    while sim.time < 0.25 * np.pi / rate:
        sim.step()
    place, velocity = sim.bodies[0].arrays["position"], sim.bodies[0].arrays["velocity"]
    spin = (place[:, 0] * velocity[:, 1] - place[:, 1] * velocity[:, 0]).mean()
    assert spin == pytest.approx(rate * (place[:, :2] ** 2).sum(axis=1).mean(), rel=0.01)
    turned = np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2.0)
    assert np.abs(place[:, :2] @ turned.T).max() < half + 0.1
    assert abs(sim.budget.conservation()["energy"]) < 1e-10


def test_the_same_bits_after_a_checkpoint():
    one, again = (between_plates(2.3, 8.6, 0.5, rise=0.2, counts=(4, 14, 1)) for _ in range(2))
    assert_resumes(one, again, 20, 20)
    assert np.array_equal(one.budget.reactions()["top"], again.budget.reactions()["top"])


def test_fluids_are_left_out_of_led_bodies():
    oil, plate = box((0, 0, 0), (4, 8, 0), OIL, (2, 2, 1), name="oil"), box((0, 0, 0), (4, 2.5, 0), SOLID, (2, 2, 1))
    sim = with_motions(case(oil, plate, counts=(4, 10, 1), **HOW), led("block"))
    assert sim.bodies[0].frame()["position"][:, 1].min() > 2.5
    assert sim.bodies[0].arrays["volume"].sum() == pytest.approx(22.0)


def test_which_bodies_are_walls():
    """Solids whose whole motion is prescribed, if they are not thin, and only viscous fluids and others of their kind share the
    field."""
    oil, plate = (
        box((0, 2, 0), (4, 8, 0), OIL, (2, 2, 1), name="oil"),
        box((0, 0, 0), (4, 2, 0), SOLID, (2, 2, 1), name="plate"),
    )
    whole, soft = led("plate"), box((0, 8, 0), (4, 9, 0), SOLID, (2, 2, 1), name="soft")
    part = whole | {"part": {"box": {"lower": [0, 0, 0], "upper": [4, 1, 0]}}}
    inviscid = oil | {"material": OIL | {"viscosity": 0.0}}
    thin, other = box((0, 1.5, 0), (4, 2, 0), SOLID, (2, 2, 1), name="plate"), {"field": "other"}
    rigid, turn = plate | {"rigid": True}, {"hold_rotation": ["z"]}
    for bodies, motion, is_wall in (
        ((oil, plate), whole, True),
        ((oil, plate), part, False),
        ((oil, plate), whole | {"hold": ["x"]}, False),
        ((inviscid, plate), whole, False),
        ((oil, plate, soft), whole, False),
        ((oil, thin), whole, False),
        ((oil, plate, soft | other), whole, True),
        ((oil, rigid), whole, False),
        ((oil, rigid), whole | turn, True),
    ):
        made = Case.model_validate(case(*bodies, counts=(4, 12, 1), **HOW).to_data() | {"motion": [motion]})
        assert made.body[1].is_wall == is_wall
        warned = [text for text in look(made) if "stops up to a cell before the surface of body plate" in text]
        assert len(warned) == (not is_wall and (bodies[1] is thin or bodies[-1] is soft))


def test_a_fluid_that_solves_its_viscosity_meets_a_wall_in_the_solve():
    """A run warns of contact after the solve with a free rigid body only."""
    oil = box((0, 2, 0), (4, 8, 0), OIL | {"implicit_viscosity": True}, (2, 2, 1), name="oil")
    plate = box((0, 0, 0), (4, 2, 0), SOLID, (2, 2, 1), name="plate", rigid=True)
    for motions in ([led("plate") | {"hold_rotation": ["z"]}], []):
        made = Case.model_validate(case(oil, plate, counts=(4, 12, 1), **HOW).to_data() | {"motion": motions})
        assert any("slips along these bodies" in text for text in look(made)) == (not motions)


def test_a_wall_that_continues_from_an_earlier_run_is_where_its_points_are():
    first = between_plates(2.3, 8.3, 0.1, counts=(4, 14, 1), rise=0.2)
    advance(first, 40)
    states = {body.name: {name: body.field(name) for name in ("id", *body.arrays)} for body in first.bodies}
    again = Simulation(first.case, threads=1, start=states)
    for one, other in zip(walls_of(first), walls_of(again), strict=True):
        assert other._wall.surface.distance == pytest.approx(one._wall.surface.distance, abs=0.02)
