"""Laws of fluid films."""

import numpy as np
import pytest

from pellucid.materials.lipid_film import LipidFilm


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.0])
def test_energy_and_slope_belong_to_the_pressure(exponent):
    film = LipidFilm(density=2.0, viscosity=1.0, stiffness=3.0, exponent=exponent)
    density = np.array([0.6, 1.2, 1.9, 2.2, 3.0])
    h = 1e-5
    slope = (film.pressure(density + h) - film.pressure(density - h)) / (2.0 * h)
    assert film.pressure_slope(density) == pytest.approx(slope, rel=1e-6, abs=1e-8)
    work = (film.stored_energy(density + h) - film.stored_energy(density - h)) / (2.0 * h)
    assert work * density**2 == pytest.approx(film.pressure(density), rel=1e-6, abs=1e-8)
    assert film.stored_energy(np.array([2.0]))[0] == 0.0


def test_energy_of_exponent_1_is_exact():
    film = LipidFilm(density=1.0, viscosity=1.0, stiffness=2.0)
    r = np.array([0.5, 2.0, 3.0])
    assert film.stored_energy(r) == pytest.approx(2.0 * (np.log(r) + 1.0 / r - 1.0), rel=1e-13)
