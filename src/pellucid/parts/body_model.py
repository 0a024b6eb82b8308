"""Interface of the model of a body in a case, which a new kind of body implements."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import PrivateAttr

from pellucid.energy import Channel
from pellucid.findings import Finding, Path, listed
from pellucid.geometry.region import Selectable
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase
from pellucid.materials.contract import BodyMaterial, ImplicitStress
from pellucid.model import Vector, name_parameter
from pellucid.parts.annotations import Body, Placement
from pellucid.parts.part import Parts
from pellucid.parts.start_of_body import StartOfBody
from pellucid.state import Field, declare_field
from pellucid.step.limit import NO_LIMIT, StepLimit

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
