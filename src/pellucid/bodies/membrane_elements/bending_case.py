"""Bending of membranes of elements as the user describes it."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import Model, check, parameter


class BendingCase(Model):
    """Resistance of a membrane against bending, with the energy (κ/2)(2H - c₀)² of unit area; 2H is the sum of the principal
    curvatures, positive as of a sphere."""

    rigidity: float = parameter("J", "κ: moment per length for a change of 2H", gt=0)
    spontaneous_curvature: float | Literal["start"] = parameter(
        "1/m", 'c₀: 2H where nothing bends it; "start": at every node that of the start', 0.0
    )
    shape: Surface | None = parameter(
        "", "instead of it a surface of the same elements, at whose nodes nothing bends the membrane", None
    )

    @check
    def _has_one_reference(self) -> None:
        if self.shape is not None and self.spontaneous_curvature != 0.0:
            raise ValueError("`shape` says where nothing bends the membrane: leave `spontaneous_curvature` out")

    def problems(self, path: Path, mesh: Mesh, flat: bool) -> Iterator[Finding]:
        """Elements that do not bend, and a shape with others than those of the membrane; flat: whether the grid is thin."""
        if flat:
            text = "is of surfaces in space, and the grid is one cell thick along an axis"
            yield Finding(path, text, "enlarge the grid, or leave it out; a curve that bends is a fluid-film")
        elif len(mesh.quads):
            text = "is that of triangles, and the membrane has quadrilaterals"
            yield Finding(path, text, 'use `elements = "triangles"`, or leave it out')
        elif self.shape is not None:
            other = self.shape.mesh("triangles")
            if other.triangles.shape != mesh.triangles.shape or np.any(other.triangles != mesh.triangles):
                text = (
                    f"its {len(other.triangles)} triangles are not the {len(mesh.triangles)} of the membrane, corner by corner"
                )
                yield Finding(
                    (*path, "shape"), text, "give a surface of the same kind with the same numbers, or a file made from it"
                )
