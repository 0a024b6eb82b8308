"""Gaps of too few cells between what does not deform are warned of, others are not."""

import pytest
from forked_blocks import forked_block
from small_cases import GAS, RATE_SOLID, SOLID, box, case

from pellucid.set_up.first_look import look
from pellucid.set_up.gaps import narrow_gaps, narrow_slits

HELD = {"hold": ["x", "y", "z"]}


def plate(name, lower, upper):
    return box((lower, 0.0, 0), (upper, 1.2, 0.1), RATE_SOLID, name=name, field=name)


def warned(*bodies, motions=HELD, cell=0.1, more_motions=(), **more):
    """Warnings about a case in a slice, in which the bodies other than `soft` are held or follow `motions`."""
    counts = (round(2 / cell), round(2 / cell), 1)
    led = [
        {"name": f"of-{body['name']}", "body": body["name"]} | motions
        for body in bodies
        if body["name"] != "soft" and not body.get("rigid")
    ]
    return list(narrow_gaps(case(*bodies, counts=counts, cell=cell, motion=[*led, *more_motions], **more)))


def layer(lower, upper, material=SOLID):
    return box((lower, 0, 0), (upper, 1, 0.1), material, name="soft", field="soft")


@pytest.mark.parametrize(("cell", "cells"), [(0.1, 2), (0.05, None)])
def test_a_layer_between_plates(cell, cells):
    found = warned(plate("low", 0.4, 0.8), layer(0.8, 1.0), plate("high", 1.0, 1.4), cell=cell)
    assert len(found) == (cells is not None)
    for text in found:
        assert (
            f"the gap between body low and body high is {cells} cells of 0.1 m wide, fewer than 3, and is filled by body soft"
            in text
        )
        assert "Set a smaller grid.cell" in text


def test_a_slit_that_a_gas_may_pass():
    (text,) = warned(plate("low", 0.4, 0.8), plate("high", 1.05, 1.4), layer(0.0, 0.4, GAS))
    assert "between body low and body high is 2.5 cells of 0.1 m wide, fewer than 3, and may be entered by body soft" in text


def test_a_slit_between_a_held_plate_and_a_rigid_one_that_is_held():
    """However each is held."""
    still = {"name": "still", "body": "high", "hold": ["x", "y", "z"], "hold_rotation": ["z"]}
    rigid = plate("high", 1.05, 1.4) | {"rigid": True}
    (text,) = warned(plate("low", 0.4, 0.8), rigid, layer(0.0, 0.4, GAS), more_motions=[still])
    assert "between body low and body high is 2.5 cells" in text


def test_bodies_that_come_nearer_are_no_slit():
    falling = plate("high", 1.05, 1.4) | {"rigid": True, "velocity": (-1, 0, 0)}
    assert warned(plate("low", 0.4, 0.8), falling, layer(0.0, 0.4, GAS)) == []


def test_the_gap_beside_where_bodies_touch_is_none():
    """That between a disc and the plate on which it lies tapers."""
    disc = plate("disc", 0, 0) | {"shape": {"cylinder": {"centre": (1.2, 0.6, 0.05), "radius": 0.4, "height": 0.1}}}
    assert warned(plate("low", 0.4, 0.8), disc, layer(0.0, 0.4, GAS)) == []


@pytest.mark.parametrize(
    ("fix", "cells"), [(("x", "y", "z"), "2"), ("normal", None)], ids=["a floor that holds", "a plane of symmetry"]
)
def test_a_layer_on_a_face_of_the_grid(fix, cells):
    """Behind a plane of symmetry it goes on."""
    found = warned(plate("high", 0.2, 0.6), layer(0.0, 0.2), support=[{"where": "x-lower", "fix": fix}])
    assert [f"between body high and face x-lower is {cells} cells" in text for text in found] == [True] * (cells is not None)


def test_a_gap_on_a_wall():
    wall = {"point": (0.1, 0, 0), "normal": (1, 0, 0), "bodies": ["soft"], "name": "ground"}
    (text,) = warned(plate("high", 0.3, 0.6), layer(0.1, 0.3), wall=[wall])
    assert "between body high and ground is 2 cells" in text


def test_the_bore_of_one_body():
    tube = plate("tube", 0, 0) | {"outside": ["soft"]}
    tube["shape"] = {"box": {"lower": (0.2, 0.2, 0), "upper": (1.8, 1.8, 0.1)}}
    (text,) = warned(tube, box((0.9, 0.2, 0), (1.1, 1.8, 0.1), name="soft", field="soft"))
    assert "between parts of body tube is 2 cells of 0.1 m wide, fewer than 3, and is filled by body soft" in text


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
