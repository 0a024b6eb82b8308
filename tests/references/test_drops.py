"""Drops in a shear."""

import pytest

from pellucid.references.flows import drop_approach, drop_deformation


def test_taylors_limits():
    """35/32 of the capillary number at equal viscosities, 1 for a bubble."""
    assert drop_deformation(1e-4, 1.0) == pytest.approx(35.0 / 32.0 * 1e-4)
    assert drop_deformation(1e-4, 0.0) == pytest.approx(1e-4)
    assert drop_deformation(1e-4, 1.0, 0.2) / drop_deformation(1e-4, 1.0) == pytest.approx(1.0 + 5.6996 * 1.75 * 0.008)


def test_a_sphere_deforms_at_first_as_the_flow_does():
    """The strain of a shear is half its rate, and D of a sphere in it half its strain's difference: 5/(2λ + 3) of γ/2."""
    small = 1e-6
    for ratio in (0.5, 1.0, 2.0):
        rate = drop_deformation(1e-3, ratio) * drop_approach(1e-3, ratio, small) / small
        assert rate == pytest.approx(5.0 / (2.0 * (2.0 * ratio + 3.0)), rel=1e-3)
