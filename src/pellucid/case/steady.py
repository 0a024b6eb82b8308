"""Steady states of a case: load steps, method and tolerance, and the checks of bodies and conditions for them."""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from math import inf
from typing import Any, Literal

from pellucid.conditions.contact import Contact
from pellucid.conditions.loads.contract import LoadModel
from pellucid.conditions.loads.rigid_load import RigidForce
from pellucid.conditions.loads.rigid_spring import RigidSpring
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.conditions.support import Support
from pellucid.conditions.wall import Wall
from pellucid.findings import Finding, Path, listed
from pellucid.model import parameter
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition, is_driven
from pellucid.parts.elastic_system import FEW_NODES, LARGEST_FACTORS
from pellucid.parts.part import Part, Parts

LARGEST_APPROXIMATE = 2e9
"""Largest number of entries of approximate factors, 8 GB in single precision: those of a compact solid of 2e5 nodes with an
averaged volume ratio."""
STIFFEST = 500.0
"""Largest ratio of bulk and shear modulus for which approximate factors serve, that of a Poisson's ratio of 0.499: the volumes
of tetrahedra differ from those of the solid, and the number of iterations grows with the ratio."""
SAME_LEVEL = 1e-6
"""Smallest difference of the times of two equilibria, as a fraction of the end time of the loads."""


