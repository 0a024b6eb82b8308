"""The least energy of a bag of liquid that is spread."""

import pytest

from pellucid.references.membranes import least_energy

RUBBER = {"thickness": 0.001, "young_modulus": 1e6, "poisson_ratio": 0.45}


def test_sphere_at_rest_has_none():
    assert least_energy(0.05, 0.05, **RUBBER) == pytest.approx(0.0, abs=1e-9)


def test_scales_with_thickness_stiffness_and_area():
    once = least_energy(0.05, 0.06, **RUBBER)
    assert once > 0.0
    twice = least_energy(0.1, 0.12, thickness=0.002, young_modulus=3e6, poisson_ratio=0.45)
    assert twice == pytest.approx(24.0 * once, rel=1e-9)


def test_costs_more_than_linearly():
    assert least_energy(0.05, 0.06, **RUBBER) > 4.0 * least_energy(0.05, 0.055, **RUBBER)
