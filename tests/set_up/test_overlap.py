"""Bodies that start inside each other or cross."""

import pytest
from membranes import sheet
from small_cases import SOLID, box, case

from pellucid.errors import CaseError
from pellucid.set_up import overlap
from pellucid.set_up.first_look import look, stand
from pellucid.set_up.overlap import contact_offsets, refuse_overlaps

WATER = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0}}


@pytest.mark.parametrize(("gap", "looked_at"), [(0.0, 2), (0.5, 2), (1.5, 0)])
@pytest.mark.parametrize("goes_on", [False, True])
def test_only_bodies_less_than_a_cell_apart_are_looked_at(gap, looked_at, goes_on, monkeypatch):
    """Of many bodies most are far from each other."""
    places, contents = [], overlap._contents
    monkeypatch.setattr(overlap, "_contents", lambda model, *rest: places.append(model.name) or contents(model, *rest))
    first, second = (box((at, 0, 0), (at + 2, 2, 2), name=name, field=name) for name, at in (("first", 0), ("second", 2 + gap)))
    whole = case(first, second, counts=(6, 3, 3))
    overlap.refuse_overlaps(whole.body, stand(whole), whole.grid_or_none, {"first"} if goes_on else set())
    assert len(places) == looked_at


def test_bodies_that_overlap_at_the_start_are_refused():
    whole = case(box((0, 0, 0), (2, 2, 2), name="one", field="a"), box((1, 1, 1), (3, 3, 3), name="two"))
    with pytest.raises(CaseError) as error:
        refuse_overlaps(whole.body, stand(whole), whole.grid_or_none)
    text = str(error.value)
    for words in ("body.one.shape", "inside body two", "contact direction is undefined"):
        assert words in text


def test_membranes_that_cross_and_balls_that_a_membrane_cuts_are_refused():
    flat = sheet(kind="membrane-elements", field="a")
    upright = sheet(kind="membrane-points", name="upright", edges=((0, 1, 0), (0, 0, 1)))
    grid = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
    # between the sheet's vertices, whose distance is 0.1 m
    ball = box((0, 0, 0), (1, 1, 1), name="ball") | {"shape": {"sphere": {"centre": (0.06, 0.07, 0.03), "radius": 0.11}}}
    for other, per_cell, words in ((upright, None, ("body.sheet.surface", "upright")), (ball, 1000, ("inside body ball",))):
        if per_cell:
            other = other | {"points_per_cell": per_cell}
        whole = case(flat, other, **grid)
        with pytest.raises(CaseError) as error:
            refuse_overlaps(whole.body, stand(whole), whole.grid_or_none)
        for text in (*words, "in contact" if other is upright else "contact direction"):
            assert text in str(error.value)


def test_a_ball_that_goes_on_is_cut_by_a_membrane_where_its_points_are():
    """Not where the case describes it."""
    flat = sheet(kind="membrane-elements", field="a")
    grid = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
    away = 1.0
    for height, is_cut in ((0.03, False), (0.03 + away, True)):
        shape = {"shape": {"sphere": {"centre": (0.06, 0.07, height), "radius": 0.11}}, "points_per_cell": 1000}
        whole = case(flat, box((0, 0, 0), (1, 1, 1), name="ball") | shape, **grid)
        standing = stand(whole)
        standing["ball"].position[:, 2] -= away
        if is_cut:
            with pytest.raises(CaseError, match="inside body ball"):
                refuse_overlaps(whole.body, standing, whole.grid_or_none, {"ball"})
        else:
            refuse_overlaps(whole.body, standing, whole.grid_or_none, {"ball"})


def test_volumes_that_overlap_in_one_field_are_warned_of():
    whole = case(box((0, 0, 0), (2, 2, 2), name="one"), box((1, 1, 1), (3, 3, 3), name="two"))
    (text,) = look(whole)
    for words in ("bodies one and two overlap", "mass of both", "`outside`"):
        assert words in text


@pytest.mark.parametrize("shift", [0.0, 1e-15, -1e-15])
def test_corners_of_what_a_body_leaves_out_are_not_within_it(shift):
    """Nodes on edges of a cube in water from which the cube is left out: rounding makes them either side of its faces."""
    lower, upper = (0.2 + shift, 0.16 + shift, 0.2 + shift), (0.4 + shift, 0.36 + shift, 0.4 + shift)
    water = box((0, 0, 0), (0.6, 0.32, 0.6), WATER, name="water", outside=["cube"])
    mesh = {"box": {"lower": lower, "upper": upper, "cells": (2, 2, 2)}}
    cube = {"name": "cube", "kind": "meshless-solid", "field": "cube", "mesh": mesh, "material": SOLID}
    assert list(look(case(water, cube, counts=(15, 15, 15), cell=0.04))) == []
    with pytest.raises(CaseError, match="points of this body start inside body cube"):
        list(look(case(water | {"outside": []}, cube, counts=(15, 15, 15), cell=0.04)))


BLOCK = box((0, 0, 2), (1, 1, 3), field="block")
LOWER = {"counts": (8, 8, 8), "lower": (-4.0, -4.0, -4.0)}


def test_each_membrane_states_its_thickness_and_where_contact_acts():
    other = sheet(name="other", field="other", kind="membrane-elements", thickness=0.08, contact_offset=0.0)
    other["surface"]["rectangle"]["corner"] = (0.0, 0.0, -2.0)
    found = contact_offsets(case(sheet(thickness=0.1, field="sheet"), other, BLOCK, **LOWER))
    assert found == [
        "contact: faces of membrane sheet are 0.05 m from `surface` on both sides (half the thickness)",
        "contact: faces of membrane other are 0 m from `surface` on both sides (`contact_offset`; the thickness is 0.08 m)",
    ]


def test_a_membrane_that_nothing_touches_has_no_line():
    assert contact_offsets(case(sheet(), **LOWER)) == []
