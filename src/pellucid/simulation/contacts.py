"""Contacts of a case: pairs of velocity fields on the nodes of the grid, surfaces of bodies, and walls."""

import warnings
from collections.abc import Mapping, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from pellucid.bodies.material_points.grid_surface import GridSurface
from pellucid.bodies.material_points.touching import PointsAtWall
from pellucid.conditions.contact import Contact
from pellucid.conditions.symmetry import seams, symmetry_planes
from pellucid.contact.contact_body import ContactBody
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Plane, Seam
from pellucid.contact.impulses import SLIP, STICK, Friction
from pellucid.contact.overlap import coefficient, swing_of
from pellucid.contact.pairs import ContactPair, ContactPairs
from pellucid.contact.surface_pair import SurfacePair
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.touch import Touch
from pellucid.contact.triangles.pair import TrianglePair
from pellucid.contact.wall import WallContact
from pellucid.energy import WorkLayout
from pellucid.errors import CaseError, Problem
from pellucid.findings import listed
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import BoundByContact, HasContactSurface, HasPointsAtWalls
from pellucid.parts.families import GridBody
from pellucid.simulation.assembly import Built, models_by_field
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.case import Case

Surfaces = Mapping[str, ContactSurface | None]
"""Contact surfaces of bodies by name, or None for a body without a surface."""
REPORTED = 1e-3  # cells: depth from which an overlap at the start is reported
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
            _refuse_pressed(contact, body, cell, f"wall.{wall.name or number}.bodies")
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
        remedy = (
            f"Confine {body.name} by supports on faces of the grid, and list the other bodies, if there are any, in `bodies`."
        )
        raise CaseError(Problem(text, path, remedy=remedy))


def contact_parts(
    case: "Case",
    built: Built,
    fields: Sequence[VelocityField],
    layout: WorkLayout,
    going_on: Mapping[str, Mapping[str, np.ndarray]],
) -> list[StepPart]:
    """Return the parts of a step that compute contact: of velocity fields on the grid nodes, and of surfaces of bodies and
    walls. Issue a warning for each overlap of surfaces of two bodies, or of a body and a wall, at the start.

    built: the bodies, by name, with their velocity fields; layout: order of the works; going_on: arrays of the bodies that
    start in the state of an earlier run, by body, see `SurfacePairs.go_on`.
    """
    gravity, column = case.largest_gravity, layout.surface_contact
    surfaces = {} if column is None else _surfaces_of(case, built, column)
    ends = seams(case.grid) if surfaces else []
    planes = symmetry_planes(case.support, case.grid) if surfaces else []
    # a band in a plane goes on beyond its ends
    around = [*(plane for plane in planes if not case.thin[plane.axis]), *_ends_of_slice(case)]
    pairs, touching = _pairs_of(fields, built, case, surfaces, gravity, around, ends)
    for field in fields:
        if isinstance(field, OwnNodesField):
            field.touches_on_nodes = any(field in pair.fields for pair in pairs)
    touching += _self_contacts(case, surfaces, around, ends)
    walls = [] if column is None else wall_contacts(case, built, surfaces, column, gravity)
    on_grid = [(body.keeps_heat, field) for body, field in built.values() if field and isinstance(body, GridBody)]
    with_heat = {field for keeps, field in on_grid if keeps}
    on_nodes = list(dict.fromkeys(field for _, field in on_grid))
    moved = [surface for surface in surfaces.values() if isinstance(surface, GridSurface) and not surface.is_hard]
    fluids = [wall.surfaces[0] for wall in walls if isinstance(wall.surfaces[0], PointsAtWall)]
    surface_pairs = SurfacePairs(
        [*touching, *walls],
        planes if touching else [],
        ends if touching else [],
        column,
        fields=on_nodes,
        moved_by_nodes=fluids if case.time.scheme == "usf" else [*moved, *fluids],
        moved_first=moved if case.time.scheme == "usf" else [],
        on_nodes_too=len(pairs) > 0,
    )
    for body, _ in built.values():
        if isinstance(body, BoundByContact):
            body.bound_by_contact(surface_pairs.surfaces)
    surface_pairs.go_on(going_on)
    if surface_pairs:
        surface_pairs.find_start_overlaps(REPORTED * case.grid.cell)
    for overlap in surface_pairs.start_overlaps:
        if len(overlap.between) > 1:  # within one body, as beside a rim or a fold, nothing acts later for it elsewhere
            warnings.warn(overlap.text, stacklevel=3)
    remaps = case.time.transfer == "flip" and case.time.scheme == "musl"
    strained_again = [field for field in on_nodes if remaps and field not in with_heat]
    reasons = _reasons_for_nodes(case, built, pairs)
    return [ContactPairs(pairs, layout.n_supports, layout.n_loads, strained_again, reasons), surface_pairs]


