"""Closed surfaces of triangles for tests of films."""

import numpy as np
from scipy.spatial import ConvexHull

from pellucid.approximants.radial import PolyharmonicModel
from pellucid.bodies.fluid_film.loop_surface import LoopSurface
from pellucid.bodies.fluid_film.radial_surface import RadialSurface
from pellucid.bodies.fluid_film.triangle_surface import TriangleSurface
from pellucid.geometry.surfaces.triangles import Icosphere


def sphere(refinements: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles and positions of evenly distributed nodes on the unit sphere."""
    mesh = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=refinements).mesh()
    surface, places = LoopSurface(mesh.triangles, len(mesh.vertices)), mesh.vertices
    for _ in range(10):
        places = surface.places(surface.smoothed(surface.through(places), 1))
        places /= np.linalg.norm(places, axis=1)[:, None]
    return mesh.triangles, places


def scattered(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles between n random points on the unit sphere, which have few or many neighbours, and the points."""
    places = np.random.default_rng(seed).normal(size=(n, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    triangles = ConvexHull(places).simplices.astype(np.int64)
    corner = places[triangles]
    inward = np.einsum("ei,ei->e", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), corner[:, 0]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles, places


def torus(around: int, across: int, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles and node positions of a torus with the minor radius 1 and the major radius `ratio`; every node
    has six neighbours."""
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")

    def number(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return ((i % around) * across + j % across).ravel()

    one = np.stack([number(i, j), number(i + 1, j), number(i, j + 1)], axis=1)
    other = np.stack([number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)], axis=1)
    phi, theta = (2.0 * np.pi * i / around).ravel(), (2.0 * np.pi * j / across).ravel()
    r = ratio + np.cos(theta)
    return np.concatenate([one, other]), np.stack([r * np.cos(phi), r * np.sin(phi), np.sin(theta)], axis=1)


def loop(mesh: tuple[np.ndarray, np.ndarray]) -> tuple[TriangleSurface, np.ndarray]:
    """Return a Loop subdivision surface through the positions of a mesh, and its control nodes."""
    surface = LoopSurface(mesh[0], len(mesh[1]))
    return surface, surface.through(mesh[1])


def radial(mesh: tuple[np.ndarray, np.ndarray]) -> tuple[TriangleSurface, np.ndarray]:
    """Return a surface by blended radial interpolation through the positions of a mesh, and its nodes."""
    return RadialSurface(*mesh, PolyharmonicModel()), mesh[1]


BOTH = {"loop": loop, "radial": radial}
