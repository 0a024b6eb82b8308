"""Where others touch a membrane: at half of its thickness, or at its contact offset."""

import pytest
from membranes import sheet
from pydantic import ValidationError
from small_cases import box, case, simulation

from pellucid.contact.surface_pairs import SurfacePairs

THICKNESS = 0.1
SHEET = {"thickness": THICKNESS, "field": "sheet"}
BLOCK = box((1, 1, 3), (2, 2, 4), field="block")
LOWER = {"counts": (8, 8, 8), "lower": (-4.0, -4.0, -4.0)}


@pytest.mark.parametrize("kind", ["membrane-elements", "membrane-points"])
@pytest.mark.parametrize("tense", [{}, {"inflation": 0.05}])
def test_by_default_it_is_half_of_the_thickness_as_given(kind, tense):
    body = case(sheet("neo-hookean-membrane", kind=kind, **SHEET, **tense), **LOWER).body[0]
    assert body.contact_reach == 0.5 * THICKNESS
    assert body.model_copy(update={"contact_offset": 0.0}).contact_reach == 0.0


def test_no_negative_offset():
    with pytest.raises(ValidationError, match="contact_offset"):
        case(sheet(contact_offset=-0.1, **SHEET), **LOWER)


@pytest.mark.parametrize(("offset", "reach"), [({}, 0.05), ({"contact_offset": 0.0}, 0.0), ({"contact_offset": "3 cm"}, 0.03)])
@pytest.mark.parametrize("place", ["own nodes", "shared field", "led", "points"])
def test_it_counts_for_every_kind_on_surfaces_and_on_nodes(place, offset, reach):
    body = sheet(kind="membrane-points" if place == "points" else "membrane-elements", **SHEET, **offset)
    more = {}
    if place == "shared field":
        more["others"] = [box((-3, -3, -3), (-2, -2, -2), name="other", field="sheet")]
    if place == "led":
        more["motion"] = [{"name": "lead", "body": "sheet", "hold": ["x", "y", "z"]}]
    bodies = body, BLOCK, *more.pop("others", ())
    sim = simulation(*bodies, **LOWER, **more)
    assert sim.bodies[0].half_width()[0] == reach
    surfaces = {surface.body: surface for surface in sim.parts.only(SurfacePairs).surfaces}
    assert ("sheet" in surfaces) is (place != "points")
    if place != "points":
        assert surfaces["sheet"].half_width == reach
