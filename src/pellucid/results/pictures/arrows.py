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
    """Select nodes of a surface at which arrows are drawn, about 0.09 times its largest extent apart; return their indices in
    ascending order. position: positions of all nodes [m], shape (n, 3)."""
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
    """Draw the velocity tangential to a surface as arrows at the nodes with the indices `some`.

    Arrows of nodes that face away from the eye are omitted. position [m] and velocity [m/s]: arrays for all nodes, shape
    (n, 3). triangles: node indices, shape (m, 3). fastest: speed of the longest arrow [m/s].
    """
    normal = vertex_normals(position, triangles)
    along = velocity - np.einsum("ni,ni->n", velocity, normal)[:, None] * normal
    some = some[normal[some] @ camera.axes[2] > FACING]
    across, upward = camera.axes[:2]
    length = LONGEST * float((camera.high - camera.low)[0]) / fastest
    x, y, u, v = (values[some] @ axis for values in (position, along) for axis in (across, upward))
    flow = x, y, length * u, length * v
    axes.quiver(*flow, angles="xy", scale_units="xy", scale=1.0, width=0.004, color=INK, zorder=3)
