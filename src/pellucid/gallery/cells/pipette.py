"""The mouth of a pipette as a load: rigid, smooth, with a rounded edge."""

from typing import Literal

import numpy as np

from pellucid.extend import Load, PointsView, parameter, register


@register
class Pipette(Load):
    """A rigid plate with a round hole about the z axis. It pushes nodes of a membrane out of the plate with the force k d
    at the depth d."""

    kind: Literal["pipette"] = "pipette"
    radius: float = parameter("m", "radius of the hole", gt=0)
    edge: float = parameter("m", "radius of the rounded edge of the hole", gt=0)
    face: float = parameter("m", "height of the plate's lower face", 0.0)
    slit: bool = parameter(
        "", "true: the lower face holds nodes in both directions; false: only against entering the plate", False
    )
    stiffness: float = parameter("Pa/m", "stiffness: pressure divided by the depth of an overlap", gt=0)

    def forces(self, points: PointsView, time: float) -> np.ndarray:
        x, y, z = points.position.T
        r = np.hypot(x, y)
        out, up = r - (self.radius + self.edge), z - (self.face + self.edge)  # from the middle of the edge's arc
        on_edge = (out < 0.0) & (up < 0.0)
        on_face = (out >= 0.0) & (up < out)
        on_wall = ~on_edge & ~on_face
        away = np.maximum(np.hypot(out, up), 1e-300)
        within = up + self.edge if self.slit else np.maximum(up + self.edge, 0.0)
        depth = np.select([on_edge, on_face], [np.maximum(self.edge - away, 0.0), within], np.maximum(out + self.edge, 0.0))
        across = np.select([on_edge, on_wall], [out / away, -1.0], 0.0)
        along = np.select([on_edge, on_face], [up / away, -1.0], 0.0)
        push = self.stiffness * points.area * depth
        inwards = push * across / np.maximum(r, 1e-300)
        return np.stack([inwards * x, inwards * y, push * along], axis=1)
