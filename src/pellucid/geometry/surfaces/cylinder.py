"""Surface of a circular cylinder with its end faces."""

from typing import Literal

import numpy as np

from pellucid.geometry.meshes.surface_mesh import NO_TRIANGLES, Mesh, grid_quads
from pellucid.geometry.meshes.triangulation import two_across
from pellucid.geometry.surfaces.disc import rings_of_a_disc
from pellucid.geometry.surfaces.tube import BetweenEnds
from pellucid.model import AtLeastTwo, parameter


class CylinderSurface(BetweenEnds):
    """A circular cylinder: a mantle of quadrilaterals, and end faces (lids) of triangles that share its edge points;
    outward normals."""

    rings: int = parameter(
        "", "number of rings of points around the centre of a lid; the circumference has 6 × `rings` points", ge=1, le=1000
    )
    along: AtLeastTwo = parameter("", "number of points along the axis, including both ends")
    open: tuple[Literal["start", "end"], ...] = parameter("", "ends without a lid", ())

    @property
    def closed(self) -> bool:
        """True if both ends have lids."""
        return not self.open

    def expected_points(self) -> float:
        return 6.0 * self.rings * (self.along + self.rings)

    def mesh(self) -> Mesh:
        """Return the mesh. Order of the points: mantle in lines along the axis, lid at the start, lid at the end."""
        axis = np.array(self.end) - np.array(self.start)
        side, up = two_across(axis)
        plane, lid = rings_of_a_disc(self.rings)
        inner, around, along = len(plane) - 6 * self.rings, 6 * self.rings, self.along
        disc = self.radius * (plane[:, :1] * side + plane[:, 1:] * up)
        s = np.linspace(0.0, 1.0, along)
        vertices = [(s[None, :, None] * axis + disc[inner:, None, :]).reshape(-1, 3)]
        triangles = [NO_TRIANGLES]
        for end, place in (("start", 0), ("end", 1)):
            if end in self.open:
                continue
            own = sum(map(len, vertices)) + np.arange(inner)
            rim = np.arange(around) * along + place * (along - 1)
            turned = np.concatenate([own, rim])[lid]
            triangles.append(turned if end == "end" else turned[:, ::-1])
            vertices.append(place * axis + disc[:inner])
        quads = grid_quads(around, along, wrapped=True)
        return Mesh(np.array(self.start) + np.concatenate(vertices), quads, np.concatenate(triangles))
