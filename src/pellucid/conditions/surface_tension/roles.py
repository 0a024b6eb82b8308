"""Faces of the grid that a fluid wets: walls and planes of symmetry.

A support describes a wall or a plane of symmetry by its `contact_angle`: the angle of a wall, or 90 degrees. Without this
key a face is a plane of symmetry if a body is cut there (`cut_at`), and a wall if its support moves, has friction, opens,
or constrains also directions along the face. A support that constrains a face along its normal only may be either: if it is
the only one, the contact angle of the fluid belongs to it; among several such faces it cannot be determined.
"""

from collections.abc import Sequence
from typing import NamedTuple

from pellucid.conditions.support import Support
from pellucid.parts.body_model import BodyModel

FACES = tuple(f"{axis}-{end}" for axis in "xyz" for end in ("lower", "upper"))
NEUTRAL = 90.0
"""Contact angle of a plane of symmetry [°], at which the fluid is continued as its mirror image."""


class FaceRoles(NamedTuple):
    """Contact angles of a fluid at the faces of the grid that supports constrain along their normals, and the faces whose
    role (wall or plane of symmetry) is unknown."""

    angles: dict[str, float]
    """Contact angles [°], by the names of the faces."""
    unknown: list[str]
    """Faces that may be walls or planes of symmetry, with different contact angles."""


def find_face_roles(
    default: float,
    supports: Sequence[Support],
    bodies: Sequence[BodyModel],
    thin: tuple[bool, bool, bool],
    has_walls: bool = False,
) -> FaceRoles:
    """Return the contact angle [°] of each face of the grid that supports constrain along its normal, and the faces whose
    role is unknown.

    default: contact angle of the fluid [°]; bodies: models of the bodies; a face at which one of them is cut (`cut_at`) is
    a plane of symmetry; thin: mask of the axes along which the grid is one cell thick; has_walls: True if there are plane
    walls.
    """
    cut = {face for body in bodies for face in getattr(body, "cut_at", ())}
    angles: dict[str, float] = {}
    unknown = []
    for face in FACES:
        holding = [support for support in supports if support.face_velocity(face) is not None]
        given = [support.contact_angle for support in holding if support.contact_angle is not None]
        if not holding or thin["xyz".index(face[0])]:
            continue
        if given:
            angles[face] = given[-1]
        elif face in cut:
            angles[face] = NEUTRAL
        elif default == NEUTRAL or any(_is_wall(support, face, thin) for support in supports if support.constrains_face(face)):
            angles[face] = default
        else:
            unknown.append(face)
    if len(unknown) == 1 and not has_walls and all(angle == NEUTRAL for angle in angles.values()):
        angles[unknown.pop()] = default
    return FaceRoles(angles, unknown)


def _is_wall(support: Support, face: str, thin: tuple[bool, bool, bool]) -> bool:
    """Return True if the support makes the face (its name) a wall: no-slip, moving, with friction or opening. thin: mask of
    the axes along which the grid is one cell thick."""
    along = () if support.fix == "normal" else [axis for axis in support.fix if axis != face[0] and not thin["xyz".index(axis)]]
    return bool(along) or support.wall_friction() > 0.0 or support.lets_go() or any(support.velocity)
