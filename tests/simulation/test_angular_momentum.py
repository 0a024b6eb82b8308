"""The angular momentum of runs on whose bodies nothing acts from outside."""

import warnings

import numpy as np
import pytest
from small_cases import GAS, SLIP, SOLID, advance, box, case

from pellucid.simulation.simulation import Simulation

FEW = {"stop": 10.0}
TURN = (0, 0, 1.0)


def spinning(*more, counts=(10, 10, 1), **keys):
    block = box((3, 3, 0), (7, 7, 0), SOLID, (2, 2, 1), angular_velocity=TURN)
    return Simulation(case(block, *more, counts=counts, **({"end": 0.5, "energy": FEW} | keys)), threads=1)


@pytest.mark.parametrize(
    ("keys", "is_reported"),
    [
        ({}, True),
        ({"support": SLIP[:4]}, True),  # which the block does not touch
        ({"gravity": (0, -1.0, 0)}, False),
        ({"motion": [{"body": "block", "name": "hold", "hold": ["x"]}]}, False),
        ({"load": [{"kind": "body-force", "body": "block", "acceleration": (1.0, 0, 0)}]}, False),
        ({"counts": (10, 1, 1)}, False),
    ],
)
def test_it_is_reported_where_nothing_acts_from_outside(keys, is_reported):
    if keys.get("counts") == (10, 1, 1):
        sim = Simulation(case(box((3, 0, 0), (7, 0, 0), SOLID, (2, 1, 1)), end=1.0, energy=FEW, **keys), threads=1)
    else:
        sim = spinning(**keys)
    advance(sim, 3)
    assert ("angular_momentum" in sim.budget.conservation()) == is_reported


def test_a_support_that_pushes_ends_the_report():
    gas = box((0, 0, 0), (10, 2, 0), GAS, (2, 2, 1), name="gas")
    sim = spinning(gas, support=SLIP[:4])
    advance(sim, 3)
    assert "angular_momentum" not in sim.budget.conservation()


@pytest.mark.parametrize(("transfer", "words"), [("pic", '"pic" damps rotation'), ("flip", None), ("apic", None)])
def test_a_drift_is_warned_of_once(transfer, words):
    """PIC smooths rotation within a cell; over a tenth of a turn FLIP keeps 99 % of it, and APIC all with these functions."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim = spinning(transfer=transfer, functions="quadratic-bspline")
        while not sim.clock.finished(None):
            sim.step()
    texts = [str(one.message) for one in caught if "angular momentum" in str(one.message)]
    assert len(texts) == (words is not None)
    if words is not None:
        assert words in texts[0]
        assert 'Set time.transfer = "apic" and grid.functions = "quadratic-bspline"' in texts[0]
    error = sim.budget.conservation()["angular_momentum"]
    assert error < {"pic": 1.0, "flip": 0.02, "apic": 1e-12}[transfer]


def test_it_counts_the_affine_fields():
    """Of a solid disc of points: the moment of their places and what the functions spread, h²/4 along each axis."""
    sim = spinning(transfer="apic", functions="quadratic-bspline")
    advance(sim, 2)
    body = sim.bodies[0]
    m, x, v, C = (body.arrays[name] for name in ("mass", "position", "velocity", "affine"))
    about = np.array([1.0, 2.0, 0.0])
    of_places = np.sum(m * np.cross(x - about, v)[:, 2])
    assert body.angular_momentum(about).vector[2] == pytest.approx(
        of_places + 0.25 * np.sum(m * (C[:, 3] - C[:, 1])), rel=1e-12
    )
