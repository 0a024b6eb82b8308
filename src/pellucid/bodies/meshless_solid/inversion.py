"""Where a meshless solid is inverted: volume ratios of its points, and the averages, of which laws take logarithms."""

import numpy as np

from pellucid.bodies.meshless_solid.solid import LEAST_J, Solid, deformation_gradients
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.parts.body import in_metres


def inversion(mesh: SimplexMesh, solid: Solid) -> tuple[str, int] | None:
    """Where, with the volume ratio there, and a node of it, if that of a point or the mean about a node is not positive."""
    if not solid.sums[:, LEAST_J].min() > 0.0:
        ratios = np.linalg.det(deformation_gradients(solid, len(mesh.cells)))
        cell = int(np.argmin(ratios)) // solid.n_points
        corners = mesh.cells[cell]
        named, place = ", ".join(map(str, sorted(corners.tolist()))), in_metres(mesh.nodes[corners].mean(axis=0))
        words = f"between nodes {named}, where {place} was at rest: the volume ratio of a point is {ratios.min():.3g}"
        return words, int(corners[0])
    if len(solid.block_volume) and not solid.node_sums[:, LEAST_J].min() > 0.0:
        node = int(np.argmin(solid.volume_ratio))
        place, ratio = in_metres(mesh.nodes[node]), solid.volume_ratio[node]
        return f"about node {node}, where {place} was at rest: the mean volume ratio about it is {ratio:.3g}", node
    return None
