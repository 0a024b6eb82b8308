"""Lines that state where membranes touch others."""

from membranes import sheet
from small_cases import box, case

from pellucid.set_up.contact_offsets import contact_offsets

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
