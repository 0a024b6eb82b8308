"""Ellipses and ellipsoids with the same second moments."""

import numpy as np
import pytest

from pellucid.geometry.algorithms.equivalent_ellipse import of_curve, of_surface
from pellucid.geometry.surfaces.sphere import SphereSurface


def test_of_an_ellipse():
    """A polygon through n places of an ellipse is less by order 1/n²."""
    errors = []
    for n in (40, 80):
        angle, turn = 2.0 * np.pi * np.arange(n) / n, np.radians(30.0)
        places = np.stack([3.0 * np.cos(angle), np.sin(angle)], axis=1)
        places = places @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + (5.0, -7.0)
        found = of_curve(places)
        errors.append(abs(found.semi_axes[1] - 3.0))
        assert found.inclination == pytest.approx(30.0)
        assert found.deformation == pytest.approx(0.5, rel=1e-12)
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=0.02)


def test_of_an_ellipsoid():
    vertices, triangles = SphereSurface(centre=(0.0, 0.0, 0.0), radius=1.0, divisions=20).triangulate()
    found = of_surface(vertices * (1.0, 2.0, 4.0) + (3.0, 2.0, 1.0), triangles)
    assert found.semi_axes == pytest.approx((1.0, 2.0, 4.0), rel=5e-3)
    assert found.deformation == pytest.approx(0.6, rel=1e-3)
    assert abs(found.directions[2, -1]) == pytest.approx(1.0)
