"""Data models of pictures and films: bodies, quantity shown by colour, times, camera, and planes of cuts and slices."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator

from pellucid.case.plot import Figure, unit_problems
from pellucid.case.probe import unknown_column
from pellucid.conditions.support import Face
from pellucid.findings import Finding, Path, hint, listed
from pellucid.model import AtLeastOne, AtLeastTwo, Model, Vector, check, one_or_several, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts
from pellucid.state import FIELDS

DERIVED = {"speed": "m/s", "displacement": "m", "load": "Pa", "normal_velocity": "m/s", "bodies": ""}
"""Quantities derived from fields, with their units. The load is the pressure of fluids and the von Mises stress of solids;
the normal velocity is that of surfaces in space; `bodies` gives each body a colour."""
Names = Annotated[tuple[str, ...], BeforeValidator(one_or_several)]


def _one_or_several_times(times: Any) -> Any:
    """Return the given times [s] as a tuple; a case may give a single time without brackets."""
    return (times,) if isinstance(times, int | float) else times


class CameraCase(Model):
    """Camera of a picture in space; it looks at the centre of the bodies, without perspective."""

    turn: float = parameter("", "azimuth of the camera about z, from x, in degrees", -50.0)
    rise: float = parameter("", "elevation of the camera above the x-y plane, in degrees", 22.0, ge=-90, le=90)


class CutCase(Model):
    """A plane at which bodies in space are cut open."""

    normal: Vector = parameter("", "direction of the side that is cut away (towards the camera)")
    at: Vector | None = parameter("m", "a point of the plane (default: centre of body `through`)", None)
    through: str | None = parameter("", "body whose initial centre is a point of the plane", None)

    @check
    def _is_complete(self) -> None:
        if (self.at is None) == (self.through is None):
            raise ValueError("a cut requires either a point `at` or a body `through`; set one of the two")
        if not any(self.normal):
            raise ValueError("`normal` is zero; set a direction")


class SliceCase(Model):
    """A plane slice of bodies in space. Points that were within the slice at the start are drawn as dots, seen along the
    viewing axis."""

    across: Literal["x", "y", "z"] = parameter("", "viewing axis, normal to the plane")
    at: float = parameter("m", "coordinate of the plane along the viewing axis")
    thickness: float | None = parameter(
        "m", "thickness of the slice, half on each side of the plane (default: one cell)", None, gt=0
    )


class WindowCase(Model):
    """Window of a flat picture, by its lower left and upper right corners."""

    lower: tuple[float, float] = parameter("m", "lower left corner")
    upper: tuple[float, float] = parameter("m", "upper right corner")

    @check
    def _has_room(self) -> None:
        if not all(low < high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError("`lower` must be less than `upper` along both axes")


class Pictured(Figure):
    """Keys common to pictures and films."""

    bodies: Names = parameter("", "bodies that are drawn (default: all)", ())
    quantity: str = parameter("", 'quantity shown by colour: a field, or "speed", "displacement", "load" or "bodies"', "speed")
    component: str | None = parameter(
        "", "x, y, z or xx, yy, zz, yz, xz, xy (default: magnitude of a vector, von Mises equivalent of a stress)", None
    )
    unit: str = parameter("", "unit of the colour scale, such as kPa (default: SI unit)", "")
    limits: tuple[float, float] | None = parameter(
        "", "limits of the colour scale in this unit (default: range of the values without a few extreme ones)", None
    )
    mirror: tuple[Face, ...] = parameter(
        "", "faces of the grid that are planes of symmetry; mirror images behind them are drawn", ()
    )
    arrows: bool = parameter("", "True: draw velocity arrows on surfaces in space", False)
    camera: CameraCase = parameter("", "direction of the camera, for bodies in space", CameraCase())
    cut: CutCase | None = parameter("", "plane at which bodies in space are cut open", None)
    slice: SliceCase | None = parameter("", "plane slice of bodies in space, drawn instead of the whole", None)
    window: WindowCase | None = parameter("", "visible part of a plane case or slice (default: all bodies)", None)

    @check
    def _has_limits(self) -> None:
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            raise ValueError("the first value of `limits` must be less than the second")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding for each key that does not fit the case: unknown bodies, fields and components, units of another
        dimension, and cuts, slices, windows or mirrors that the case cannot have.

        path: location of this table in the case. parts: all valid parts (tables) of the case.
        """
        yield from super().problems(path, parts)
        for name in self.bodies:
            yield from parts.unknown(BodyModel, (*path, "bodies"), name)
        if self.cut is not None and self.cut.through is not None:
            yield from parts.unknown(BodyModel, (*path, "cut", "through"), self.cut.through)
        if self.cut is not None and not all(parts.active_axes):
            yield Finding((*path, "cut"), "a plane case cannot be cut open", "Remove this key.")
        if self.slice is not None and not all(parts.active_axes):
            yield Finding((*path, "slice"), "a plane case cannot be sliced", "Remove this key.")
        if self.window is not None and self.slice is None and all(parts.active_axes):
            yield Finding(
                (*path, "window"),
                "`window` is the visible part of a plane case or slice, but this picture shows bodies in space",
                "Add a `slice`, or remove this key.",
            )
        if self.slice is not None and self.cut is not None:
            yield Finding((*path, "slice"), "a slice cannot be cut open", "Remove `cut` or `slice`.")
        if self.slice is not None and self.slice.thickness is None and parts.lacks_grid:
            yield from parts.no_grid((*path, "slice", "thickness"), "the default thickness of a slice is one cell")
        if self.mirror and parts.lacks_grid:
            yield from parts.no_grid((*path, "mirror"), "the faces are faces of the grid")
        for number, face in enumerate(self.mirror):
            yield from parts.seam((*path, "mirror", number), face)
        if sum(parts.active_axes) == 1:
            yield Finding(path, "a one-dimensional case cannot be drawn as a picture", "Use a [[plot]] of probes.")
        shown = [body for body in parts.of(BodyModel) if not self.bodies or body.name in self.bodies]
        known = dict.fromkeys(name for body in shown for name in body.probed)
        if self.quantity not in (*DERIVED, *known):
            if parts.are_sound(BodyModel):
                names = [*DERIVED, *known]
                text = f"no drawn body has this field; available: {listed(names)}"
                yield Finding((*path, "quantity"), text, hint(self.quantity, names))
            return
        derived = self.quantity in DERIVED
        choices = () if derived else FIELDS[self.quantity].names
        if self.component is not None and self.component not in choices:
            text = f"{self.quantity} has {f'the components {listed(choices)}' if choices else 'no components'}"
            yield Finding((*path, "component"), text, "" if choices else "Remove `component`.")
        yield from unit_problems(self.unit, DERIVED[self.quantity] if derived else FIELDS[self.quantity].unit, (*path, "unit"))


