"""Data model of a case. The same classes define the case file and the Python interface."""

from collections.abc import Iterator, Mapping
from html import escape
from math import hypot, inf
from pathlib import Path as FilePath
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from pellucid.bodies.damped_model import DampedModel
from pellucid.bodies.models import Body
from pellucid.case.checking import changed
from pellucid.case.judgement import Check
from pellucid.case.picture import Film, Picture
from pellucid.case.plot import Plot
from pellucid.case.probe import Probe
from pellucid.case.schema import schema_of
from pellucid.case.sections import parts_of, places
from pellucid.case.stages import GravityAmplitude, SettleCase, StartCase
from pellucid.case.steady import SteadyCase, why_not_implicit
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.bodies_as_walls import with_walls
from pellucid.conditions.contact import Contact
from pellucid.conditions.damping import Damping
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.conditions.loads import AnyLoad
from pellucid.conditions.loads.rigid_spring import RigidSpring
from pellucid.conditions.open_faces.inflow import Inflow
from pellucid.conditions.outflow import Outflow
from pellucid.conditions.porous import Porous
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.rigid.model import Rigid
from pellucid.conditions.rotating_frame import RotatingFrame
from pellucid.conditions.support import Support
from pellucid.conditions.surface_tension.model import SurfaceTension
from pellucid.conditions.wall import Wall
from pellucid.errors import UsageError
from pellucid.findings import Disagreement, Finding, Path
from pellucid.grid.model import GridCase
from pellucid.grid.velocity_transfer import AFFINE
from pellucid.model import InputFile, Model, Vector, check, parameter
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition, is_driven
from pellucid.parts.part import Part, Parts
from pellucid.step.limit import with_consistent_mass
from pellucid.users.users_code import ExtensionError, load_file, load_installed

ZERO = (0.0, 0.0, 0.0)
STEP_MARGIN = 0.05
"""Largest relative amount by which a fixed step may exceed the stable step."""
MOST_FRAMES, MOST_ROWS = 100_000, 10_000_000
MOST_STEPS = 1e12
"""Largest number of steps of a run."""
ROUNDING = 1e-12
"""Relative tolerance of the end time."""


