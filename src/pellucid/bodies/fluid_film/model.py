"""Settings of a fluid film in a case file, and their checks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import PrivateAttr

from pellucid.approximants.radial import AnyRadial
from pellucid.approximants.radial.polyharmonic import PolyharmonicModel
from pellucid.bodies.fluid_film.checks import own_problems, problems_alone, problems_in_fluid
from pellucid.bodies.fluid_film.conditions.volume_constraints import Goals, VolumeCase, reduced_to_volume
from pellucid.bodies.fluid_film.drag import DragCase
from pellucid.bodies.initial import INITIAL_MEANING, Initial
from pellucid.bodies.initial.state import initial_problems, initial_velocity
from pellucid.energy import DAMPING_HEAT, VISCOUS_HEAT, Channel
from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.meshes.points import spatial_order
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.geometry.region import Selectable
from pellucid.geometry.surfaces.film_shapes import FilmShape
from pellucid.grid.model import GridCase
from pellucid.materials.lipid_film import LipidFilm
from pellucid.model import Vector, parameter
from pellucid.parts.body_model import BodyModel, is_alone
from pellucid.parts.part import Parts
from pellucid.parts.standing import Standing
from pellucid.parts.step_limit import NO_LIMIT, StepLimit
from pellucid.state import Field

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.balance import FilmBalance
    from pellucid.bodies.fluid_film.forms.virtual_power import FilmPhysics
    from pellucid.bodies.fluid_film.own_steps import OwnSteps
    from pellucid.bodies.fluid_film.solvers.contract import FilmSolver
    from pellucid.bodies.fluid_film.surfaces.contract import FilmGeometry
    from pellucid.bodies.fluid_film.surfaces.operators import Operators
    from pellucid.parts.body import Body
    from pellucid.parts.placement import Placement

CURVE_BYTES, SURFACE_BYTES = 27_000, 80_000  # memory per node, see `validation/memory`


class FluidFilmCase(BodyModel):
    """A film of fluid, such as the skin of a vesicle: viscous within its surface, without inertia."""

    place: ClassVar[str] = "shape"
    start_only: ClassVar[tuple[str, ...]] = (*BodyModel.start_only, "density")
    strained_from_place: ClassVar[bool] = False
    is_surface: ClassVar[bool] = True
    evaluates_loads: ClassVar[bool] = True
    fields: ClassVar[Mapping[str, Field]] = {
        "areal_density": Field(1, "kg/m^2", "surface density of a fluid film"),
        "tension": Field(1, "N/m", "tension of a film (minus its surface pressure) or of a membrane (mean of both directions)"),
        "curvature": Field(1, "1/m", "sum of the principal curvatures of a film or membrane, positive for a sphere"),
        "bending_energy": Field(
            1, "J", "bending energy of a film or membrane around the node; the sum over the nodes is the energy of the body"
        ),
        "distance": Field(1, "m", "distance of a node of a fluid film from the film's centre of mass"),
    }
    pictured: ClassVar[tuple[str, str]] = "areal_density", "surface density"

    kind: Literal["fluid-film"] = "fluid-film"
    shape: FilmShape = parameter("", "initial shape of the film")
    material: LipidFilm = parameter("", "material of the film")
    density: float | None = parameter("kg/m^2", "initial surface density; default: the rest density", None, gt=0)
    drag: DragCase = parameter("", "drag of the surrounding fluid", DragCase(normal=0.0, tangential=0.0))
    velocity: Vector = parameter(
        "m/s", "initial velocity, for a film that shares its velocity field with other bodies", (0.0, 0.0, 0.0)
    )
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())
    volume: VolumeCase | None = parameter("", "constraint of the enclosed volume; default: free", None)
    area: Literal["free", "kept"] = parameter("", "total area of the film: free, or kept constant", "free")
    interpolation: Literal["radial", "loop"] | None = parameter(
        "",
        "interpolation between nodes: radial functions (curves), or Loop subdivision (surfaces in space: default, and "
        "required with bending)",
        None,
    )
    radial: AnyRadial = parameter("", 'radial basis functions, used with interpolation = "radial"', PolyharmonicModel())
    nodes: Literal["even", "material"] = parameter(
        "", "even: nodes stay at equal distances and the film flows past them; material: nodes move with the film", "even"
    )
    scheme: Literal["implicit"] = parameter("", "time integration: implicit in the stiff terms", "implicit")
    accuracy: float = parameter("", "allowed error of a substep, relative to the smallest node distance", 1e-3, gt=0, le=0.1)
    time_weight: float = parameter(
        "",
        "parameter α of the generalised trapezoidal rule of time integration: 1/2 is the midpoint rule, of second order",
        0.5,
        gt=0,
        le=1,
    )

    _is_shared: bool = PrivateAttr(False)  # True if other bodies share its velocity field

    @property
    def initial_density(self) -> float:
        """Initial surface density [kg/m²]."""
        return self.density or self.material.density

    def physics(self) -> "FilmPhysics":
        """Return viscosities, bending properties and drag coefficients of the film in the form that the kernels use."""
        from pellucid.bodies.fluid_film.forms.virtual_power import Drag, FilmPhysics

        m = self.material
        drag = Drag(self.drag.normal, self.drag.tangential)
        return FilmPhysics(m.viscosity, m.dilatational_viscosity, m.bending_rigidity, m.spontaneous_curvature, drag)

    def geometry(self) -> "tuple[FilmGeometry, np.ndarray]":
        """Return the geometry and the initial positions of its nodes [m], shape (n, d). Raises CaseError if the geometry
        cannot be built."""
        if self.shape.surface is not None:
            from pellucid.bodies.fluid_film.surfaces.initial_surface import film_surface

            try:
                return film_surface(self.shape.surface.triangulate(), self.radial if self.interpolation == "radial" else "loop")
            except ValueError as error:
                raise CaseError(Problem(str(error), f"body.{self.name}.shape.surface")) from error
        from pellucid.bodies.fluid_film.surfaces.curve import Curve

        places = self.shape.chosen().places()
        return Curve(len(places), self.radial, self.is_around), places

    def numbers(self) -> np.ndarray:
        """Return for each node of the geometry its number in the initial shape, shape (n,). The two orders differ because
        surfaces store their nodes in spatial order.
        """
        if self.shape.surface is not None:
            return spatial_order(self.shape.surface.triangulate().vertices)
        return np.arange(len(self.positions()))

    def solver(self, geometry: "FilmGeometry", x: np.ndarray) -> "FilmSolver":
        """Return the solver for the nodal velocities of a film with this geometry. x: initial positions of the nodes [m],
        shape (n, d).
        """
        if self.shape.surface is not None:
            from pellucid.bodies.fluid_film.solvers.sparse_solver import SparseSolver

            return SparseSolver(geometry.nodes, geometry.held, geometry.places(x))
        from pellucid.bodies.fluid_film.solvers.curve_solver import CurveSolver

        return CurveSolver(geometry.nodes, geometry.held)

    def steps(self, balance: "FilmBalance", goals: Goals, arrays: "dict[str, np.ndarray]") -> "OwnSteps":
        """Build the object that moves the film by substeps. balance: computes its nodal velocities; goals: prescribed volume
        and area; arrays: state arrays of the film.
        """
        from pellucid.bodies.fluid_film.own_steps import OwnSteps

        return OwnSteps(balance, goals, self, arrays)

    @property
    def has_drag(self) -> bool:
        """True if the surrounding fluid exerts drag on the film."""
        return max(self.drag.normal, self.drag.tangential) > 0.0

    def sides(self) -> np.ndarray:
        """Return the nodes of each segment or triangle of the initial shape, shape (m, 2) or (m, 3)."""
        if self.shape.surface is not None:
            return self.shape.surface.triangulate().triangles
        first = np.arange(len(self.positions()))
        return np.stack([first, np.roll(first, -1)], axis=1)

    @property
    def is_around(self) -> bool:
        """True if the film is a surface of revolution."""
        return self.shape.span == "around"

    def goals(self, o: "Operators") -> Goals:
        """Return the prescribed volume [m³] and area [m²] from the settings of the case and the initial geometry o of the
        film.
        """
        start, area, goal = o.volume(), float(o.area.sum()), None
        if self.volume is not None:
            reduced = self.volume.reduced
            goal = start if reduced is None else reduced_to_volume(reduced, area, self.shape.span == "plane")
        return Goals(start, goal, (self.volume and self.volume.over) or 0.0, area if self.area == "kept" else None)

    # data for other parts

    def channels(self) -> Sequence[Channel]:
        return (VISCOUS_HEAT, DAMPING_HEAT) if self.has_drag else (VISCOUS_HEAT,)

    @property
    def has_own_step(self) -> bool:
        """Return True: a film divides the time step of the run into its own substeps."""
        return True

    @property
    def probed(self) -> tuple[str, ...]:
        return ("position", "velocity", "mass", "areal_density", "tension", "curvature", "distance", "bending_energy")

    def build(self, placement: "Placement") -> "Body":
        from pellucid.bodies.fluid_film.body import FluidFilm
        from pellucid.bodies.fluid_film.on_grid import FilmOnGrid

        if self._is_shared and placement.grid_case is not None:
            return FilmOnGrid(self, *placement.on_grid(), placement.velocity_transfer)
        return FluidFilm(self, placement)

    def with_others(self, bodies: Sequence[BodyModel]) -> Self:
        aware = self.model_copy()
        aware._is_shared = sum(body.field == self.field for body in bodies) > 1
        return aware

    def step_limit(self, cell: float | None, is_driven: bool) -> StepLimit | None:
        """Return the largest step in which waves, viscosity and bending forces act across at most one grid cell, of edge
        length `cell` [m]; no limit if the film has its own velocity field, since it then divides the step into substeps.
        is_driven: not used.
        """
        if not self._is_shared or cell is None:
            return NO_LIMIT
        from pellucid.bodies.fluid_film.wave_speeds import Signals

        signals = Signals(self.physics(), self.material, np.array([self.initial_density]))
        return signals.limit(cell, self.fastest_at_start(self.positions()))

    @property
    def deforms_in_contact(self) -> bool:
        """True: a film has contact by its surface with the other bodies in its velocity field."""
        return True

    def owns_nodes(self, alone: bool) -> bool:
        """True if the film moves its nodes itself, which is so if no other body shares its velocity field (`alone`); otherwise
        the nodes of the grid move them.
        """
        return alone

    def needs_grid(self, parts: Parts) -> bool:
        return any(body.kind != self.kind for body in parts.of(BodyModel))

    def positions(self) -> np.ndarray:
        """Return the initial positions of the nodes [m], shape (n, 3)."""
        if self.shape.surface is not None:
            return self.shape.surface.triangulate().vertices
        places = self.shape.chosen().places()
        result = np.zeros((len(places), 3))
        result[:, [0, 1] if self.shape.span == "plane" else [0, 2]] = places
        return result

    @property
    def has_triangles(self) -> bool:
        return self.shape.surface is not None

    def selectable(self) -> Selectable:
        return Selectable(self.positions())

    def occupied(self) -> None:
        """Return None: the region enclosed by a film cannot be excluded from other bodies."""

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.positions())

    def standing(self, grid: GridCase) -> Standing:
        if self.shape.surface is not None:
            return Standing(*self.shape.surface.triangulate())
        return Standing(self.positions(), np.zeros((0, 3), int))

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.positions())

    def table_bytes(self) -> float:
        return len(self.positions()) * (SURFACE_BYTES if self.shape.surface is not None else CURVE_BYTES)

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return initial_velocity(self.velocity, self.name, self.initial, position)

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        return Reason(
            f"{self.name} is a fluid film, whose inside cannot be excluded",
            "name bodies of material points or closed membranes",
        )

    def why_no_motion(self) -> Reason | None:
        """Return the reason why no motion can be prescribed: the nodes do not stay at the same material points."""
        text = f"the nodes of film {self.name} do not follow its material, so they cannot get a motion along the axes"
        return Reason(text, "use a displacement along the `normal`, or a support with a `velocity`")

    def why_no_normal_motion(self, whole: bool) -> Reason | None:
        """Return the reason why no motion along the normal of the film can be prescribed; None if it can.

        There are two reasons: other bodies share the velocity field of the film, so that the grid moves its nodes; or the
        motion applies to all nodes (`whole` is True) and thus contradicts a constraint of the volume or area.
        """
        if self._is_shared:
            return Reason(
                f"the fluid around film {self.name} moves its nodes, so their motion cannot be prescribed", "remove this motion"
            )
        if not whole or (self.volume is None and self.area == "free"):
            return None
        held = "area" if self.volume is None else "volume"
        text = f"the motion prescribes all nodes of film {self.name}, whose {held} is already prescribed"
        return Reason(text, f"remove `{held}` of the film, or prescribe only a `part` of it")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for settings of the film that are incompatible with each other or with other
        bodies.

        path: path of the film in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity",), path)
        yield from own_problems(self, path)
        yield from problems_alone(self, path, parts) if is_alone(self, parts) else problems_in_fluid(self, path, parts)
