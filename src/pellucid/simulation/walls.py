"""Walls that are planes without a body, and the bodies that touch them."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.wall import Wall
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.overlap import coefficient, swing_of
from pellucid.contact.wall import WallContact, WallPlane
from pellucid.errors import CaseError, Problem
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.simulation.assembly import Built, Surfaces
from pellucid.simulation.overlap import DEPTH

if TYPE_CHECKING:
    from pellucid.case import Case

MOST_PRESSED = 0.1  # of a cell, by which the pressure of a fluid at the start may press it into a wall


def touching_names(wall: Wall, models: Sequence[BodyModel]) -> list[str]:
    """The bodies that touch a wall: those that it names, or all that can."""
    return [model.name for model in models if model.name in wall.bodies or not (wall.bodies or model.why_no_wall())]


def wall_contacts(
    case: "Case",
    built: Built,
    surfaces: Surfaces,
    column: int | None,
    gravity: float,
    going_on: AbstractSet[str] = frozenset(),
) -> list[WallContact]:
    """Each wall of a case with the bodies that touch it, but for those that follow a motion as a whole: nothing pushes them.

    column: of the work of contact between surfaces; gravity: largest [m/s²]. going_on: names of the bodies that begin in the
    state of an earlier run. Raises CaseError where another body starts behind a wall.
    """
    if case.grid_or_none is None or column is None:
        return []
    contacts, cell = [], case.grid.cell
    for number, wall in enumerate(case.wall):
        for name in touching_names(wall, case.body):
            body, plane = built[name][0], wall.plane()
            surface = surfaces.get(name) or body.make_points_at(plane, column)
            if surface is None or (surface.is_hard and surface.rigid_mass == np.inf):
                continue
            swing = 0.0
            if surface.rigid_mass < np.inf:
                swing = swing_of(cell, gravity, surface.speed() + float(np.linalg.norm(plane.velocity)))
            friction = coefficient(wall.kind, wall.friction)
            contact = WallContact(surface, plane, friction, case.time.courant, swing, wall.name)
            _refuse_pressed(contact, body, cell, f"wall.{number}.bodies")
            if name not in going_on:
                _refuse_overlap(surface, plane, name, cell, f"wall.{number}.point")
            contacts.append(contact)
    return contacts


def _refuse_overlap(surface: ContactSurface, plane: WallPlane, name: str, cell: float, path: str) -> None:
    depth = surface.half_width - plane.height(surface.place)
    if len(depth) and depth.max() > DEPTH * cell:
        deepest = int(depth.argmax())
        place = ", ".join(f"{value:.4g}" for value in surface.place[deepest])
        text = (
            f"body {name} starts behind this wall, at ({place}) m by {depth[deepest]:.4g} m; at most a quarter of a cell, "
            f"{DEPTH * cell:.4g} m, is allowed"
        )
        remedy = "move one of the two, turn `normal` to the side where bodies are, or name in `bodies` those that touch it"
        raise CaseError(Problem(text, path, remedy=remedy))


def _refuse_pressed(contact: WallContact, body: Body, cell: float, path: str) -> None:
    """Refuse a fluid whose pressure at the start alone would press it deep into the wall: a gas."""
    surface = contact.surfaces[0]
    if surface.drag is None:
        return
    pressed = float(np.max(body.field("pressure"))) / contact.law.stiffness / cell
    if pressed > MOST_PRESSED:
        text = (
            f"the pressure of body {body.name} at the start would press it {pressed:.2g} cells into the wall, which gives way "
            f"as a layer of the fluid does; at most {MOST_PRESSED:g} is allowed: a gas cannot touch a wall"
        )
        remedy = "name other bodies in `bodies`, and hold this one by supports on faces of the grid"
        raise CaseError(Problem(text, path, remedy=remedy))