def _ends_of_slice(case: "Case") -> list[Plane]:
    """Return the planes at both ends of the single cell along the thin axis of a slice, which are planes of symmetry; empty if
    the case is not a slice."""
    axes = [axis for axis, thin in enumerate(case.thin) if thin]
    if len(axes) != 1:
        return []
    (axis,), grid = axes, case.grid
    return [Plane(axis, grid.lower[axis]), Plane(axis, grid.lower[axis] + grid.cell)]


def _surfaces_of(case: "Case", built: Built, column: int) -> Surfaces:
    """Build the contact surfaces, by body name, of bodies that may touch walls or bodies of other velocity fields.

    built: the bodies, by name, with their velocity fields; column: place of the work of forces between surfaces in arrays of
    works.
    """
    able = {name: body for name, (body, _) in built.items() if has_surface(body)}
    fields = [
        {model.name for model in members if model.name in able}
        for members in models_by_field(case).values()
        if _have_surfaces([built[model.name][0] for model in members])
    ]
    names = {body.name for wall in case.wall for body in wall.touching(case.body)}.union(*(fields if len(fields) > 1 else []))
    names |= {contact.between[0] for contact in case.contact if contact.is_of_one_body}
    surfaces = {name: body.make_contact_surface(column) for name, body in able.items() if name in names}
    ends = [("xyz".index(face[0]), face.endswith("upper")) for outflow in case.outflow for face in outflow.where]
    open_faces = [(axis, float((case.grid.extent_upper() if upper else case.grid.lower)[axis])) for axis, upper in ends]
    for name, surface in surfaces.items():
        if surface is not None:
            surface.body = name
            surface.end_at(open_faces)
    return surfaces


def _pairs_of(
    fields: Sequence[VelocityField],
    built: Built,
    case: "Case",
    surfaces: Surfaces,
    gravity: float,
    planes: Sequence[Plane],
    ends: Sequence[Seam],
) -> tuple[list[ContactPair], list[Touch]]:
    """Return the contacts of each pair of velocity fields, on the nodes and by surfaces; without friction if the case does not
    list the pair.

    built: the bodies, by name, with their velocity fields; surfaces: their contact surfaces; gravity: largest gravity
    [m/s²]; planes: planes of symmetry; ends: seams of a periodic grid. Two fields are in contact by surfaces if all their
    bodies have suitable surfaces, and otherwise on the nodes of the grid, as fluids are. Membranes are in contact with each
    other by their triangles, which store the side of each contact.
    """
    members = {field: [body for body, own in built.values() if own is field] for field in fields}
    of_bodies = {body.name: body.field for body in case.body}
    names = {built[name][1]: of_field for name, of_field in of_bodies.items()}
    named = {tuple(of_bodies[name] for name in contact.between): contact for contact in case.contact}
    pairs, touching = list[ContactPair](), list[Touch]()
    for one, other in combinations(fields, 2):
        if names[one] == names[other]:  # a wall of fluids acts on them by its surface
            continue
        if (names[other], names[one]) in named:  # so that the first is the first named
            one, other = other, one
        contact = named.get((names[one], names[other]))
        found = [[surfaces.get(body.name) for body in members[field]] for field in (one, other)]
        known = [surface for surface in (*found[0], *found[1]) if surface is not None]
        serve = (
            all(_have_surfaces(members[field]) for field in (one, other))
            and len(known) == sum(has_surface(body) for field in (one, other) for body in members[field])
            and all(surface.is_hard or surface.serves_deformed for surface in known)
        )
        sheets = all(surface.two_sided for surface in known)
        if serve and not sheets:
            touching += _surface_pairs(one.grid, found, contact, gravity, case, ends)
        elif serve and all(surface.triangles is not None for surface in known):
            touching += _triangle_pairs(found, contact, case, planes, ends)
        else:
            met = {field: [met for body in bodies if (met := body.contact_body)] for field, bodies in members.items()}
            pairs.append(_pair((one, other), met, contact))
    return pairs, touching


