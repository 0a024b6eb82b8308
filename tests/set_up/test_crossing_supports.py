"""What is told of supports that prescribe different velocities at the same nodes."""

import pytest
from small_cases import box, case

from pellucid.set_up.crossing_supports import crossing_supports

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
        "support number 2 prescribes 1 m/s along x and support number 1 0 m/s at 5 nodes, first at (0, 4, 0) m"
    )
    assert "end one cell before this face" in text
    assert told(WALLS, region((1, 3.5, 0), (3, 4, 4), (1, 0, 0))) == []


def test_regions_that_overlap():
    one, other = region((1, 1, 1), (2, 2, 2), (0, 0, 0), name="one"), region((2, 1, 1), (3, 2, 2), (0, 0, 1))
    (text,) = told(one, other)
    assert text.startswith("support `one` prescribes 0 m/s along z and support number 2 1 m/s at 4 nodes")
    assert "the later one" in text
    assert told(one, other | {"until": 1.0}) == []
    assert told(one, other | {"velocity": (0, 0, 0)}) == []


def test_lids_that_meet():
    (text,) = told({"where": "x-lower", "velocity": (0, 0, 1)}, {"where": "y-lower", "velocity": (0, 0, -2)})
    assert "there support number 1 counts, the slower one" in text


def test_two_velocities_of_a_face_are_refused():
    with pytest.raises(ValueError, match=r"support number 1 prescribes 0 m/s along x on the face y-upper, and this one 1 m/s"):
        case(box((0, 0, 0), (4, 4, 4)), support=[{"where": ["x-lower", "y-upper"]}, LID])
    case(box((0, 0, 0), (4, 4, 4)), support=[{"where": "y-upper", "fix": "normal"}, LID | {"fix": ["x"]}])
