"""Pictures and films of a case: which bodies, coloured by what, when, from where, and where they are cut open."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator

from pellucid.case.columns import unknown_column
from pellucid.case.plot import Figure, unit_problems
from pellucid.conditions.support import Face
from pellucid.findings import Finding, Path, hint, listed
from pellucid.model import AtLeastOne, AtLeastTwo, Model, Vector, check, one_or_several, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts
from pellucid.state import FIELDS

DERIVED = {"speed": "m/s", "displacement": "m", "load": "Pa", "normal_velocity": "m/s", "bodies": ""}
"""What is worked out of fields, with units: the load is the pressure of fluids and von Mises' equivalent stress of solids, the
normal velocity that of surfaces in space; bodies have a colour each."""
Names = Annotated[tuple[str, ...], BeforeValidator(one_or_several)]


def _one_or_several_times(times: Any) -> Any:
    """Times of which a case may say a single one without brackets."""
    return (times,) if isinstance(times, int | float) else times


class CameraCase(Model):
    """Camera of a picture in space; it looks at the centre of the bodies, without perspective."""

    turn: float = parameter("", "degrees from x about z at which the eye stands", -50.0)
    rise: float = parameter("", "degrees above the plane of x and y", 22.0, ge=-90, le=90)


class CutCase(Model):
    """A plane at which bodies in space are cut open."""

    normal: Vector = parameter("", "direction in which bodies are cut away, towards the eye")
    at: Vector | None = parameter("m", "a place in the plane; without it the middle of `through`", None)
    through: str | None = parameter("", "the body through whose middle at the start the plane goes", None)

    @check
    def _is_complete(self) -> None:
        if (self.at is None) == (self.through is None):
            raise ValueError("a cut needs a place `at` or a body `through`, and not both")
        if not any(self.normal):
            raise ValueError("`normal` needs a length")


class SliceCase(Model):
    """A plane of bodies in space, beside which points lay at the start: they are drawn as dots, seen along the axis."""

    across: Literal["x", "y", "z"] = parameter("", "axis along which it is looked at")
    at: float = parameter("m", "place of the plane along it")
    thickness: float | None = parameter("m", "of what is shown, half on either side; without it that of a cell", None, gt=0)


class WindowCase(Model):
    """Window of a flat picture, by its lower left and upper right corners."""

    lower: tuple[float, float] = parameter("m", "lower left corner")
    upper: tuple[float, float] = parameter("m", "upper right corner")

    @check
    def _has_room(self) -> None:
        if not all(low < high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError("`lower` must be below `upper` along both axes")


class Pictured(Figure):
    """Keys common to pictures and films."""

    bodies: Names = parameter("", "the bodies that are shown; without it all", ())
    quantity: str = parameter("", 'what colours them: a field, or "speed", "displacement", "load" or "bodies"', "speed")
    component: str | None = parameter("", "x, y, z or xx, yy, zz, yz, xz, xy; without it length or von Mises' stress", None)
    unit: str = parameter("", "unit of the colours' scale, such as kPa; without it SI", "")
    limits: tuple[float, float] | None = parameter(
        "", "values at the ends of the colours in that unit; without it as the values are, but for a few extreme ones", None
    )
    mirror: tuple[Face, ...] = parameter("", "faces of the grid that are planes of symmetry, whose mirror images are shown", ())
    arrows: bool = parameter("", "whether surfaces in space have arrows of the velocity in them", False)
    camera: CameraCase = parameter("", "where the eye is, in space", CameraCase())
    cut: CutCase | None = parameter("", "where bodies in space are cut open", None)
    slice: SliceCase | None = parameter("", "a plane of bodies in space that is shown alone", None)
    window: WindowCase | None = parameter("", "what is shown of a flat case or a slice; without it all of the bodies", None)

    @check
    def _has_limits(self) -> None:
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            raise ValueError("the first of `limits` must be below the second")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report unknown bodies, fields and components."""
        yield from super().problems(path, parts)
        for name in self.bodies:
            yield from parts.unknown(BodyModel, (*path, "bodies"), name)
        if self.cut is not None and self.cut.through is not None:
            yield from parts.unknown(BodyModel, (*path, "cut", "through"), self.cut.through)
        if self.cut is not None and not all(parts.active_axes):
            yield Finding((*path, "cut"), "the case is flat: there is nothing to cut open", "leave it out")
        if self.slice is not None and not all(parts.active_axes):
            yield Finding((*path, "slice"), "the case is flat itself", "leave it out")
        if self.window is not None and self.slice is None and all(parts.active_axes):
            yield Finding((*path, "window"), "the picture is not flat", "add a `slice`, or leave it out")
        if self.slice is not None and self.cut is not None:
            yield Finding((*path, "slice"), "a slice has nothing to be cut open", "leave `cut` out")
        if self.slice is not None and self.slice.thickness is None and parts.lacks_grid:
            yield from parts.no_grid((*path, "slice", "thickness"), "without it a slice is as thick as a cell")
        if self.mirror and parts.lacks_grid:
            yield from parts.no_grid((*path, "mirror"), "faces are those of a grid")
        for number, face in enumerate(self.mirror):
            yield from parts.seam((*path, "mirror", number), face)
        if sum(parts.active_axes) == 1:
            yield Finding(path, "the case is a line, of which there is no picture", "use a [[plot]] of probes")
        shown = [body for body in parts.of(BodyModel) if not self.bodies or body.name in self.bodies]
        known = dict.fromkeys(name for body in shown for name in body.probed)
        if self.quantity not in (*DERIVED, *known):
            if parts.are_sound(BodyModel):
                names = [*DERIVED, *known]
                text = f"no body here has such a field; there are {listed(names)}"
                yield Finding((*path, "quantity"), text, hint(self.quantity, names))
            return
        derived = self.quantity in DERIVED
        choices = () if derived else FIELDS[self.quantity].names
        if self.component is not None and self.component not in choices:
            text = f"{self.quantity} has {f'the components {listed(choices)}' if choices else 'no components'}"
            yield Finding((*path, "component"), text, "" if choices else "leave `component` out")
        yield from unit_problems(self.unit, DERIVED[self.quantity] if derived else FIELDS[self.quantity].unit, (*path, "unit"))


class Picture(Pictured):
    """A figure of the report, `figures/NAME.png`: bodies at some instants side by side."""

    instants: AtLeastOne | None = parameter(
        "", "how many of the recorded instants, evenly from the first to the last; without it 4", None
    )
    times: Annotated[tuple[float, ...], BeforeValidator(_one_or_several_times)] = parameter(
        "s", "instants instead: the recorded ones nearest to these", ()
    )
    largest: str | None = parameter("", "column of the history at whose largest value it shows the bodies", None)
    smallest: str | None = parameter("", "column of the history at whose smallest value it shows the bodies", None)

    @check
    def _has_instants(self) -> None:
        if self.instants is not None and (self.times or self.largest or self.smallest):
            raise ValueError("`instants` are chosen evenly: leave it out beside `times`, `largest` and `smallest`")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Report unknown columns too. For times beyond the end, the last frame is shown."""
        yield from super().problems(path, parts)
        for key in ("largest", "smallest"):
            if (name := getattr(self, key)) is not None:
                yield from unknown_column(name, (*path, key), parts)


class Film(Pictured):
    """A film of the report, `figures/NAME.gif`: bodies at many instants, one after the other."""

    pictures: AtLeastTwo = parameter("", "how many of the recorded instants at most, evenly from the first to the last", 40)