class SteadyCase(Part):
    """Steady states under loads: equilibria, without motion in time.

    Time refers to the loads only: the loads grow from time 0 to `time.end` in load steps, and results are equilibria. They
    are found with a factored stiffness, or by dynamic relaxation, whose inertia and damping do not affect the results.
    """

    method: Literal["factored", "relaxation"] | None = parameter(
        "",
        "how equilibria are found: factored (minimum of the potential energy, with a factored stiffness; a load step in which "
        "this fails is relaxed) or relaxation (damped motion). Default: factored if the bodies without prescribed motion are "
        'meshless solids with essential = "direct" and membranes of triangles without wrinkling, at most one of the bodies in '
        "contact is a membrane, and the conditions are supports, prescribed motions, pressures, given volumes, enclosed gases "
        "or liquids that do not flow out, body forces, point loads, tractions, forces and springs of rigid bodies, contacts "
        "and walls; otherwise relaxation",
        None,
    )

    control: Literal["load", "arc-length"] = parameter(
        "",
        "load: each equilibrium is at given loads; arc-length: each equilibrium is at a given distance along the path, through "
        "limit points, and all loads share an unknown factor. With arc-length the run ends when the factor reaches 1, or after "
        "`load_steps` equilibria; the first one is where the factor would be 1/`load_steps` in the linear theory",
        "load",
    )
    load_steps: int = parameter(
        "",
        "number of equilibria (load steps) at equal intervals of time; with arc-length the largest number of equilibria",
        1,
        ge=1,
        le=100_000,
    )
    at: tuple[float, ...] = parameter(
        "s",
        "times of additional equilibria, between the times given by `load_steps`",
        (),
        max_length=100_000,
    )
    loading: int | None = parameter(
        "",
        "number of relaxation steps in which the loads increase smoothly to a load step (default: shear waves cross the body "
        "sixteen times while all loads increase, and at least 800 steps in total)",
        None,
        ge=1,
    )
    tolerance: float = parameter(
        "",
        "tolerance of a steady state: estimated error of the displacements divided by the largest displacement",
        1e-6,
        ge=1e-14,
        le=0.1,
    )
    courant: float = parameter("", "fraction of the largest stable step of the relaxation", 0.8, gt=0, le=1)
    mass_scaling: bool = parameter("", "True: scale the inertia so that all nodes have the same stable step", False)
    most_steps: int = parameter(
        "", "largest number of relaxation steps of a load step; the run stops when it is exceeded", 100_000, ge=100
    )

    def levels(self, end: float) -> list[float]:
        """Return the load levels at the start and at each equilibrium of a steady analysis, in ascending order and in units
        of a load step: 0 at the start, k after the k-th of the `load_steps` equal load steps, numbers in between at the
        times `at`.

        end: end time of the loads [s]. Times in `at` that agree with another equilibrium are omitted.
        """
        regular = [float(number) for number in range(self.load_steps + 1)]
        own = sorted(time / end * self.load_steps for time in self.at)
        apart = SAME_LEVEL * self.load_steps
        for level in own:
            place = min(bisect_left(regular, level), len(regular) - 1)
            if level - regular[place - 1] > apart and regular[place] - level > apart:
                regular.insert(place, level)
        return regular

    def columns(self) -> dict[str, str]:
        """Return names and SI units of the columns of the history that show the state of the analysis."""
        return {"load_factor": "", "unstable_modes": ""} if self.control == "arc-length" else {}

    def is_factored(self, parts: Parts) -> bool:
        """Return True if equilibria are found with a factored stiffness, not by relaxation; parts: all parts of the case."""
        return self.method != "relaxation" and why_not_factored(parts) is None

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for times outside the run, and for bodies that cannot be relaxed or do not start at rest.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        bodies = parts.of(BodyModel)
        if bodies and all(_is_tool(body, parts) for body in bodies):
            text = "all bodies of the case are rigid, so there is no steady state to compute"
            yield Finding(path, text, "Remove [steady], or add a meshless solid or a membrane of elements.")
        end = getattr(parts.sections["time"].items[0], "end", inf)
        wrong = next((each for each in self.at if not 0.0 < each <= end), None)
        if wrong is not None:
            text = f"{wrong:g} s is not between 0 and time.end = {end:g} s"
            yield Finding(
                (*path, "at"), text, f"Remove {wrong:g} from the list" + ", or set a later `time.end`" * (wrong > 0.0) + "."
            )
        of_volumes = any(condition.kind_of_load() == "volume" for condition in parts.of(Condition))  # they are told below
        if self.method == "factored" and not of_volumes and (lacking := why_not_factored(parts)) is not None:
            yield Finding((*path, "method"), lacking, 'Set it to "relaxation", or remove this key.')
        if self.control == "arc-length":
            yield from self._path_problems(path, parts)
        for other, condition in parts.placed(Condition):
            if (reason := condition.why_not_steady()) is None:
                continue
            if condition.kind_of_load() != "volume":
                yield Finding(other, *reason)
            elif not self.is_factored(parts):
                lacking = why_not_factored(parts) or 'steady.method is "relaxation"'
                yield Finding(other, *(condition.why_not_factored() or (f"{reason.text}, and {lacking}", reason.remedy)))
        for other, body in parts.placed(BodyModel):
            initial = getattr(body, "initial", None)
            velocity = any(getattr(body, "velocity", ()))
            if body.moves and (velocity or initial):
                key = "velocity" if velocity else "initial"
                yield Finding((*other, key), "the computation of steady states starts at rest", "Remove this key.")
            if _is_tool(body, parts):
                yield from _tool_problems(self, body, other, parts)
                continue
            if fault := _why_not_relaxed(body, is_alone(body, parts)):
                yield Finding((*other, *fault.path), f"[steady]: {fault.text}", fault.remedy)
            elif self.mass_scaling and not body.scales_inertia:
                yield Finding(
                    (*path, "mass_scaling"), f'the inertia of bodies of kind "{body.kind}" cannot be scaled', "Remove this key."
                )

    def _path_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for everything that the path of equilibria under loads with an unknown factor does not include; path,
        parts: as for `problems`."""
        place, without = (*path, "control"), 'or set steady.control = "load"'
        bodies = parts.of(BodyModel)
        if self.at:
            yield Finding((*path, "at"), "the loads have no times with arc-length control", f"Remove this key, {without}.")
        if self.method == "relaxation":
            yield Finding((*path, "method"), "a relaxation finds stable equilibria only", f"Remove this key, {without}.")
        elif (lacking := why_not_factored(parts)) is not None:
            yield Finding(place, f"arc-length control needs a factored stiffness, but {lacking}", "Remove this key.")
        elif not parts.are_sound(BodyModel):
            pass  # the errors of the bodies are told, and how many can deform is not known
        elif len(bodies) != 1:
            text = f"arc-length control follows one body, and the case has {len(bodies)}"
            yield Finding(place, text, f"Remove the other bodies, {without}.")
        elif bodies[0].n_points(None) > FEW_NODES and (size := bodies[0].stiffness_size()) is not None and size.is_approximate:
            text = f"arc-length control needs the factors of the stiffness itself, and those of {bodies[0].name} are too large"
            yield Finding(place, text, f"Use a coarser mesh, {without}.")
        for other, condition in parts.placed(Condition):
            if isinstance(condition, (Contact, Wall)):
                yield Finding(other, "arc-length control does not include walls and contact", f"Remove this table, {without}.")
            elif condition.kind_of_load() == "volume":
                text = "arc-length control does not include pressures that depend on the volume"
                yield Finding(other, text, 'Set steady.control = "load": a given volume passes limit points of the pressure.')
            elif isinstance(condition, Motion) and (condition.top_speed() > 0.0 or condition.top_turn() > 0.0):
                text = "arc-length control multiplies loads by a factor, and prescribes no displacements"
                remedy = 'Set steady.control = "load": a prescribed displacement passes limit points of the force.'
                yield Finding(other, text, remedy)
            elif isinstance(condition, Support) and (any(condition.velocity) or condition.until is not None):
                key = "velocity" if any(condition.velocity) else "until"
                text = "with arc-length control supports are fixed, since there is no time"
                yield Finding((*other, key), text, f"Remove this key, {without}.")
        load: Any
        for other, load in parts.placed(Part):
            if isinstance(load, ChangesInTime) and (change := load.key_of_change()) is not None:
                text = "with arc-length control all loads are multiplied by the same load factor, from their full values"
                yield Finding((*other, change), text, f"Remove this key, {without}.")


def deforming_bodies(parts: Parts) -> list[BodyModel]:
    """Return the bodies whose equilibria are sought: all but those whose motion is prescribed. parts: all parts of the case."""
    return [body for body in parts.of(BodyModel) if not (_is_tool(body, parts) or is_driven(body.name, parts))]


def sought_bodies(parts: Parts) -> dict[str, str]:
    """Return the rigid bodies whose place a search with a factored stiffness finds, by name, with the axes along which they are
    free, as text. parts: all parts of the case."""
    rigid = {body.name: _free_axes(body, parts) for body in parts.of(BodyModel) if body.is_rigid}
    return {name: listed(["xyz"[axis] for axis in free]) for name, free in rigid.items() if free}


def why_not_factored(parts: Parts) -> str | None:
    """Return the reason why equilibria of a case cannot be found with a factored stiffness, as a clause, or None. parts: all
    parts of the case."""
    deforming = deforming_bodies(parts)
    if not deforming:
        return "the motion of every body is prescribed" if parts.are_sound(BodyModel) else None
    for body in deforming:
        if (reason := body.why_no_stiffness()) is not None:
            return reason
    if (reason := _why_too_large(deforming, parts)) is not None:
        return reason
    for path, condition in parts.placed(Condition):
        if (own := condition.why_not_factored()) is not None:
            return own.text
        if condition.kind_of_load() == "other":
            return f"the factored stiffness does not include the forces of [[{path[0]}]]"
        if isinstance(condition, Contact) and condition.is_of_one_body:
            return f"the factored stiffness does not include contact of {condition.between[0]} with itself"
    sheets = [body.name for body in parts.of(BodyModel) if body.is_surface]
    if len(sheets) > 1 and not parts.lacks_grid:
        return f"the factored stiffness does not include contact of two membranes ({sheets[0]} and {sheets[1]})"
    return None


def _why_too_large(bodies: Sequence[BodyModel], parts: Parts) -> str | None:
    """Return the reason why the factors of the stiffness of these bodies are too large for the case, as a clause, or None."""
    if sum(body.n_points(None) for body in bodies) <= FEW_NODES:
        return None
    sizes = {body.name: size for body in bodies if (size := body.stiffness_size()) is not None}
    exact = sum(size.numbers for size in sizes.values() if not size.is_approximate)
    if exact > LARGEST_FACTORS:
        return f"the factors of the stiffness need {exact * 8e-9:.2g} GB, and at most {LARGEST_FACTORS * 8e-9:.2g} GB are used"
    approximate = {name: size.numbers for name, size in sizes.items() if size.is_approximate}
    if (total := sum(approximate.values())) > LARGEST_APPROXIMATE:
        least = f"even approximate factors of the stiffness need {total * 4e-9:.2g} GB"
        return f"{least}, and at most {LARGEST_APPROXIMATE * 4e-9:.2g} GB are used"
    if approximate and not parts.lacks_grid and (len(parts.of(BodyModel)) > 1 or parts.of(Wall)):
        largest = max(approximate, key=approximate.__getitem__)
        return f"contact needs the factors of the stiffness itself, and those of body {largest} are too large"
    for body in bodies:
        speeds = body.wave_speeds()
        if body.name in approximate and speeds is not None and (speeds[0] / speeds[1]) ** 2 - 4.0 / 3.0 > STIFFEST:
            return (
                f"body {body.name} is nearly incompressible (bulk modulus more than {STIFFEST:g} times the shear modulus), and "
                "the factors of its stiffness are too large"
            )
    return None


def why_not_implicit(parts: Parts) -> str | None:
    """Return the reason why the bodies of a case cannot move in implicit time steps, as a clause, or None. parts: all parts of
    the case."""
    if not parts.lacks_grid:
        return "implicit steps do not include contact and walls, which a case with a grid can have"
    for body in parts.of(BodyModel):
        if (reason := body.why_no_implicit_steps()) is not None:
            return reason
    if (reason := why_not_factored(parts)) is not None:
        return reason
    for body in parts.of(BodyModel):
        if body.n_points(None) > FEW_NODES and (size := body.stiffness_size()) is not None and size.is_approximate:
            return f"implicit steps need the factors of the stiffness itself, and those of body {body.name} are too large"
    return None


def _why_not_relaxed(body: BodyModel, alone: bool) -> Finding | None:
    """Return the reason why no steady state of the body can be computed, with the offending key of its table, or None; alone:
    True if no other body is in its velocity field."""
    if not body.own_material_nodes:
        return Finding(("kind",), f'steady states of kind "{body.kind}" cannot be computed', "remove the table [steady]")
    if not body.owns_nodes(alone):
        text = f"steady states require a separate velocity field, but other bodies share the field of body {body.name}"
        return Finding(("field",), text, "set a separate `field` for it")
    if body.material.creeps:
        text = f'the material of {body.name}, kind "{body.material.kind}", creeps in time, which steady states do not include'
        return Finding(("material", "kind"), text, "use its `elastic` material, which carries the load at rest")
    return None


def _is_tool(body: BodyModel, parts: Parts) -> bool:
    """Return True if a body of points on the grid is rigid, or if its motion as a whole is prescribed; the relaxation does
    not move such a body. parts: the parts of the case."""
    return body.is_rigid or (body.deforms_in_contact and not body.owns_nodes(True) and is_driven(body.name, parts))


def _tool_problems(steady: SteadyCase, body: BodyModel, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding for a rigid body whose motion is not fully prescribed, if the search for equilibria does not find its
    place. steady: settings of the analysis; path: path of the body in the case; parts: the parts of the case."""
    motions, free = [motion for motion in parts.of(Motion) if motion.body == body.name], _free_axes(body, parts)
    about = {axis for axis in range(3) if all(parts.active_axes[other] for other in range(3) if other != axis)}
    remedy = "replace the body by a meshless solid of a stiff material"
    axes = listed(["xyz"[axis] for axis in free])
    if free and body.is_rigid and steady.is_factored(parts):
        yield from _free_tool_problems(body, axes, path, parts)
    elif free:
        held = ", ".join(f'"{"xyz"[axis]}"' for axis in free)
        reason = 'steady.method is "relaxation"' if steady.method == "relaxation" else why_not_factored(parts)
        text = (
            f"[steady]: the rigid body {body.name} is free along {axes}, but the relaxation does not move rigid bodies, and "
            f"equilibria are relaxed because {reason}"
        )
        add = f"Add hold = [{held}] or a `displacement` along {axes} to" if motions else f"Add hold = [{held}] in"
        yield Finding((*path, "rigid"), text, f"{add} a [[motion]] of body {body.name}, or {remedy}.")
        return
    turned = about.difference(*(motion.turns_about() for motion in motions))
    if turned != about or any(motion.hold_rotation is not None for motion in motions):  # silence means that it is held
        turned = turned if body.is_rigid else set()
        for motion in motions[-1:] if turned else []:
            axes = ", ".join(f'"{"xyz"[axis]}"' for axis in sorted({*turned, *("xyz".index(a) for a in motion.held_turns)}))
            about_axes = listed(["xyz"[axis] for axis in sorted(turned)])
            text = (
                f"[steady]: the rigid body {body.name} is free to rotate about {about_axes}, but [steady] does not "
                "rotate rigid bodies"
            )
            yield Finding((*path, "rigid"), text, f"Set hold_rotation = [{axes}] in motion {motion.name}, or {remedy}.")


def _free_axes(body: BodyModel, parts: Parts) -> list[int]:
    """Return the axes along which no motion prescribes a body; parts: all parts of the case."""
    along = {axis for axis, counts in enumerate(parts.active_axes) if counts}
    return sorted(along.difference(*(motion.axes() for motion in parts.of(Motion) if motion.body == body.name)))


def _free_tool_problems(body: BodyModel, free: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings for loads on a rigid body whose place the search for equilibria finds, if these loads are not included or
    if there are none. free: axes along which the body is free, for messages; path: path of the body in the case; parts: the
    parts of the case."""
    acting = [(place, load) for place, load in parts.placed(LoadModel) if load.body == body.name]
    for place, load in acting:
        if not isinstance(load, (RigidForce, RigidSpring)):
            text = f"[steady] does not include loads of this kind on the rigid body {body.name}, which is free along {free}"
            yield Finding((*place, "kind"), text, 'Use kind = "rigid-force".')
    if not acting and not any(parts.gravity or ()):
        text = f"[steady]: the rigid body {body.name} is free along {free}, but no load acts on it"
        remedy = f'Add a [[load]] of kind = "rigid-force" on {body.name}, or hold it along {free} by a [[motion]].'
        yield Finding((*path, "rigid"), text, remedy)
