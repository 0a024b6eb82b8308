"""Bending of membranes as the user describes it."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.geometry.algorithms.lids import rims_of
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.surfaces.surface import Surface
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.model import Model, check, parameter

FLUID = 1.0 - 1e-9  # from here on a Poisson's ratio leaves no resistance against twist


class BendingCase(Model):
    """Resistance of a membrane against bending. Closed surfaces have the energy (κ/2)(2H - c₀)² of unit area; 2H is the sum of
    the principal curvatures, positive as of a sphere. Open ones are isotropic plates, κ/2 [(tr k)² - 2(1-ν) det k], with the
    change k of the curvature tensor."""

    rigidity: float = parameter("J", "κ: moment per length for a change of 2H; of a solid plate E h³/12(1-ν²)", gt=0)
    poisson_ratio: float | None = parameter(
        "", "ν of the bending of an open surface; without it Poisson's ratio of the material in the plane", None, gt=-1, lt=1
    )
    spontaneous_curvature: float | Literal["start"] = parameter(
        "1/m", 'c₀: 2H where nothing bends it; "start": at every place the curvature of the start', 0.0
    )
    shape: Surface | None = parameter(
        "", "instead of it a surface of the same elements, at whose nodes nothing bends the membrane", None
    )

    @check
    def _has_one_reference(self) -> None:
        if self.shape is not None and self.spontaneous_curvature != 0.0:
            raise ValueError("`shape` says where nothing bends the membrane: leave `spontaneous_curvature` out")

    def plate_ratio(self, material: MembraneMaterial) -> float:
        """Poisson's ratio of an open surface of this material."""
        return material.plane_poisson_ratio if self.poisson_ratio is None else self.poisson_ratio

    def problems(
        self, path: Path, mesh: Mesh, material: MembraneMaterial, flat: bool, functions: str | None = None
    ) -> Iterator[Finding]:
        """Report element types and functions without bending, a mismatched shape, or a missing Poisson's ratio.

        flat: whether the grid is thin; functions: those of the grid if its nodes move the membrane.
        """
        if flat:
            text = "is of surfaces in space, and the grid is one cell thick along an axis"
            yield Finding(path, text, "enlarge the grid, or leave it out; a curve that bends is a fluid-film")
        elif len(mesh.quads):
            text = "is that of triangles, and the membrane has quadrilaterals"
            yield Finding(path, text, 'use `elements = "triangles"`, or leave it out')
        elif functions == "trilinear" and len(rims_of(mesh.triangles).edges):
            text = 'open surfaces cannot bend with `functions = "trilinear"` of the grid: kinks make them up to twice as stiff'
            yield Finding(path, text, 'set grid.functions = "quadratic-bspline", or leave `bending` out')
        else:
            yield from self._shape_problems((*path, "shape"), mesh)
            yield from self._ratio_problems((*path, "poisson_ratio"), mesh, material)

    def _shape_problems(self, path: Path, mesh: Mesh) -> Iterator[Finding]:
        if self.shape is None:
            return
        other = self.shape.mesh("triangles")
        if other.triangles.shape != mesh.triangles.shape or np.any(other.triangles != mesh.triangles):
            text = f"its {len(other.triangles)} triangles are not the {len(mesh.triangles)} of the membrane, corner by corner"
            yield Finding(path, text, "give a surface of the same kind with the same numbers, or a file made from it")

    def _ratio_problems(self, path: Path, mesh: Mesh, material: MembraneMaterial) -> Iterator[Finding]:
        is_closed = not len(rims_of(mesh.triangles).edges)
        if is_closed and self.poisson_ratio is not None:
            text = "has no effect on a closed surface, over which the Gaussian curvature is constant"
            yield Finding(path, text, "leave `poisson_ratio` out")
        elif not is_closed and self.plate_ratio(material) > FLUID:
            text = "the material does not resist shear: with its Poisson's ratio of 1 nothing resists twist at the rim"
            yield Finding(path, text, "give `poisson_ratio`, for example 0.5")
