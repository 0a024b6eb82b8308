import math

import numpy as np
import pytest

from pellucid.results.storage import history
from pellucid.results.storage.files import OutputError

COLUMNS = {"time": "s", "step": "", "energy": "J"}
ROWS = [(0.0, 0, 1.0 / 3.0), (0.1 + 0.2, 1, -1e-308), (1e22, 2, math.pi)]


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "history.csv"
    history.create(path, COLUMNS)
    for row in ROWS:
        history.append(path, row)
    return path


def test_begins_with_a_row_of_names_and_a_row_of_units(path):
    assert path.read_text().splitlines()[:2] == ["time,step,energy", "#s,1,J"]


def test_floats_come_back_exactly(path):
    table = history.read(path)
    for number, name in enumerate(COLUMNS):
        assert table[name].tolist() == [row[number] for row in ROWS]


def test_numpy_reads_it_too(path):
    table = np.genfromtxt(path, delimiter=",", names=True, comments="#")
    assert table["energy"].tolist() == [row[2] for row in ROWS]


def test_knows_its_units(path):
    assert history.read_units(path) == {"time": "s", "step": "1", "energy": "J"}


def test_an_unfinished_last_line_is_left_out(path):
    with path.open("a") as file:
        file.write("2.0,3")
    assert len(history.read(path)["time"]) == 3


@pytest.mark.parametrize("rest", ["", "2.0,3", "2.0,3,4.0\n"])
def test_is_cut_back_to_the_rows_of_a_checkpoint(path, rest):
    whole = path.read_bytes()
    with path.open("a") as file:
        file.write(rest)
    history.cut(path, 3)
    assert path.read_bytes() == whole
    history.cut(path, 1)
    assert history.read(path)["time"].tolist() == [0.0]


def test_too_few_rows_for_the_checkpoint_are_an_error(path):
    with pytest.raises(OutputError, match="fewer than the 4 rows"):
        history.cut(path, 4)


def test_a_history_without_rows_can_be_read(tmp_path):
    history.create(tmp_path / "history.csv", COLUMNS)
    assert history.read(tmp_path / "history.csv")["energy"].shape == (0,)


def test_a_missing_history_is_told(tmp_path):
    with pytest.raises(OutputError, match="no history"):
        history.read(tmp_path / "history.csv")
