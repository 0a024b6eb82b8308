"""Stages before or instead of time stepping: steady states, settling, the initial state from an earlier run,
and gravity that changes in time."""

from bisect import bisect_left
from collections.abc import Iterator
from math import inf
from pathlib import Path as FilePath

from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.signals.time_table import Amplitude
from pellucid.conditions.support import Support
from pellucid.findings import Finding, Path, listed
from pellucid.model import InputFile, parameter
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.condition import Condition, is_driven
from pellucid.parts.part import Part, Parts

SAME_LEVEL = 1e-6
"""Smallest difference of the times of two equilibria, as a fraction of the end time of the loads."""


class SteadyCase(Part):
    """Steady states under loads, by dynamic relaxation.

    Time refers to the loads only: the loads grow from time 0 to `time.end` in load steps, and results are equilibria. The
    inertia and damping of the relaxation do not affect the results.
    """

    load_steps: int = parameter("", "number of equilibria (load steps) at equal intervals of time", 1, ge=1, le=100_000)
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
        gt=0,
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
        for other, condition in parts.placed(Condition):
            if reason := condition.why_not_steady():
                yield Finding(other, *reason)
        for other, body in parts.placed(BodyModel):
            initial = getattr(body, "initial", None)
            velocity = any(getattr(body, "velocity", ()))
            if body.moves and (velocity or initial):
                key = "velocity" if velocity else "initial"
                yield Finding((*other, key), "the computation of steady states starts at rest", "Remove this key.")
            if _is_tool(body, parts):
                yield from _tool_problems(body, other, parts)
                continue
            if fault := _why_not_relaxed(body, is_alone(body, parts)):
                yield Finding((*other, *fault.path), f"[steady]: {fault.text}", fault.remedy)
            elif self.mass_scaling and not body.scales_inertia:
                yield Finding(
                    (*path, "mass_scaling"), f'the inertia of bodies of kind "{body.kind}" cannot be scaled', "Remove this key."
                )


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


def _tool_problems(body: BodyModel, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding for a rigid body whose motion is not fully prescribed. path: path of the body in the case; parts: the
    parts of the case."""
    motions = [motion for motion in parts.of(Motion) if motion.body == body.name]
    along = {axis for axis, counts in enumerate(parts.active_axes) if counts}
    about = {axis for axis in range(3) if not (along ^ {0, 1, 2}) - {axis}}
    free = sorted(along.difference(*(motion.axes() for motion in motions)))
    remedy = "replace the body by a meshless solid of a stiff material, which is relaxed"
    if free:
        axes = listed(["xyz"[axis] for axis in free])
        held = ", ".join(f'"{"xyz"[axis]}"' for axis in free)
        text = f"[steady]: the rigid body {body.name} is free along {axes}, but the relaxation does not move rigid bodies"
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
                f"[steady]: the rigid body {body.name} is free to rotate about {about_axes}, but the relaxation does "
                "not rotate bodies"
            )
            yield Finding((*path, "rigid"), text, f"Set hold_rotation = [{axes}] in motion {motion.name}, or {remedy}.")


class SettleCase(Part):
    """Settling: before time stepping starts, bodies come to rest in equilibrium with the loads at time 0.

    The bodies move by their own equations, and lose all velocity whenever their kinetic energy passes a peak. The time of
    loads and motions stays at 0.
    """

    share: float = parameter(
        "",
        "tolerance of settling: kinetic energy divided by the largest kinetic energy during settling",
        1e-8,
        gt=0,
        le=0.1,
    )
    most_steps: int = parameter("", "largest number of settling steps; the run stops when it is exceeded", 100_000, ge=10)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for steady states, for bodies without inertia or not at rest, and for supports that move.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if parts.one(SteadyCase) is not None:
            yield Finding(path, "[settle] and [steady] cannot be combined", "Remove one of the two.")
        for other, body in parts.placed(BodyModel):
            if not body.moves or body.has_own_step:
                yield Finding(
                    (*other, "kind"), f'[settle]: kind "{body.kind}" has no inertia and cannot settle', "Remove [settle]."
                )
            for key in ("velocity", "angular_velocity", "velocity_wave"):
                value = getattr(body, key, None)
                if value is not None and (not isinstance(value, tuple) or any(value)):
                    yield Finding(
                        (*other, key),
                        "[settle] brings all bodies to rest, so an initial velocity has no effect",
                        "Remove this key.",
                    )
            for number, initial in enumerate(getattr(body, "initial", None) or ()):
                if initial.kind == "velocity-gradient":
                    text = "[settle] brings all bodies to rest, so an initial velocity has no effect"
                    yield Finding((*other, "initial", number, "kind"), text, "Remove this initial field.")
        for other, support in parts.placed(Support):
            if any(support.velocity):
                text = "[settle] cannot be combined with a moving support"
                yield Finding((*other, "velocity"), text, "Set the velocity to 0, and move the body by a [[motion]].")


class StartCase(Part):
    """Start from an earlier run: bodies begin in the state of the bodies with the same names in that run.

    Time, work and impulses start at zero. Positions, velocities and the state of the material come from the earlier run;
    grid, supports, motions and loads come from the case, and its regions select points by their positions in that state.
    """

    path: InputFile = parameter("", "folder of the earlier run, relative to the folder of the case file")
    time: float | None = parameter(
        "s", "time in the earlier run: its nearest frame is used (default: last checkpoint)", None, ge=0
    )
    body: tuple[str, ...] | None = parameter("", "names of the bodies (default: all bodies of both runs)", None)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for an earlier run that does not exist, and for bodies that are not in the case.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        folder = FilePath(self.path)
        if not (folder / "case.toml").is_file():
            other = "it is a file" if folder.exists() else "it does not exist"
            what = "it contains no case.toml" if folder.is_dir() else other
            within = folder.is_file() and (folder.parent / "case.toml").is_file()
            remedy = f'Set path = "{folder.parent}".' if within else "Set it to the folder (--out) of a run of pellucid."
            yield Finding((*path, "path"), f"is not the folder of a run: {what}", remedy)
        if self.body == ():
            yield Finding((*path, "body"), "is empty", "Remove this key for all bodies of both runs, or remove [start].")
        names = [body.name for body in parts.of(BodyModel)]
        for number, name in enumerate(self.body or ()):
            if name not in names:
                yield Finding((*path, "body", number), f"no body has this name; available: {', '.join(names)}")


class GravityAmplitude(Amplitude, Part):
    """Factor on gravity as a function of time: piecewise linear, constant before the first and after the last time."""

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if the amplitude is given in a case without gravity or with steady states, or with hydrostatic
        fluids if the factor at time 0 is not 1.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        if parts.gravity is not None and not any(parts.gravity):
            yield Finding(path, "the case has no gravity", "Add `gravity`, such as [0, -9.81, 0] m/s^2, or remove this key.")
        if parts.one(SteadyCase) is not None:
            yield Finding(
                path,
                "in steady states gravity increases with the other loads, so it cannot have an amplitude",
                "Remove this key.",
            )
        for other, body in parts.placed(BodyModel):
            if getattr(body, "hydrostatic", None) is not None and self.at(0.0) != 1.0:
                text = f"`hydrostatic` is the equilibrium under full gravity, but its amplitude at time 0 is {self.at(0.0):g}"
                yield Finding((*other, "hydrostatic"), text, "Start the amplitude with 1, or remove this key.")
