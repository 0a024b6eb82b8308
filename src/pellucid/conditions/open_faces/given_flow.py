"""Data model of a flow through a face of the grid: its magnitude, profile and change in time."""

from collections.abc import Iterator, Sequence
from typing import Any, Literal, TypeGuard

import numpy as np

from pellucid.conditions.open_faces.columns import ROUNDING, OpenFace, columns, why_apart
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.conditions.support import Support
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.region import Selectable, Shape, within
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box, Cylinder
from pellucid.grid.model import GridCase
from pellucid.model import check, parameter
from pellucid.parts.part import Parts

TERMS = 200  # terms of the series of a duct, which decrease with the cube of their index
Wall = tuple[float, float]


def across_tube(tube: Cylinder, axis: int, places: np.ndarray) -> np.ndarray:
    """Return the velocity profile 1 - r²/R² of the flow in a tube with radius R along an axis, at the positions `places`
    [m], shape (n, 3), with the distances r from the axis: dimensionless, shape (n,); 0 outside the tube."""
    offset = np.delete(places - np.array(tube.centre_), axis, axis=1)
    return np.maximum(1.0 - np.sum(offset * offset, axis=1) / tube.radius**2, 0.0)


def across_walls(walls: Sequence[Wall | None], places: np.ndarray) -> np.ndarray:
    """Return the velocity profile of the flow between one or two pairs of walls at the positions `places` [m], shape (n,
    3): dimensionless with an arbitrary scale, shape (n,); 0 outside the walls.

    walls: for each axis the positions of its two walls [m], or None. For two pairs the profile is Boussinesq's series, see
    White 2006, Viscous Fluid Flow, section 3-3.3.
    """
    pairs = [(axis, pair) for axis, pair in enumerate(walls) if pair is not None]
    scaled = [(2.0 * places[:, axis] - low - high) / (high - low) for axis, (low, high) in pairs]
    half = [0.5 * (high - low) for _, (low, high) in pairs]
    inside = np.all([np.abs(y) <= 1.0 for y in scaled], axis=0)
    if len(pairs) == 1:
        return np.where(inside, 1.0 - scaled[0] ** 2, 0.0)
    y, z = (np.clip(s, -1.0, 1.0) for s in scaled)
    share = np.zeros(len(places))
    for n in range(1, 2 * TERMS, 2):
        k, side = 0.5 * n * np.pi, half[1] / half[0]
        # cosh(k b z)/cosh(k b), without large numbers
        decay = (np.exp(k * side * (np.abs(z) - 1.0)) + np.exp(-k * side * (np.abs(z) + 1.0))) / (1.0 + np.exp(-2.0 * k * side))
        share += (-1.0) ** (n // 2) / n**3 * (1.0 - decay) * np.cos(k * y)
    return np.where(inside, np.maximum(share, 0.0), 0.0)


def why_no_profile(geometry: Geometry, axis: int) -> Reason | None:
    """Return the reason why the laminar velocity profile across an opening of this geometry is unknown, None if it is known
    (slit, duct or tube); axis: normal axis of the face."""
    if isinstance(geometry, Box) or is_tube(geometry, axis):
        return None
    text = "only slits, ducts and tubes along the normal have this profile, but the opening has another shape"
    return Reason(text, f'define a box, or a cylinder along {"xyz"[axis]}, with `through`, or use profile = "uniform"')


def is_tube(geometry: Geometry, axis: int) -> TypeGuard[Cylinder]:
    """Return True if `geometry` is a cylinder along the axis `axis`, the normal of a face, so that its opening in the face
    is round."""
    return isinstance(geometry, Cylinder) and "xyz".index(geometry.axis) == axis


Profile = Literal["uniform", "parabolic"]


class GivenFlow(ChangesInTime):
    """Flow through a face of the grid: its magnitude and profile across the opening if they are prescribed, and the change of
    the flow or of a pressure in time."""

    velocity: float | None = parameter("m/s", "mean velocity through the opening, in the direction of the flow", None, ge=0)
    flow_rate: float | None = parameter(
        "m^3/s",
        "alternative to `velocity`: volume flow rate; in plane problems, through the thickness of the slice",
        None,
        ge=0,
    )
    profile: Profile = parameter(
        "",
        "velocity profile of a prescribed flow: uniform, or that of steady laminar flow in a slit, duct or tube. Under a "
        "`pressure` the profile results from the flow",
        "uniform",
    )
    through: Shape | None = parameter(
        "", "the opening is the intersection of this shape with the face; default: of the body with the face", None
    )

    @check
    def _flows_one_way(self) -> None:
        if self.amplitude is not None and self.amplitude.smallest < 0.0 and self.is_led:
            text = f"`amplitude` has the fraction {self.amplitude.smallest:g}, but a prescribed flow cannot reverse"
            raise ValueError(f"{text}; use shares of 0 or more")

    @property
    def is_led(self) -> bool:
        """True if the flow is prescribed (velocity or flow rate)."""
        return len(self.sizes()) > 0

    def sizes(self) -> list[str]:
        """Return the names of the given keys that define the magnitude of the flow (`velocity`, `flow_rate`)."""
        return [key for key in ("velocity", "flow_rate") if getattr(self, key) is not None]

    def largest_share(self) -> float:
        """Return the largest fraction of the flow, as `amplitude` defines it, at any time."""
        return 1.0 if self.amplitude is None else self.amplitude.largest

    def extreme_shares(self) -> tuple[float, float]:
        """Return the smallest and the largest fraction of the flow or pressure at any time."""
        if self.amplitude is not None:
            return self.amplitude.smallest, self.amplitude.largest
        return 0.0 if self.rise > 0.0 else 1.0, 1.0

    def opening_problems(self, face: str, path: Path, parts: Parts, body: Any = None) -> Iterator[Finding]:
        """Yield findings about an opening that does not reach the face (its name), is closed by supports, or has an unknown
        profile.

        path: location of the condition in the case; parts: all parts of the case; body: model of the body that flows
        through the opening, or None.
        """
        grid = parts.grid
        if grid is None:
            return
        place = OpenFace.of(face, grid)
        has_profile = self.is_led and self.profile == "parabolic"
        if has_profile and not any(walled_axes(grid, face)):
            text = f"the face {face} has no side walls: along every other axis the grid is one cell thick or periodic"
            yield Finding((*path, "profile"), text, 'use profile = "uniform"')
        if reason := self._why_shut(place, grid, body):
            yield Finding((*path, "where" if self.through is None else "through"), *reason)
        elif has_profile and (reason := self._why_no_profile(place, body)):
            yield Finding((*path, "profile"), *reason)
        if self._is_closed(place, grid, parts):
            text = f"supports constrain all nodes of the opening in the face {face}: nothing can flow through it"
            yield Finding(path, text, "remove the supports from the opening, or enlarge it")

    def _is_closed(self, face: OpenFace, grid: GridCase, parts: Parts) -> bool:
        """Return True if supports of regions constrain all nodes of the opening in the face along the normal of the face."""
        nodes, periods, active = face.nodes(grid), grid.periods(), parts.active_axes
        if self.through is not None:
            just_inside = nodes + face.inward * ROUNDING * grid.cell * np.eye(3)[face.axis]
            nodes = nodes[within(self.through.geometry(), just_inside, active, periods)]
        held, of = np.zeros(len(nodes), bool), Selectable(nodes, periods=periods)
        for support in parts.of(Support):
            held |= support.holds(of, face.axis, active, ROUNDING * grid.cell)
        return len(nodes) > 0 and bool(held.all())

    def _why_no_profile(self, face: OpenFace, body: Any) -> Reason | None:
        shape = self.through or (body and body.shape)
        return None if shape is None else why_no_profile(shape.geometry(), face.axis)

    def _why_shut(self, face: OpenFace, grid: GridCase, body: Any) -> Reason | None:
        """Return the reason why no point can cross the opening in a face; None if points can cross it. body: model of the
        body, or None."""
        if self.through is None:
            apart = None if body is None else why_apart(f"body {body.name}", body.shape.geometry(), face, grid)
            return apart and apart._replace(remedy=f"{apart.remedy}, or define an opening with `through`")
        shape = self.through.geometry()
        if apart := why_apart("the opening", shape, face, grid):
            return apart
        if body is None or columns(shape, (), body.points_per_cell, grid, face).n > 0:
            return None
        text = f"no seed point of body {body.name} lies in the opening at the face {face.name}"
        return Reason(text, "make the opening several points wide, and extend it one cell deep into the grid")


def walled_axes(grid: GridCase, face: str) -> list[bool]:
    """Return for each axis True if the opening in a face can have walls normal to this axis: axes along the face that are
    not periodic and along which the grid is more than one cell thick."""
    normal = "xyz".index(face[0])
    return [axis != normal and not (grid.thin()[axis] or grid.is_periodic()[axis]) for axis in range(3)]
