"""Planes of symmetry at faces of the grid, and seams (pairs of opposite faces that are identified) of periodic grids."""

from collections.abc import Sequence

from pellucid.approximants import Ends
from pellucid.conditions.support import Support
from pellucid.contact.images import Plane, Seam
from pellucid.grid.model import GridCase
from pellucid.model import Vector
from pellucid.parts.condition import Condition


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


def mirrored_ends(supports: Sequence[Support], conditions: Sequence[Condition], grid: GridCase, pull: Vector) -> Ends:
    """Return the ends of the axes beyond which the shape functions of a grid are mirrored.

    They are faces that are held at rest along their normals and free along all other axes, throughout the run: planes of
    symmetry, or walls on which bodies slip without friction, at which the tangential velocity of a viscous fluid has no slope
    either. Gravity across a face makes it a floor, where the pressure of mirrored fluids would have a kink.

    conditions: all conditions of the case, of which some accelerate material as gravity does; pull: gravity [m/s²].
    """
    ends = []
    for axis, name in enumerate("xyz"):
        faces = (f"{name}-lower", f"{name}-upper")
        lower, upper = (
            grid.active_axes()[axis]
            and name not in grid.periodic
            and pull[axis] == 0.0
            and not any(one.accelerates(axis) for one in conditions)
            and _mirrors(face, supports, conditions, grid)
            for face in faces
        )
        ends.append((lower, upper))
    return ends[0], ends[1], ends[2]


def _mirrors(face: str, supports: Sequence[Support], conditions: Sequence[Condition], grid: GridCase) -> bool:
    """Return True if shape functions are mirrored beyond a face of the grid, given by its name, see `mirrored_ends`."""
    held = [one for support in supports for one in support.on_each_face() if face in one.faces()]
    active = grid.active_axes()
    smooth = all(
        one.body is None
        and one.until is None
        and not (one.wall_friction() > 0.0 or one.lets_go())
        and one.velocity["xyz".index(face[0])] == 0.0
        and not any(one.axes()[axis] and active[axis] for axis in range(3) if axis != "xyz".index(face[0]))
        for one in held
    )
    closed = any(one.face_velocity(face) is not None for one in held) and not any(one.opens_face(face) for one in conditions)
    return smooth and closed and grid.functions != "trilinear"


def seams(grid: GridCase) -> list[Seam]:
    """Return the seams of a periodic grid (pairs of opposite faces that are identified), one for each periodic axis."""
    ends = enumerate(zip(grid.lower, grid.periods(), strict=True))
    return [Seam(axis, low, period) for axis, (low, period) in ends if period > 0.0]
