"""Bodies that start behind a wall are refused, by `validate` as by a run."""

import pytest
from small_cases import GAS, RATE_SOLID, SOLID, box, case

from pellucid.errors import CaseError
from pellucid.set_up.behind_walls import refuse_behind_walls

WALL = {"point": (0, 0.25, 0), "normal": (0, 1, 0)}


def beside(height, material=SOLID, others=(), motion=(), **more):
    block = box((0.2, height, 0), (0.8, height + 0.4, 0.1), material) | more
    return case(block, *others, counts=(10, 10, 1), cell=0.1, wall=[WALL], motion=motion)


@pytest.mark.parametrize("material", [SOLID, GAS, RATE_SOLID])
def test_a_quarter_of_a_cell_is_allowed(material):
    refuse_behind_walls(beside(0.23, material))
    with pytest.raises(CaseError) as error:
        refuse_behind_walls(beside(0.2, material))
    for words in ("wall.0.point", "body block starts behind this wall", "by 0.05 m", "0.025 m, is allowed", "turn `normal`"):
        assert words in str(error.value)


def test_a_corner_of_a_turned_block_counts():
    turned = {"shape": {"box": {"lower": (0.3, 0.3, 0), "upper": (0.7, 0.7, 0.1)}, "rotate": {"angle": 45, "axis": (0, 0, 1)}}}
    with pytest.raises(CaseError, match="body block starts behind this wall"):
        refuse_behind_walls(beside(0.3, **turned))


def test_one_that_a_motion_leads_through_it_may():
    held = box((0.2, 0.0, 0), (0.8, 0.2, 0.1), name="held", field="held")
    motion = [{"name": "rest", "body": "held", "hold": ["x", "y", "z"]}]
    refuse_behind_walls(beside(0.25, others=[held], motion=motion))


def test_one_that_goes_on_is_where_its_points_are():
    refuse_behind_walls(beside(0.2), {"block"})
