"""The view of a case's parts: what is right in itself, the names of what is not, and what is there at all."""

import pytest
from small_cases import box, case

from pellucid.case import Case
from pellucid.case.sections import parts_in, parts_of
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Support
from pellucid.grid.model import GridCase
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition, is_driven
from pellucid.parts.part import Part

MOTION = {"name": "hand", "body": "block", "hold": ["x", "y"]}
DATA = case(
    box((1, 1, 1), (3, 3, 3)),
    box((0, 0, 0), (1, 1, 1), name="small"),
    support=[{"name": "wall", "where": "x-lower", "fix": "normal"}],
    motion=[MOTION],
).to_data()


def changed(key, index, **values):
    """The data with other values in a table."""
    items = [item | values if number == index else item for number, item in enumerate(DATA[key])]
    return DATA | {key: items}


def test_all_parts_of_a_sound_case_are_there_with_their_paths():
    for parts in (parts_of(Case.model_validate(DATA)), parts_in(Case, DATA)):
        assert [path for path, _ in parts.placed(BodyModel)] == [("body", 0), ("body", 1)]
        assert [type(condition) for condition in parts.of(Condition)] == [Support, Motion]
        assert parts.grid == GridCase(**DATA["grid"])
        assert parts.named(BodyModel, "small").name == "small"
        assert parts.are_sound(Part)
        assert not parts.findings()


def test_of_what_is_wrong_in_itself_the_name_is_known():
    parts = parts_in(Case, changed("body", 0, points_per_cell=-1))
    assert [body.name for body in parts.of(BodyModel)] == ["small"]
    assert parts.names(BodyModel) == ["block", "small"]
    assert parts.are_named(BodyModel)
    assert not parts.are_sound(BodyModel)
    assert parts.are_sound(Condition)
    assert not list(parts.unknown(BodyModel, (), "block"))
    assert next(parts.unknown(BodyModel, (), "blok")).remedy == "did you mean `block`?"


def test_a_name_that_cannot_be_read_may_be_any():
    parts = parts_in(Case, changed("body", 0, name=3))
    assert not parts.are_named(BodyModel)
    assert not list(parts.unknown(BodyModel, (), "blok"))


@pytest.mark.parametrize(
    ("key", "words"), [("body", "body number 1 already has this name"), ("motion", "motion number 1 already has this name")]
)
def test_names_that_are_there_twice(key, words):
    parts = parts_in(Case, DATA | {key: [DATA[key][0] | {"name": "one"}] * 2})
    assert words in [found.text for found in parts.findings()]


@pytest.mark.parametrize(
    ("hold", "more", "driven"), [(["x", "y", "z"], {}, True), (["x", "y"], {}, False), (["x", "y", "z"], {"part": True}, False)]
)
def test_a_body_that_follows_a_motion_as_a_whole_is_driven(hold, more, driven):
    part = {"part": {"box": {"lower": [0, 0, 0], "upper": [2, 2, 2]}}} if more else {}
    parts = parts_in(Case, DATA | {"motion": [MOTION | {"hold": hold} | part]})
    assert is_driven("block", parts) is driven
    assert not is_driven("small", parts)


def test_a_grid_that_is_wrong_is_not_lacking():
    wrong = parts_in(Case, DATA | {"grid": DATA["grid"] | {"cell": -1.0}})
    assert wrong.grid is None
    assert not wrong.lacks_grid
    none = parts_in(Case, {key: value for key, value in DATA.items() if key != "grid"})
    assert none.lacks_grid
    assert ("grid",) in [found.path for found in none.findings()]
