"""Settings of a diffusing field in a case file, their checks, and the material of such a field."""

from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from pellucid.approximants.radial import AnyRadial
from pellucid.approximants.radial.functions import PolyharmonicModel
from pellucid.bodies.initial import INITIAL_MEANING, Initial, initial_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.choice import Choice
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box
from pellucid.geometry.surfaces.surface import Inside, Surface
from pellucid.grid.model import GridCase
from pellucid.materials.contract import BodyMaterial
from pellucid.model import Model, parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.body_model import BodyModel, Standing
from pellucid.parts.part import Parts
from pellucid.state import Field


class DiffusiveMaterial(BodyMaterial):
    """Fick's law: the flux of the concentration c is -D ∇c, with the diffusion coefficient D."""

    kind: Literal["diffusive"] = "diffusive"
    density: float = parameter("kg/m^3", "density of the carrier medium; it affects only the masses in the results", 1.0, gt=0)
    diffusivity: float = parameter("m^2/s", "coefficient of diffusion D", gt=0)

    def wave_speeds(self) -> tuple[float, float]:
        """Return zero for both wave speeds: there are no waves."""
        return 0.0, 0.0


class Line(Model):
    """An interval of the x-axis with equally spaced nodes, including one at each end."""

    lower: float = parameter("m", "x of the lower end of the line")
    upper: float = parameter("m", "x of the upper end of the line")
    nodes: int = parameter("", "number of nodes", ge=3, le=1_000_000)
    at_lower: float | None = parameter("", "fixed concentration at the lower end; default: no flux", None)
    at_upper: float | None = parameter("", "fixed concentration at the upper end; default: no flux", None)

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        if self.upper <= self.lower:
            raise ValueError(f"the line extends from {self.lower:g} to {self.upper:g} m: set `upper` above `lower`")
        return self

    def places(self) -> np.ndarray:
        """Return the positions of the nodes along x [m], shape (n,)."""
        return np.linspace(self.lower, self.upper, self.nodes)


class Domain(Choice):
    """A line or a closed surface with the nodes on which a field diffuses."""

    what: ClassVar[str] = "a domain"

    line: Line | None = None
    surface: Surface | None = None

    def positions(self) -> np.ndarray:
        """Return the positions of the nodes [m], shape (n, 3)."""
        if self.line is None:
            return np.asarray(self.chosen().triangulate().vertices)
        x = self.line.places()
        return np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)

    @property
    def dimension(self) -> int:
        """Return the dimension of the domain: 1 for a line, 2 for a surface."""
        return 1 if self.line is not None else 2


STENCIL_BYTES = 60  # memory per node and squared number of stencil nodes, measured on a sphere of 10 242 nodes
WIDEST = 1.0
"""Largest half-width of a window divided by the node spacing; in wider windows, oscillations from node to node grow."""


class DiffusingFieldCase(BodyModel):
    """A concentration that diffuses on fixed nodes of a line or a closed surface, ∂c/∂t = D Δc; nothing moves."""

    place: ClassVar[str] = "domain"
    start_only: ClassVar[tuple[str, ...]] = (*BodyModel.start_only, "concentration")
    moves: ClassVar[bool] = False
    fields: ClassVar[Mapping[str, Field]] = {
        "concentration": Field(1, "1", "concentration of a diffusing field, amount per volume"),
        "amount": Field(1, "m^3", "concentration times nodal volume; the sum is the amount in the body"),
    }
    pictured: ClassVar[tuple[str, str]] = "concentration", "concentration"

    kind: Literal["diffusing-field"] = "diffusing-field"
    domain: Domain = parameter("", "domain of the diffusion")
    material: DiffusiveMaterial = parameter("", "material in which the field diffuses")
    radial: AnyRadial = parameter("", "radial functions that interpolate the field", PolyharmonicModel())
    window: float = parameter(
        "",
        "on a line, half-width of the intervals over which the balance is integrated, divided by the node "
        "spacing; with 0.5 the intervals adjoin and the amount is conserved",
        0.5,
        gt=0,
    )
    alpha: float = parameter(
        "", "weight α of the new state in the rate of change over a step; 0.5 gives second order", 0.5, ge=0.5, le=1
    )
    concentration: float = parameter("", "uniform initial concentration", 0.0)
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())

    def build(self, placement: Placement) -> Body:
        from pellucid.bodies.diffusing_field.body import DiffusingField

        return DiffusingField(self, placement)

    def owns_nodes(self, alone: bool) -> bool:
        return True

    def needs_grid(self, parts: Parts) -> bool:
        return False

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return np.zeros_like(position)

    def occupied(self) -> Geometry:
        """Return the region that other bodies can exclude from theirs: the region enclosed by the surface; for a line, a box
        of zero width.
        """
        if self.domain.surface is not None:
            return Inside(surface=self.domain.surface)
        (x, y, z), (a, b, c) = (end.tolist() for end in self.bounds())
        return Box(lower=(x, y, z), upper=(a, b, c))

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.domain.positions())

    def standing(self, grid: GridCase) -> Standing:
        return Standing(self.domain.positions())

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.domain.positions()) if self.domain.line is None else self.domain.line.nodes

    def table_bytes(self) -> float:
        return STENCIL_BYTES * self.radial.stencil_size(self.domain.dimension) ** 2 * self.n_points(None)

    @property
    def probed(self) -> tuple[str, ...]:
        return "position", "mass", "volume", "density", "concentration", "amount"

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for a grid, which this body cannot have, stencils that are too wide, an invalid
        surface, and fewer nodes than a stencil needs. path: path of the body in the data of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("concentration",), path)
        if parts.grid is not None:
            text = f"{self.name} is fixed and has no contact: it cannot be combined with bodies on a grid"
            yield Finding((*path, "kind"), text, "remove the table [grid], and put the field in its own case")
        if self.window >= WIDEST:
            text = (
                f"must be below {WIDEST:g}: wider windows do not respond to certain waves of the nodal values, which then grow"
            )
            yield Finding((*path, "window"), text, "use 0.5: then windows are contiguous and the amount is conserved")
        if self.window != type(self).model_fields["window"].default and self.domain.line is None:
            yield Finding((*path, "window"), "`window` applies to lines, not to surfaces", "remove it")
        if (surface := self.domain.surface) is not None:
            place = (*path, self.place, "surface")
            if not surface.closed:
                yield Finding(
                    place, "the surface is open, but a field needs a closed surface", "use a surface that encloses a volume"
                )
                return
            yield from (Finding(place, text, remedy) for text, remedy in faults(*surface.triangulate(), closed=True))
        yield from self._stencil_problems(path)

    def _stencil_problems(self, path: Path) -> Iterator[Finding]:
        size, least = self.radial.stencil_size(self.domain.dimension), self.radial.n_polynomials(self.domain.dimension)
        if size < least:
            text = f"must be at least {least}, the number of polynomials of degree {self.radial.degree} to be determined"
            yield Finding((*path, "radial", "neighbours"), text, f"use at least {least} neighbours, or a lower `degree`")
        elif size > self.n_points(None):
            text = f"a stencil has {size} nodes, but the domain only {self.n_points(None):g}"
            yield Finding((*path, self.place), text, "use more nodes, or a lower `radial.degree`")
