"""Settings of the bending resistance of a membrane in a case file, their checks, and the step limit of bending at the start,
computed without compilation.
"""

from collections.abc import Iterator
from math import sqrt
from typing import Literal

import numpy as np

from pellucid.bodies.membrane_elements.mesh import hinges_of
from pellucid.findings import Finding, Path
from pellucid.geometry.meshes.enclosure import rims_of
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.surfaces.surface import Surface
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.model import Model, check, parameter

FLUID = 1.0 - 1e-9  # Poisson's ratio from which on there is no resistance to twist


class BendingCase(Model):
    """Resistance of a membrane to bending.

    Closed surfaces have the energy (κ/2)(2H - c₀)² per unit area; 2H is the sum of the principal curvatures, positive for a
    sphere. Open surfaces are isotropic plates with κ/2 [(tr k)² - 2(1-ν) det k] per unit area and the change k of the
    curvature tensor.
    """

    rigidity: float = parameter(
        "J", "bending rigidity κ: moment per length and change of 2H; for a solid plate E h³/12(1-ν²)", gt=0
    )
    poisson_ratio: float | None = parameter(
        "", "Poisson's ratio ν of bending of an open surface; default: the in-plane ratio of the material", None, gt=-1, lt=1
    )
    spontaneous_curvature: float | Literal["start"] = parameter(
        "1/m", 'spontaneous curvature c₀, the value of 2H without bending; "start": the initial curvature everywhere', 0.0
    )
    shape: Surface | None = parameter(
        "", "alternative to `spontaneous_curvature`: a surface with the same elements, in its shape without bending", None
    )

    @check
    def _has_one_reference(self) -> None:
        if self.shape is not None and self.spontaneous_curvature != 0.0:
            raise ValueError("`shape` already defines the unbent state: remove `spontaneous_curvature`")

    def plate_ratio(self, material: MembraneMaterial) -> float:
        """Return Poisson's ratio for the bending of an open surface of this material."""
        return material.plane_poisson_ratio if self.poisson_ratio is None else self.poisson_ratio

    def problems(
        self, path: Path, mesh: Mesh, material: MembraneMaterial, flat: bool, functions: str | None = None
    ) -> Iterator[Finding]:
        """Yield findings (errors of the case) for element types and shape functions without bending, an unbent shape that does
        not match the mesh, or a missing Poisson's ratio.

        path: path of the settings in the data of the case; mesh, material: of the membrane; flat: True if the grid is thin
        along an axis; functions: shape functions of the grid if its nodes move the membrane.
        """
        if flat:
            text = "bending applies to surfaces in space, but the grid is one cell thick along an axis"
            yield Finding(path, text, "enlarge the grid, or remove `bending`; for a curve with bending use a fluid-film")
        elif len(mesh.quads):
            text = "bending applies to triangles, but the membrane has quadrilaterals"
            yield Finding(path, text, 'use `elements = "triangles"`, or remove `bending`')
        elif functions == "trilinear" and len(rims_of(mesh.triangles).edges):
            text = 'open surfaces cannot bend with `functions = "trilinear"` of the grid: kinks make them up to twice as stiff'
            yield Finding(path, text, 'set grid.functions = "quadratic-bspline", or remove `bending`')
        else:
            yield from self._shape_problems((*path, "shape"), mesh)
            yield from self._ratio_problems((*path, "poisson_ratio"), mesh, material)

    def _shape_problems(self, path: Path, mesh: Mesh) -> Iterator[Finding]:
        if self.shape is None:
            return
        other = self.shape.mesh("triangles")
        if other.triangles.shape != mesh.triangles.shape or np.any(other.triangles != mesh.triangles):
            text = (
                f"its {len(other.triangles)} triangles do not match the {len(mesh.triangles)} triangles of the "
                "membrane, corner by corner"
            )
            yield Finding(
                path, text, "use a surface of the same kind with the same numbers of elements, or a file made from it"
            )

    def _ratio_problems(self, path: Path, mesh: Mesh, material: MembraneMaterial) -> Iterator[Finding]:
        is_closed = not len(rims_of(mesh.triangles).edges)
        if is_closed and self.poisson_ratio is not None:
            text = "`poisson_ratio` has no effect on a closed surface, over which the Gaussian curvature is constant"
            yield Finding(path, text, "remove `poisson_ratio`")
        elif not is_closed and self.plate_ratio(material) > FLUID:
            text = (
                "the material has no shear stiffness: with its Poisson's ratio of 1 there is no resistance to twist at the rim"
            )
            yield Finding(path, text, "set `poisson_ratio`, for example to 0.5")


def bending_rate(triangles: np.ndarray, position: np.ndarray, mass: np.ndarray, rigidity: float, poisson_ratio: float) -> float:
    """Return an upper bound of half the largest eigenfrequency of bending of a membrane [1/s], which limits the time step.

    triangles: shape (t, 3); position: nodal positions [m], shape (n, 3); mass: nodal masses [kg], shape (n,); rigidity: κ
    [J]; poisson_ratio: ν, for an open surface. `Bending` and, for an open membrane without supports, `PlateBending` compute
    the same bound in a run. The bound depends on lengths and areas, not on angles.
    """
    n, hinges = len(position), hinges_of(triangles)
    if len(rims_of(triangles).edges):
        from pellucid.bodies.membranes.plate_operators import build_plate_operators, no_supports  # imports scipy

        supports = no_supports(len(triangles), n)
        operators = build_plate_operators(triangles, position, rigidity, poisson_ratio, supports)
        return operators.rate(position, mass, supports.fixed)
    a, b, c, d = (position[corner] for corner in hinges.T)
    along, left, right = b - a, c - a, d - a
    square = np.sum(along * along, axis=1)
    length = np.sqrt(square)
    one, two = (length / np.linalg.norm(np.cross(along, way), axis=1) for way in (left, right))
    s, t = (np.sum(way * along, axis=1) / square for way in (left, right))
    # |∂φ/∂x| at the corners: across, and at most at the ends of the edge
    turned = np.stack([np.abs(1.0 - s) * one + np.abs(1.0 - t) * two, np.abs(s) * one + np.abs(t) * two, one, two], axis=1)
    edges = position[triangles] - position[triangles[:, [1, 2, 0]]]
    thirds = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 6.0
    area = np.bincount(triangles.ravel(), np.repeat(thirds, 3), n)
    reach = np.bincount(hinges[:, :2].ravel(), np.repeat(0.5 * length * turned.sum(axis=1), 2), n)
    stiff = rigidity * reach / area
    values = (0.5 * length * stiff[hinges[:, :2]].sum(axis=1))[:, None] * turned
    return 0.5 * sqrt(float((np.bincount(hinges.ravel(), values.ravel(), n) / mass).max()))
