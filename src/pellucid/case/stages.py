"""Stages before time stepping: settling, and the initial state from an earlier run; and gravity that changes in time."""

from collections.abc import Iterator
from pathlib import Path as FilePath

from pellucid.case.steady import SteadyCase
from pellucid.conditions.signals.time_table import Amplitude
from pellucid.conditions.support import Support
from pellucid.findings import Finding, Path
from pellucid.model import InputFile, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Part, Parts


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
