"""A force that holds a mean velocity, and what it cannot do."""

import pytest
from small_cases import GAS, SLIP, box, case

from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

DRIVE = {"kind": "mean-velocity", "body": "gas", "axis": "x", "velocity": 1.0, "response": 0.1}


def driven(*loads, periodic=("x",), rigid=False):
    table = case(box((0, 0, 0), (4, 4, 4), GAS, name="gas")).to_data()
    table["grid"]["periodic"] = list(periodic)
    table["body"].append(box((0, 0, 0), (2, 2, 2), name="ball", field="ball", rigid=rigid))
    return Case.model_validate(table | {"load": loads})


@pytest.mark.parametrize("others", [(), ("ball",)])
def test_it_drives_several_bodies_by_one_acceleration(others):
    """With walls that slip nothing resists: all that is driven comes to the velocity, what is not stays at rest."""
    bodies = [box((0, 0, 0), (4, 4, 4), GAS, name="gas"), box((0, 6, 0), (4, 8, 4), GAS, name="ball", field="ball")]
    table = case(*bodies, counts=(4, 8, 4), support=SLIP[2:], end=20.0).to_data()
    table["grid"]["periodic"] = ["x"]
    table["load"] = [DRIVE | {"others": list(others), "response": 1.5}]
    sim = Simulation(Case.model_validate(table), threads=1)
    for _ in sim:
        pass
    mean = [body.totals.momentum[0] / body.mass for body in sim.bodies]
    assert mean[0] == pytest.approx(1.0, rel=1e-3)
    assert mean[1] == pytest.approx(mean[0] if others else 0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("loads", "more", "words"),
    [
        ([DRIVE], {"periodic": ["y"]}, "load.0.axis: the grid is not periodic along x: faces stop the flow"),
        ([DRIVE | {"response": 0.0}], {}, "greater than 0"),
        ([DRIVE | {"body": "water"}], {}, "no body has this name"),
        ([DRIVE | {"others": ["drop"]}], {}, "load.0.others.0: no body has this name"),
        ([DRIVE | {"others": ["gas"]}], {}, "body gas is named twice"),
        ([DRIVE | {"others": ["ball"]}], {"rigid": True}, "body ball is rigid: this load cannot drive rigid bodies"),
        ([DRIVE, DRIVE], {}, "load number 1 already drives body gas along x"),
        ([DRIVE | {"name": "time"}, DRIVE | {"axis": "y"}], {}, "the grid is not periodic along y"),
    ],
)
def test_what_cannot_be_driven(loads, more, words):
    with pytest.raises((CaseError, ValueError), match=f"(?s){words}"):
        driven(*loads, **more)
