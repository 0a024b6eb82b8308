"""Hints for misspelt names."""

import pytest

import pellucid.case  # noqa: F401 - every kind is registered with the case
from pellucid.findings import hint
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
