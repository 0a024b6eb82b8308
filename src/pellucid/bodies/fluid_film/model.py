"""Settings of a fluid film in a case file, and their checks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import PrivateAttr

from pellucid.approximants.radial import AnyRadial
from pellucid.approximants.radial.functions import PolyharmonicModel
from pellucid.bodies.initial import INITIAL_MEANING, Initial, initial_problems, initial_velocity
from pellucid.bodies.placing import longest_edge, place_problems
from pellucid.energy import DAMPING_HEAT, VISCOUS_HEAT, Channel
from pellucid.errors import CaseError, Problem
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.meshes.points import coincident, side_by_side
from pellucid.geometry.meshes.triangulation import bounding_box
from pellucid.geometry.region import Selectable
from pellucid.geometry.surfaces.film_shapes import FilmShape
from pellucid.grid.model import GridCase
from pellucid.materials.lipid_film import THINNEST, LipidFilm
from pellucid.model import Model, Vector, parameter
from pellucid.parts.body_model import BodyModel, Standing, is_alone
from pellucid.parts.part import Parts
from pellucid.state import Field
from pellucid.step.limit import NO_LIMIT, StepLimit

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.balance import FilmBalance, Goals, OwnSteps
    from pellucid.bodies.fluid_film.film_geometry import FilmGeometry, Operators
    from pellucid.bodies.fluid_film.forces import FilmPhysics
    from pellucid.bodies.fluid_film.solvers import FilmSolver
    from pellucid.parts.body import Body, Placement


FULLEST = 0.999
"""Largest reduced volume that can be prescribed. At 1 the film is a sphere: constant volume and area allow no motion, and the
equations for the velocity are singular. Curves and meridians with 8 nodes and surfaces with 42 nodes reach 0.999."""

CURVE_BYTES, SURFACE_BYTES = 27_000, 80_000  # memory per node, see `validation/memory`


class DragCase(Model):
    """Drag coefficients of the fluid around a film."""

    normal: float = parameter("N*s/m^3", "normal drag coefficient ζ_n", ge=0)
    tangential: float = parameter("N*s/m^3", "tangential drag coefficient ζ_t", ge=0)


class VolumeCase(Model):
    """The volume inside a film: kept constant or changed to a prescribed reduced volume."""

    reduced: float | None = parameter(
        "", "target reduced volume; 1 for a sphere of the same area; default: the volume is constant", None, gt=0
    )
    over: float | None = parameter(
        "s", "duration of the smooth change from the initial volume; required with `reduced`", None, gt=0
    )

    def problems(self, path: Path, plane: bool, keeps_area: bool) -> Iterator[Finding]:
        """Yield findings (errors of the case) for a reduced volume above 1 (the value of a sphere or circle), a change of
        volume without a duration, and a change of volume if the area is free.

        path: path of the film in the data of the case; plane: True for a curve in a plane; keeps_area: True if the area is
        constant.
        """
        if self.reduced is None:
            if self.over is not None:
                yield Finding((*path, "over"), "`over` applies to a changing volume", "add `reduced`, or remove `over`")
            return
        if self.reduced > FULLEST:
            curve, full, of = ("curve", "circle", "length") if plane else ("surface", "sphere", "area")
            if self.reduced > 1.0:
                text = f"{self.reduced:g} is impossible: no {curve} encloses more than a {full} of the same {of}, which has 1"
            else:
                text = f"{self.reduced:g} is above {FULLEST:g}: a {full}, which has 1, cannot move at constant volume and {of}"
            remedy = f"use at most {FULLEST:g}; for a {full}, use a {full} as `shape` and remove `volume` and `area`"
            yield Finding((*path, "reduced"), text, remedy)
        if self.over is None:
            text = "an instantaneous change of volume would need an infinite velocity"
            yield Finding(path, text, "add `over = ...`, the duration of the change, such as the relaxation time of the film")
        if not keeps_area:
            text = "a reduced volume refers to a fixed area, but the area of this film is free and would change"
            yield Finding((*path, "reduced"), text, 'add area = "kept"')


class FluidFilmCase(BodyModel):
    """A film of fluid, such as the skin of a vesicle: viscous within its surface, without inertia."""

    place: ClassVar[str] = "shape"
    start_only: ClassVar[tuple[str, ...]] = (*BodyModel.start_only, "density")
    takes_motions: ClassVar[bool] = False  # its nodes do not follow the material
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
        from pellucid.bodies.fluid_film.forces import Drag, FilmPhysics

        m = self.material
        drag = Drag(self.drag.normal, self.drag.tangential)
        return FilmPhysics(m.viscosity, m.dilatational_viscosity, m.bending_rigidity, m.spontaneous_curvature, drag)

    def geometry(self) -> "tuple[FilmGeometry, np.ndarray]":
        """Return the geometry and the initial positions of its nodes [m], shape (n, d); nodes of surfaces are in spatial order.
        Raises CaseError if the geometry cannot be built."""
        if self.shape.surface is not None:
            from pellucid.bodies.fluid_film.loop_surface import LoopSurface
            from pellucid.bodies.fluid_film.radial_surface import RadialSurface

            mesh = side_by_side(self.shape.surface.triangulate())
            try:
                if self.interpolation == "radial":
                    return RadialSurface(mesh.triangles, mesh.vertices, self.radial), mesh.vertices
                surface = LoopSurface(mesh.triangles, len(mesh.vertices))
                return surface, surface.smoothed(surface.through(mesh.vertices))  # curvatures need evenly spaced nodes
            except ValueError as error:
                raise CaseError(Problem(str(error), f"body.{self.name}.shape.surface")) from error
        from pellucid.bodies.fluid_film.curve import Curve

        places = self.shape.chosen().places()
        return Curve(len(places), self.radial, self.shape.span == "around"), places

    def solver(self, geometry: "FilmGeometry", x: np.ndarray) -> "FilmSolver":
        """Return the solver for the nodal velocities of a film with this geometry. x: initial positions of the nodes [m],
        shape (n, d).
        """
        if self.shape.surface is not None:
            from pellucid.bodies.fluid_film.solvers import SparseSolver

            return SparseSolver(geometry.nodes, geometry.held, geometry.places(x))
        from pellucid.bodies.fluid_film.solvers import CurveSolver

        return CurveSolver(geometry.nodes, geometry.held)

    def steps(self, balance: "FilmBalance", goals: "Goals", arrays: "dict[str, np.ndarray]") -> "OwnSteps":
        """Build the object that moves the film by substeps. balance: computes its nodal velocities; goals: prescribed volume
        and area; arrays: state arrays of the film.
        """
        from pellucid.bodies.fluid_film.balance import OwnSteps

        return OwnSteps(balance, goals, self, arrays)

    @property
    def has_drag(self) -> bool:
        """True if the surrounding fluid exerts drag on the film."""
        return max(self.drag.normal, self.drag.tangential) > 0.0

    def goals(self, o: "Operators") -> "Goals":
        """Return the prescribed volume [m³] and area [m²] from the settings of the case and the initial geometry o of the
        film.
        """
        from pellucid.bodies.fluid_film.balance import Goals

        start, area, goal = o.volume(), float(o.area.sum()), None
        if self.volume is not None:
            reduced = self.volume.reduced
            goal = start if reduced is None else reduced_to_volume(reduced, area, self.shape.span == "plane")
        return Goals(start, goal, (self.volume and self.volume.over) or 0.0, area if self.area == "kept" else None)

    # data for other parts

    def channels(self) -> Sequence[Channel]:
        return (VISCOUS_HEAT, DAMPING_HEAT) if self.has_drag else (VISCOUS_HEAT,)

    has_own_step: ClassVar[bool] = True

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
        from pellucid.bodies.fluid_film.forces import Signals

        signals = Signals(self.physics(), self.material, np.array([self.initial_density]))
        return signals.limit(cell, self.fastest_at_start(self.shape.positions()))

    @property
    def deforms_in_contact(self) -> bool:
        """True: a film has contact by its surface with the other bodies in its velocity field."""
        return True

    def owns_nodes(self, alone: bool) -> bool:
        """True if the film moves its nodes itself, which is so if no other body shares its velocity field (`alone`); otherwise
        the nodes of the grid move them.
        """
        return alone

    @property
    def is_shared(self) -> bool:
        """True if other bodies share the velocity field of the film, so that the nodes of the grid move it."""
        return self._is_shared

    def needs_grid(self, parts: Parts) -> bool:
        return any(body.kind != self.kind for body in parts.of(BodyModel))

    @property
    def has_triangles(self) -> bool:
        return self.shape.surface is not None

    def selectable(self) -> Selectable:
        return Selectable(self.shape.positions())

    def occupied(self) -> None:
        """Return None: the region enclosed by a film cannot be excluded from other bodies."""

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.shape.positions())

    def standing(self, grid: GridCase) -> Standing:
        if self.shape.surface is not None:
            return Standing(*self.shape.surface.triangulate())
        return Standing(self.shape.positions(), np.zeros((0, 3), int))

    def n_points(self, grid: GridCase | None) -> float:
        return len(self.shape.positions())

    def table_bytes(self) -> float:
        return len(self.shape.positions()) * (SURFACE_BYTES if self.shape.surface is not None else CURVE_BYTES)

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return initial_velocity(self.velocity, self.name, self.initial, position)

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        return Reason(
            f"{self.name} is a fluid film, whose inside cannot be excluded",
            "name bodies of material points or closed membranes",
        )

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for settings of the film that are incompatible with each other or with other
        bodies.

        path: path of the film in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity",), path)
        yield from own_problems(self, path)
        yield from problems_alone(self, path, parts) if is_alone(self, parts) else problems_in_fluid(self, path, parts)


def reduced_to_volume(reduced: float, area: float, plane: bool) -> float:
    """Return the enclosed volume [m³] of a film from its reduced volume, which is 1 for a sphere (for a circle if the film is
    a plane curve of depth 1 m), and from its area [m²]. plane: True for a plane curve.
    """
    return reduced * area**2 / (4.0 * np.pi) if plane else reduced * area**1.5 / (6.0 * np.sqrt(np.pi))


def own_problems(film: FluidFilmCase, path: Path) -> Iterator[Finding]:
    """Yield findings (errors of the case) for settings of a film that do not depend on other bodies: its volume, its shape and
    the interpolation between its nodes. path: path of the film in the data of the case.
    """
    if film.volume is not None:
        yield from film.volume.problems((*path, "volume"), film.shape.span == "plane", film.area == "kept")
    interpolation, surface, rest = (*path, "interpolation"), film.shape.surface, film.material.density
    if film.initial_density < THINNEST * rest:
        text = f"{film.initial_density:g} kg/m^2 is below {THINNEST:g} of the rest density {rest:g} kg/m^2: too thin for a film"
        yield Finding((*path, "density"), text, "increase it, or reduce the density of the material")
    if surface is None and film.interpolation == "loop":
        text = "Loop subdivision applies to surfaces in space, but this film is described by a curve"
        yield Finding(interpolation, text, "remove `interpolation`")
    yield from _place_problems(film, (*path, "shape"))
    if surface is not None and film.interpolation == "radial" and film.material.bending_rigidity > 0.0:
        text = "a surface of radial functions with bending does not reach equilibrium: its curvature is too noisy"
        yield Finding(interpolation, text, 'use "loop", or remove `bending_rigidity`')


def _thickness_problems(film: FluidFilmCase, path: Path) -> Iterator[Finding]:
    """Yield a finding (an error of the case) if the reduced volume is so small that opposite sides of the film would be closer
    than the node spacing. path: path of the film in the data of the case.
    """
    if film.volume is None or film.volume.reduced is None:
        return
    reduced, plane, in_space = film.volume.reduced, film.shape.span == "plane", film.shape.span == "space"
    corners = film.shape.positions()[film.shape.sides()]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    if plane:
        area = float(edges[:, 0].sum())
    elif in_space:
        area = float(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()) / 2.0
    else:
        area = float(2.0 * np.pi * corners[:, :, 0].mean(axis=1) @ edges[:, 0])
    spacing, full = float(np.median(edges)), reduced_to_volume(1.0, area, plane)
    least = 0.5 * area * spacing / full  # of a disc or a band of thickness 2 V/A, or a tube of that radius
    if reduced >= least:
        return
    text = f"a reduced volume of {reduced:g} would leave {2.0 * reduced * full / area:.2g} m between the sides of the film, "
    text += f"but its nodes are {spacing:.2g} m apart"
    more = (least / reduced) ** (2 if in_space else 1)
    remedy = (
        f"use a value of at least {np.ceil(1000.0 * least) / 1000.0:g}, or {np.ceil(11.0 * more) / 10.0:g} times as many nodes"
    )
    yield Finding((*path, "volume", "reduced"), text, remedy)


def _place_problems(film: FluidFilmCase, path: Path) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a surface that is open or invalid, coincident nodes, and too few nodes for the
    volume.

    path: path of the film in the data of the case.
    """
    surface = film.shape.surface
    if surface is not None:
        place = (*path, "surface")
        if not surface.closed:
            yield Finding(place, "the surface is open, but a film must be closed", "use a surface that encloses a volume")
            return
        found = [Finding(place, text, remedy) for text, remedy in faults(*surface.triangulate(), closed=True)]
        yield from found
        if found:
            return
    places = film.shape.positions()
    if pair := coincident(places, film.shape.sides()):
        at = ", ".join(f"{value:g}" for value in places[pair[0]])
        text = f"the film has two nodes at one position, ({at}) m: a film cannot touch itself"
        yield Finding(path, text, "move the two nodes apart, or merge them into one")
        return
    yield from _thickness_problems(film, path[:-1])


