"""Points of a body as balls or bricks of the same volume."""

import numpy as np
from scipy.spatial import cKDTree

from pellucid.results.pictures.rendering.drawables import Colour, Mesh


def ball_radii(mass: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Return the radii [m] of balls with the volume of the points, from mass [kg] and density [kg/m^3]."""
    return np.asarray(np.cbrt(0.75 / np.pi * mass / density))


def lattice_sides(position: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Return the spacings [m] of points on a regular lattice along x, y, z, shape (3,).

    Along an axis with a single layer the spacing follows from the volume of a point. position: [m], shape (n, 3). volume:
    [m^3], shape (n,).
    """
    mean = float(np.mean(volume))
    gaps = [np.diff(np.sort(values)) for values in position.T]
    layers = [gap[gap > 0.05 * np.cbrt(mean)] for gap in gaps]
    sides = np.array([np.median(gap) if len(gap) else np.nan for gap in layers])
    lone = np.isnan(sides)
    sides[lone] = (mean / np.prod(sides[~lone])) ** (1.0 / max(1, lone.sum()))
    return sides


def box_corners(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the corners of a box, shape (8, 3), from its lower and upper corner, shape (3,)."""
    ends = np.stack([lower, upper])
    return np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)


def bricks(centres: np.ndarray, sides: np.ndarray, colour: Colour) -> Mesh:
    """Build the surface of equal bricks centred at points of a lattice. The cut plane does not cut bricks.

    Faces between two bricks are omitted because they are not visible. centres: [m], shape (n, 3). sides: the three edge lengths
    of a brick [m]. colour: RGB.
    """
    corner = box_corners(np.full(3, -0.5), np.full(3, 0.5))  # number 4i + 2j + k
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])  # outward
    squares = (centres[:, None] + corner[faces.ravel()] * sides).reshape(-1, 4, 3)
    touching = cKDTree(squares.mean(axis=1)).query_pairs(0.25 * sides.min(), output_type="ndarray")
    vertices = np.delete(squares, touching.ravel(), axis=0).reshape(-1, 3)
    quads = np.arange(0, len(vertices), 4)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    n = len(vertices)
    return Mesh(vertices, quads.reshape(-1, 3), np.tile(colour, (n, 1)), np.zeros(n, bool), cuttable=False)