class TimeCase(Part):
    """Time stepping: explicit or implicit steps, order of the operations in a step, end time, choice of the step, transfer of
    velocities."""

    method: Literal["explicit", "implicit"] = parameter(
        "",
        "explicit: steps that the fastest wave limits; implicit: steps of the length `step`, each with an iteration that uses "
        "a factored stiffness, for one meshless solid without a grid, under the conditions for "
        'which steady.method = "factored" is possible',
        "explicit",
    )
    scheme: Literal["musl", "usf", "usl"] = parameter(
        "", "order of the operations in a step: update of stress after (musl, usl) or before (usf) the momentum", "musl"
    )
    end: float = parameter("s", "end time of the run", gt=0)
    step: float | None = parameter("s", "fixed time step (default: `courant` times the largest stable step)", None, gt=0)
    courant: float = parameter("", "fraction of the largest stable step", 0.4, gt=0, le=1)
    transfer: Literal["flip", "pic", "blend", "apic", "aflip"] = parameter(
        "", "velocity transfer from grid to points (G2P)", "flip"
    )
    flip_fraction: float = parameter(
        "", 'fraction of FLIP in the transfers "blend" and "aflip"; the rest is PIC', 0.99, ge=0, le=1
    )
    mass_matrix: Literal["lumped", "consistent"] = parameter(
        "",
        "masses in the momentum equation of the grid: lumped at its nodes, or the consistent mass matrix, approximated by one "
        'iteration, with the transfers "apic" and "aflip"',
        "lumped",
    )

    def reached(self, time: float) -> bool:
        """Return True if a time [s] is at or beyond the end of the run."""
        return time >= self.end * (1.0 - ROUNDING)

    def passed(self, time: float) -> bool:
        """Return True if a time [s] is beyond the end of the run."""
        return time * (1.0 - ROUNDING) > self.end

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for a chosen step together with steady states, a fixed step above the stable step at the start or
        with too many steps, a missing step if no body moves, and bodies whose strain the scheme `usf` cannot update first.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if parts.one(SteadyCase) is not None:
            text = "the step of a relaxation to steady states is chosen automatically"
            if self.step is not None:
                yield Finding(
                    (*path, "step"), text, "Remove this key; steady.courant is the fraction of the largest stable step."
                )
            if self.courant != type(self).model_fields["courant"].default:  # a resolved case has every default
                yield Finding(
                    (*path, "courant"), f"{text} by steady.courant", "Remove this key and set steady.courant instead."
                )
        bodies = parts.of(BodyModel)
        if self.step is None and bodies and parts.are_sound(BodyModel) and not any(body.moves for body in bodies):
            text = f"is missing: body {bodies[0].name} does not move, so no stable step can be computed"
            yield Finding((*path, "step"), text, "Set a time step that resolves the processes in the body.")
        if self.method == "implicit":
            yield from self._implicit_problems(path, parts)
        if self.mass_matrix == "consistent" and (reason := self._why_lumped(parts)) is not None:
            yield Finding((*path, "mass_matrix"), *reason)
        if self.step is not None and self.end / self.step > MOST_STEPS:
            text = (
                f"{self.end / self.step:.3g} steps would be needed until time.end = "
                f"{self.end:g} s; the limit is {MOST_STEPS:.0e} steps"
            )
            remedy = f"Set `time.step` to at least {self.end / MOST_STEPS:.3g} s"
            automatic = ", or remove it: `time.courant` then sets the step" * (self.method == "explicit")
            yield Finding((*path, "step"), text, f"{remedy}{automatic}.")
        for body in bodies:
            stress = body.implicit_stress
            if stress is not None and stress.stiffness > 0.0 and self.scheme != "usl":
                text = f"the implicit pressure of body {body.name} is solved for with the velocities that also strain it"
                yield Finding((*path, "scheme"), text, 'use "usl", or remove `implicit_pressure`')
            elif stress is not None and self.scheme == "usf":
                text = f"the implicit viscosity of body {body.name} determines its stress in the momentum equation, not before"
                yield Finding((*path, "scheme"), text, 'use "musl" or "usl", or remove `implicit_viscosity`')
        if self.step is None or self.method == "implicit":
            return
        cell = None if parts.grid is None else parts.grid.cell
        names = {body.name for body in bodies}
        for body in bodies:
            aware = body.with_others(bodies) if names.issuperset(body.excluded_bodies()) else body
            limit = aware.step_limit(cell, is_driven(body.name, parts))
            if limit is not None and self.mass_matrix == "consistent" and not body.owns_nodes(is_alone(body, parts)):
                limit = with_consistent_mass(limit)
            if limit is not None and self.step > limit.step * (1.0 + STEP_MARGIN):
                text = f"exceeds {limit.step:.3g} s, the largest stable step at the start, of body {body.name}: {limit.reason}"
                remedy = (
                    f"Set `time.step` to at most {0.8 * limit.step:.2g} s, or remove it: `time.courant` then sets the step."
                )
                yield Finding((*path, "step"), text, remedy)

    def _why_lumped(self, parts: Parts) -> tuple[str, str] | None:
        """Return the reason why the masses of the nodes must be lumped and a remedy, or None. parts: all valid parts (tables)
        of the case."""
        if self.transfer not in AFFINE:
            text = f'"consistent" requires nodal velocities without smoothing, but the transfer "{self.transfer}" smooths them'
            return text, 'Set `time.transfer` to "aflip" or "apic", or remove this key.'
        if parts.grid is not None and not parts.grid.is_smooth:
            text = f'"consistent" is not available with {parts.grid.functions} shape functions'
            return text, 'Set `grid.functions` to "quadratic-bspline", or remove this key.'
        of_explicit = '"consistent" corrects the momentum equation of explicit forces'
        if parts.one(SteadyCase) is not None:
            return f"{of_explicit}; steady states do not depend on masses", "Remove this key."
        for body in parts.of(BodyModel):
            if body.implicit_stress is not None:
                return f"{of_explicit}, but body {body.name} has implicit viscosity or pressure", "Remove this key."
            if body.is_rigid:
                return f'"consistent" does not include rigid bodies, such as {body.name}', "Remove this key."
        for path, condition in parts.placed(Condition):
            if isinstance(condition, Motion):
                return '"consistent" does not include points with a prescribed motion', "Remove this key, or the [[motion]]."
            if isinstance(condition, Support) and (condition.stick or condition.opens or condition.friction is not None):
                wall = ".".join(map(str, path))
                return f'"consistent" does not include walls that rub or open, such as `{wall}`', "Remove this key."
        return None

    def _implicit_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for a missing step, and for bodies, conditions and tables that implicit steps do not include. path:
        location of this table in the case. parts: all valid parts (tables) of the case."""
        method = *path, "method"
        if self.step is None and parts.one(SteadyCase) is None:
            remedy = "Set it to at most a twentieth of the shortest period, or of the shortest duration of loads, that matters."
            yield Finding((*path, "step"), "is missing: the length of implicit steps is not limited by stability", remedy)
        if self.courant != type(self).model_fields["courant"].default:
            yield Finding((*path, "courant"), "implicit steps have the length time.step", "Remove this key.")
        for table, kind in (("steady", SteadyCase), ("settle", SettleCase)):
            if parts.one(kind) is not None:
                yield Finding(
                    method, f"[{table}] does not move bodies in time by implicit steps", f"Remove this key or [{table}]."
                )
        if (lacking := why_not_implicit(parts)) is not None:
            yield Finding(method, lacking, 'Set it to "explicit", or remove this key.')


class OutputCase(Part):
    """Intervals of the output."""

    history: float | None = parameter("s", "time between rows of history.csv (default: end/200)", None, gt=0)
    frames: float | None = parameter("s", "time between frames of the fields (default: end/10)", None, gt=0)
    checkpoint: float = parameter("s", "wall-clock time between checkpoints", 30.0, gt=0)

    def rows_every(self, end: float) -> float:
        """Return the time between rows of the history [s] for a run to `end` [s]."""
        return self.history or end / 200

    def frames_every(self, end: float) -> float:
        """Return the time between frames of the fields [s] for a run to `end` [s]."""
        return self.frames or end / 10

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for too many rows or frames, since their space in the files is reserved at the start of the run.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        time = parts.one(TimeCase)
        rows = ("history", self.history, MOST_ROWS, "rows of history.csv")
        frames = ("frames", self.frames, MOST_FRAMES, "frames of the fields")
        end = 0.0 if time is None else time.end
        for key, interval, most, what in (rows, frames):
            if interval is not None and end / interval > most * (1.0 + 1e-5):  # so that the remedy, rounded, is enough
                text = f"{end / interval:.3g} {what} until time.end = {end:g} s; the limit is {most:,}".replace(",", " ")
                yield Finding((*path, key), text, f"Set it to at least {end / most:g} s, or remove it.")


class EnergyCase(Part):
    """Limits on the relative error of the energy balance."""

    warn: float = parameter("", "relative energy error above which the run warns", 0.02, gt=0)
    stop: float = parameter("", "relative energy error above which the run stops", 0.10, gt=0)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the limit for warnings is above the limit that stops the run.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if self.warn > self.stop:
            text = f"is above energy.stop = {self.stop:g}, so the run would stop without a warning"
            yield Finding((*path, "warn"), text, f"Set it to at most {self.stop:g}, or increase energy.stop.")


class TimesCase(Model):
    """Expected run times on two cores, for `pellucid list`."""

    quick: float = parameter("s", "wall-clock time of the quick variant", ge=0)
    full: float = parameter("s", "wall-clock time of the full case", ge=0)


class Case(Model):
    """A complete case; build it in Python or read it with `pellucid.load`."""

    schema_version: Literal[1] = parameter("", "version of this format", 1, alias="schema")
    title: str = parameter("", "title of the case, one line")
    id: str = parameter("", "gallery case whose metrics and figures apply to this case", "")
    source: str = parameter("", "source of the case", "")
    description: str = parameter("", "description of the case", "")
    extensions: tuple[InputFile, ...] = parameter(
        "", "Python files that register additional kinds; they are executed before the rest of the case is read", ()
    )
    gravity: Vector = parameter("m/s^2", "acceleration of gravity", ZERO)
    gravity_amplitude: GravityAmplitude | None = parameter("", "factor on gravity as a function of time", None)
    grid_or_none: GridCase | None = parameter(
        "", "background grid; not required for bodies with their own nodes", None, alias="grid"
    )
    time: TimeCase = parameter("", "end time and time stepping")
    steady: SteadyCase | None = parameter("", "computation of steady states instead of motion in time", None)
    start: StartCase | None = parameter("", "earlier run that provides the initial state of bodies", None)
    settle: SettleCase | None = parameter("", "settling to equilibrium before time 0", None)
    body: tuple[Body, ...] = parameter("", "bodies", min_length=1)
    support: tuple[Support, ...] = parameter("", "constrained nodes", ())
    motion: tuple[Motion, ...] = parameter("", "prescribed motions", ())
    absorbing: tuple[Absorbing, ...] = parameter("", "faces that absorb waves", ())
    inflow: tuple[Inflow, ...] = parameter("", "faces of the grid through which a fluid enters", ())
    outflow: tuple[Outflow, ...] = parameter("", "faces of the grid through which material points leave", ())
    pressure: tuple[Pressure, ...] = parameter("", "pressures on membranes and faces of solids", ())
    enclosed: tuple[Enclosed, ...] = parameter("", "gases and liquids in membranes", ())
    surface_tension: tuple[SurfaceTension, ...] = parameter("", "surface tension of fluids of material points", ())
    load: tuple[AnyLoad, ...] = parameter("", "forces on bodies", ())
    porous: tuple[Porous, ...] = parameter("", "porous boxes that slow a fluid", ())
    rotating_frame: tuple[RotatingFrame, ...] = parameter("", "rotation of the coordinates, at most one", ())
    contact: tuple[Contact, ...] = parameter("", "contact between bodies of different velocity fields", ())
    wall: tuple[Wall, ...] = parameter("", "rigid planes that bodies cannot penetrate", ())
    probe: tuple[Probe, ...] = parameter("", "columns of the history", ())
    picture: tuple[Picture, ...] = parameter("", "pictures of bodies at given times, for the report", ())
    film: tuple[Film, ...] = parameter("", "films of bodies, for the report", ())
    plot: tuple[Plot, ...] = parameter("", "plots of columns of the history and measured curves, for the report", ())
    checks: tuple[Check, ...] = parameter("", "comparisons of results with references", (), alias="check")
    output: OutputCase = parameter("", "intervals of output", OutputCase())
    energy: EnergyCase = parameter("", "relative errors of the energy balance at which a run warns and stops", EnergyCase())
    times: TimesCase | None = parameter("", "expected wall-clock times", None)
    quick: dict[str, Any] = Field({}, description="settings of the quick variant, by dotted key")

    @property
    def longest_step(self) -> float:
        """Largest step [s]: the interval of the history if a body has sub-steps of its own or implicit pressure; else
        infinite."""
        for body in self.body:
            stress = body.implicit_stress
            if body.has_own_step or (stress is not None and stress.stiffness > 0.0):
                return self.output.rows_every(self.time.end)
        return inf

    @property
    def largest_gravity(self) -> float:
        """Largest magnitude of the acceleration of gravity during the run [m/s²]."""
        return hypot(*self.gravity) * (self.gravity_amplitude.largest if self.gravity_amplitude else 1.0)

    @model_validator(mode="before")
    @classmethod
    def _with_extensions(cls, data: Any) -> Any:
        load_installed()
        files = data.get("extensions", ()) if isinstance(data, dict) else ()
        found = []
        for index, path in enumerate(files if isinstance(files, (list, tuple)) else ()):
            try:
                load_file(str(FilePath(path).absolute()))
            except ExtensionError as error:
                found.append(Finding(("extensions", index), str(error), error.remedy))
            except TypeError:
                continue  # no text: the field says so
        if found:
            raise Disagreement(found)
        return data

    @model_validator(mode="after")
    def _keep_fluids_out_of_walls(self) -> Self:
        object.__setattr__(self, "body", tuple(with_walls(self.body, self.motion, self.support, self.grid_or_none)))
        return self

    @check
    def _parts_fit_together(self) -> None:
        found = parts_of(self).findings()
        if found:
            raise Disagreement(found)

    @property
    def grid(self) -> GridCase:
        """The grid of the case. Raises ValueError if the case has no grid."""
        if self.grid_or_none is None:
            raise ValueError("this case has no grid")
        return self.grid_or_none

    @property
    def thin(self) -> tuple[bool, bool, bool]:
        """Mask of the axes along which the grid is one cell thick; all False without a grid."""
        return (False, False, False) if self.grid_or_none is None else self.grid_or_none.thin()

    @property
    def periods(self) -> Vector:
        """Period of the grid along each axis [m]; 0 along axes that are not periodic."""
        return (0.0, 0.0, 0.0) if self.grid_or_none is None else self.grid_or_none.periods()

    def conditions(self) -> dict[type[Condition], tuple[Condition, ...]]:
        """Return the conditions on the bodies, such as supports, loads and contacts, by class. Damping comes first,
        rigidity last, since rigid bodies receive the impulses of all other conditions."""
        led = {body.name: tuple(motion for motion in self.motion if motion.body == body.name) for body in self.body}
        if self.steady is not None:
            led |= {body.name: self._without_turns(led[body.name]) for body in self.body if body.is_rigid}
        springs = [load for load in self.load if isinstance(load, RigidSpring)]
        rigid = tuple(
            Rigid(body=name, motions=led[name], springs=tuple(spring for spring in springs if spring.body == name))
            for name in (body.name for body in self.body if body.is_rigid)
        )
        parts = {place.base: getattr(self, place.attribute) for place in places(type(self)).values()}
        acting = {base: several for base, several in parts.items() if issubclass(base, Condition)}
        if self.steady is not None:
            acting = {base: tuple(map(self._growing, several)) for base, several in acting.items()}
        every, grid = [condition for several in acting.values() for condition in several], self.grid_or_none
        thin = grid.thin() if grid is not None else (False, False, False)
        acting = {base: tuple(one.in_case(self.body, every, thin) for one in several) for base, several in acting.items()}
        damped = [body for body in self.body if isinstance(body, DampedModel) and body.damping > 0.0 and self.steady is None]
        drags = tuple(Damping(body=body.name, rate=body.damping, until=body.damping_until) for body in damped)
        first: dict[type[Condition], tuple[Condition, ...]] = {Damping: drags}
        return first | acting | {Rigid: rigid}

    def _without_turns(self, motions: tuple[Motion, ...]) -> tuple[Motion, ...]:
        """Return the prescribed motions of a rigid body in a steady analysis. If none of the motions prescribes or holds a
        rotation, the last motion is replaced by a copy that prevents all rotations."""
        if not motions or any(motion.turns_about() or motion.hold_rotation is not None for motion in motions):
            return motions
        return (*motions[:-1], motions[-1].model_copy(update={"hold_rotation": ("x", "y", "z")}))

    def _growing(self, condition: Condition) -> Condition:
        """Return a condition for a steady analysis: if its load would act fully at once, a copy whose load grows until the
        end of the load time; otherwise the condition itself."""
        at_once = getattr(condition, "rise", None) == 0.0 and getattr(condition, "amplitude", None) is None
        return condition.model_copy(update={"rise": self.time.end}) if at_once else condition

    def with_settings(self, settings: Mapping[str, Any]) -> "Case":
        """Return the case with values set at dotted keys, such as {"grid.cell": 0.02, "body.driver.velocity": [1, 0, 0]}.

        Raises CaseError, which names the setting, if a key or value is invalid.
        """
        return changed(type(self), self.to_data(), settings)

    def quick_variant(self) -> "Case":
        """Return the case with its quick settings applied (a smaller problem that runs within seconds); the case itself if
        no quick settings are given."""
        return self.with_settings(self.quick) if self.quick else self

    def __repr__(self) -> str:
        bodies = ", ".join(body.name for body in self.body)
        return f"Case({self.title!r}, bodies {bodies}, to t = {self.time.end:g} s)"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Return HTML for notebooks: title, bodies, time, and the folded case file."""
        from pellucid.case.toml import dumps

        rows = [(f"body {body.name}", body.kind) for body in self.body]
        if self.grid_or_none is not None:
            rows.insert(0, ("grid", " × ".join(map(str, self.grid.counts())) + f" cells of {self.grid.cell:g} m"))
        rows.append(("time", f"to {self.time.end:g} s"))
        table = "".join(f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in rows)
        whole = f"<details><summary>the case file</summary><pre>{escape(dumps(self))}</pre></details>"
        return f"<b>{escape(self.title)}</b><table>{table}</table>{whole}"

    def to_data(self) -> dict[str, Any]:
        """Return the case as plain tables, lists, texts and numbers in SI units, including defaults, without None."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)


def json_schema() -> dict[str, Any]:
    """Return the JSON schema of a case file, including all kinds that are registered at the time of the call."""
    load_installed()
    return schema_of(Case).whole


def required(case: object) -> Case:
    """Return `case` if it is a `Case`. Raises UsageError for anything else, such as the name of a case."""
    if isinstance(case, Case):
        return case
    text = f"{case!r} is not a case"
    raise UsageError(f'{text}.\n    Read one with pellucid.load("basics/sod"), or build a pellucid.Case.')
