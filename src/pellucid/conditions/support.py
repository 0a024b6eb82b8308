"""Data model of supports: nodes with prescribed velocity."""

from collections.abc import Iterator, Sequence
from itertools import product
from math import inf
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import field_validator

from pellucid.energy import FRICTION_HEAT, IMPACT_HEAT, Channel
from pellucid.findings import Finding, Path, Reason, listed
from pellucid.geometry.region import (
    CONSTRAINS_NOTHING,
    EVERY_AXIS,
    NOWHERE,
    Region,
    Selectable,
    Shape,
    Where,
    chosen_nodes,
    faults,
    needs_mesh,
)
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.geometry.shapes.rotation import plane_problems
from pellucid.grid.model import GridCase
from pellucid.model import Vector, check, name_parameter, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel, is_alone, selectable_of
from pellucid.parts.condition import Condition, LoadKind
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart
from pellucid.units import in_degrees

Face = Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"]
Axis = Literal["x", "y", "z"]


class Support(Condition):
    """Prescribed nodal velocity. `fix = "normal"` on a face is a symmetry plane or slip wall; a velocity moves the wall.

    A wall with `friction` or `stick` resists sliding of bodies in contact. A wall with `opens` releases bodies that move
    away.
    """

    load_kind: ClassVar[LoadKind] = "dead"
    name: str | None = name_parameter("name of the support, for probes of its reaction", None)
    body: str | None = parameter(
        "",
        "name of a body with its own nodes, to constrain only these. Default: the nodes of the grid and of "
        "all bodies with their own nodes; for "
        "regions by named set, normal or boundary, the nodes of the only body",
        None,
    )
    where: Literal["all-nodes"] | Face | tuple[Face, ...] | Where = parameter(
        "", "constrained nodes: all-nodes, a face of the grid, a list of faces, or a region"
    )
    fix: tuple[Axis, ...] | Literal["normal"] = parameter("", "constrained directions", ("x", "y", "z"))
    velocity: Vector = parameter(
        "m/s", "velocity of the constrained directions; a wall with friction also drags along its plane", (0.0, 0.0, 0.0)
    )
    friction: float | None = parameter(
        "",
        'friction coefficient μ of a wall (`fix = "normal"`) in contact; default: frictionless',
        None,
        ge=0,
    )
    stick: bool = parameter("", "true: no sliding on a wall in contact", False)
    opens: bool | None = parameter(
        "",
        "true: bodies can separate from the wall; false: the wall also holds bodies that move away; default: "
        "true for a wall with friction, else false",
        None,
    )
    contact_angle: float | None = parameter(
        "",
        "contact angle of fluids with surface tension at this face, measured within the fluid, in degrees, "
        "or a text with a unit: angle "
        "at a wall, or 90 for a plane of symmetry; default: angle given for the fluid, if the face can only be a wall",
        None,
        ge=0,
        le=180,
    )

    _in_degrees = field_validator("contact_angle", mode="before")(in_degrees)

    until: float | None = parameter(
        "s", "time at which the support releases the nodes: 0 for a support that acts only during settling", None, ge=0
    )

    @field_validator("fix")
    @classmethod
    def _something_is_fixed(cls, fix: tuple[Axis, ...] | Literal["normal"]) -> tuple[Axis, ...] | Literal["normal"]:
        if not fix:
            raise ValueError('`fix` is empty; list some of "x", "y", "z", or remove the support')
        return fix

    @field_validator("where")
    @classmethod
    def _names_a_face(cls, where: Any) -> Any:
        if where == ():
            raise ValueError('`where` is empty; list faces, such as "x-lower", or remove the support')
        return where

    @check
    def _normal_needs_a_face(self) -> None:
        if self.fix == "normal" and not self.faces() and self.wall_of_fluids() is None:
            raise ValueError(
                'fix = "normal" needs a face of the grid as `where`, such as "x-lower", or a shape without the keys `body` and '
                "`until`"
            )

    def _wall_keys(self) -> list[str]:
        """Return the names of the given keys that make the support a wall with friction or an opening wall (which bodies can
        leave)."""
        given = {"friction": self.friction is not None, "stick": self.stick, "opens": self.opens is not None}
        return [key for key, is_given in given.items() if is_given]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body without its own nodes, a face that does not exist, a region without nodes, and
        invalid keys of friction or opening. path: location of the condition in the case; parts: all parts of the case."""
        yield from self._face_problems((*path, "where"), parts)
        yield from self._yielding_problems(path, parts)
        yield from self._slip_problems((*path, "fix"), parts)
        yield from self._velocity_problems(path, parts)
        yield from self._wetting_problems((*path, "contact_angle"), parts)
        films = [body for body in parts.of(BodyModel) if body.has_own_step and body.owns_nodes(is_alone(body, parts))]
        if self.until is not None and (held := [body.name for body in films if self.body in (None, body.name)]):
            text = f"the nodes of {held[0]} cannot be released during a run, since it has its own substeps"
            yield Finding((*path, "until"), text, "remove `until`, or name another body in `body`")
        bodies = parts.of(BodyModel) if self.body is None else [parts.named(BodyModel, self.body)]
        fixed = [body.name for body in bodies if body is not None and not body.moves]
        if fixed and len(fixed) == len(bodies) and parts.are_sound(BodyModel):
            yield Finding(
                (*path, "body"), f"body {fixed[0]} does not move, so a support has no effect on it", "remove this support"
            )
        elif self.body is not None:
            yield from self._body_problems(self.body, path, parts)
        elif self._means_a_body:
            yield from self._only_body_problems(path, parts)
        elif parts.lacks_grid:
            yield from self._nothing_problems((*path, "where"), parts)
        elif parts.grid is not None and isinstance(self.where, Region):
            yield from plane_problems(self.where.rotate, (*path, "where"), parts.active_axes)
            if self.where.outside is not None and any(parts.grid.thin()):
                text = "the grid is one cell thick, and a closed surface has an inside only in space"
                yield Finding((*path, "where", "outside"), text, "use shapes, such as boxes and cylinders, or a grid in space")
            if self.where.box is not None and (shape := self.where.shape) is not None:
                yield from self._box_problems((*path, "where", "box"), *shape.geometry().bounds(), parts.grid)

    def _slip_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding about a shape on which fluids slip in a case with bodies that cannot slip on it. path: location in
        the case for the finding; parts: all parts of the case."""
        bodies = parts.of(BodyModel)
        if not self.slips() or not parts.are_sound(BodyModel):
            return
        for body in bodies:
            of_field = [other for other in bodies if other.field == body.field]
            alone = not any(other.is_fluid for other in of_field)
            slips = body.is_fluid or ((body.is_rigid or body.is_surface) and not alone)
            if not (slips or body.owns_nodes(is_alone(body, parts))):
                text = f"only fluids, and membranes and rigid bodies with them, slip on a shape, but not body {body.name}"
                remedy = "remove `fix`, so that bodies stick to the shape, use a face of the grid, or a [[wall]] for contact"
                yield Finding(path, text, remedy)
                return

    def _face_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about faces that do not exist or are named twice. path: location in the case for the findings;
        parts: all parts of the case."""
        if self.faces():
            yield from parts.no_grid(path, "faces belong to a grid")
        for number, face in enumerate(self.faces()):
            here = (*path, number) if isinstance(self.where, tuple) else path
            yield from parts.seam(here, face)
            if face in self.faces()[:number]:
                yield Finding(here, f"the face {face} is listed twice", "remove one of the two")
            elif self.fix != "normal" and parts.grid is not None and not parts.active_axes["xyz".index(face[0])]:
                text = f"the grid is one cell thick along {face[0]}: all of its nodes lie on the face {face}"
                yield Finding(here, text, 'remove it, or use "all-nodes"')

    def _wetting_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a contact angle where there is no wall or no surface tension, and different angles on one
        face. path: location in the case for the findings; parts: all parts of the case."""
        if self.contact_angle is None:
            return
        held = [face for face in self.faces() if self.face_velocity(face) is not None]
        if len(held) < len(self.faces()) or not held:
            text = "only a face of the grid that is constrained along its normal for all bodies can have a contact angle"
            yield Finding(path, text, 'set fix = "normal", with a face as `where` and no `body`, or remove the contact angle')
        elif not parts.sections["surface_tension"].items:
            text = "no fluid in this case has surface tension"
            yield Finding(
                path, text, "add a [[surface_tension]] with the name of a fluid as `body`, or remove the contact angle"
            )
        for place, other in parts.placed(Support):
            same = [face for face in held if other.face_velocity(face) is not None]
            if same and place < path[:-1] and other.contact_angle not in (None, self.contact_angle):
                text = (
                    f"support number {int(place[1]) + 1} sets the contact angle {other.contact_angle:g} on the face "
                    f"{listed(same)}"
                )
                yield Finding(path, text, "set one contact angle per face")

    def _velocity_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings if another support prescribes a different velocity of the same face along the same axis. path:
        location of the condition in the case; parts: all parts of the case."""
        for place, other in parts.placed(Support):
            meets = self.body is None or other.body in (None, self.body)
            if place >= path or not meets or self.until is not None or other.until is not None:
                continue
            for one, before in product(self.on_each_face(), other.on_each_face()):
                same = one.faces() and one.faces() == before.faces()
                for axis in range(3) if same else ():
                    velocity, given = self.velocity[axis], other.velocity[axis]
                    if one.axes()[axis] and before.axes()[axis] and velocity != given and parts.active_axes[axis]:
                        text = (
                            f"support number {int(place[1]) + 1} prescribes {given:g} m/s along {'xyz'[axis]} on the face "
                            f"{listed(one.faces())}, and this one {velocity:g} m/s"
                        )
                        remedy = f"remove the face {listed(one.faces())} from one of the two, or give both the same velocity"
                        yield Finding((*path, "velocity"), text, remedy)
                        return

    def _yielding_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about keys of friction or opening that contradict each other, on supports that are not walls, or
        for bodies that they cannot act on. path: location of the condition in the case; parts: all parts of the case."""
        keys = self._wall_keys()
        if keys and (self.fix != "normal" or not self.faces()):
            kind = "a shape" if self.slips() else "a clamp"
            text = f"only a face of the grid that is constrained along its normal can have friction or open; this is {kind}"
            yield Finding((*path, keys[0]), text, f'set fix = "normal", with a face as `where`, or remove {keys[0]}')
            return
        if self.friction is not None and self.stick:
            text = "a wall with `stick` has no sliding, so `friction` has no effect"
            yield Finding((*path, "stick"), text, "remove one of the two")
        for place, other in parts.placed(Support):
            same = [face for face in self.faces() if face in other.faces()]
            meets = self.body is None or other.body in (None, self.body)
            if keys and same and meets and place < path and other._wall_keys():
                text = f"support number {int(place[1]) + 1} already sets friction or opening of {listed(same)}"
                yield Finding((*path, keys[0]), text, "set friction and opening once per face, or for different bodies")
                break
        yields = keys and (self.lets_go() or self.wall_friction() > 0.0)
        for body in parts.of(BodyModel) if yields else []:
            if self.body not in (None, body.name):
                continue
            alone = is_alone(body, parts)
            reason = _why_no_yielding_wall(body, alone)
            if reason is not None:
                yield Finding((*path, keys[0]), *reason)
            elif self.opens is False and body.owns_nodes(alone):
                text = f"body {body.name} has its own nodes; a wall that holds them cannot have friction"
                yield Finding((*path, "opens"), text, "remove `opens`: bodies separate from a wall with friction by default")

    @property
    def _means_a_body(self) -> bool:
        """True if the region refers to the mesh of a body (named set, normal or boundary)."""
        region = self.region()
        return region is not None and needs_mesh(region)

    def _only_body_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the region refers to the mesh of a body (named set, normal or boundary), but the support names
        no body and the case has no single body with its own nodes. path: location of the condition in the case; parts: all
        parts of the case."""
        text, bodies = 'named sets, normals and "boundary" belong to a body', parts.of(BodyModel)
        if len(parts.names(BodyModel)) > 1:
            yield Finding(path, f"{text}, and the case has {listed(parts.names(BodyModel))}", "name one of them as `body`")
        elif len(bodies) == 1 and not bodies[0].owns_nodes(alone=True):
            text = f"{text} with nodes of its own, but {bodies[0].name} moves with the nodes of the grid"
            yield Finding((*path, "where"), text, "select the nodes by a shape, or by a face of the grid")
        elif len(bodies) == 1:
            yield from self._body_problems(bodies[0].name, path, parts)

    def _body_problems(self, name: str, path: Path, parts: Parts) -> Iterator[Finding]:
        yield from parts.unknown(BodyModel, (*path, "body"), name)
        body, region = parts.named(BodyModel, name), self.region()
        if body is None:
            return
        if not body.owns_nodes(is_alone(body, parts)):
            text = f"body {name} has no nodes of its own: it moves with the nodes of the grid"
            yield Finding((*path, "body"), text, "remove `body`, to constrain the nodes of the grid")
        elif region is not None and (nodes := selectable_of(body, parts)) is not None:
            yield from faults(region, nodes, (*path, "where"), name, parts.active_axes)

    def _nothing_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the support, not restricted to one body, constrains no node; only for cases without a grid in
        which all nodes are known. path: location in the case for the finding; parts: all parts of the case."""
        region = self.region()
        nodes = [selectable_of(body, parts) for body in parts.of(BodyModel)]
        known = [selectable for selectable in nodes if selectable is not None]
        if region is None or not parts.are_sound(BodyModel) or len(known) < len(nodes):
            return
        if not any(chosen_nodes(region, of, parts.active_axes).any() for of in known):
            yield Finding(path, CONSTRAINS_NOTHING, NOWHERE)

    @staticmethod
    def _box_problems(path: Path, lower: np.ndarray, upper: np.ndarray, grid: GridCase) -> Iterator[Finding]:
        ends = zip("xyz", lower, upper, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
        for axis, low, high, grid_low, grid_high, thin in ends:
            if not (thin or axis in grid.periodic) and (high < low or high < grid_low or low > grid_high):
                box, nodes = f"{low:g} to {high:g} m", f"{grid_low:g} to {grid_high:g} m"
                text = f"the box contains no node: it covers {axis} from {box}, but the grid from {nodes}"
                yield Finding(path, text, "move or enlarge the box to overlap the grid")

    def channels(self) -> Sequence[Channel]:
        """Return the channels (entries of the energy balance) that a support needs: kinetic energy lost when points take
        the velocity of the support, and friction heat."""
        clamps = self.body is None and (not self.faces() or self.lets_go())
        return (*([IMPACT_HEAT] if clamps else []), *([FRICTION_HEAT] if self.wall_friction() > 0.0 else []))

    @classmethod
    def activate(cls, conditions: Sequence["Support"], assembly: Assembly) -> Sequence[StepPart]:
        """Constrain nodes of all grids, also along axes where the grid is one cell thick, and nodes of bodies with their own
        nodes; return the supports, no-slip walls and opening walls as parts of the step."""
        from pellucid.conditions.constrained_nodes import ActiveSupports, open_walls
        from pellucid.conditions.no_slip_walls import no_slip_walls

        only = {"body": next(iter(assembly.bodies))}  # for supports that refer to a body but do not name it
        known = [one.model_copy(update=only) if one.body is None and one._means_a_body else one for one in conditions]
        active = ActiveSupports(known, assembly)
        return [active, *no_slip_walls(active.supports, assembly), *open_walls(active.supports, assembly)]

    def reaction(self) -> str | None:
        return self.name

    def constrains_face(self, face: str) -> bool:
        return face in self.faces() and self.body is None

    def face_velocity(self, face: str) -> Vector | None:
        held = self.constrains_face(face) and (self.fix == "normal" or face[0] in self.fix)
        return self.velocity if held else None

    def holds(self, nodes: Selectable, axis: int, active: ActiveAxes, reach: float) -> np.ndarray:
        """Return a mask of the grid nodes that the region of the support constrains along an axis, shape (n,); all False for
        a support without a region or with a body.

        nodes: nodes from which the region selects; active: mask of the axes along which the grid is more than one cell
        thick; reach: distance by which nodes may lie outside a box [m].
        """
        region = self.region()
        if region is None or needs_mesh(region) or self.body is not None or not self.axes()[axis]:
            return np.zeros(len(nodes.position), bool)
        return chosen_nodes(region, nodes, active, reach)

    def region(self) -> Where | None:
        """Return the region whose nodes the support constrains; None for all nodes or a face of the grid."""
        return self.where if isinstance(self.where, Region) else "boundary" if self.where == "boundary" else None

    def holds_all(self, active: ActiveAxes = EVERY_AXIS) -> bool:
        """Return True if the support constrains nodes along all `active` axes (the grid is more than one cell thick there)."""
        return self.fix != "normal" and {name for name, counts in zip("xyz", active, strict=True) if counts} <= set(self.fix)

    def wall_of_fluids(self) -> Shape | None:
        """Return the shape whose surface stops fluids, see `pellucid.conditions.no_slip_walls`; None if the support makes no
        such wall."""
        region = self.region()
        if not isinstance(region, Region) or region.needs_mesh or self.body is not None or self.until is not None:
            return None
        return region.shape

    def slips(self) -> bool:
        """Return True for a shape on whose surface fluids slip."""
        return self.fix == "normal" and not self.faces()

    def acts_as_wall_among(self, bodies: Sequence[BodyModel]) -> bool:
        """Return True if the shape of the support stops the fluids of a velocity field with these bodies at its surface: the
        field has fluids, which must be viscous unless they slip on the shape, and beside them only rigid bodies, membranes
        and bodies that act as walls themselves."""
        if self.wall_of_fluids() is None:
            return False
        bodies = [body for body in bodies if not body.is_wall]
        flows = [body.is_fluid and not body.is_rigid and (self.slips() or body.shear_viscosity > 0.0) for body in bodies]
        rest = (body for one, body in zip(flows, bodies, strict=True) if not one)
        return any(flows) and all(body.is_rigid or body.is_surface for body in rest)

    def wall_friction(self) -> float:
        """Return the friction coefficient of the wall; 0 without friction, infinite for `stick`."""
        return inf if self.stick else self.friction or 0.0

    def lets_go(self) -> bool:
        """Return True for an opening wall, i.e. a wall that does not hold bodies that move away from it."""
        return self.wall_friction() > 0.0 if self.opens is None else self.opens

    def label(self, number: int) -> str:
        """Return the label of the support in messages; `number` counts the supports of the case from 0."""
        return f"support `{self.name}`" if self.name else f"support number {number + 1}"

    def faces(self) -> tuple[Face, ...]:
        """Return the names of the faces of the grid that the support constrains."""
        if isinstance(self.where, tuple):
            return self.where
        if isinstance(self.where, Region) or self.where == "all-nodes" or self.where == "boundary":
            return ()
        return (self.where,)

    def on_each_face(self) -> "list[Support]":
        """Return one support for each listed face of the grid, or only the support itself without a list of faces."""
        return [self.model_copy(update={"where": face}) for face in self.where] if isinstance(self.where, tuple) else [self]

    # of a support on at most one face

    def axes(self) -> tuple[bool, bool, bool]:
        """Return for x, y and z True if the support constrains this direction."""
        face = self.face()
        if self.fix == "normal":
            return (True, True, True) if face is None else (face[0] == 0, face[0] == 1, face[0] == 2)
        return "x" in self.fix, "y" in self.fix, "z" in self.fix

    def face(self) -> tuple[int, int] | None:
        """Return the axis and the end (0 lower, 1 upper) of the face of the grid on which the support acts, or None. Raises
        ValueError for a list of faces."""
        if isinstance(self.where, tuple):
            raise ValueError(f"a support of the faces {listed(self.where)} is on more than one face; call on_each_face() first")
        return next((("xyz".index(face[0]), ("lower", "upper").index(face[2:])) for face in self.faces()), None)


def on_each_face(supports: Sequence[Support]) -> list[Support]:
    """Return the supports, split so that each acts on at most one face of the grid."""
    return [one for support in supports for one in support.on_each_face()]


def _why_no_yielding_wall(body: BodyModel, alone: bool) -> Reason | None:
    """Return the reason why walls cannot have friction with the body or open (release it when it moves away), or None;
    alone: True if no other body is in its velocity field."""
    if body.is_rigid:
        remedy = 'use a [[wall]] with `kind = "coulomb"` and `friction`, or with `kind = "stick"`, instead of this support'
        return Reason(f"body {body.name} is rigid: supports act on it as frictionless walls only", remedy)
    if body.moves and body.owns_nodes(alone) and not body.own_material_nodes:
        remedy = "remove this key, and model the floor as a body held by a motion, with a `field` of its own and a [[contact]]"
        return Reason(f"body {body.name} has its own nodes, for which supports have no friction and do not open", remedy)
    if (stress := body.implicit_stress) is not None:
        text = f"the viscosity of body {body.name} is implicit, so walls with friction or openings are not possible"
        key = "implicit_pressure" if stress.stiffness > 0.0 else "implicit_viscosity"
        return Reason(text, f"remove friction and opening of the wall, or `{key}` of the body")
    return None
