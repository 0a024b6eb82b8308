"""Interface of the model of a body in a case, which a new kind of body implements: its geometry and motion at the start, its
keys and checks."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import PrivateAttr

from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Reason, listed
from pellucid.geometry.region import Selectable, within
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase
from pellucid.materials.contract import BodyMaterial, ImplicitStress
from pellucid.model import Vector, name_parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.elastic_system import StiffnessSize
from pellucid.parts.part import Part, Parts
from pellucid.state import Field, declare_field
from pellucid.step.limit import NO_LIMIT, StepLimit


class Standing(NamedTuple):
    """Initial positions of the n points of a body."""

    position: np.ndarray
    """Positions of the points [m], shape (n, 3)."""
    triangles: np.ndarray | None = None
    """Triangles of a membrane, shape (m, 3), as point numbers."""
    volume: np.ndarray | None = None
    """Volumes of the points [m³], shape (n,), if they are more accurate than the shape of the body."""


class StartOfBody(Part):
    """Base class of the models of bodies: the state at the start."""

    place: ClassVar[str]
    """Name of the key that defines the initial geometry of the body."""
    start_only: ClassVar[tuple[str, ...]] = ("velocity", "initial")
    """Keys of the initial state, in addition to `place`; for a body that continues an earlier run, the state comes from
    that run."""
    strained_from_place: ClassVar[bool] = True
    """True if strains are measured from the geometry in the case, also for a body that continues an earlier run."""

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of the body's bounding box at the start [m], each of shape (3,)."""

    def standing(self, grid: GridCase) -> Standing:
        """Return the initial positions of the points on the grid; without points if the positions are known only when the
        body is built. Raises CaseError if the body cannot be placed."""
        return Standing(np.zeros((0, 3)))

    @abstractmethod
    def occupied(self) -> Geometry | None:
        """Return the initial region of the body, which other bodies can exclude from theirs; None if there is none."""

    @abstractmethod
    def n_points(self, grid: GridCase | None) -> float:
        """Return the number of points of the body, accurate to one layer of points; grid: None if the case has no grid."""

    @abstractmethod
    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Return the initial velocities [m/s], shape (n, 3), at positions [m], shape (n, 3)."""

    def touching_places(self, grid: GridCase, hard: bool) -> np.ndarray:
        """Return the initial positions at which other bodies can touch this body first [m], shape (m, 3); hard: True if this
        body does not deform; grid: table of the grid."""
        return self.standing(grid).position

    def faces_pressed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Return centres [m], shape (m, 3), and outward vector areas [m²], shape (m, 3), and edge lengths [m], shape (m,), of
        the faces of the body on which pressure acts.

        Returns None if pressure acts on the body through cells of the grid instead.
        """
        return None

    def selectable(self) -> Selectable | None:
        """Return the initial nodes and faces from which regions in the case select; None if they are known only when the body
        is built."""
        return None

    @property
    def has_triangles(self) -> bool:
        """True if the body has a triangulated surface, whose area and enclosed volume probes can read."""
        return False

    def contains(self, places: np.ndarray, active: tuple[bool, bool, bool], periods: Vector = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return a mask of the positions [m], shape (n, 3), that are inside the body at the start along the `active` axes,
        shape (n,).

        periods: periods of the grid [m], see `GridCase.periods`.
        """
        region = self.occupied()
        return np.zeros(len(places), bool) if region is None else within(region, places, active, periods)

    def excluded_bodies(self) -> tuple[str, ...]:
        """Return the names of the bodies whose regions this body excludes from its own."""
        return ()

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """Return the reason why another body cannot exclude the region of this body from its own, or None; grid: None if the
        case has none."""
        return None

    def with_others(self, bodies: "Sequence[BodyModel]") -> Self:
        """Return the model with access to the other bodies of the case, whose regions it may exclude from its own."""
        return self

    def fastest_at_start(self, places: np.ndarray) -> float:
        """Return the largest initial speed of the body [m/s] at positions [m], shape (n, 3)."""
        velocity = self.initial_velocity(places)
        return float(np.sqrt(np.max(np.sum(velocity * velocity, axis=1))))

    def places_between_bounds(self) -> np.ndarray:
        """Return the points of a regular lattice that spans the bounding box of the body [m], 9 along each axis, shape
        (729, 3)."""
        lower, upper = self.bounds()
        share = np.stack(np.meshgrid(*3 * [np.linspace(0.0, 1.0, 9)], indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(lower + share * (upper - lower))


FIELD_MEANING = "velocity field: bodies in the same field move together, bodies in different fields interact by contact"


class BodyModel(StartOfBody):
    """A body as defined in a case. A new kind of body is a subclass with its own `kind`."""

    unique_name: ClassVar[bool] = True
    scales_inertia: ClassVar[bool] = False
    """True if, in the search for a steady state, the nodes can have an inertia that differs from their mass; such a body
    has a key `scale_inertia`."""
    moves: ClassVar[bool] = True
    """True if the body has inertia, on which forces act; otherwise it does not limit the time step."""
    takes_motions: ClassVar[bool] = True
    """True if the nodes or points can follow a prescribed motion along the axes."""
    separate_points: ClassVar[bool] = False
    """True if the body consists of points that are not connected, so that points can leave and enter."""
    own_material_nodes: ClassVar[bool] = False
    """True if the body can have its own nodes, which follow its material, as meshless solids and membranes of elements. Such
    a body touches walls and itself, and its steady states can be computed."""
    is_surface: ClassVar[bool] = False
    """True if the body is a membrane, which has two sides and no volume of its own."""
    has_own_step: ClassVar[bool] = False
    """True if the body has its own sub-steps; then only output limits the time step of the run."""
    remedy_for_node_contact: ClassVar[str] = "use a smaller grid.cell"
    """Remedy, as text for the user, if the body has contact with solids or membranes on the nodes of the grid instead of by
    surfaces."""
    evaluates_loads: ClassVar[bool] = False
    """True if the body evaluates loads on its surface itself: the built body then `TakesTractions`."""
    fields: ClassVar[Mapping[str, Field]] = {}
    """Fields of the body in addition to `pellucid.state.FIELDS`, by name."""
    pictured: ClassVar[tuple[str, str] | None] = None
    """Name and label of the field that pictures show as the load of the body; None for the default, pressure or stress."""

    kind: str
    name: str = name_parameter("name of the body, used for its files and in probes")
    field: str = name_parameter(FIELD_MEANING, "common")

    _is_wall: bool = PrivateAttr(default=False)

    if TYPE_CHECKING:  # each kind declares them among its own keys, in the order of the reference
        material: BodyMaterial
        velocity: Vector

    @classmethod
    def __pydantic_init_subclass__(cls, **arguments: Any) -> None:
        """Declare the additional `fields` of a new kind of body, so that results can store these fields. Raises TypeError
        if a name is already used."""
        super().__pydantic_init_subclass__(**arguments)
        for name, field in cls.fields.items():
            declare_field(name, field, cls.__name__)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield an error if the case has no grid, for the first body that needs one.

        path: location of the body in the case; parts: all parts of the case.
        """
        needing = [body for body in parts.of(BodyModel) if body.needs_grid(parts)]
        if parts.lacks_grid and needing and needing[0] is self:
            several = len(needing) > 1
            names = listed([body.name for body in needing])
            text = f"is missing: bodies {names} need one" if several else f"is missing: body {self.name} needs one"
            yield Finding(("grid",), text, "add a table [grid] with `lower`, `upper` and `cell`")

    @property
    @abstractmethod
    def probed(self) -> tuple[str, ...]:
        """Names of the fields of the body that probes can read."""

    def table_bytes(self) -> float:
        """Return the memory needed in addition to that of the points, such as for tables of shape functions [bytes]."""
        return 0.0

    @abstractmethod
    def build(self, placement: Placement) -> Body:
        """Build the body in the surroundings `placement`; in a case with several bodies, this method is called on the model
        that `with_others` returns."""

    def check_set_up(self) -> None:
        """Raise CaseError for errors that appear only during set-up, if they can be found quickly. Optional."""

    def start_warnings(self) -> Iterator[str]:
        """Yield warnings about probable mistakes in the case that do not prevent a run, found without building the body."""
        yield from ()

    def owns_nodes(self, alone: bool) -> bool:
        """Return True if the body has its own nodes instead of the nodes of the grid; alone: no other body is in its
        velocity field."""
        return False

    @property
    def deforms_in_contact(self) -> bool:
        """True if the body is deformable and has contact by its surface, not on the nodes of the grid."""
        return False

    @property
    def is_fluid(self) -> bool:
        """True for a fluid, whose contact is on the nodes of the grid."""
        return False

    @property
    def shear_viscosity(self) -> float:
        """Shear viscosity of a fluid at rest [Pa s]; 0 for other bodies."""
        return 0.0

    def keep_out_of(self, walls: Sequence[Geometry]) -> Self:
        """Return a copy of the settings of a fluid that leaves out the parts of the body inside walls; of other bodies, the
        settings themselves."""
        return self

    def wall_region(self, grid: GridCase) -> Geometry | None:
        """Return the region that a solid fills at the start, else None; called on the model that `with_others` returns."""
        return None

    @property
    def is_wall(self) -> bool:
        """True if the body acts as a wall on the fluids of its velocity field: fluids do not slip on its surface, and its
        points have grid nodes of their own."""
        return self._is_wall

    def as_wall(self, is_wall: bool) -> Self:
        """Return a copy of the settings with this value of `is_wall`, or the settings themselves if it is the same."""
        if is_wall == self._is_wall:
            return self
        aware = self.model_copy()
        aware._is_wall = is_wall
        return aware

    @property
    def nodes_of(self) -> str:
        """Name of the set of grid nodes that the body shares with others: the velocity field, except for walls of fluids."""
        return f"walls of {self.field}" if self.is_wall else self.field

    @property
    def crumples(self) -> bool:
        """True if the body resists neither compression nor bending, so that it folds within the length of an element."""
        return False

    @property
    def implicit_stress(self) -> ImplicitStress | None:
        """Parameters of the stress of the body that is solved for on the nodes of the grid; None without."""
        return None

    @property
    def is_rigid(self) -> bool:
        """True if the body is rigid."""
        return False

    def channels(self) -> Sequence[Channel]:
        """Return the channels (entries of the energy balance) of works and losses that the body itself computes."""
        return ()

    def needs_grid(self, parts: Parts) -> bool:
        return True

    def why_no_stiffness(self) -> str | None:
        """Return the reason why equilibria of the body cannot be found with a factored stiffness, as a clause; None if they
        can: the built body then `HasElasticSystem`."""
        return f'the stiffness of bodies of kind "{self.kind}" is not available for factored methods'

    def why_no_implicit_steps(self) -> str | None:
        """Return the reason why the body cannot move in implicit time steps, as a clause; None if it can: the built body then
        `HasMovingSystem`."""
        return f'bodies of kind "{self.kind}" cannot move in implicit steps'

    def stiffness_size(self) -> StiffnessSize | None:
        """Return the size of the factored stiffness of the body; None if its equilibria cannot be found with it
        (`why_no_stiffness`)."""
        return None

    def wave_speeds(self) -> tuple[float, float] | None:
        """Return the initial speeds of plane pressure and shear waves [m/s] that travel in the body and that an absorbing face
        of the grid can absorb.

        Returns None if no such waves reach the face.
        """
        return None

    def waves_at_start(self) -> tuple[float, float]:
        """Return the initial speeds of pressure and shear waves of the material [m/s], from which time scales of the body
        follow."""
        return self.material.wave_speeds()

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the largest stable time step at the start, as an upper bound of a fixed step; None if it is known only
        when the body is built.

        cell: edge length of the cells [m], or None; is_driven: the whole body follows a prescribed motion along every axis.
        """
        return None if self.moves else NO_LIMIT

    def limit_in_motion(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return an estimate of the largest stable time step once the body moves; None if it is known only when the body is
        built. cell, is_driven: see `step_limit`."""
        return self.step_limit(cell, is_driven)


def selectable_of(body: BodyModel, parts: Parts) -> Selectable | None:
    """Return the nodes and faces of a body from which regions in the case select, if these are known before the body is
    built, else None; parts: all parts of the case."""
    of, grid = body.selectable(), parts.grid
    return of if of is None or grid is None else of._replace(periods=grid.periods())


def may_be_wall(body: BodyModel) -> bool:
    """Return True for a solid that fills a region of its own, and can thus act as a wall of fluids if its motion is
    prescribed."""
    return body.separate_points and not body.is_fluid


def is_alone(body: BodyModel, parts: Parts) -> bool:
    """Return True if no other body shares the velocity field of a body; always True without a grid. parts: all parts of the
    case."""
    return parts.grid is None or sum(other.field == body.field for other in parts.of(BodyModel)) == 1
