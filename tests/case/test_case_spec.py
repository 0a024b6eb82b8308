import json

import pytest
from pydantic import ValidationError
from small_cases import box
from small_cases import case as small_case

from pellucid import catalogue
from pellucid.case import Case, dumps, json_schema, load, loads


def test_a_case_survives_the_way_through_toml(text: str) -> None:
    case = loads(text)
    assert loads(dumps(case)) == case
    assert dumps(loads(dumps(case))) == dumps(case)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if k % 4 == 0 else pytest.mark.slow) for k, name in enumerate(catalogue.ids())]
)
def test_gallery_cases_are_valid_and_survive_the_way_through_toml(name: str) -> None:
    for case in (load(name), load(name).quick_variant()):
        assert case.id == name
        assert loads(dumps(case)) == case


def test_numbers_keep_every_bit(text: str) -> None:
    number = 0.1 + 0.2  # has no short decimal form
    velocity = [5e-324, -1.7976931348623157e308, 0.0]
    case = loads(text).with_settings({"time.end": number, "gravity": [1 / 3, 0, 0], "body.drop.velocity": velocity})
    again = loads(dumps(case))
    assert again.time.end == number
    assert (*again.body[0].velocity, again.gravity[0]) == (*velocity, 1 / 3)


def test_texts_with_quotes_and_lines_survive() -> None:
    case = load(catalogue.ids()[0]).with_settings({"description": 'a "b"\nc\\d\té = [1] # no comment'})
    assert loads(dumps(case)) == case


def test_defaults_are_written_out_so_that_a_later_version_runs_the_same(text: str) -> None:
    written = dumps(loads(text))
    for key in ('scheme = "musl"', "flip_fraction = 0.99", "exponent = 7", "stop = 0.1"):
        assert key in written


def test_units_as_text_become_si_numbers_also_inside_vectors(text: str) -> None:
    written = text.replace("cell = 0.05", 'cell = "5 cm"').replace("velocity = [1.0, 0, 0]", 'velocity = ["100 cm/s", 0, 0]')
    written = written.replace("radius = 0.1", 'radius = "10 cm"').replace("[0.25, 0.25, 0]", '["25 cm", 0.25, 0]')
    assert loads(written) == loads(text)


def test_the_same_classes_build_a_case_in_python(text: str) -> None:
    case = loads(text)
    built = Case(
        title=case.title,
        gravity=case.gravity,
        grid=case.grid,
        time=case.time,
        body=case.body,
        support=case.support,
        probe=case.probe,
        quick=case.quick,
    )
    assert built == case


def test_a_case_built_in_python_is_checked_as_a_whole(text: str) -> None:
    case = loads(text)
    with pytest.raises(ValidationError, match="already has this name"):
        Case(title="twice", grid=case.grid, time=case.time, body=(case.body[0], case.body[0]))


def test_intervals_of_output_have_defaults(text: str) -> None:
    case = loads(text)
    assert case.output.rows_every(case.time.end) == pytest.approx(case.time.end / 200)
    assert case.output.frames_every(case.time.end) == pytest.approx(case.time.end / 10)
    assert case.with_settings({"output.frames": 0.025}).output.frames_every(case.time.end) == 0.025


def test_the_quick_variant_takes_the_quick_settings(text: str) -> None:
    assert loads(text).quick_variant().grid.cell == 0.1


def test_the_schema_is_json_and_carries_units_and_limits() -> None:
    schema = json.loads(json.dumps(json_schema()))
    cell = schema["$defs"]["GridCase"]["properties"]["cell"]
    assert cell["unit"] == "m"
    assert cell["exclusiveMinimum"] == 0
    assert "schema" in schema["properties"]
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize("name", ["time", "kinetic_energy", "energy_error", "load_work"])
def test_no_probe_is_called_like_another_column_of_the_history(name):
    load = [{"kind": "body-force", "body": "block", "acceleration": (1, 0, 0)}]
    probe = [{"name": name, "body": "block", "quantity": "pressure"}]
    with pytest.raises(ValidationError, match="the name is reserved for a column of the history"):
        small_case(box((0, 0, 0), (1, 1, 1)), load=load, probe=probe)
    small_case(box((0, 0, 0), (1, 1, 1)), probe=[probe[0] | {"name": "other_work"}])
