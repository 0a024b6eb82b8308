"""Hints for misspelt names."""

import copy
import pickle

import pytest

import pellucid.case  # noqa: F401 - every kind is registered with the case
from pellucid.errors import PellucidError, UnknownName, UsageError
from pellucid.findings import Named, hint
from pellucid.registry import Family, Registry

FAMILIES = [registry for registry in Registry.every if isinstance(registry, Family)]
KINDS = ["neo-hookean", "holzapfel-gasser-ogden", "mooney-rivlin", "moving-least-squares", "cell-based-maximum-entropy"]


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.what)
def test_a_letter_left_out_of_any_kind_is_found(family):
    kinds = list(family.entries)
    assert kinds
    for kind in kinds:
        assert hint(kind[:2] + kind[3:], kinds) == f"did you mean `{kind}`?"


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("hgo", "holzapfel-gasser-ogden"),
        ("HGO", "holzapfel-gasser-ogden"),
        ("mls", "moving-least-squares"),
        ("cme", "cell-based-maximum-entropy"),
        ("max-ent", "cell-based-maximum-entropy"),
        ("mooney", "mooney-rivlin"),
    ],
)
def test_abbreviations_are_found(name, meant):
    assert hint(name, KINDS) == f"did you mean `{meant}`?"


@pytest.mark.parametrize("name", ["c10", "c01", "c3"])
def test_names_with_other_digits_are_other_names(name):
    assert hint(name, ["c1", "c2", "bulk_modulus"]) == ""
    assert hint("C1", ["c1", "c2", "bulk_modulus"]) == "did you mean `c1`?"
    assert hint("radius1", ["radius"]) == "did you mean `radius`?"


@pytest.mark.parametrize("name", ["fluid", "h", "ogh", ""])
def test_nothing_is_guessed_where_nothing_is_near(name):
    assert hint(name, KINDS) == ""


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
