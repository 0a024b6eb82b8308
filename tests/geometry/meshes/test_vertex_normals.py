"""Normals at vertices against those of smooth surfaces."""

import numpy as np
import pytest

from pellucid.geometry.meshes.triangulation import vertex_normals
from pellucid.geometry.surfaces.triangles import Icosphere


def ellipsoid_error(refinements):
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).mesh().triangulated()
    axes = np.array([1.0, 2.0, 1.5])
    exact = vertices / axes
    exact /= np.linalg.norm(exact, axis=1)[:, None]
    return np.sqrt(np.mean((vertex_normals(vertices * axes, triangles) - exact) ** 2))


def test_they_are_exact_on_a_sphere_whatever_the_triangles():
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=2).mesh().triangulated()
    vertices = vertices + np.random.default_rng(1).uniform(-0.05, 0.05, vertices.shape)
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    assert vertex_normals(3.0 * vertices + 7.0, triangles) == pytest.approx(vertices, abs=1e-12)


def test_they_are_of_second_order_on_an_ellipsoid():
    coarse, fine = ellipsoid_error(3), ellipsoid_error(4)
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.2)
