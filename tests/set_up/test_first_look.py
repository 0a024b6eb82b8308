"""Warnings about a case as a whole."""

import pytest
from small_cases import SOLID, box, case

from pellucid.set_up.first_look import look

FLAT = {"counts": (4, 4, 0)}
BLOCK = box((1, 1, 0), (3, 3, 0), SOLID, (2, 2, 1))


def test_gravity_across_a_plane_problem_is_warned_of():
    (text,) = look(case(BLOCK, gravity=(0, 0, -9.81), **FLAT))
    assert text.startswith("gravity acts only along z, where the grid is one cell thick, so it moves nothing")
    assert "Set a component of `gravity` along x or y, or enlarge the grid along z" in text


@pytest.mark.parametrize("gravity", [(0, -9.81, 0), (0, -9.81, -1), (0, 0, 0)])
def test_other_gravity_is_not(gravity):
    assert list(look(case(BLOCK, gravity=gravity, **FLAT))) == []