def has_surface(body: Body) -> TypeGuard[HasContactSurface]:
    """Return True if a body can make a contact surface, by which other bodies can have contact with this body."""
    return isinstance(body, HasContactSurface) and body.has_surface()


def _have_surfaces(bodies: Sequence[Body]) -> bool:
    """Return True if the bodies of a velocity field have contact by surfaces only, not on grid nodes: each body has a
    contact surface, or lies within a body with a contact surface."""
    having = [body for body in bodies if has_surface(body)]
    return all(has_surface(body) or any(other.encloses(body.places()) for other in having) for body in bodies)


def _triangle_pairs(
    found: Sequence[Sequence[ContactSurface | None]],
    contact: Contact | None,
    case: "Case",
    planes: Sequence[Plane],
    ends: Sequence[Seam],
) -> list[TrianglePair]:
    friction, name = _friction_and_name(contact)
    how = friction, courant_of(case), case.time.step or 0.0, name, planes, ends
    known = [(a, b) for a, b in product(*found) if a is not None and b is not None]
    return [TrianglePair(a, b, *how) for a, b in known if not (a.is_hard and b.is_hard)]


def _self_contacts(case: "Case", surfaces: Surfaces, planes: Sequence[Plane], ends: Sequence[Seam]) -> list[TrianglePair]:
    """Return the contacts of bodies with themselves. A body whose motion is prescribed has none.

    surfaces: contact surfaces by body name; planes: planes of symmetry; ends: seams of a periodic grid.
    """
    pairs = []
    for number, contact in enumerate(case.contact):
        surface = surfaces.get(contact.between[0])
        if contact.is_of_one_body and surface is not None and not surface.is_hard:
            friction, _ = _friction_and_name(contact)
            how = friction, courant_of(case), case.time.step or 0.0, None, planes, ends
            pair = TrianglePair(surface, surface, *how)
            _refuse_without_side(pair, contact.between[0], f"contact.{number}.between")
            pairs.append(pair)
    return pairs


def _refuse_without_side(pair: TrianglePair, name: str, path: str) -> None:
    """Raise CaseError if layers of a body coincide at the start, since the side on which each lies is then unknown.

    pair: contact of the body with itself; name: name of the body; path: location of the contact in the case.
    """
    place = pair.place_without_side()
    if place is not None:
        x, y, z = place.tolist()
        text = f"layers of body {name} coincide at ({x:.4g}, {y:.4g}, {z:.4g}) m, so their sides in contact are undefined"
        remedy = "Separate the layers by at least 0.01 of the thickness; contact acts after they have opened."
        raise CaseError(Problem(text, path, remedy=remedy))


def _friction_and_name(contact: Contact | None) -> tuple[float, str | None]:
    return (0.0, None) if contact is None else (coefficient(contact.kind, contact.friction), contact.name)


