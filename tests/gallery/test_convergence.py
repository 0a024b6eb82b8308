"""Errors of the elastic wave fall at the nominal order; contact of discs comes nearer to the reference."""

from math import log2

import pytest

import pellucid
from pellucid.case import load


def run(name, cell):
    return pellucid.run(load(name).quick_variant().with_settings({"grid.cell": cell}), report=False)


def test_elastic_wave_converges_at_second_order():
    coarse, fine = (run("basics/elastic-wave", cell).metrics for cell in (0.025, 0.0125))
    for name in ("displacement_l2", "period"):
        assert log2(coarse[name].error / fine[name].error) == pytest.approx(2.0, abs=0.2), name


def test_discs_approach_the_finite_elements():
    coarse, fine = (run("basics/colliding-discs", cell).metrics for cell in (0.05, 0.025))
    for name in ("contact_begins", "contact_duration", "rebound", "energy_swing"):
        assert fine[name].error < coarse[name].error, name
