"""What a case leaves free though its user may think it held is warned of."""

import pytest
from membranes import sheet
from small_cases import RATE_SOLID, box, case

from pellucid.set_up.left_free import free_turns, passed_walls

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
