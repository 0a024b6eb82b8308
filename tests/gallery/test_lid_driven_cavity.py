"""Profiles of the lid-driven cavity: fits without bias, and the published extremes of the reference."""

import numpy as np
import pytest

from pellucid.gallery.flows.lid_driven_cavity import PLACES, profile, reference


def test_a_fit_has_the_value_of_a_parabola_through_scattered_points():
    place = np.random.default_rng(1).uniform(0.0, 1.0, 400)
    assert profile(place, 1.0 - 2.0 * place + 3.0 * place**2, 0.03) == pytest.approx(1.0 - 2.0 * PLACES + 3.0 * PLACES**2)


@pytest.mark.parametrize(("number", "extremes"), [(100, (-0.21090, 0.17527, -0.24533)), (400, (-0.32726, 0.30203, -0.44993))])
def test_the_reference_has_the_published_extremes(number, extremes):
    """Ghia, Ghia & Shin 1982 have 128 cells and values at stations; the extremes between these lie up to 4 % further out."""
    _, u, v = reference(number)
    for found, published in zip((u.min(), v.max(), v.min()), extremes, strict=True):
        assert 0.995 < found / published < 1.04
