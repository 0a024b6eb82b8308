"""Equivalent ellipse or ellipsoid: the same second moments per area or volume as the space in a closed curve or surface."""

from typing import NamedTuple

import numpy as np


class Ellipsoid(NamedTuple):
    """An ellipse or ellipsoid: semi-axes [m], ascending, shape (d,), and their directions as columns of a matrix, shape (d,
    d)."""

    semi_axes: np.ndarray
    directions: np.ndarray

    @property
    def deformation(self) -> float:
        """Taylor's deformation parameter (L - B)/(L + B), with the longest semi-axis L and the shortest semi-axis B."""
        shortest, longest = float(self.semi_axes[0]), float(self.semi_axes[-1])
        return (longest - shortest) / (longest + shortest)

    @property
    def inclination(self) -> float:
        """Angle between the longest axis and the x axis, in the plane of x and y [°], from -90 to 90."""
        x, y = self.directions[:2, -1]
        return float((np.degrees(np.arctan2(y, x)) + 90.0) % 180.0 - 90.0)


def of_curve(places: np.ndarray) -> Ellipsoid:
    """Return the ellipse that has the same second moments about its centroid per area as a polygon with the corners
    `places` in order [m], shape (n, 2)."""
    x, y = (places - places.mean(axis=0)).T
    following = np.roll(np.stack([x, y]), -1, axis=1)
    corners = np.stack([np.stack([x, y]), following, np.zeros((2, len(x)))])  # of triangles with the mean position
    return _of_simplices(corners.transpose(2, 0, 1), 0.5 * (x * following[1] - following[0] * y))


def of_surface(vertices: np.ndarray, triangles: np.ndarray) -> Ellipsoid:
    """Return the ellipsoid that has the same second moments about its centroid per volume as the space inside a closed
    surface with vertices [m], shape (n, 3), and triangles, shape (m, 3)."""
    corners = (vertices - vertices.mean(axis=0))[triangles]
    volumes = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    return _of_simplices(np.concatenate([corners, np.zeros((len(corners), 1, 3))], axis=1), volumes)


def _of_simplices(corners: np.ndarray, measures: np.ndarray) -> Ellipsoid:
    """Return the ellipse or ellipsoid that has the same second moments about its centroid per area or volume as triangles
    or tetrahedra with corners, shape (m, d + 1, d), and signed measures (areas or volumes), shape (m,).

    The integral of x ⊗ x over a simplex is its measure times (Σ c ⊗ c + (Σ c) ⊗ (Σ c)) / ((d + 1)(d + 2)).
    """
    d, whole = corners.shape[2], measures.sum()
    sums = corners.sum(axis=1)
    centre = measures @ sums / ((d + 1) * whole)
    products = np.einsum("tci,tcj->tij", corners, corners) + np.einsum("ti,tj->tij", sums, sums)
    moments = np.einsum("t,tij->ij", measures, products) / ((d + 1) * (d + 2) * whole) - np.outer(centre, centre)
    squares, directions = np.linalg.eigh(moments)
    return Ellipsoid(np.sqrt((d + 2) * squares), directions)
