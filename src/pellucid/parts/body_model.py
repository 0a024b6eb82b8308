"""The interface of the model of a body."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Reason, listed
from pellucid.geometry.region import Selectable, within
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase
from pellucid.materials.contract import BodyMaterial
from pellucid.model import Vector, name_parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.part import Part, Parts
from pellucid.parts.standing import Standing
from pellucid.parts.step_limit import NO_LIMIT, StepLimit
from pellucid.state import Field, declare_field

FIELD_MEANING = "velocity field: bodies of one field move together, those of different fields touch by contact"


class BodyModel(Part):
    """A body as the user describes it. A new kind is a subclass with a `kind` of its own."""

    unique_name: ClassVar[bool] = True
    scales_inertia: ClassVar[bool] = False
    """Whether its nodes can have another inertia than their masses on the way to a steady state: it has a `scale_inertia`."""
    moves: ClassVar[bool] = True
    """Whether it has inertia, on which forces act; what does not bounds no step."""
    place: ClassVar[str]
    """The key that says where it is at the start."""
    start_only: ClassVar[tuple[str, ...]] = ("velocity", "initial")
    """Keys of its state at the start alone, beside the place: one that goes on from an earlier run has its state from there."""
    strained_from_place: ClassVar[bool] = True
    """Whether strains are measured from where the case places it, also in a body that goes on from an earlier run."""
    is_surface: ClassVar[bool] = False
    """Whether it is a membrane, which has two sides and no volume of its own."""

    evaluates_loads: ClassVar[bool] = False
    """Whether it evaluates loads on its surface itself: its body `TakesTractions`."""
    fields: ClassVar[Mapping[str, Field]] = {}
    """Fields that it has beside those of `pellucid.state.FIELDS`, by name."""
    pictured: ClassVar[tuple[str, str] | None] = None
    """The field that pictures show as what it bears, and what they call it; without it pressure or stress."""

    kind: str
    name: str = name_parameter("name of the body, used for its files and in probes")
    field: str = name_parameter(FIELD_MEANING, "common")

    if TYPE_CHECKING:  # each kind declares them among its own keys, in the order of the reference
        material: BodyMaterial
        velocity: Vector

    @classmethod
    def __pydantic_init_subclass__(cls, **arguments: Any) -> None:
        """Declare its fields. Raises TypeError where others have their names."""
        super().__pydantic_init_subclass__(**arguments)
        for name, field in cls.fields.items():
            declare_field(name, field, cls.__name__)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """That there is no grid, reported by the first body that needs one."""
        needing = [body for body in parts.of(BodyModel) if body.needs_grid(parts)]
        if parts.lacks_grid and needing and needing[0] is self:
            several = len(needing) > 1
            names = listed([body.name for body in needing])
            text = f"is missing: bodies {names} need one" if several else f"is missing: body {self.name} needs one"
            yield Finding(("grid",), text, "add a table [grid] with `lower`, `upper` and `cell`")

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner at the start [m], each of shape (3,)."""

    def standing(self, grid: GridCase) -> Standing:
        """Where it stands at the start, without points where only the body that is built knows these. Raises CaseError where it
        can have none there."""
        return Standing(np.zeros((0, 3)))

    @abstractmethod
    def occupied(self) -> Geometry | None:
        """The region that it occupies at the start, which other bodies can leave out of theirs; None where there is no such."""

    @property
    @abstractmethod
    def probed(self) -> tuple[str, ...]:
        """The fields that probes can read."""

    @abstractmethod
    def n_points(self, grid: GridCase | None) -> float:
        """Number of points, good to a layer of them; None where the case has no grid."""

    def table_bytes(self) -> float:
        """Memory that it takes beside its points, such as tables of shape functions [bytes]."""
        return 0.0

    @abstractmethod
    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Velocities at the start [m/s], shape (n, 3), at positions [m], shape (n, 3)."""

    @abstractmethod
    def build(self, placement: Placement) -> Body:
        """Build the body; in a case with several, from the model that `with_others` returns."""

    def check_set_up(self) -> None:
        """Raise CaseError for what is found only while it is set up, where that is quickly told; nothing needs to be."""

    def start_warnings(self) -> Iterator[str]:
        """What is likely wrong though it can be run, found without setting it up."""
        yield from ()

    def touching_places(self, grid: GridCase, hard: bool) -> np.ndarray:
        """Where others touch it first at the start [m], shape (m, 3); hard: whether it does not deform."""
        return self.standing(grid).position

    def faces_pressed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Where its own faces resolve what presses on it at the start: their middles [m] and outward vector areas [m²], shape
        (m, 3), and edges [m], shape (m,); None where the cells of the grid do."""
        return None

    def owns_nodes(self, alone: bool) -> bool:
        """Whether it has nodes of its own, not those of the grid; `alone`: whether it has a velocity field to itself."""
        return False

    @property
    def has_triangles(self) -> bool:
        """Whether it has a surface of triangles between its points, of which probes can tell area and enclosed volume."""
        return False

    def selectable(self) -> Selectable | None:
        """What regions of conditions choose from at the start; None where that is known only when it is built."""
        return None

    @property
    def deforms_in_contact(self) -> bool:
        """Whether others touch it by its surface though it deforms, and not on the nodes of the grid."""
        return False

    @property
    def solves_viscosity(self) -> bool:
        """Whether its viscosity is solved for on the nodes of the grid."""
        return False

    @property
    def is_rigid(self) -> bool:
        """Whether it moves as a rigid body."""
        return False

    def channels(self) -> Sequence[Channel]:
        """The channels of work and losses that it counts itself."""
        return ()

    @property
    def has_own_step(self) -> bool:
        """Whether it takes steps of its own within those of the clock, which then need no bound but that of the output."""
        return False

    def why_not_relaxed(self, alone: bool) -> Finding | None:
        """Why it cannot be brought to a steady state, at the key of its table at fault, if so; `alone`: whether it has a
        velocity field to itself."""
        return Finding(("kind",), f'kind "{self.kind}" has no steady states', "leave [steady] out")

    def with_others(self, bodies: "Sequence[BodyModel]") -> Self:
        """The same model with the others of its case, whose regions it may leave out."""
        return self

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool], periods: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Which places [m], shape (n, 3), lie inside it at the start, shape (n,), along the axes that are `active`; periods: of
        the grid [m], see `GridCase.periods`."""
        region = self.occupied()
        return np.zeros(len(places), bool) if region is None else within(region, places, active, periods)

    def needs_grid(self, parts: Parts) -> bool:
        """Whether it cannot do without a grid in this case."""
        return True

    def excluded_bodies(self) -> tuple[str, ...]:
        """Names of the bodies whose regions it leaves out of its own."""
        return ()

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """Why another body cannot leave out its region, if so."""
        return None

    def why_no_motion(self) -> Reason | None:
        """Why it cannot follow a prescribed motion, if so."""
        return None

    def why_no_outflow(self) -> Reason | None:
        """Why its points cannot leave through faces of the grid, if so."""
        return Reason(f"the points of body {self.name} belong together: none can leave", "name bodies of material points")

    def why_no_inflow(self) -> Reason | None:
        """Why no points can come into it through faces of the grid, if so."""
        return Reason(f"the points of body {self.name} belong together: none can come in", "name a body of material points")

    def why_no_wall(self) -> Reason | None:
        """Why it cannot touch walls that are planes without a body, if so."""
        return Reason(f'body {self.name}, of kind "{self.kind}", cannot touch a wall', "leave it out of `bodies`")

    def why_no_self_contact(self, alone: bool) -> Reason | None:
        """Return why contact of the body with itself cannot be computed; None if it can. alone: whether no other body is in its
        velocity field."""
        text = f'body {self.name}, of kind "{self.kind}", cannot touch itself: its parts share the velocities of the grid'
        return Reason(text, "use kind membrane-elements or meshless-solid, or name two bodies")

    def why_no_normal_motion(self, whole: bool) -> Reason | None:
        """Why its nodes, or where `whole` all of them, cannot follow a prescribed motion along their normal, if so."""
        return Reason(f"body {self.name} is no fluid film", "give the displacement along x, y or z")

    def why_no_yielding_wall(self, alone: bool) -> Reason | None:
        """Why walls neither rub on it nor let it go, if so; `alone`: whether it has a velocity field to itself."""
        remedy = "leave it out; a floor that does is a body held by a motion, in a `field` of its own and with a [[contact]]"
        if self.is_rigid and not self.why_no_wall():
            remedy = (
                'use a [[wall]] in place of this support, which takes `kind = "coulomb"` with `friction`, or `kind = "stick"`'
            )
        if self.is_rigid:
            return Reason(f"body {self.name} is rigid: walls do not rub on it, and push alone", remedy)
        if self.moves and self.owns_nodes(alone):
            return Reason(f"body {self.name} has nodes of its own, on which no wall rubs and which none lets go", remedy)
        return None

    def why_not_strained_first(self) -> Reason | None:
        """Why its points cannot be strained before the momentum equation, as with USF, if so."""
        return None

    def wave_speeds(self) -> tuple[float, float] | None:
        """Speeds of plane pressure and shear waves at the start [m/s], which a face of the grid can absorb; None where no such
        waves cross it."""
        return None

    def waves_at_start(self) -> tuple[float, float]:
        """Speeds of pressure and shear waves of its material at the start [m/s], by which times are measured."""
        return self.material.wave_speeds()

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """The largest stable step at the start, in cells of this edge [m] if there are any: a fixed one must not pass it. None
        where only the body that is built knows one.

        is_driven: whether the whole body follows a prescribed motion along every axis.
        """
        return None if self.moves else NO_LIMIT

    def limit_in_motion(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """What is likely to bound the step once the body moves: as near as its model tells."""
        return self.step_limit(cell, is_driven)

    def fastest_at_start(self, places: np.ndarray) -> float:
        """The largest speed at the start [m/s] at places [m], shape (n, 3)."""
        velocity = self.initial_velocity(places)
        return float(np.sqrt(np.max(np.sum(velocity * velocity, axis=1))))

    def places_between_bounds(self) -> np.ndarray:
        """A lattice of places where it may be at the start [m], shape (n, 3)."""
        lower, upper = self.bounds()
        share = np.stack(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 9)], indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(lower + share * (upper - lower))


def selectable_of(body: BodyModel, parts: Parts) -> Selectable | None:
    """What regions of conditions choose from of a body in a case, as far as that is known before it is built."""
    of, grid = body.selectable(), parts.grid
    return of if of is None or grid is None else of._replace(periods=grid.periods())


def is_alone(body: BodyModel, parts: Parts) -> bool:
    """Whether a body has a velocity field to itself; without a grid there are no fields."""
    return parts.grid is None or sum(other.field == body.field for other in parts.of(BodyModel)) == 1
