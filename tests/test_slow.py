"""The list of slow tests names tests that exist."""

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent
LINES = [line for line in (FOLDER / "slow.txt").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]


@pytest.mark.parametrize("line", LINES)
def test_a_line_names_a_file_and_a_test_in_it(line):
    file, _, test = line.partition("::")
    name = test.partition("[")[0]
    assert name == "*" or re.search(rf"^def {name}\(", (FOLDER / file).read_text(encoding="utf-8"), re.M)


def test_the_list_is_sorted_and_has_no_line_twice():
    assert sorted(set(LINES)) == LINES
