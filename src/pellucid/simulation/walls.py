"""Walls, i.e. planes without a body, and the bodies in contact with them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.overlap import coefficient, swing_of
from pellucid.contact.wall import WallContact
from pellucid.errors import CaseError, Problem
from pellucid.parts.body import Body
from pellucid.parts.capabilities import HasPointsAtWalls
from pellucid.simulation.assembly import Built

if TYPE_CHECKING:
    from pellucid.case import Case

Surfaces = Mapping[str, ContactSurface | None]
"""Contact surfaces of bodies by name, or None for a body without a surface."""
MOST_PRESSED = 0.1  # largest depth [cells] to which the initial pressure of a fluid may press it into a wall


def wall_contacts(
    case: "Case",
    built: Built,
    surfaces: Surfaces,
    column: int,
    gravity: float,
) -> list[WallContact]:
    """Return the contacts of each wall of a case with bodies. Bodies whose motion is fully prescribed are left out, since
    contact does not affect their motion.

    built: the bodies, by name, with their velocity fields; surfaces: contact surfaces by body name; column: place of the
    work of contact between surfaces in arrays of works; gravity: largest gravity [m/s²]. Raises CaseError if a gas is in
    contact with a wall.
    """
    contacts, cell = [], case.grid.cell
    # sums over walls must not depend on the order of the tables
    for number, wall in sorted(enumerate(case.wall), key=lambda item: (item[1].normal, item[1].point, item[1].velocity)):
        for model in wall.touching(case.body):
            body, plane = built[model.name][0], wall.plane()
            surface = surfaces.get(model.name)
            if surface is None and isinstance(body, HasPointsAtWalls):
                surface = body.make_points_at(plane, column)
            if surface is None or (surface.is_hard and surface.rigid_mass == np.inf):
                continue
            swing = 0.0
            if surface.rigid_mass < np.inf:
                swing = swing_of(cell, gravity, surface.speed() + float(np.linalg.norm(plane.velocity)))
            friction = coefficient(wall.kind, wall.friction)
            contact = WallContact(surface, plane, friction, courant_of(case), swing, wall.name, cell, case.time.step or 0.0)
            contact.label, surface.body = f"wall {wall.name or number}", model.name
            _refuse_pressed(contact, body, cell, f"wall.{number}.bodies")
            contacts.append(contact)
    return contacts


def courant_of(case: "Case") -> float:
    """Return the Courant number of a case, i.e. the length of its steps relative to the largest stable step."""
    return case.steady.courant if case.steady else case.time.courant


def _refuse_pressed(contact: WallContact, body: Body, cell: float, path: str) -> None:
    """Raise CaseError for a fluid whose initial pressure alone would press its points deep into a wall, i.e. a gas.

    contact: contact of the fluid (`body`) with the wall; cell: edge length of the cells [m]; path: location of the wall in
    the case.
    """
    surface = contact.surfaces[0]
    if surface.drag is None:
        return
    pressed = float(np.max(body.field("pressure"))) / contact.law.stiffness / cell
    if pressed > MOST_PRESSED:
        text = (
            f"the initial pressure of body {body.name} would press it {pressed:.2g} cells into the wall (limit: "
            f"{MOST_PRESSED:g}), because the wall is as compliant as a layer of the fluid; a gas cannot be in contact "
            "with a wall"
        )
        remedy = "List the other bodies in `bodies`, and confine this one by supports on faces of the grid."
        raise CaseError(Problem(text, path, remedy=remedy))
