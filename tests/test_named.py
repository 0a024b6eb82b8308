"""Dictionaries whose errors for unknown names list the known names."""

import copy
import pickle

import pytest

from pellucid.errors import PellucidError, UnknownName, UsageError
from pellucid.named import Named

COLUMNS = Named("the history has no column", {"time": 1, "momentum_x": 2})


def test_a_name_that_is_there_is_found():
    assert COLUMNS["time"] == 1
    assert COLUMNS.get("nothing", 3) == 3
    assert "nothing" not in COLUMNS
    assert COLUMNS == {"time": 1, "momentum_x": 2}


@pytest.mark.parametrize(("name", "more"), [("momentum", "\n    did you mean `momentum_x`?"), (0, ""), ("x" * 500, "")])
def test_a_name_that_is_not_is_told_with_those_that_are(name, more):
    with pytest.raises(UnknownName) as caught:
        COLUMNS[name]
    assert isinstance(caught.value, (UsageError, PellucidError))
    assert isinstance(caught.value, KeyError), "so that code which catches this goes on"
    assert str(caught.value).startswith("the history has no column `")
    assert str(caught.value).endswith(f"`; available: time, momentum_x{more}")
    assert len(str(caught.value)) < 200


def test_where_there_is_nothing_the_error_says_so():
    with pytest.raises(UnknownName, match=r"^the run has no metric `order`; available: none$"):
        Named("the run has no metric", {})["order"]


@pytest.mark.parametrize("copied", [copy.deepcopy(COLUMNS), pickle.loads(pickle.dumps(COLUMNS))])
def test_copies_tell_it_too(copied):
    with pytest.raises(UnknownName, match="the history has no column `tim`"):
        copied["tim"]
