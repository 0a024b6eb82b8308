"""What is told of supports that prescribe different velocities at the same nodes, or move a face of the grid out of it."""

import pytest
from membranes import sheet
from small_cases import RATE_SOLID, advance, box, case, simulation

from pellucid.errors import RunStopped
from pellucid.set_up.first_look import look
from pellucid.set_up.supports import crossing_supports, free_turns, leading_out, passed_walls

WALLS = {"where": ["x-lower", "x-upper", "y-lower"]}
LID = {"where": "y-upper", "velocity": (1, 0, 0)}


def region(lower, upper, velocity, **more):
    return {"where": {"box": {"lower": lower, "upper": upper}}, "velocity": velocity} | more


def told(*support):
    return list(crossing_supports(case(box((0, 0, 0), (4, 4, 4)), support=support)))


@pytest.mark.parametrize("supports", [[WALLS, LID], [LID, WALLS], [WALLS | {"fix": "normal"}, LID]])
def test_a_lid_between_walls_is_told_nothing(supports):
    assert told(*supports) == []


def test_a_region_that_would_move_through_a_face():
    (text,) = told(WALLS, region((0, 3.5, 0), (4, 4, 4), (1, 0, 0)), {"where": "y-upper", "fix": "normal"})[:1]
    assert text.startswith(
        "support number 2 prescribes 1 m/s along x, but support number 1 0 m/s, at 5 nodes, first at (0, 4, 0) m"
    )
    assert "one cell before this face" in text
    assert told(WALLS, region((1, 3.5, 0), (3, 4, 4), (1, 0, 0))) == []


def test_regions_that_overlap():
    one, other = region((1, 1, 1), (2, 2, 2), (0, 0, 0), name="one"), region((2, 1, 1), (3, 2, 2), (0, 0, 1))
    (text,) = told(one, other)
    assert text.startswith("support `one` prescribes 0 m/s along z, but support number 2 1 m/s, at 4 nodes")
    assert "because it is later in the case" in text
    assert told(one, other | {"until": 1.0}) == []
    assert told(one, other | {"velocity": (0, 0, 0)}) == []


def test_lids_that_meet():
    (text,) = told({"where": "x-lower", "velocity": (0, 0, 1)}, {"where": "y-lower", "velocity": (0, 0, -2)})
    assert "support number 1 is applied to these nodes, because it is slower" in text


def test_two_velocities_of_a_face_are_refused():
    with pytest.raises(ValueError, match=r"support number 1 prescribes 0 m/s along x on the face y-upper, and this one 1 m/s"):
        case(box((0, 0, 0), (4, 4, 4)), support=[{"where": ["x-lower", "y-upper"]}, LID])
    case(box((0, 0, 0), (4, 4, 4)), support=[{"where": "y-upper", "fix": "normal"}, LID | {"fix": ["x"]}])


FLUID = {"kind": "fluid", "density": 1.0, "viscosity": 0.01, "eos": {"kind": "tait", "sound_speed": 10.0}}
RISING = {"name": "lid", "where": "y-upper", "velocity": (1, 0.5, 0)}
REST = {"where": ["x-lower", "x-upper", "y-lower"]}


def cavity(*support, **more):
    return {"support": support, "counts": (4, 4, 0), "cell": 0.25, "end": 9.0} | more


FILLED = box((0, 0, 0), (1, 1, 0), FLUID, (2, 2, 1))


def test_a_lid_that_moves_out_is_warned_of():
    built = case(FILLED, **cavity(RISING, REST))
    (text,) = leading_out(built)
    assert text.startswith("support `lid` moves the face y-upper out of the grid at 0.5 m/s")
    assert "Set the velocity of the support along y to 0" in text
    assert text in list(look(built))


@pytest.mark.parametrize(
    "lid",
    [
        {"velocity": (1, 0, 0)},
        {"velocity": (1, -0.5, 0)},
        {"velocity": (1, 0.5, 0), "fix": ["x"]},
        {"where": "x-lower", "velocity": (0.3, 0, 0)},
    ],
    ids=["along", "into", "not-held-across", "piston"],
)
def test_lids_and_pistons_that_stay_or_move_in_are_not(lid):
    assert list(leading_out(case(FILLED, **cavity({"where": "y-upper"} | lid)))) == []


def test_a_point_that_follows_it_names_the_support():
    with pytest.raises(RunStopped, match=r"crossed the face y-upper, whose support moves out of the grid at 0.5 m/s; set the"):
        advance(simulation(FILLED, **cavity(RISING, REST)), 400)


DISC = box((0, 0, 0), (1, 1, 1), RATE_SOLID, name="disc", rigid=True)


@pytest.mark.parametrize(
    ("motion", "warns"),
    [
        ({"hold": ["x", "y"]}, True),
        ({"hold": ["x", "y"], "hold_rotation": ["z"]}, False),
        ({"hold": ["x", "y"], "hold_rotation": []}, False),
        ({"hold": ["x", "y"], "rotation": {"z": {"kind": "steady", "angular_velocity": 1.0}}}, False),
        ({"hold": ["y"]}, False),
    ],
)
def test_a_rigid_body_held_along_all_axes_that_turns(motion, warns):
    found = list(free_turns(case(DISC, motion=[{"name": "axle", "body": "disc"} | motion], counts=(4, 4, 1))))
    assert len(found) == warns
    for text in found:
        assert 'rotates freely about z. Add hold_rotation = ["z"] to motion axle' in text
        assert "hold_rotation = []" in text


def test_the_warning_is_lost_by_no_setting():
    whole = case(DISC, motion=[{"name": "axle", "body": "disc", "hold": ["x", "y"]}], counts=(4, 4, 1))
    assert list(free_turns(whole.with_settings({"time.end": 0.5}))) == list(free_turns(whole))


@pytest.mark.parametrize(("bodies", "warns"), [((), True), (("ball",), False)])
def test_a_membrane_of_points_falls_through_a_wall(bodies, warns):
    wall = {"point": (0, 0, -1.5), "normal": (0, 0, 1), "bodies": bodies}
    ball = box((0, 0, 0), (1, 1, 1), name="ball", field="ball") | {"shape": {"sphere": {"centre": (0, 0, 1), "radius": 0.4}}}
    grid = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
    found = list(passed_walls(case(sheet(field="sheet"), ball, wall=[wall], **grid)))
    assert len(found) == warns
    for text in found:
        assert "wall 1 does not act on sheet" in text
        assert 'bodies = ["ball"]' in text