def problems_alone(film: FluidFilmCase, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a film that has its own velocity field, or no grid.

    path: path of the film in the data of the case; parts: all parts of the case.
    """
    if film.velocity != (0.0, 0.0, 0.0) or film.initial:
        text = (
            "an initial velocity applies to films that share their velocity field; the "
            "velocity of other films follows from their loads"
        )
        yield Finding((*path, "initial" if film.initial else "velocity"), text, "remove it")
    if other := next((body for body in parts.of(BodyModel) if body.kind != film.kind), None):
        text = f"the film has its own velocity field and cannot touch body {other.name}: a film has no inertia for contact"
        yield Finding((*path, "field"), text, f'use field = "{other.field}", to move it with that body')
    bends, some = film.material.bending_rigidity > 0.0, min(film.drag.normal, film.drag.tangential) > 0.0
    if film.shape.span == "plane" and bends and not some:
        text = "a curve with bending needs drag: otherwise nothing resists motions that bend it without stretching"
        yield Finding((*path, "drag"), text, "add `drag`, the drag coefficients of the surrounding fluid")


def problems_in_fluid(film: FluidFilmCase, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a film that shares its velocity field with other bodies.

    path: path of the film in the data of the case; parts: all parts of the case.
    """
    grid, shape = parts.grid, (*path, "shape")
    if grid is None:
        return
    plane = film.shape.span == "plane"
    if film.shape.span == "around":
        text = "a surface of revolution cannot share the velocity field of other bodies, which are three-dimensional"
        yield Finding(shape, text, "use a `surface`, or an `ellipse` or a `curve` in a plane grid")
        return
    if grid.thin() != (False, False, plane):
        needed = "one cell thick along z only" if plane else "more than one cell thick along every axis"
        text = f"the film shares the velocity field of other bodies: the grid must be {needed}"
        yield Finding(shape, text, "change grid.lower or grid.upper, or the shape")
    else:
        yield from place_problems(shape, film.bounds(), grid, is_surface=True)
    for key, given, why in (
        ("volume", film.volume is not None, "the fluid inside determines the volume"),
        ("area", film.area == "kept", "set the `stiffness` of the material instead, which resists changes of the area"),
        ("drag", film.has_drag, "the surrounding fluid is computed"),
    ):
        if given:
            text = f"this key applies to films with their own velocity field; in a shared field {why}"
            yield Finding((*path, key), text, "remove this key")
    spacing = longest_edge(film.shape.positions()[film.shape.sides()])
    if spacing > grid.cell:
        more = np.ceil(11.0 * spacing / grid.cell) / 10.0
        text = (
            f"the film has nodes up to {spacing:.3g} m apart, more than a cell of "
            f"{grid.cell:g} m: fluid would pass between them"
        )
        yield Finding(shape, text, f"use {more:g} times as many nodes along it, or a larger grid.cell")
