import pytest
from small_studies import SPEED, case, write_csv

import pellucid
from pellucid.errors import CaseError, UsageError
from pellucid.studies.ranges import Range, all_checked, at_key, range_of, read_rows, read_values, unit_at, with_units


def test_values_and_ends_are_told_apart() -> None:
    found = read_values(["grid.cell=0.5,0.25", "body.a.density=1 kPa:50 kPa", "a.scheme=usf,musl", "a.b=[1,1],[2,2]"])
    assert found == {
        "grid.cell": [0.5, 0.25],
        "body.a.density": ("1 kPa", "50 kPa"),
        "a.scheme": ["usf", "musl"],
        "a.b": [[1, 1], [2, 2]],
    }


@pytest.mark.parametrize("text", ["grid.cell", "=1,2", "grid.cell=", "a=1:", "a=1:2:3"])
def test_a_bad_text_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match="must have the form KEY="):
        read_values([text])


def test_a_key_given_twice_is_refused() -> None:
    with pytest.raises(UsageError, match="given twice"):
        read_values(["a=1", "a=2"])


def test_ends_are_read_in_the_units_of_the_field() -> None:
    found = range_of(case(), "body.block.material.young_modulus", "1 kPa", "50 kPa")
    assert found == Range(1e3, 5e4)
    assert found.is_logarithmic


def test_a_range_goes_from_end_to_end_and_back() -> None:
    for each in (Range(2.0, 6.0), Range(1e3, 1e5), Range(-1.0, 1.0)):
        assert (each.at(0.0), each.at(1.0)) == (each.low, each.high)
        assert each.share(each.at(0.3)) == pytest.approx(0.3, abs=1e-6)
    assert Range(1e3, 1e5).at(0.5) == 1e4
    assert Range(-1.0, 1.0).at(0.5) == 0.0


def test_values_have_seven_digits() -> None:
    assert Range(0.0, 1.0).at(1 / 3) == 0.3333333


@pytest.mark.parametrize(("low", "high", "why"), [(2, 1, "must be less"), ("usf", "musl", "cannot have a range")])
def test_a_range_that_is_none_is_refused(low: object, high: object, why: str) -> None:
    key = "time.scheme" if low == "usf" else SPEED
    with pytest.raises(UsageError, match=why):
        range_of(case(), key, low, high)


def test_rows_are_read_with_their_keys(tmp_path) -> None:
    path = write_csv(tmp_path / "t.csv", ("grid.cell", "time.scheme"), ("0.5", "usf"), ("0.25", "musl"))
    assert read_rows(path) == [{"grid.cell": 0.5, "time.scheme": "usf"}, {"grid.cell": 0.25, "time.scheme": "musl"}]


@pytest.mark.parametrize("rows", [[("a",)], [("a", "b"), ("1",)], [("a", "a"), ("1", "2")], [("a", ""), ("1", "2")]])
def test_a_bad_table_is_refused_with_its_file(rows: list, tmp_path) -> None:
    with pytest.raises(UsageError, match=r"t\.csv"):
        read_rows(write_csv(tmp_path / "t.csv", *rows))


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(CaseError, match="2 errors in the 3 members; none was run") as caught:
        all_checked(case(), [{"grid.cell": -1}, {"grid.cell": 0.5}, {"body.blok.velocity": 1}])
    assert "did you mean `body.block`?" in str(caught.value)


def test_a_value_is_found_by_the_name_of_its_entry() -> None:
    assert at_key(case(), "body.block.material.young_modulus") == 1000.0
    assert at_key(case(), "steady.tolerance") is None


def test_keys_have_the_units_of_their_fields() -> None:
    case = pellucid.load("gan2011/piezo-icsi")
    keys = (
        "grid.cell",
        "body.zona.material.young_modulus",
        "body.zona.material.damage.elastic_limit",
        "time.transfer",
        "no.key",
    )
    assert [unit_at(case, key) for key in keys] == ["m", "Pa", "", "", ""]
    assert with_units(["grid.cell", "steps"], {"grid.cell": "m"}) == ["grid.cell [m]", "steps"]
