"""A force that holds a mean velocity: what it cannot do."""

import pytest
from small_cases import GAS, box, case

from pellucid.case import Case
from pellucid.errors import CaseError

DRIVE = {"kind": "mean-velocity", "body": "gas", "axis": "x", "velocity": 1.0, "response": 0.1}


def driven(*loads, periodic=("x",), rigid=False):
    table = case(box((0, 0, 0), (4, 4, 4), GAS, name="gas")).to_data()
    table["grid"]["periodic"] = list(periodic)
    table["body"].append(box((0, 0, 0), (2, 2, 2), name="ball", field="ball", rigid=rigid))
    return Case.model_validate(table | {"load": loads})


def test_it_drives_several_bodies():
    assert driven(DRIVE | {"others": ["ball"]}).load[0].bodies() == ("gas", "ball")


@pytest.mark.parametrize(
    ("loads", "more", "words"),
    [
        ([DRIVE], {"periodic": ["y"]}, "load.0.axis: the grid is not periodic along x: what flows there ends at its faces"),
        ([DRIVE | {"response": 0.0}], {}, "greater than 0"),
        ([DRIVE | {"body": "water"}], {}, "no body has this name"),
        ([DRIVE | {"others": ["drop"]}], {}, "load.0.others.0: no body has this name"),
        ([DRIVE | {"others": ["gas"]}], {}, "body gas is named twice"),
        ([DRIVE | {"others": ["ball"]}], {"rigid": True}, "body ball is rigid: a motion leads it"),
        ([DRIVE, DRIVE], {}, "load number 1 drives body gas along x already"),
        ([DRIVE | {"name": "time"}, DRIVE | {"axis": "y"}], {}, "the grid is not periodic along y"),
    ],
)
def test_what_cannot_be_driven(loads, more, words):
    with pytest.raises((CaseError, ValueError), match=f"(?s){words}"):
        driven(*loads, **more)
