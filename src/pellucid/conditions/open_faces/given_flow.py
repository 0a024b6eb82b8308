"""What a case says of a flow through a face of the grid."""

from collections.abc import Iterator
from typing import Literal

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.findings import Finding, Path
from pellucid.geometry.shape import Shape
from pellucid.grid.model import GridCase
from pellucid.model import check, parameter
from pellucid.parts.part import Parts

Profile = Literal["uniform", "parabolic"]


class GivenFlow(ChangesInTime):
    """A flow through a face of the grid: its size, what it is across the opening, and how it changes in time."""

    velocity: float | None = parameter("m/s", "mean velocity through the opening, along which it flows", None, ge=0)
    flow_rate: float | None = parameter(
        "m^3/s", "instead of it, volume in unit of time, of the slice in plane problems", None, ge=0
    )
    profile: Profile = parameter(
        "",
        "velocities across the opening: all the same, or those of a steady slow flow in a slit, duct or tube",
        "uniform",
    )
    through: Shape | None = parameter(
        "", "the opening is where this shape meets the face; without it, where a body does that flows through it", None
    )

    @check
    def _flows_one_way(self) -> None:
        if self.amplitude is not None and self.amplitude.smallest < 0.0 and not self._allows_turning():
            text = f"`amplitude` has the share {self.amplitude.smallest:g}, and what comes in or is led out cannot turn round"
            raise ValueError(f"{text}; use shares of 0 or more")

    def _allows_turning(self) -> bool:
        """Whether it may act the other way at times."""
        return False

    def sizes(self) -> list[str]:
        """Which keys say how large it is."""
        return [key for key in ("velocity", "flow_rate") if getattr(self, key) is not None]

    def largest_share(self) -> float:
        """The largest share of it at any time."""
        return 1.0 if self.amplitude is None else self.amplitude.largest

    def opening_problems(self, face: str, path: Path, parts: Parts) -> Iterator[Finding]:
        """Of an opening that does not reach the face, or across which nothing tells a profile."""
        grid = parts.grid
        if grid is None:
            return
        if self.profile == "parabolic" and not any(walled_axes(grid, face)):
            text = f"the face {face} has no walls across: along every other axis the grid is one cell thick or periodic"
            yield Finding((*path, "profile"), text, 'use profile = "uniform"')
        if self.through is not None:
            axis, upper = "xyz".index(face[0]), face.endswith("upper")
            level = (grid.extent_upper() if upper else grid.lower)[axis]
            low, high = (float(corner[axis]) for corner in self.through.geometry().bounds())
            if not low - 1e-6 * grid.cell <= level <= high + 1e-6 * grid.cell:
                text = f"the shape lies between {low:g} and {high:g} m along {face[0]}, the face {face} at {level:g} m"
                yield Finding((*path, "through"), text, "let the shape reach through the face, a cell deep into the grid")


def walled_axes(grid: GridCase, face: str) -> list[bool]:
    """Across which of the axes x, y, z walls may bound an opening in a face."""
    normal = "xyz".index(face[0])
    return [axis != normal and not (grid.thin()[axis] or grid.is_periodic()[axis]) for axis in range(3)]
