"""Mesh smoothing: moves the nodes of a surface along it so that they stay evenly distributed, and stops a run if a triangle is
too flat.
"""

import numpy as np

from pellucid.errors import RunStopped
from pellucid.geometry.checks.quality import triangle_qualities
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.triangulation import Rings, vertex_normals

SMOOTHING = 0.3  # displacement of a node per step, relative to its distance from the centroid of its triangles
LONGEST = 0.4  # largest displacement of a node along the surface, relative to the distance to its nearest neighbour
WORST = 0.1  # lowest acceptable quality of a triangle; 1 is equilateral
WELL_SPREAD = 0.7  # lowest quality at which smoothing may be postponed if it would add energy


def check_quality(triangles: np.ndarray, places: np.ndarray) -> None:
    """Raise RunStopped if a triangle, shape (t, 3), with nodes at `places` [m], shape (n, 3), is too flat, or if its normal
    points against the normals of the surface.
    """
    quality = triangle_qualities(places, triangles)
    corner = places[triangles]
    along = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    turned = np.einsum("ei,ei->e", along, vertex_normals(places, triangles)[triangles].sum(axis=1)) <= 0.0
    quality = np.where(turned | ~np.isfinite(quality), 0.0, quality)
    worst = int(quality.argmin())
    if quality[worst] < WORST:
        node, place = int(triangles[worst, 0]), places[triangles[worst]].mean(axis=0)
        text = f"the triangle at node {node} has a quality of {quality[worst]:.2g}, below {WORST:g} (1 is equilateral)"
        where = ", ".join(f"{value:.6g}" for value in place)
        advice = 'set nodes = "even", use more nodes, or end the run earlier'
        raise RunStopped(f"{text}, near ({where}) m: {advice}", node=node, position=tuple(place.tolist()))


def way_along(mesh: Rings, places: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Return displacements along a surface that smooth the mesh [m], shape (n, 3), after the film moved the nodes by
    `moved` [m], shape (n, 3), to `places`.

    The displacements revert the tangential part of `moved`, except its rigid part, and move each node towards the centroids
    of the triangles around the node.
    """
    triangles, n = mesh.triangles, len(places)
    corner = places[triangles]
    area = np.linalg.norm(vector_areas(places, triangles), axis=1)
    weight = np.bincount(triangles.ravel(), np.repeat(area, 3), n)
    middles = np.repeat(area[:, None] * corner.mean(axis=1), 3, axis=0)
    centroid = np.stack([np.bincount(triangles.ravel(), middles[:, i], n) for i in range(3)], axis=1) / weight[:, None]
    way = SMOOTHING * (centroid - places) - (moved - rigid_part(places - moved, moved, weight))
    normal = vertex_normals(places, triangles)
    way -= np.einsum("ni,ni->n", way, normal)[:, None] * normal
    nearest = np.linalg.norm(places[mesh.neighbours] - places[:, None], axis=2).min(axis=1)
    length = np.linalg.norm(way, axis=1)
    return np.asarray(way * np.minimum(1.0, LONGEST * nearest / np.maximum(length, 1e-300))[:, None])


def rigid_part(places: np.ndarray, moved: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the displacements [m], shape (n, 3), of the small rigid motion of nodes at `places` [m] that fits the
    displacements `moved` [m] best, shape (n, 3) both, by weighted least squares with weights, shape (n,).
    """
    total = weight.sum()
    centre, mean = weight @ places / total, weight @ moved / total
    offset = places - centre
    inertia = (weight[:, None] * offset).T @ offset
    spin = (weight[:, None] * np.cross(offset, moved - mean)).sum(axis=0)
    turn = np.linalg.solve(np.trace(inertia) * np.eye(3) - inertia, spin)
    return np.asarray(mean + np.cross(turn, offset))
