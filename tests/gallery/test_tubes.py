"""Tubes that a user reaches by --set: the metrics follow the case."""

import pytest

import pellucid
from pellucid.case import load

TUBES = {
    "Sod from the paper's tube": {"body.driven.material.pressure": 0.1, "time.end": 0.2},
    "strong, monatomic": {
        "body.driver.material.pressure": 10.0,
        "body.driven.material.density": 0.02,
        "body.driver.material.eos.gamma": 1.6667,
        "body.driven.material.eos.gamma": 1.6667,
        "time.end": 0.04,
    },
}


def run(settings):
    return pellucid.run(load("gan2011/shock-tube").quick_variant().with_settings(settings), report=False)


@pytest.mark.parametrize("settings", TUBES.values(), ids=TUBES)
def test_other_tubes_are_within_their_tolerances(settings):
    found = run(settings | {"time.step": None})
    assert not {name: metric for name, metric in found.metrics.items() if not metric.passed}


def test_errors_fall_under_refinement():
    errors = []
    for cell in (0.01, 0.005):
        found = run({"grid.cell": cell, "time.step": 8e-5 * cell / 0.005})
        errors.append({name: found.metrics[f"{name}_l1"].value for name in ("density", "pressure", "velocity")})
    for name in errors[0]:
        # between first order (fronts) and the 2/3 that an artificial viscosity of second order leaves at contacts
        assert errors[1][name] < errors[0][name] / 1.5, errors


def test_explicit_energy_is_worse_behind_a_strong_shock():
    found = {}
    for update in ("closed", "explicit"):
        settings = {f"body.{body}.material.energy_update": update for body in ("driver", "driven")}
        found[update] = run(settings | {"energy.stop": 1e6, "energy.warn": 1e6}).metrics["largest_density"]
    assert found["closed"].passed
    assert found["closed"].error < found["explicit"].error