def _surface_pairs(
    grid: Grid,
    found: Sequence[Sequence[ContactSurface | None]],
    contact: Contact | None,
    gravity: float,
    case: "Case",
    ends: Sequence[Seam],
) -> list[SurfacePair]:
    friction, name = _friction_and_name(contact)
    dimension = 2 - sum(grid.thin)
    pairs = []
    for one, other in product(*found):
        if one is not None and other is not None:
            swing = swing_of(grid.lattice.cell, gravity, one.speed() + other.speed())
            steps = courant_of(case), swing, name, grid.lattice.cell, ends, case.time.step or 0.0
            how = friction, dimension, grid.slice_thickness, *steps
            pairs.append(SurfacePair((one, other), *how))
            _refuse_out_of_sight(pairs[-1])
    return pairs


def _refuse_out_of_sight(pair: SurfacePair) -> None:
    """Raise CaseError if the distance at which contact between two surfaces begins (the sum of their contact offsets) exceeds
    the distance up to which contact between them is detected."""
    if pair.distance <= pair.sight:
        return
    thick = max(pair.surfaces, key=lambda surface: float(np.max(surface.half_width)))
    text = (
        f"the contact distance of {' and '.join(pair.between)} is {pair.distance:.4g} m (sum of their contact offsets), but "
        f"with these faces and cells contact is detected only up to {pair.sight:.4g} m"
    )
    remedy = "Set a smaller `contact_offset` (default: half of `thickness`), or use coarser faces on both bodies."
    raise CaseError(Problem(text, f"body.{thick.body}.contact_offset", remedy=remedy))


def _pair(
    fields: tuple[VelocityField, VelocityField],
    bodies: Mapping[VelocityField, Sequence[ContactBody]],
    contact: Contact | None,
) -> ContactPair:
    sides = bodies[fields[0]], bodies[fields[1]]
    if contact is None:
        return ContactPair(fields, sides, Friction(SLIP))
    kind = STICK if contact.kind == "stick" else SLIP
    return ContactPair(fields, sides, Friction(kind, contact.friction or 0.0), contact.name)


def _reasons_for_nodes(case: "Case", built: Built, pairs: Sequence[ContactPair]) -> list[str]:
    """Return a message for each pair of velocity fields with solids or membranes that are in contact on the nodes of the grid.

    Contact of fluids is not reported, since fluids are always in contact on the nodes. built: all bodies, by name; pairs:
    the contacts on nodes.
    """
    lines = []
    for pair in pairs:
        members = [[model for model in case.body if built[model.name][1] is field] for field in pair.fields]
        sides = [[model for model in models if not model.is_fluid] for models in members]
        if all(sides):
            names = " and ".join(listed([model.name for model in side]) for side in sides)
            reason, remedy = _explain(members, built)
            lines.append(
                f"contact: {names} touch on the nodes of the grid, since {reason}: bodies that slide or roll there lose "
                f"some per cent of their speed; {remedy}"
            )
    return lines


def _explain(members: Sequence[Sequence[BodyModel]], built: Built) -> tuple[str, str]:
    """Return the reason why the bodies of two velocity fields are in contact on the grid nodes and not by surfaces, and a
    remedy.

    members: models of the bodies of each field; built: all bodies, by name.
    """
    for models in members:
        for model in models:
            if not model.is_fluid and not has_surface(built[model.name][0]):
                return f'body {model.name}, of kind "{model.kind}", has no contact surface', model.remedy_for_node_contact
    for models in members:
        solids, fluids = ([model for model in models if model.is_fluid is wanted] for wanted in (False, True))
        if fluids and solids:
            inner, outer = (listed([model.name for model in some]) for some in (solids, fluids))
            return (
                f"the velocity field of {inner} also contains the fluid outside of it ({outer})",
                "use another `field` for the fluid outside, or a smaller grid.cell",
            )
    return "two membranes of these kinds have no common contact", "use membranes of elements for both, or a smaller grid.cell"
