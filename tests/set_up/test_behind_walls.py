"""Bodies that start behind a wall are refused, by `validate` as by a run; the grid has room behind walls."""

import pytest
from small_cases import GAS, RATE_SOLID, SOLID, box, case

from pellucid.errors import CaseError
from pellucid.set_up.behind_walls import refuse_behind_walls, with_room_behind_walls

WALL = {"point": (0, 0.25, 0), "normal": (0, 1, 0)}


def beside(height, material=SOLID, others=(), motion=(), **more):
    block = box((0.2, height, 0), (0.8, height + 0.4, 0.1), material) | more
    return case(block, *others, counts=(10, 10, 1), cell=0.1, wall=[WALL], motion=motion)


@pytest.mark.parametrize("material", [SOLID, GAS, RATE_SOLID])
def test_a_quarter_of_a_cell_is_allowed(material):
    refuse_behind_walls(beside(0.23, material))
    with pytest.raises(CaseError) as error:
        refuse_behind_walls(beside(0.2, material))
    for words in (
        "wall.0.point",
        "body block starts 0.05 m behind this wall",
        "quarter of a cell, 0.025 m",
        "set `normal` to point",
    ):
        assert words in str(error.value)


def test_a_corner_of_a_turned_block_counts():
    turned = {"shape": {"box": {"lower": (0.3, 0.3, 0), "upper": (0.7, 0.7, 0.1)}, "rotate": {"angle": 45, "axis": (0, 0, 1)}}}
    with pytest.raises(CaseError, match=r"body block starts .* m behind this wall"):
        refuse_behind_walls(beside(0.3, **turned))


def test_one_that_a_motion_leads_through_it_may():
    held = box((0.2, 0.0, 0), (0.8, 0.2, 0.1), name="held", field="held")
    motion = [{"name": "rest", "body": "held", "hold": ["x", "y", "z"]}]
    refuse_behind_walls(beside(0.25, others=[held], motion=motion))


def test_one_that_goes_on_is_where_its_points_are():
    refuse_behind_walls(beside(0.2), {"block"})


def grid_of(*walls, counts=(10, 10, 0), support=(), absorbing=(), **more):
    """Lower and upper corner of the grid that a run has [cells]."""
    size = [n * 0.1 if n else 0.1 for n in counts]
    body = box([0.3 * a for a in size], [0.6 * a for a in size], SOLID, [2 if n else 1 for n in counts]) | more
    table = {"wall": list(walls), "support": support, "absorbing": absorbing, "thickness": 0.1 if 0 in counts else None}
    motion = more.pop("motion", ())
    larger = with_room_behind_walls(case(body, counts=counts, cell=0.1, motion=motion, **table))
    assert with_room_behind_walls(larger) is larger, "a run that goes on has the same grid"
    grid = larger.grid
    return [tuple(round(value / 0.1) for value in corner) for corner in (grid.lower, grid.extent_upper())]


def facing(axis, end, gap=0.0, tilt=0.0):
    """A wall so far before a face [m]."""
    normal, point = [0.0] * 3, [0.5, 0.5, 0.0]
    normal[axis], point[axis] = (1.0, gap) if end == "lower" else (-1.0, 1.0 - gap)
    normal[(axis + 1) % 2] = tilt
    return {"point": point, "normal": normal}


@pytest.mark.parametrize("gap", [0.0, 0.05, 0.099])
def test_the_grid_has_room_behind_walls_on_its_faces(gap):
    assert grid_of(facing(0, "lower", gap)) == [(-1, 0, 0), (10, 10, 1)]
    assert grid_of(facing(1, "upper", gap)) == [(0, 0, 0), (10, 11, 1)]
    assert grid_of(facing(0, "lower", gap), facing(1, "upper", gap)) == [(-1, 0, 0), (10, 11, 1)]
    assert grid_of(facing(0, "upper", gap), counts=(10, 0, 0)) == [(0, 0, 0), (11, 1, 1)]
    deep = {"point": [0.5, 0.5, gap], "normal": [0, 0, 1]}
    assert grid_of(deep, counts=(10, 10, 10)) == [(0, 0, -1), (10, 10, 10)]


def test_also_for_rigid_bodies():
    """Their edges pass the wall by what they sink in, too."""
    assert grid_of(facing(0, "lower"), rigid=True) == [(-1, 0, 0), (10, 10, 1)]


def test_also_at_the_foot_of_a_trough_that_walls_make():
    trough = [{"point": (0.5, 0.02, 0), "normal": (side * 0.5, 0.866, 0)} for side in (-1, 1)]
    assert grid_of(*trough) == [(0, -1, 0), (10, 10, 1)]


def test_also_before_a_wall_that_leaves_the_grid_by_less_than_a_cell():
    assert grid_of(facing(1, "lower", tilt=0.1)) == [(0, -2, 0), (10, 10, 1)]  # from -0.05 m to 0.05 m


@pytest.mark.parametrize(
    ("walls", "more"),
    [
        ([facing(0, "lower", 0.11)], {}),
        ([facing(1, "lower", tilt=0.577)], {}),
        ([facing(0, "lower")], {"support": [{"where": "x-lower", "fix": "normal"}]}),
        ([facing(0, "lower")], {"support": [{"where": "x-lower", "fix": ["y"]}]}),
        ([facing(0, "lower")], {"absorbing": [{"body": "block", "where": ["x-lower"]}]}),
        ([], {}),
    ],
    ids=["far", "slope", "held", "along", "absorbing", "none"],
)
def test_other_grids_stay_as_they_are(walls, more):
    assert grid_of(*walls, **more) == [(0, 0, 0), (10, 10, 1)]
