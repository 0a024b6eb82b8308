"""Data model of the surface tension of a fluid of material points, and the roles of the faces of the grid in it."""

from collections.abc import Iterator, Mapping, Sequence
from math import pi, sqrt
from typing import ClassVar, NamedTuple, Self

from pydantic import PrivateAttr, field_validator

from pellucid.conditions.support import Support
from pellucid.conditions.wall import Wall
from pellucid.energy import SURFACE_ENERGY, SURFACE_TENSION_WORK, Channel
from pellucid.findings import Finding, Path, Reason, listed
from pellucid.grid.model import GridCase
from pellucid.model import parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition, Swing
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart
from pellucid.units import in_degrees

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


FUNCTIONS = "quadratic-bspline"


class SurfaceTension(Condition):
    """Surface tension of a fluid of material points, and its contact angle at walls."""

    swings_as: ClassVar[Swing] = Swing("capillary", "its shortest capillary waves cross a cell")
    losses: ClassVar[Sequence[Channel]] = (SURFACE_ENERGY,)

    body: str = parameter("", "name of a fluid of material points")
    tension: float = parameter("N/m", "surface tension σ", gt=0)
    contact_angle: float = parameter(
        "",
        "contact angle at walls whose support sets none, measured within the fluid, in degrees, or a text with a unit such as "
        '"1 rad"; for a face constrained along its normal only, which may be a plane of symmetry, set the angle in its support',
        NEUTRAL,
        ge=0,
        le=180,
    )

    _in_degrees = field_validator("contact_angle", mode="before")(in_degrees)
    _angles: dict[str, float] = PrivateAttr(default_factory=dict)

    _walls: list[tuple[Wall, float]] = PrivateAttr(default_factory=list)

    @property
    def walls(self) -> Sequence[tuple[Wall, float]]:
        """Plane walls at rest in contact with the fluid, with their contact angles [°]; known once `in_case` has placed the
        condition in a case."""
        return self._walls

    @property
    def angles(self) -> Mapping[str, float]:
        """Contact angles [°] at the faces of the grid, by name of the face; known once `in_case` has placed the condition
        in a case."""
        return self._angles

    def in_case(self, bodies: Sequence[BodyModel], conditions: Sequence[Condition], thin: tuple[bool, bool, bool]) -> Self:
        supports = [condition for condition in conditions if isinstance(condition, Support)]
        walls = [condition for condition in conditions if isinstance(condition, Wall)]
        copy = self.model_copy()
        copy._angles = find_face_roles(self.contact_angle, supports, bodies, thin, bool(walls)).angles
        copy._walls = [
            (wall, self.contact_angle if wall.contact_angle is None else wall.contact_angle)
            for wall in walls
            if not wall.advances and any(body.name == self.body for body in wall.touching(bodies))
        ]
        return copy

    def rate(self, density: float, cell: float) -> float:
        """Return the frequency scale of the shortest capillary waves on the grid [1/s], the inverse of their step limit
        (Brackbill, Kothe & Zemach 1992, J. Comput. Phys. 100, 335, eq. 61, for a fluid of this density [kg/m³] next to
        vacuum); cell: cell size [m]."""
        return sqrt(4.0 * pi * self.tension / (density * cell**3))

    def load_channel(self) -> str:
        """Return the name of the channel (entry of the energy balance) for the work of surface tension. This work is
        exchanged with the surface energy, so that it does not change the total energy."""
        return SURFACE_TENSION_WORK.name

    def columns(self) -> Mapping[str, str]:
        return {f"{self.body}_surface_energy": "J"}

    def swing_of(self, body: BodyModel, rate: float, cell: float | None) -> float:
        if body.name != self.body or cell is None:
            return 0.0
        return self.rate(body.material.density, cell)

    def why_not_steady(self) -> Reason | None:
        """Return the reason why no steady state can be computed: the relaxation does not include the stiffness of
        capillary waves."""
        return Reason(
            "[steady] cannot find the equilibrium of a fluid with surface tension",
            "remove [steady], and let the viscosity damp the motion",
        )

    @classmethod
    def activate(cls, conditions: Sequence["SurfaceTension"], assembly: Assembly) -> Sequence[StepPart]:
        from pellucid.conditions.surface_tension.active import TenseSurface

        return [TenseSurface(condition, assembly) for condition in conditions]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about bodies without surface tension, duplicates, unsuitable grids or schemes, and contact angles
        without a wall. path: location of the condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "body"), "the surface is found on the nodes of a grid")
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        yield from self._body_problems((*path, "body"), parts)
        if parts.grid is not None:
            yield from self._grid_problems(path, parts.grid)
        for key, section in parts.sections.items():
            for item in section.items if key in ("inflow", "outflow") else ():
                if item is not None:
                    text = (
                        f"the case has an [[{key}]], but the energy of a fluid surface "
                        "that crosses a face of the grid is not computed"
                    )
                    yield Finding(path, text, f"remove the {key} or the surface tension")
        time = next(iter(parts.sections["time"].items), None)
        if getattr(time, "scheme", None) == "usf":
            text = (
                'the scheme "usf" changes volumes before the step that moves the points, but the '
                "surface energy depends on the positions of the points"
            )
            yield Finding(path, text, 'use time.scheme = "musl" or "usl"')
        yield from self._angle_problems((*path, "contact_angle"), parts)

    def _angle_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a contact angle without a wall, and faces that may be walls or planes of symmetry. path:
        location in the case for the findings; parts: all parts of the case."""
        if self.contact_angle == NEUTRAL or not parts.are_sound(Condition):
            return
        x, y, z = parts.active_axes
        walls, thin = parts.of(Wall), (not x, not y, not z)
        angles, unknown = find_face_roles(self.contact_angle, parts.of(Support), parts.of(BodyModel), thin, bool(walls))
        if not (angles or unknown or walls):
            text = "no support constrains a face of the grid along its normal, so there is no wall for this angle"
            yield Finding(
                path, text, 'add a [[support]] with a face as `where` and fix = "normal", or remove the contact angle'
            )
        for place, support in parts.placed(Support):
            faces = [face for face in unknown if support.face_velocity(face) is not None]
            if faces:
                yield self._unknown_role(place, support, faces)

    def _unknown_role(self, place: Path, support: Support, faces: Sequence[str]) -> Finding:
        """Return a finding about a support at `place` in the case with faces that may be walls or planes of symmetry, with
        the contact angles to add as a remedy."""
        angle, named = f"{self.contact_angle:g}", [f'"{face}"' for face in faces]
        text = (
            f"{listed(faces)}, constrained along the normal only: it is unknown whether this is a wall with the contact angle "
            f"{angle} degrees, or a plane of symmetry with 90 degrees"
        )
        either = f"contact_angle = {angle} if it is a wall, contact_angle = 90 if it is a plane of symmetry"
        if len(support.faces()) == 1:
            remedy = f"add to the support of {named[0]} {either}"
        elif len(faces) == 1:
            held = f'where = {named[0]}, fix = "normal"'
            remedy = f"remove {named[0]} from this list, and add a [[support]] with {held} and {either}"
        else:
            remedy = (
                f"remove {listed(named)} from this list, and add a [[support]] for each, such as where = {named[-1]}, "
                f'fix = "normal", contact_angle = {angle} for a wall, and where = {named[0]}, fix = "normal", '
                "contact_angle = 90 for a plane of symmetry"
            )
        return Finding((*place, "where"), text, remedy)

    def _body_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        body = parts.named(BodyModel, self.body)
        if body is None:
            return
        if body.is_surface or body.owns_nodes(is_alone(body, parts)) or not getattr(body.material, "flows", False):
            text = f"body {self.body} is not a fluid of material points"
            yield Finding(path, text, "name a fluid of material points; the tension of a membrane is set in its material")
        elif getattr(getattr(body.material, "eos", None), "carries_tension", True) is False:
            text = (
                f"body {self.body} cannot have surface tension: its equation of state allows the volume to grow at "
                "zero pressure"
            )
            yield Finding(path, text, f"add `carries_tension = true` to the eos of body {self.body}")
        for place, other in parts.placed(SurfaceTension):
            if place < (*path[:-1],) and other.body == self.body:
                text = f"surface_tension number {int(place[1]) + 1} already applies to body {self.body}"
                yield Finding(path, text, "remove one of the two")

    def _grid_problems(self, path: Path, grid: GridCase) -> Iterator[Finding]:
        if grid.functions != FUNCTIONS:
            text = f'grid.functions is "{grid.functions}", but surface tension needs quadratic B-splines'
            yield Finding(path, text, f'use grid.functions = "{FUNCTIONS}"')
        if grid.periodic:
            text = f"the grid is periodic along {grid.periodic[0]}, but surface tension is not computed across a periodic seam"
            yield Finding(path, text, "use walls, or remove the surface tension")
        if sum(grid.thin()) > 1:
            text = "the grid is one cell thick along two axes: a surface cannot curve in one dimension"
            yield Finding(path, text, "remove the surface tension, or enlarge the grid")