class Picture(Pictured):
    """A figure of the report, `figures/NAME.png`: bodies at several times, one picture for each."""

    instants: AtLeastOne | None = parameter(
        "", "number of recorded frames, evenly spaced from the first to the last (default: 4)", None
    )
    times: Annotated[tuple[float, ...], BeforeValidator(_one_or_several_times)] = parameter(
        "s", "times to draw (instead of `instants`); the nearest recorded frames are used", ()
    )
    largest: str | None = parameter("", "column of the history; the frame at its largest value is drawn", None)
    smallest: str | None = parameter("", "column of the history; the frame at its smallest value is drawn", None)

    @check
    def _has_instants(self) -> None:
        if self.instants is not None and (self.times or self.largest or self.smallest):
            raise ValueError("`instants` cannot be combined with `times`, `largest` or `smallest`; remove `instants`")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield the findings of `Pictured.problems`, and one for each unknown column of the history. For times beyond the end,
        the last frame is shown."""
        yield from super().problems(path, parts)
        for key in ("largest", "smallest"):
            if (name := getattr(self, key)) is not None:
                yield from unknown_column(name, (*path, key), parts)


class Film(Pictured):
    """A film of the report, `figures/NAME.gif`: bodies at many times."""

    pictures: AtLeastTwo = parameter(
        "", "draw at most this many of the recorded frames, evenly spaced from the first to the last", 40
    )
