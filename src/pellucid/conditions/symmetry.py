"""Planes of symmetry at faces of the grid, and seams (pairs of opposite faces that are identified) of periodic grids."""

from collections.abc import Sequence

from pellucid.conditions.support import Support
from pellucid.contact.images import Plane, Seam
from pellucid.grid.model import GridCase


def symmetry_planes(supports: Sequence[Support], grid: GridCase) -> list[Plane]:
    """Return, as planes of symmetry, the faces of the grid that supports hold at rest along their normals; surfaces are
    continued beyond them as mirror images.

    Supports that also constrain directions along the face, or that name a body, count as well.

    """
    planes = []
    for axis, name in enumerate("xyz"):
        for end, place in (("lower", grid.lower[axis]), ("upper", grid.extent_upper()[axis])):
            held = [support.face_velocity(f"{name}-{end}") for support in supports]
            if any(velocity is not None and velocity[axis] == 0.0 for velocity in held):
                planes.append(Plane(axis, float(place)))
    return planes


def seams(grid: GridCase) -> list[Seam]:
    """Return the seams of a periodic grid (pairs of opposite faces that are identified), one for each periodic axis."""
    ends = enumerate(zip(grid.lower, grid.periods(), strict=True))
    return [Seam(axis, low, period) for axis, (low, period) in ends if period > 0.0]
