"""The exact compression of a column under its own weight."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.references.solids import HeavyColumn

COLUMN = HeavyColumn(1.0, 1000.0, 9.81, 3e4, 2e4)


def test_stress_of_the_stretch_holds_the_weight():
    y = np.linspace(0.0, 1.0, 11)
    stretch = COLUMN.stretch(y)
    energy = lambda s: 0.5 * 2e4 * (s**2 - 1.0) - 2e4 * np.log(s) + 0.5 * 3e4 * np.log(s) ** 2  # noqa: E731
    slope = (energy(stretch + 1e-6) - energy(stretch - 1e-6)) / 2e-6
    assert slope == pytest.approx(-9810.0 * (1.0 - y), abs=1e-4)
    assert stretch[-1] == pytest.approx(1.0)


def test_places_are_the_integral_of_the_stretch():
    y, h = np.linspace(0.05, 0.95, 10), 1e-3
    assert (COLUMN.place(y + h) - COLUMN.place(y - h)) / (2 * h) == pytest.approx(COLUMN.stretch(y), rel=1e-6)
    assert COLUMN.place(np.zeros(1)) == 0.0


def test_small_strains_are_those_of_linear_elasticity():
    light = HeavyColumn(1.0, 1000.0, 1e-3, 3e4, 2e4)
    y = np.linspace(0.0, 1.0, 11)
    assert light.place(y) - y == pytest.approx(-(y - 0.5 * y**2) / 7e4, rel=1e-4, abs=1e-15)


def test_column_of_the_case():
    column = HeavyColumn.of(load("basics/hydrostatic-column"))
    assert (column.height, column.gravity) == (1.0, 9.81)
    assert column.first + 2 * column.shear == pytest.approx(5e4 * 0.7 / (1.3 * 0.4))
