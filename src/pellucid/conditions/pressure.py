"""Data model of a pressure on a membrane or on faces of a solid."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np

from pellucid.conditions.enclosed.foretold import encloses_problems, membrane_at_start, volume_at_start
from pellucid.conditions.enclosed.given_volume import ActiveVolume, GivenVolume, bound_of_spring, critical, start_fault
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.conditions.enclosed.volume import failed_points
from pellucid.conditions.loaded_faces import LoadedFaces, face_problems, in_plane_problem
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.geometry.region import Where, faults
from pellucid.model import check, parameter
from pellucid.parts.annotations import Assembly, Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import SurfacePoints, TakesPressure, TakesTractions
from pellucid.parts.condition import Condition, LoadKind, Swing
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart


class Pressure(ChangesInTime, Condition):
    """A pressure difference across a membrane or a pressure on the faces of a solid, along the current normal (follower
    load)."""

    load_kind: ClassVar[LoadKind] = "follower"
    swings_as: ClassVar[Swing] = Swing("spring", "its membrane oscillates on its given volume")

    body: str = parameter("", "name of a membrane, or of a solid with its own nodes")
    value: float | None = parameter(
        "Pa",
        "for a membrane, pressure on its back minus pressure on its front, acting along the normal; "
        "for a solid: pressure against the outward normal",
        None,
    )
    volume: GivenVolume | None = parameter(
        "", "alternative to `value`: the prescribed enclosed volume of a membrane; the pressure enforces it", None
    )
    stiffness: float | None = parameter(
        "Pa",
        "penalty: pressure per volume error divided by the largest prescribed volume; default: as stiff as "
        "possible without limiting the time step",
        None,
        gt=0,
    )
    lids: bool = parameter("", "true: flat lids close the rims of a membrane with prescribed volume", False)
    where: Where | None = parameter(
        "", "faces on which the pressure acts; default: all of a membrane, all outer faces of a solid", None
    )
    choose: Literal["start", "each-step"] = parameter(
        "",
        "when the faces in `where` are selected: at the start, so that the same faces stay loaded, or in each step by "
        "their centres, so that the region is fixed in space",
        "start",
    )

    @check
    def _has_one_size(self) -> None:
        if (self.value is None) == (self.volume is None):
            raise Refusal("both `value` and `volume`" if self.volume else "neither `value` nor `volume`", "give one of the two")
        for_volumes = [key for key in ("stiffness", "lids") if getattr(self, key)]
        if self.volume is None and for_volumes:
            raise ValueError(f"`{for_volumes[0]}` belongs to `volume`: add a volume, or remove this key")
        for_values = [key for key in ("where", "rise", "amplitude") if getattr(self, key)]
        if self.volume is not None and for_values:
            raise ValueError(
                f"`{for_values[0]}` belongs to `value`: the pressure follows from a prescribed volume; remove this key"
            )

    @check
    def _chooses_something(self) -> None:
        if self.choose == "each-step" and self.where is None:
            raise ValueError("`choose` belongs to `where`: add a region, or remove `choose`")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or has no normal, and faces that do not exist. path: location of
        the condition in the case; parts: all parts of the case."""
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is None:
            return
        if self.volume is not None:
            yield from self._volume_problems(self.volume, path, parts)
            return
        place, each_step = (*path, "body" if self.where is None else "where"), self.choose == "each-step"
        if body.is_surface and self.where is not None:
            yield from self._region_problems(self.where, place, body, parts)
        elif not body.is_surface and body.selectable() is None:
            text = f"body {self.body} is not a membrane and has no mesh, so it has no normal"
            yield Finding((*path, "body"), text, "name a membrane or a body of kind meshless-solid")
        elif not body.is_surface:
            yield from face_problems(self.where or "boundary", place, self.body, parts, each_step)

    def _region_problems(self, where: Where, path: Path, body: BodyModel, parts: Parts) -> Iterator[Finding]:
        """Yield findings if a pressure cannot act on a region (`where`) of a membrane: the body takes pressure on all of it
        only, the problem is plane, or the region contains no faces. path: location in the case for the findings; parts: all
        parts of the case; body: model of the membrane."""
        start = body.selectable()
        if body.evaluates_loads or start is None:
            text = f'body {self.body} is of kind "{body.kind}": a pressure acts on all of it'
            yield Finding(path, text, "remove `where`, or use a [[load]] of kind film-pressure with a `band`")
        elif not all(parts.active_axes):
            yield in_plane_problem(path, self.body)
        else:
            yield from faults(where, start, path, self.body, faces=True, by_centre=True)

    def _volume_problems(self, given: GivenVolume, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings if a membrane cannot have the prescribed volume `given`: it encloses no volume, starts with
        another volume, or another condition determines its pressure. path: location of the condition in the case; parts:
        all parts of the case."""
        wrong = list(encloses_problems(self.body, self.lids, path, parts, allows_flat=given.ratios is None))
        yield from wrong
        body = parts.named(BodyModel, self.body)
        start = None if wrong or body is None else body.selectable()
        if start is not None and (text := start_fault(given, volume_at_start(start.position, start.faces))):
            yield Finding((*path, "volume"), text, "start with that volume, or give `ratios` of it")
        for other_path, other in parts.placed(Condition):
            if other is not self and other_path < path and set(self.columns()) & set(other.columns()):
                yield Finding(
                    (*path, "volume"),
                    f"`{'.'.join(map(str, other_path))}` already has history columns with these names",
                    "remove one of the two",
                )
            if isinstance(other, Enclosed) and other.body == self.body:
                text = f"`{other.name}` is enclosed in body {self.body} and already determines the pressure"
                yield Finding((*path, "volume"), text, "remove one of the two")

    def columns(self) -> Mapping[str, str]:
        return {} if self.volume is None else {f"{self.body}_pressure": "Pa", f"{self.body}_volume": "m^3"}

    def swing_of(self, body: BodyModel, rate: float, cell: float | None) -> float:
        start = membrane_at_start(body) if self.volume is not None and body.name == self.body else None
        if start is None or self.volume is None:
            return 0.0
        spring = self.volume.spring(self.stiffness, start.volume, rate, start.mobility)
        return bound_of_spring(spring, critical(spring, start.mobility), start.mobility)

    def why_not_steady(self) -> Reason | None:
        """Return the reason why no steady state can be computed with a prescribed volume: the relaxation does not include
        the stiffness of the spring that enforces the volume. None for a prescribed pressure."""
        if self.volume is None:
            return None
        text = "the relaxation cannot find the equilibrium of a membrane with a prescribed volume"
        return Reason(text, "use a case that can have a factored stiffness, use a `value`, or remove [steady]")

    def kind_of_load(self) -> LoadKind:
        return self.load_kind if self.volume is None else "volume"

    def load_channel(self) -> str:
        return "load_work"

    @classmethod
    def activate(cls, conditions: Sequence["Pressure"], assembly: Assembly) -> Sequence[StepPart]:
        return [pressure.active(assembly, number) for number, pressure in enumerate(conditions)]

    def active(self, assembly: Assembly, number: int) -> StepPart:
        """Build the condition that applies the pressure in a run; number: index of this pressure in the case."""
        if self.volume is not None:
            if assembly.finds_equilibria:
                from pellucid.conditions.enclosed.steady import SteadyVolume

                return SteadyVolume(self.body, self.volume, self.load_channel(), assembly)
            return ActiveVolume(self.body, self.volume, self.stiffness, self.load_channel(), assembly)
        member, channel = assembly.bodies[self.body], self.load_channel()
        is_surface = member.body.is_surface
        if not is_surface or self.where is not None:
            each_step, outward = self.choose == "each-step", -1.0 if is_surface else 1.0
            path = ("pressure", number, "where")
            faces = LoadedFaces(member, self.where or "boundary", path, is_surface or each_step, each_step)
            return PressedFaces(faces, lambda time: outward * self.at(time), assembly.forces_on(self.body, channel), path)
        if isinstance(member.body, TakesTractions):
            return surface_load(self.traction, self.body, channel, assembly, f"pressure.{number}")
        membrane, column = member.offers(TakesPressure), assembly.load_column(self.body, channel)
        return PressedMembrane(lambda time: membrane.add_pressure(self.at(time), column), member.body)

    def at(self, time: float) -> float:
        """Return the pressure [Pa] at a time [s]."""
        return (self.value or 0.0) * self.share(time)

    def traction(self, points: SurfacePoints, time: float) -> np.ndarray:
        """Return the force per unit current area [Pa], shape (..., 3), at points of a film surface and a time [s]."""
        return self.at(time) * points.normal


class PressedMembrane(AtEachStep):
    """Applies a pressure to a whole membrane in each step."""

    def __init__(self, act: Callable[[float], object], body: Body) -> None:
        super().__init__(act)
        self._body = body

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        return _holes(self._body)


def _holes(body: Body) -> dict[str, str]:
    """Return a warning about the failed points of a membrane, through which no flow is computed, by topic."""
    if not (failed := len(failed_points(body))):
        return {}
    text = (
        f"membrane {body.name} has failed at {failed} of its {body.n_points} points: the prescribed pressure continues and "
        "does not act on their holes; reduce it by `amplitude`, use an [[enclosed]] gas, which flows out "
        "through the holes, or end the run before"
    )
    return {"holes": text}


class PressedFaces(StepPart):
    """Applies a pressure to the faces of a body in a region in each step."""

    def __init__(
        self, faces: LoadedFaces, pressure: Callable[[float], float], add: Callable[[np.ndarray], object], path: Path
    ) -> None:
        """faces: faces that the region selects; pressure: pressure against the outward normals [Pa] as a function of time
        [s]; add: function that applies forces [N], shape (n, 3), to the body; path: path of the region in the case."""
        self._faces, self._pressure, self._add, self._path = faces, pressure, add, path
        self._misses = False

    def begin(self, time: float, dt: float) -> None:
        pressure = self._pressure(time)
        self._add(self._faces.pressure(pressure))
        self._misses = pressure != 0.0 and self._faces.is_left

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return warnings if no face of the body is in the region of the pressure now, and about holes that failed points
        leave."""
        found = _holes(self._faces.body)
        if not self._misses:
            return found
        where, name = ".".join(map(str, self._path)), self._faces.body.name
        what = f"`{where}` has no effect: no face of body `{name}` has its centre in it now"
        return found | {"region": f'{what}; enlarge it, or set choose = "start" to load the same faces wherever they move'}


TractionInTime = Callable[[SurfacePoints, float], np.ndarray]
"""Function of surface points and time [s] that returns the force per unit current area [Pa], shape (..., 3)."""


def surface_load(traction: TractionInTime, body: str, channel: str, assembly: Assembly, label: str) -> StepPart:
    """Return an active condition that applies a force per unit area [Pa], given by the function `traction` of points and
    time, to the body named `body`; channel: name of the entry of the energy balance for the work of this force; label: name
    of the load for users."""
    film, column = assembly.bodies[body].offers(TakesTractions), assembly.load_column(body, channel)
    return AtEachStep(lambda time: film.add_traction(lambda points, after: traction(points, time + after), column, label))
