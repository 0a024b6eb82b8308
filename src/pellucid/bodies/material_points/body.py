"""A fluid or solid body of material points, which carry its mass and state through the grid."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from pellucid.approximants import grid_functions
from pellucid.bodies.material_points.at_wall import PointsAtWall
from pellucid.bodies.material_points.derived_fields import point_energies, point_pressures
from pellucid.bodies.material_points.grid_surface import GridSurface
from pellucid.bodies.material_points.hydrostatic import REMEDY, NoRest, states_by_height
from pellucid.bodies.material_points.leaving import OpenFaces, brought_in, empty, taken_along
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.seeding import Wanted, everywhere, points_along_axes
from pellucid.bodies.material_points.surface import RigidSurface, TakesForces, surface_of
from pellucid.bodies.material_points.surface_parts import SurfaceParts
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.approaching_parts import describe_gap
from pellucid.contact.contact_body import WarnsOfApproach
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.wall_plane import WallPlane
from pellucid.energy import FIRST_LOAD, Passed
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.grid.implicit_viscosity import VISCOUS_STRESS
from pellucid.grid.model import GridCase
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.points_pass import PassAlone, traffic_of
from pellucid.grid.points import DISSIPATED, LOST, OK, POWER
from pellucid.grid.shared_points import SpreadPoints
from pellucid.grid.sorting import points_here
from pellucid.grid.straining import straining
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.jit.bundle import Bundle
from pellucid.materials.law import Law
from pellucid.materials.point_state import in_arrays, initial_arrays
from pellucid.model import Vector
from pellucid.parts.capabilities import BoundByContact, GainsPoints, HasContactSurface, HasPointsAtWalls, KeepsHeat, LosesPoints
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.limit import StepLimit, motion_in_cells, signals_seen, swings, tightest

NOBODY = np.zeros(0, dtype=bool)


class MaterialPoints(
    PointsOnGrid, HasContactSurface, BoundByContact, HasPointsAtWalls, LosesPoints, GainsPoints, KeepsHeat, WarnsOfApproach
):
    """A fluid or solid body of material points that fill a volume, each with the state variables of its material law."""

    _surface_parts: SurfaceParts | None = None

    def __init__(
        self,
        case: SeededBody,
        grid_case: GridCase,
        velocity_field: VelocityField,
        velocity_transfer: VelocityTransfer,
        gravity: Vector,
    ) -> None:
        self.material = case.material
        self.law: Law = case.material.law()
        self.energy_kind = case.material.energy_kind
        self._by_cells = case.cell_pressure
        self._model, self._grid_case, self._gravity = case, grid_case, gravity
        self._open_faces: OpenFaces | None = None
        self._leaving, self._takes_in = NOBODY, False
        per_cell = points_along_axes(case.points_per_cell, grid_case.thin())
        functions = grid_functions(grid_case.functions, per_cell, grid_case.thin(), grid_case.is_periodic())
        here = partial(points_here, velocity_field.grid.lattice, functions)
        arrays, there = _initial_arrays(case, grid_case, here, gravity)
        self._begun: np.ndarray | None = None  # initial positions by point number, if this process stores all [m]
        if not case.material.flows and there == len(arrays["id"]):
            self._begun = arrays["position"][np.argsort(arrays["id"])]
        super().__init__(case.name, velocity_field, functions, velocity_transfer, arrays, there)

    def _sharing(self) -> SpreadPoints:
        return SpreadPoints(self.slabs, self.arrays)

    def _bind(self) -> None:
        super()._bind()
        self._stressed: bool | None = None
        self._state = in_arrays(self.material.initial_state(), self.arrays)

    def _make_bundles(self) -> None:
        super()._make_bundles()
        self._strain = straining(self.law, self.mapped.content, self._state, self._cells)
        self._strain_at_rest: Bundle | None = None

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        self._stressed = None

    @property
    def _strains(self) -> bool:
        """True if the velocity gradients of the grid strain the body, i.e. no constraint moves it as a whole."""
        return self.constraint is None or self.constraint.strains

    @property
    def has_surface(self) -> bool:  # type: ignore[override]
        """True if the body has a contact surface of its own, i.e. its material is a solid."""
        return not self.material.flows

    def make_contact_surface(self, column: int) -> GridSurface | None:
        self.keep_whole()
        leads: object = self.constraint
        takes = leads if isinstance(leads, TakesForces) else None
        where = self.grid, self.arrays, self.mapped, self._load_of(column)
        first = self._model.seeded(self._grid_case).position if self._goes_on else None
        self.contact_surface = surface_of(
            self._model, self._grid_case, *where, rigid=takes is not None, hard=not self._strains, first=first
        )
        if self._goes_on and self.contact_surface is not None:
            self.contact_surface.go_on(self._begun_surface)
        if isinstance(self.contact_surface, RigidSurface) and takes is not None:
            self.contact_surface.takes = takes
            if takes.moves_freely:
                self.contact_surface.rigid_mass = self.mass
        return self.contact_surface

    def make_points_at(self, plane: WallPlane, column: int) -> ContactSurface | None:
        if not self.material.flows:
            return None
        self.keep_whole()
        if self.n_there == 0:
            return None
        return PointsAtWall(self, plane, self.material.density, self.material.wave_speeds()[0], self._load_of(column))

    def _load_of(self, column: int) -> Callable[[], np.ndarray]:
        """Return a function that returns the nodal forces of the grid [N], shape (nodes, 3), whose work is recorded in column
        `column` of the works of a step (`StepWork.works`).
        """
        return lambda: self.velocity_field.load_row(column - FIRST_LOAD)

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:
        if not any(surface is self.contact_surface for surface in touching):
            self.contact_surface = None
        if self.contact_surface is not None:
            self.keep_whole()
            self.totals.rate = max(self.totals.rate, self.contact_surface.least_rate)

    def signal_limit(self) -> StepLimit:
        cell, fastest = self.grid.lattice.cell, self.fastest()
        if self._strains:
            return signals_seen(cell, self.totals.rate, self.material.signals(cell)[1], fastest)
        swing = self.contact_surface.contact_rate() if self.contact_surface is not None else 0.0
        return tightest([motion_in_cells(cell, fastest), swings(swing, "contact")])

    @property
    def fills_cells(self) -> bool:
        """True if mean pressures of full cells act on the body: `cell_pressure` is on and no motion prescribes the body."""
        return self._by_cells and self.constraint is None

    @property
    def solves_viscosity(self) -> bool:
        """True if the viscosity is implicit and the grid strains the body."""
        return VISCOUS_STRESS in self.arrays and self._strains

    @property
    def viscosities(self) -> tuple[float, float]:
        """Shear viscosity μ and second viscosity λ of the implicit viscosity [Pa s]."""
        return self.material.implicit_viscosities() or (0.0, 0.0)

    @property
    def viscous_stress(self) -> np.ndarray:
        """Stress of the implicit viscosity in the last step [Pa], shape (n, 6). `stress` contains it only within a step."""
        return self.arrays[VISCOUS_STRESS]

    def fluid_volume(self) -> float:
        """Return the volume of the points of a fluid [m³]; 0 for a solid."""
        return float(self.stored_field("volume").sum()) if self.material.flows else 0.0

    def state_warning(self) -> str | None:
        """Return a warning if a liquid is compressed beyond the limit of its material law; None otherwise."""
        volume = self.fluid_volume()
        told = self.material.too_soft(float(self.stored_field("mass").sum()) / volume) if volume > 0.0 else None
        if told is None:
            return None
        passage = "; and balance the [[inflow]] with an [[outflow]] of the same flow rate" if self._takes_in else ""
        return f"body `{self.name}`: {told}{passage}"

    def approach_warning(self, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> str | None:
        if self.material.flows or not self._strains or self._takes_in:
            return None
        if self._surface_parts is None:
            begun = self._model.seeded(self._grid_case).position if self._begun is None else self._begun
            self._surface_parts, self._begun = SurfaceParts(self._model, self._grid_case, begun), None
        parts = self._surface_parts
        if not parts.has_deformed(self._positions_of(parts.hosts)):
            return None
        gap = parts.find_closing_gap(np.asarray(self.field("position")), is_filled)
        return None if gap is None else describe_gap(self.name, gap, self._grid_case.cell, at_start=False)

    def _positions_of(self, numbers: np.ndarray) -> np.ndarray:
        """Return the positions of points by their numbers [m], shape (k, 3)."""
        if domain.is_cut:
            return np.asarray(self.field("position")[numbers])
        stored = np.empty(self.n_points, np.int64)
        stored[self.arrays["id"]] = np.arange(self.n_points)
        return np.asarray(self.arrays["position"][stored[numbers]])

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Scatter mass and momentum (`inertia`) and internal forces (`force`) to the grid (P2G). A body that the grid does not
        strain, such as a rigid one, keeps its initial stress (usually zero).
        """
        if force and not self._strains:
            if self._stressed is None:
                self._stressed = domain.any(bool(self._there("stress").any()))
            force = self._stressed
        if inertia or force:
            super().particle_to_grid(inertia, force)

    def renew_totals(self) -> None:
        super().renew_totals()
        if not self._strains:  # else straining finds it
            self.totals.stored = float(np.sum(self.stored_field("stored_energy")))

    def begin_stress(self, dt: float, move: bool) -> None:
        if self._strains:
            each_point(self._strain if move else self._strain_alone(), dt)
        if move and self.is_led(by_slabs=True):
            self.prescribe_positions()

    def passes(self) -> dict[str, PassAlone]:
        straining = PassAlone(lambda: each_point(self._strain, 0.0), traffic_of(self._strain))
        return {**super().passes(), "straining": straining}

    def _strain_alone(self) -> Bundle:
        """Return the loop over the points that updates strain and stress without moving the points, for USF and before the
        first step.
        """
        if self._strain_at_rest is None:
            self._strain_at_rest = straining(self.law, self.mapped.content, self._state, self._cells, moving=False)
        return self._strain_at_rest

    def end_stress(self, dt: float, move: bool) -> None:
        """Complete a stress update: sum energy and power, compute the step limit and, if `move` is True, move the contact
        surface over the step dt [s] and the points of a body whose motion is prescribed as a whole.
        """
        if move and self.is_led(by_slabs=False):
            self.prescribe_positions()
        if move:
            self._complete("position")
        squares = None if self._strains else np.einsum("pi,pi->p", self._there("velocity"), self._there("velocity"))
        if move and self.contact_surface is not None:
            if squares is None or domain.any(bool(squares.any())):
                self.contact_surface.follow(dt)
            else:
                self.contact_surface.rest()
        if squares is None:
            self._collect_strain_sums(last=move)
        else:
            swing = self.contact_surface.contact_rate() if self.contact_surface is not None else 0.0
            fastest = domain.largest(float(np.sqrt(squares.max(initial=0.0))))
            self._bound_rate(max(fastest * self.grid.lattice.inverse_cell, swing))

    @property
    def keeps_heat(self) -> bool:  # type: ignore[override]
        """True if the material has an internal energy that heating changes, and the grid strains the body."""
        return self.material.keeps_heat and self._strains

    def return_heat(self, share: float) -> None:
        energy = self._there("internal_energy")
        energy -= share * np.maximum(self._heat[: self.n_there], 0.0)
        self.totals.stored -= share * self.transfer_loss.kept

    def _collect_strain_sums(self, last: bool) -> None:
        super()._collect_strain_sums(last)
        if self.material.keeps_heat:
            self.totals.half_power = 0.0  # its energy follows that of the points step by step
        if "dissipated_energy" in self.arrays:
            lost = float(self.sums()[DISSIPATED])
            self.totals.parts["dissipated"] = lost
            self.totals.stored += lost

    # points that leave

    @property
    def may_leave(self) -> bool:  # type: ignore[override]
        """True if points may leave through open faces of the grid: no motion prescribes the body, and its pressure is not
        averaged over cells (`cell_pressure`).
        """
        return self.constraint is None and not self._by_cells

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        self.keep_whole()
        self._open_faces = self._open_faces or OpenFaces()
        self._open_faces.add(faces)
        self.constant_fields = ("id",)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped` if a point has a fault, such as a position outside the grid. Points that left through open faces
        are no faults; they are removed when the step is recorded.
        """
        fault = self.slabs.fault if self._open_faces is None else domain.complete(self.slabs.fault)
        if (
            self._open_faces is not None
            and np.count_nonzero(fault[:, 0])
            and np.all((fault[:, 0] == OK) | (fault[:, 0] == LOST))
        ):
            self._leaving, lost = self._open_faces.crossed(self._there("position"), self.grid.lattice)
            if lost.any():
                self.stop(LOST, int(np.flatnonzero(lost)[0]), n_steps, time)
            if self._leaving.any():
                return
        super().check(n_steps, time)

    def let_leave(self) -> Passed | None:
        gone, self._leaving = self._leaving, NOBODY
        if not gone.any():
            return None
        there = {name: self._there(name) for name in self.arrays}
        stored, dissipated = self.stored_field("stored_energy"), "dissipated_energy" in there
        if dissipated:
            lost = there["mass"] * there["dissipated_energy"]
            self.totals.parts["dissipated"] -= float(np.sum(lost[gone]))
            stored = stored + lost
        self.complete_arrays()
        of_lost = domain.complete(self.slabs.of_lost)
        power = 0.0 if self.material.keeps_heat else -0.5 * float(ordered_sum(of_lost)[POWER])
        left, affine = taken_along(there, stored, gone, power)
        speed = np.linalg.norm(there["velocity"][gone], axis=1)
        self.totals.momentum_size -= float(np.sum(there["mass"][gone] * speed))
        self.totals.give(left, affine)
        empty(there, gone, self.grid.lattice)
        self._put_behind(gone)
        self.sort()
        return left

    # points that come in

    @property
    def n_told(self) -> int:
        """Number of points in messages and summaries: the points present if points can enter, otherwise all, including points
        that left.
        """
        return self.n_there if self._takes_in else self.n_points

    def make_room(self, rows: int, place: np.ndarray) -> None:
        self.keep_whole()
        self._takes_in = True
        before, n = self.n_points, self.n_points + rows
        self.arrays = {name: _with_room(array, n) for name, array in self.arrays.items()}
        self.arrays["id"][before:], self.arrays["position"][before:] = np.arange(before, n), place
        self._heat = np.zeros(n if self.keeps_heat else 0)
        self.constant_fields = ("id",)
        self._bind()
        self._make_bundles()

    def state_at(self, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        return _arrays_at(self._model, position, volume, self._gravity)

    def stresses_of(self, sets: Callable[[np.ndarray], Sequence[np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
        self._complete("position", "stress", "volume")
        chosen = sets(self.arrays["position"][: self.n_there])
        return [(self.arrays["stress"][numbers], self.arrays["volume"][numbers]) for numbers in chosen]

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        return self.material.pressed(arrays, more)

    def let_in(self, arrays: Mapping[str, np.ndarray], n_steps: int, time: float) -> Passed:
        """Add points with these arrays (position, velocity, mass, volume, material state) to the body, e.g. at an inflow,
        after a step; the points must lie in the grid. They are stored in the rows of points that left or have not entered
        yet.

        n_steps, time: steps and time [s] of the run, for the message. Returns mass, momentum and energies of the added
        points. Raises RunStopped if no rows are left.
        """
        there, mass = self.n_there, arrays["mass"]
        end = there + len(mass)
        if end > self.n_points:
            text = (
                f"step {n_steps}, time {time:.6g} s: the grid is full: no points can be added to the {there} points "
                f"of body `{self.name}`"
            )
            remedy = "add an [[outflow]], or enlarge the grid"
            raise RunStopped(f"{text}; {remedy}", step=n_steps, time=time, body=self.name)
        self.complete_arrays()
        for name, array in self.arrays.items():
            if name != "id":
                array[there:end] = arrays.get(name, 0.0)
        entered, size = brought_in(arrays, self._stored_in(arrays))
        self.totals.take(entered, size)
        self.shared.first[-1] = end
        self._sort()
        return entered

    def _stored_in(self, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the internal or strain energies of points [J], shape (n,), from their arrays (mass, volume, material
        state).
        """
        kind = self.material.energy_field
        if kind in arrays:
            return np.asarray(arrays["mass"] * arrays[kind])
        state = in_arrays(self.material.initial_state(), arrays)
        return np.asarray(arrays["mass"] * point_energies(self.law, state, arrays["mass"] / arrays["volume"]))

    @property
    def field_names(self) -> list[str]:
        names = super().field_names
        energy = self.material.energy_field
        return names if energy in names else [*names, energy]

    def _field_there(self, name: str) -> np.ndarray:
        """Return a field of the points present on this process, by name; pressure and stored energy are computed from the
        material law.
        """
        if name == "pressure":
            return point_pressures(self.law, self._state, self._field_there("density"))
        if name == "stored_energy":
            return self._there("mass") * self._field_there(self.material.energy_field)
        if name == self.material.energy_field and name not in self.arrays:
            return point_energies(self.law, self._state, self._field_there("density"))
        return super()._field_there(name)


def _initial_arrays(case: SeededBody, grid: GridCase, here: Wanted, gravity: Vector) -> tuple[dict[str, np.ndarray], int]:
    """Return the initial arrays of the points that `here` selects, in memory with room for all points of the body, and the
    number of selected points. here: function that returns the indices of the selected positions; gravity: [m/s²].
    """
    seeds = case.seeded(grid, everywhere if case.has_users_fields else here)
    arrays = {"id": seeds.number, **_arrays_at(case, seeds.position, seeds.volume, gravity)}
    if case.has_users_fields:
        chosen = here(seeds.position)
        arrays = {name: values[chosen] for name, values in arrays.items()}
    return {name: _with_room(values, seeds.n) for name, values in arrays.items()}, len(arrays["id"])


def _arrays_at(case: SeededBody, position: np.ndarray, volume: np.ndarray, gravity: Vector) -> dict[str, np.ndarray]:
    """Build the initial arrays (mass, velocity, material state) of points at positions [m], shape (n, 3), with volumes [m³],
    shape (n,). gravity: [m/s²], for a hydrostatic start.
    """
    density, state = _initial_state(case, position, gravity)
    velocity = case.initial_velocity(position)
    arrays = {"position": position, "velocity": velocity, "mass": density * volume, "volume": volume, **state}
    if case.material.implicit_viscosities() is not None:
        arrays[VISCOUS_STRESS] = np.zeros((len(position), 6))
    case.add_initial_state(arrays)
    return arrays


def _with_room(values: np.ndarray, n: int) -> np.ndarray:
    """Return an array of n rows, of which the first are `values`, one for each point; the memory of the other rows is
    allocated on first use.
    """
    if len(values) == n:
        return values
    array = np.zeros((n, *values.shape[1:]), values.dtype)
    array[: len(values)] = values
    return array


def _initial_state(case: SeededBody, position: np.ndarray, gravity: Vector) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
    material, n = case.material, len(position)
    if case.initial_stress is not None:
        density, state = material.stressed(case.initial_stress)
        return np.full(n, density), initial_arrays(state, n)
    if case.hydrostatic is None:
        return np.full(n, material.density), initial_arrays(material.initial_state(), n)
    try:
        return states_by_height(case.hydrostatic, material, case.bounds(), gravity, position, domain.largest)
    except NoRest as error:
        raise CaseError(Problem(str(error), f"body.{case.name}.hydrostatic", remedy=REMEDY)) from None
