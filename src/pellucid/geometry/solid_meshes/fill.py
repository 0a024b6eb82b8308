"""Tetrahedral mesh that fills a shape."""

from math import prod

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.shape import Shape
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.geometry.solid_meshes.stuffing import stuffed
from pellucid.geometry.surfaces.inside import Inside, closed_triangles
from pellucid.model import check, parameter

SPACE = (True, True, True)
MOST_OFF = 0.1  # largest relative error of the volume


class FillMesh(Tetrahedral):
    """A shape filled by a lattice of tetrahedra whose outer nodes are moved to its boundary; sharp edges are cut off."""

    shape: Shape = parameter("", "shape that is filled, as for material points")
    size: float = parameter(
        "m",
        "edge length of the cubes of the lattice, each divided into twelve "
        "tetrahedra; at most half the thickness of thin parts",
        gt=0,
    )

    @check
    def _can_be_made(self) -> None:
        self.mesh()

    def expected_points(self) -> float:
        lower, upper = self.shape.geometry().bounds()
        return 2.0 * prod(extent / self.size + 1.0 for extent in (upper - lower).tolist())

    def make(self) -> SimplexMesh:
        """Return the mesh; the lattice is centred on the shape. Raises ValueError if the lattice is too coarse or too fine."""
        geometry, chosen = self.shape.geometry(), self.shape.chosen()
        if isinstance(chosen, Inside):
            closed_triangles(chosen.surface)
        lower, upper = geometry.bounds()
        n = np.ceil((upper - lower) / self.size).astype(int) + 1  # margin of half a cube at both ends
        counts = int(n[0]), int(n[1]), int(n[2])
        start = 0.5 * (lower + upper - self.size * n)
        mesh = stuffed(lambda points: geometry.contains(points, SPACE), start, counts, self.size)
        share = float(mesh.volumes.sum()) / geometry.measure(SPACE)
        if abs(share - 1.0) > MOST_OFF:
            text = f"with `size` = {self.size:g} m the mesh has {100.0 * share:.0f} % of the volume of the shape"
            raise Refusal(f"{text}; the error must be at most {100.0 * MOST_OFF:.0f} %", "decrease `size`")
        return mesh
