"""The cube between smooth plates: Hooke's law at small strains, slopes against differences, no stress across."""

import pytest

from pellucid.references.free_cube import FreeCube

FORMS = [FreeCube(3e3, 0.49), FreeCube(3e3, 0.49, decoupled=True), FreeCube(3e3, 0.3, decoupled=True)]


@pytest.mark.parametrize("cube", FORMS)
def test_small_strains_follow_hooke(cube):
    strain = 1e-6
    assert cube.stress(1.0 + strain) == pytest.approx(cube.young_modulus * strain, rel=1e-5)
    assert cube.across(1.0 + strain) - 1.0 == pytest.approx(-cube.poisson_ratio * strain, rel=1e-5)


@pytest.mark.parametrize("cube", FORMS)
@pytest.mark.parametrize("along", [0.5, 0.8, 1.5])
def test_slopes_are_those_of_the_energy(cube, along):
    across, step = 1.1, 1e-6
    by_along = (cube.energy(along + step, across) - cube.energy(along - step, across)) / (2.0 * step)
    by_across = (cube.energy(along, across + step) - cube.energy(along, across - step)) / (2.0 * step)
    assert cube.slopes(along, across) == pytest.approx((by_along, by_across), rel=1e-8)


@pytest.mark.parametrize("cube", FORMS)
@pytest.mark.parametrize("along", [0.5, 0.8, 1.5])
def test_nothing_pulls_across_and_the_stress_is_the_slope_of_the_least_energy(cube, along):
    across, step = cube.across(along), 1e-5
    assert cube.slopes(along, across)[1] == pytest.approx(0.0, abs=1e-9 * cube.young_modulus)
    energies = [cube.energy(along + change, cube.across(along + change)) for change in (-step, step)]
    assert cube.stress(along) == pytest.approx((energies[1] - energies[0]) / (2.0 * step), rel=1e-8)
