"""The heavy elastica: small deflections, and its own equation by another method."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from pellucid.references.solids import heavy_elastica


def test_small_deflections_are_those_of_a_beam():
    _, below = heavy_elastica(np.array([0.5, 1.0]), 1.0, 1.0, 1e-3)
    x = np.array([0.5, 1.0])
    assert below == pytest.approx(1e-3 * x**2 * (x**2 - 4.0 * x + 6.0) / 24.0, rel=1e-6)


@pytest.mark.parametrize(("stiffness", "drop"), [(np.inf, 0.49590), (100.0, 0.49771)])
def test_large_ones_are_those_of_shooting(stiffness, drop):
    def change(s, y):
        stretch = 1.0 + (1.0 - s) * np.sin(y[0]) / stiffness
        return [y[1], -stretch * (1.0 - s) * np.cos(y[0]) / 0.2, stretch * np.sin(y[0])]

    def end(bend):
        return solve_ivp(change, (0.0, 1.0), [0.0, bend, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]

    shot = end(brentq(lambda bend: end(bend)[1], 0.5, 3.0))[2]
    assert shot == pytest.approx(drop, abs=1e-5)
    assert heavy_elastica(np.array([1.0]), 1.0, 0.2, 1.0, stiffness)[1][0] == pytest.approx(shot, rel=1e-6)
