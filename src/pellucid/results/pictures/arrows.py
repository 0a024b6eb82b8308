"""Arrows of the tangential velocity on surfaces in space."""

import numpy as np

from pellucid.geometry.meshes.triangulation import vertex_normals
from pellucid.results.pictures.annotations import Axes
from pellucid.results.pictures.rendering.axes import INK
from pellucid.results.pictures.rendering.camera import Camera

APART = 0.09  # distance of arrows, of the largest side of the surface at the start
LONGEST = 0.1  # of the picture's width, of an arrow
FACING = 0.25  # share of the normal towards the eye: nearer to the rim arrows would be seen end on


def spread(position: np.ndarray) -> np.ndarray:
    """Return the indices of nodes for arrows, about one arrow spacing apart, in ascending order."""
    low = position.min(axis=0)
    side = APART * float((position.max(axis=0) - low).max())
    return np.asarray(np.sort(np.unique(((position - low) / side).astype(np.int64), axis=0, return_index=True)[1]))


def draw_arrows(
    axes: Axes,
    camera: Camera,
    position: np.ndarray,
    triangles: np.ndarray,
    velocity: np.ndarray,
    some: np.ndarray,
    fastest: float,
) -> None:
    """Draw arrows of the tangential velocity at the nodes `some` of a surface. The longest arrow represents the speed
    `fastest` [m/s]."""
    normal = vertex_normals(position, triangles)
    along = velocity - np.einsum("ni,ni->n", velocity, normal)[:, None] * normal
    some = some[normal[some] @ camera.axes[2] > FACING]
    across, upward = camera.axes[:2]
    length = LONGEST * float((camera.high - camera.low)[0]) / fastest
    x, y, u, v = (values[some] @ axis for values in (position, along) for axis in (across, upward))
    flow = x, y, length * u, length * v
    axes.quiver(*flow, angles="xy", scale_units="xy", scale=1.0, width=0.004, color=INK, zorder=3)
