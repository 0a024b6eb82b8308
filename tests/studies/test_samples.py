import numpy as np
import pytest
from small_studies import SPEED, case

from pellucid.errors import UsageError
from pellucid.studies.ranges import rows_of


def test_every_value_meets_every_other() -> None:
    rows = rows_of(case(), {SPEED: [1.0, 2.0], "time.scheme": ["usf", "musl"]})
    assert [tuple(row.values()) for row in rows] == [(1.0, "usf"), (1.0, "musl"), (2.0, "usf"), (2.0, "musl")]


def test_a_hypercube_has_one_member_in_each_layer() -> None:
    rows = rows_of(case(), {SPEED: (1.0, 3.0), "body.block.material.young_modulus": ("1 kPa", "100 kPa")}, samples=20)
    assert sorted(int(10 * (row[SPEED] - 1.0)) for row in rows) == list(range(20))
    moduli = np.log10([row["body.block.material.young_modulus"] for row in rows])
    assert sorted((10 * (moduli - 3.0)).astype(int)) == list(range(20)), "a range of decades goes by its logarithm"
    assert rows == rows_of(case(), {SPEED: (1.0, 3.0), "body.block.material.young_modulus": ("1 kPa", "100 kPa")}, samples=20)


def test_listed_values_are_drawn_evenly() -> None:
    rows = rows_of(case(), {SPEED: (1.0, 3.0), "time.scheme": ["usf", "musl"]}, samples=10)
    assert [row["time.scheme"] for row in rows].count("usf") == 5


def test_rows_of_a_table_meet_every_value() -> None:
    rows = rows_of(case(), {SPEED: [1.0, 2.0]}, listed=[{"time.scheme": "usf"}, {"time.scheme": "musl"}])
    assert len(rows) == 4


@pytest.mark.parametrize(
    ("over", "samples", "why"),
    [
        ({}, None, "No key varies"),
        ({SPEED: (1.0, 2.0)}, None, "--samples"),
        ({SPEED: (1.0, 2.0)}, 0, "at least 1"),
        ({SPEED: []}, None, "no values"),
        ({SPEED: range(1000), "grid.cell": range(1000)}, None, "the limit of 100000"),
    ],
)
def test_what_cannot_be_drawn_is_refused(over: dict, samples: int | None, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        rows_of(case(), over, samples)
