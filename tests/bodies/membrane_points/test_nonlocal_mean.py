"""Means over a radius of the surface."""

import numpy as np
import pytest

from pellucid.bodies.membrane_points.surface import NonlocalMean


def points(n=400, seed=0):
    numbers = np.random.default_rng(seed)
    return numbers.uniform(0.0, 1.0, (n, 3)) * (1.0, 1.0, 0.0), numbers.uniform(0.5, 1.5, n)


def test_weights_are_the_bell_times_the_area():
    position, area = points()
    mean = NonlocalMean(position, area, 0.3)
    mean.local[:] = np.sin(7.0 * position[:, 0])
    mean.update()
    for i in (0, 17, 399):
        r = np.linalg.norm(position - position[i], axis=1)
        weight = np.where(r < 0.3, (1.0 - (r / 0.3) ** 2) ** 2, 0.0) * area
        assert mean.mean[i] == pytest.approx(weight @ mean.local / weight.sum(), rel=1e-13)


def test_a_constant_stays_and_a_lone_point_is_its_own_mean():
    position, area = points()
    position[5] = (9.0, 9.0, 9.0)
    mean = NonlocalMean(position, area, 0.2)
    mean.local[:] = 3.0
    mean.local[5] = 8.0
    mean.update()
    assert np.delete(mean.mean, 5) == pytest.approx(3.0, rel=1e-14)
    assert mean.mean[5] == 8.0


def test_a_line_keeps_its_slope_away_from_edges():
    side = np.linspace(0.0, 1.0, 41)
    position = np.stack(np.meshgrid(side, side, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    mean = NonlocalMean(position, np.ones(len(position)), 0.2)
    mean.local[:] = 2.0 * position[:, 0] - position[:, 1]
    mean.update()
    inner = np.all(np.abs(position[:, :2] - 0.5) < 0.29, axis=1)
    assert mean.mean[inner] == pytest.approx(mean.local[inner], abs=1e-13)
