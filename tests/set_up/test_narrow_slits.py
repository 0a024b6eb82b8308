"""Slits that are narrower than material points of one body can tell apart are warned of, others are not."""

import pytest
from forked_blocks import forked_block
from small_cases import RATE_SOLID, SOLID, case

from pellucid.set_up.first_look import look
from pellucid.set_up.narrow_slits import narrow_slits


def forked(tmp_path, slit, cell=0.1, **more):
    forked_block(tmp_path / "fork.obj", (0.2, 0.1, 0.2), (1.2, 0.3, 0.8), slit, 0.8)
    shape = {"inside": {"surface": {"file": {"path": str(tmp_path / "fork.obj"), "closed": True}}}}
    counts = tuple(round(n * 0.1 / cell) for n in (17, 5, 14))
    return case({"name": "fork", "shape": shape, "material": SOLID} | more, counts=counts, cell=cell)


@pytest.mark.parametrize("slit", [0.06, 0.1, 0.14])
def test_a_narrow_slit_is_named_with_place_width_and_remedies(tmp_path, slit):
    (text,) = look(forked(tmp_path, slit))
    assert f"a slit in body fork is {slit / 0.1:.2g} cells ({slit:.3g} m) wide at (" in text
    assert 0.55 < float(text.split("at (")[1].split(")")[0].split(", ")[2]) < 0.65, "the slit is at z = 0.6 m"
    assert "stick to each other" in text
    assert '[[contact]] `between = ["fork"]`' in text
    assert "two bodies with a `field` each" in text


def test_wide_slits_and_smaller_cells_are_not(tmp_path):
    assert list(narrow_slits(forked(tmp_path, 0.2))) == []
    assert list(narrow_slits(forked(tmp_path, 0.1, cell=0.05))) == []


def test_what_does_not_deform_is_not(tmp_path):
    assert list(narrow_slits(forked(tmp_path, 0.1, material=RATE_SOLID, rigid=True, field="own"))) == []


@pytest.mark.parametrize(
    "shape",
    [
        {"box": {"lower": (0.2, 0.2, 0.2), "upper": (0.4, 1.0, 0.25)}},
        {"sphere": {"centre": (0.6, 0.6, 0.6), "radius": 0.4}},
        {"shell": {"centre": (0.6, 0.6, 0.6), "inner_radius": 0.1, "outer_radius": 0.4}},
    ],
)
def test_convex_bodies_and_wide_cavities_are_not(shape):
    assert list(narrow_slits(case({"name": "block", "shape": shape, "material": SOLID}, counts=(12, 12, 12), cell=0.1))) == []


def test_a_slit_that_another_body_fills_is_not(tmp_path):
    forked_block(tmp_path / "fork.obj", (0.2, 0.1, 0.2), (1.2, 0.3, 0.8), 0.1, 0.8)
    shape = {"inside": {"surface": {"file": {"path": str(tmp_path / "fork.obj"), "closed": True}}}}
    pad = {"box": {"lower": (0.2, 0.1, 0.55), "upper": (1.0, 0.4, 0.65)}}
    bodies = {"name": "fork", "shape": shape, "material": SOLID}, {"name": "pad", "shape": pad, "material": SOLID}
    assert list(narrow_slits(case(*bodies, counts=(17, 5, 14), cell=0.1))) == []
