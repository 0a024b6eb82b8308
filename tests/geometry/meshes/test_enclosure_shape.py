"""Area, enclosed volume and ellipsoid of surfaces, closed and open."""

from math import pi

import numpy as np
import pytest

from pellucid.geometry.meshes.enclosure import capped, ellipse_of, ellipsoid_of, surface_area, volume_with_lids
from pellucid.geometry.surfaces.quadrilaterals import SphereSurface
from pellucid.geometry.surfaces.surface import Surface

BOX = Surface(box={"lower": [1, 2, 3], "upper": [2, 4, 6], "points": [3, 4, 5]}).triangulate()


def ellipsoid(refinements, radii=(2.0, 1.0, 0.5)):
    mesh = Surface(icosphere={"centre": [0, 0, 0], "radius": 1, "refinements": refinements}).mesh("triangles")
    return mesh.vertices * radii + [3.0, -1.0, 7.0], mesh.triangles


def test_a_box_is_exact():
    assert surface_area(*BOX) == pytest.approx(2.0 * (2 + 3 + 6), rel=1e-13)
    assert volume_with_lids(*BOX) == pytest.approx(6.0, rel=1e-13)
    assert volume_with_lids(BOX[0], BOX[1][:, ::-1]) == pytest.approx(-6.0, rel=1e-13)
    axes, directions = ellipsoid_of(*BOX)  # second moments of a box: a²/12
    assert axes == pytest.approx(np.sqrt(5.0 / 12.0) * np.array([3.0, 2.0, 1.0]), rel=1e-12)
    assert np.abs(directions) == pytest.approx(np.eye(3)[::-1], abs=1e-12)


def test_an_ellipsoid_is_found_with_the_order_of_its_facets():
    errors = []
    for refinements in (2, 3, 4):
        axes, directions = ellipsoid_of(*ellipsoid(refinements))
        assert np.abs(directions[0]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
        errors.append(np.abs(axes / [2.0, 1.0, 0.5] - 1.0).max())
    assert errors[-1] < 1e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.2)


def test_it_turns_with_the_body():
    x, triangles = ellipsoid(2)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    axes, directions = ellipsoid_of(x, triangles)
    turned = ellipsoid_of(x @ turn.T, triangles)
    assert turned.axes == pytest.approx(axes, rel=1e-12)
    assert np.abs(turned.directions @ turn @ directions.T) == pytest.approx(np.eye(3), abs=1e-9)


def test_open_ends_have_flat_lids():
    n, m = 96, 5
    tube = Surface(tube={"start": [0, 0, -1], "end": [0, 0, 1], "radius": 1, "points": [n, m]}).triangulate()
    polygon = 0.5 * n * np.sin(2.0 * pi / n)
    assert volume_with_lids(*tube) == pytest.approx(2.0 * polygon, rel=1e-12)
    vertices, triangles = capped(*tube)
    assert len(vertices) == len(tube[0]) + 2
    assert surface_area(vertices, triangles) - surface_area(*tube) == pytest.approx(2.0 * polygon, rel=1e-12)


def test_a_flat_surface_has_no_ellipsoid():
    disc = Surface(disc={"centre": [1, 2, 3], "normal": [0, 0, 1], "radius": 1, "rings": 3}).triangulate()
    assert abs(volume_with_lids(*disc)) < 1e-14
    assert np.isnan(ellipsoid_of(*disc).axes).all()


def test_the_ellipse_of_a_polygon_converges():
    """A polygon through n places of an ellipse is less by order 1/n²."""
    errors = []
    for n in (40, 80):
        angle, turn = 2.0 * np.pi * np.arange(n) / n, np.radians(30.0)
        places = np.stack([3.0 * np.cos(angle), np.sin(angle)], axis=1)
        places = places @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + (5.0, -7.0)
        found = ellipse_of(places)
        errors.append(abs(found.axes[0] - 3.0))
        assert found.inclination == pytest.approx(30.0)
        assert found.deformation == pytest.approx(0.5, rel=1e-12)
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=0.02)


def test_an_ellipsoid_of_quadrilaterals_is_found():
    vertices, triangles = SphereSurface(centre=(0.0, 0.0, 0.0), radius=1.0, divisions=20).triangulate()
    found = ellipsoid_of(vertices * (1.0, 2.0, 4.0) + (3.0, 2.0, 1.0), triangles)
    assert found.axes == pytest.approx((4.0, 2.0, 1.0), rel=5e-3)
    assert found.deformation == pytest.approx(0.6, rel=1e-3)
    assert abs(found.directions[0, 2]) == pytest.approx(1.0)
