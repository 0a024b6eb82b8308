"""Closest points on triangles and the signs of distances."""

import numpy as np
import pytest

from pellucid.contact.triangles.closest_point import CORNER, INSIDE, closest_shares
from pellucid.jit.space import Vector3


@pytest.mark.parametrize("seed", range(5))
def test_closest_point_is_the_nearest_of_many_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(3, 3))
    s = np.linspace(0.0, 1.0, 201)
    u, v = (grid[grid_sum] for grid_sum in [np.add.outer(s, s) <= 1.0 + 1e-12] for grid in np.meshgrid(s, s, indexing="ij"))
    many = u[:, None] * corners[0] + v[:, None] * corners[1] + (1.0 - u - v)[:, None] * corners[2]
    found_regions = set()
    for x in rng.normal(size=(60, 3)) * 1.5:
        *shares, region = closest_shares(Vector3(*x), *(Vector3(*corner) for corner in corners))
        foot = np.array(shares) @ corners
        found_regions.add(region)
        assert min(shares) >= 0.0
        assert sum(shares) == pytest.approx(1.0, abs=1e-12)
        nearest = np.linalg.norm(many - x, axis=1).min()
        spacing = np.linalg.norm(corners[:2] - corners[2], axis=1).max() / 200.0
        assert nearest - spacing <= np.linalg.norm(foot - x) <= nearest + 1e-12
        inside = min(shares) > 1e-12
        assert inside == (region == INSIDE)
        assert (max(shares) == 1.0) == (region >= CORNER)
    assert len(found_regions) >= 5
