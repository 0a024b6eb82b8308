"""Fluid films: bodies with their own nodes whose velocities follow from a balance of forces without inertia (Benet 2015)."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, Led, StepDone
from pellucid.bodies.fluid_film.film_geometry import FilmGeometry, Operators
from pellucid.bodies.fluid_film.forces import FilmForces, bending_energies, in_space
from pellucid.bodies.fluid_film.solvers import FilmSolver
from pellucid.energy import DAMPING, FIRST_LOAD, GRAVITY, INTERNAL, MOTION, SUPPORT, VISCOUS, StepWork, Totals, no_work
from pellucid.errors import CaseError, Problem, RunStopped
from pellucid.geometry.meshes.cells import Cells
from pellucid.parts.body import Placement
from pellucid.parts.capabilities import (
    ActingTraction,
    Membrane,
    NodalSupport,
    ShowsStart,
    TakesExternalForces,
    TakesGravity,
    TakesNormalMotions,
    TakesSupports,
    TakesTractions,
    Traction,
)
from pellucid.parts.families import NodalBody
from pellucid.parts.support_precedence import find_owners

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase


FIELDS = ("id", "position", "velocity", "mass", "areal_density", "tension", "curvature", "distance")


class NodalFields:
    """Computes nodal fields of a fluid film for the stored results. forces: forces and densities of the film; arrays:
    arrays of the film, of which `position`, `velocity` and `mass` are updated here; is_around: True for a surface of
    revolution."""

    def __init__(self, forces: FilmForces, arrays: dict[str, np.ndarray], is_around: bool) -> None:
        self._forces, self._arrays, self._is_around = forces, arrays, is_around
        cells = forces.geometry.cells()
        self._corners = cells.lines if len(cells.lines) else cells.triangles

    def show(self, o: Operators) -> None:
        """Update the positions [m], velocities [m/s] and masses [kg] at the nodes in the results. o: geometry of the film at
        its present positions.
        """
        arrays, geometry = self._arrays, self._forces.geometry
        arrays["position"][:] = in_space(geometry.places(arrays["x"]), geometry.axes)
        self.show_velocities(arrays["v"])
        density = self._forces.at_points(self._forces.densities(o, arrays["part_mass"]))
        arrays["mass"][:] = self._shared(o.area * density)

    def show_velocities(self, v: np.ndarray) -> None:
        """Update the velocities of the film at its nodes. v: velocities of the nodes (of a Loop surface: control points) [m/s],
        shape (n, d)."""
        geometry = self._forces.geometry
        self._arrays["velocity"][:] = in_space(geometry.places(v), geometry.axes)

    def field(self, name: str) -> np.ndarray:
        """Return the field of this name at the nodes; fields of elements are averaged by area over the elements around each
        node.
        """
        arrays, forces = self._arrays, self._forces
        if name == "kinetic_energy":
            return np.zeros(len(arrays["mass"]))
        if name in arrays:
            return arrays[name]
        if name == "distance":
            return self._distances()
        o = forces.geometry.operators(arrays["x"])
        if name == "curvature":
            return self._at_nodes(o.area, o.curvature)
        if name == "bending_energy":
            return self._shared(bending_energies(o, forces.physics))
        density = forces.densities(o, arrays["part_mass"])
        if name == "areal_density":
            return self._at_nodes(o.area, forces.at_points(density))
        if name == "tension":
            return self._at_nodes(o.area, forces.at_points(-forces.material.pressure(density)))
        raise KeyError(name)

    def areas(self, o: Operators) -> np.ndarray:
        """Return the area of the film that belongs to each node [m²], shape (n,). o: geometry of the film at its present
        positions.
        """
        return self._shared(o.area)

    def _distances(self) -> np.ndarray:
        """Return the distances of the nodes from the centre of mass [m]; for a surface of revolution the centre is on the
        axis."""
        places, mass = self._forces.geometry.places(self._arrays["x"]), self._arrays["mass"]
        centre = mass @ places / float(mass.sum())
        if self._is_around:
            centre[0] = 0.0
        return np.asarray(np.linalg.norm(places - centre, axis=1))

    def _shared(self, of_points: np.ndarray) -> np.ndarray:
        """Distribute values at the quadrature points of the elements, `of_points`, shape (e, q), equally among the corners of
        each element, and return the sums at the nodes, shape (n,).
        """
        corners = self._corners
        share = np.repeat(of_points.sum(axis=1) / corners.shape[1], corners.shape[1])
        return np.bincount(corners.ravel(), share, len(self._arrays["mass"]))

    def _at_nodes(self, area: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the area-weighted averages at the nodes, shape (n,), of values at the quadrature points.

        area: areas of the quadrature points [m²]; values: any quantity there; shape (e, q) both.
        """
        return np.asarray(self._shared(area * values) / self._shared(area))


class HeldNodes:
    """Stores the prescribed velocities of n film nodes and records the work of prescribing them.

    axes: the d axes of space along which the film extends; is_around: True for a surface of revolution, on which forces
    perpendicular to the axis cancel.
    """

    def __init__(self, n: int, axes: Sequence[int], is_around: bool) -> None:
        self._n, self._axes, self._across = n, list(axes), 0.0 if is_around else 1.0
        self.supports: Sequence[NodalSupport] = ()
        self._owner = np.zeros((n, 3), np.int64)
        self.motions: Sequence[str] = ()
        self.numbers = np.zeros(n, np.int64)  # of each node: 1 + index of its motion, or 0 without a motion
        self.rates = np.zeros(0)  # of the motions along the normal [m/s]

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Set the supports that prescribe velocities of nodes."""
        self.supports, self._owner = supports, find_owners(supports, self._n, may_leave=True)

    def check(self, name: str) -> None:
        """Raise CaseError if a node has both a support and a prescribed motion along the normal. name: name of the film."""
        for number, support in enumerate(self.supports):
            both = np.flatnonzero(self._constrained(number).any(axis=1) & (self.numbers > 0))
            if len(both):
                motion = self.motions[self.numbers[both[0]] - 1]
                text = f"{support.label} constrains {len(both)} of the nodes of film {name} that follow this motion"
                remedy = "move or shrink its `part` or the `where` of the support, so that they do not overlap"
                raise CaseError(Problem(text, f"motion.{motion}.part", remedy=remedy))

    def prescribed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a mask of the velocity components prescribed by supports and their values [m/s], shape (n, d) each."""
        known, velocity = np.zeros((self._n, len(self._axes)), bool), np.zeros((self._n, len(self._axes)))
        for number, support in enumerate(self.supports):
            chosen = self._constrained(number)
            known |= chosen
            velocity = np.where(chosen, np.array(support.velocity)[self._axes], velocity)
        return known, velocity

    def led(self, before: np.ndarray) -> Led:
        """Return the nodes with a prescribed velocity along the normal, and these velocities. before: nodal velocities in the
        previous step [m/s], shape (n, d).
        """
        return Led(self.numbers > 0, np.append(0.0, self.rates)[self.numbers], before)

    def no_work(self, columns: int) -> StepWork:
        """Return a `StepWork` (work and impulses of a step) with all entries zero. columns: length of its array of works."""
        motions = {name: np.zeros(3) for name in self.motions}
        return StepWork(np.zeros(columns), 0.0, np.zeros((len(self.supports) + 1, 3)), np.zeros(3), motions)

    def count(self, done: StepDone, dt: float, work: StepWork) -> None:
        """Add the work and the impulses of supports and motions in one substep of the film to `work`.

        done: velocities and forces of the substep; dt: its length [s].
        """
        for number in range(len(self.supports)):
            forces = np.where(self._constrained(number), done.prescribed, 0.0)
            work.reactions[number] += self._counted(forces, done, dt, SUPPORT, work)
        for number, name in enumerate(self.motions, start=1):
            forces = np.where((self.numbers == number)[:, None], done.leading, 0.0)
            work.motions[name][:] += self._counted(forces, done, dt, MOTION, work)

    def _counted(self, forces: np.ndarray, done: StepDone, dt: float, column: int, work: StepWork) -> np.ndarray:
        """Add the work of forces on the nodes [N], shape (n, d), over a substep dt [s] to `work.works[column]`, and return
        their impulse [N s], shape (3,). done: velocities of the substep.
        """
        worked = dt * float(np.sum(forces * done.velocity))
        work.works[column] += worked
        work.works[INTERNAL] -= worked
        return np.asarray(dt * in_space(forces, self._axes).sum(axis=0) * (self._across, 1.0, 1.0))

    def _constrained(self, number: int) -> np.ndarray:
        """Return a mask of the velocity components that the support with this number prescribes, shape (n, d)."""
        return np.asarray(self._owner[:, self._axes] == number + 1)


class FluidFilm(
    NodalBody, Membrane, TakesExternalForces, TakesTractions, TakesGravity, TakesSupports, TakesNormalMotions, ShowsStart
):
    """A fluid film with its own nodes, stored in the order of its geometry.

    State arrays: `x`, nodal positions in the coordinates of the geometry [m], and `part_mass`, masses of the parts of the film
    [kg]; a part is the piece of the film that belongs to a node or an element.
    """

    energy_kind = "strain"

    def __init__(self, case: "FluidFilmCase", placement: Placement) -> None:
        self.name = case.name
        self.geometry, x = case.geometry()
        solver = case.solver(self.geometry, x)
        self.balance = FilmBalance(self.geometry, case.material, case.physics(), case.initial_density, solver)
        o = self.geometry.operators(x)
        part_mass = case.initial_density * self.balance.part_areas(o)
        n = len(x)
        self.arrays = {
            "id": case.shape.numbers(),
            "position": np.zeros((n, 3)),
            "velocity": np.zeros((n, 3)),
            "mass": np.zeros(n),
            "x": x,
            "v": np.zeros_like(x),
            "part_mass": part_mass,
            "own_step": np.zeros(1),
            "unspread": np.zeros_like(x),
        }
        self.areal_density = case.initial_density
        self._full_gravity = np.array(placement.gravity)[list(self.geometry.axes)]
        self._gravity = self._full_gravity.copy()  # the part that acts now [m/s²], see `share_gravity`
        self._columns = FIRST_LOAD + placement.n_loads
        self._steps = case.steps(self.balance, case.goals(o), self.arrays)
        is_around = case.shape.span == "around"
        self._fields = NodalFields(self.balance, self.arrays, is_around)
        self._held = HeldNodes(n, self.geometry.axes, is_around)
        self._tractions: list[ActingTraction] = []
        self._forces: list[tuple[int, np.ndarray]] = []
        self._work = no_work(self._columns, 0)
        self.totals = Totals()
        self._elapsed = 0.0
        self._show(o)

    def order(self) -> np.ndarray:
        return np.argsort(self.arrays["id"])

    # conditions

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        self._forces.append((column, np.asarray(force)[:, list(self.geometry.axes)]))

    def add_traction(self, traction: Traction, column: int, label: str) -> None:
        self._tractions.append(ActingTraction(column, traction, label))

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        self._held.add_supports(supports)

    def add_normal_motions(self, names: Sequence[str], numbers: np.ndarray) -> None:
        self._held.motions, self._held.numbers = names, numbers

    def set_normal_velocities(self, rates: np.ndarray) -> None:
        self._held.rates = rates

    def complete(self) -> None:
        """Raise CaseError if a support and a prescribed motion along the normal act on the same node; called when all
        conditions are known.
        """
        self._held.check(self.name)

    def share_gravity(self, share: float) -> None:
        self._gravity[:] = share * self._full_gravity

    # the step

    def begin(self, dt: float) -> None:
        self._tractions.clear()
        self._forces.clear()

    def show_start(self, dt: float) -> None:
        self._fields.show_velocities(self._steps.velocities_now(dt, self._elapsed, self._driving()))

    def predict(self, dt: float) -> None:
        """Do nothing: `update` moves the film when all loads are known."""

    def correct(self, remap: bool) -> None:
        """Do nothing: `update` moves the film."""

    def update(self, dt: float) -> None:
        """Advance the film over a step dt [s] of the run, in as many substeps as the accuracy of its time integration needs."""
        self._work = self._held.no_work(self._columns)
        o = self._steps.over(dt, self._elapsed, self._driving(), self._count)
        self._elapsed += dt
        self._show(o)

    def _count(self, done: StepDone, dt: float) -> None:
        work, gained = self._work, 0.0
        for column, power in done.loads:
            work.works[column] += dt * power
            gained += power
        work.works[VISCOUS] += dt * done.viscous
        work.works[DAMPING] += dt * done.drag
        work.works[SUPPORT] += dt * done.bordered
        work.works[INTERNAL] -= dt * (gained + done.bordered - done.viscous - done.drag)
        self._held.count(done, dt, work)

    def _driving(self) -> Driving:
        forces = list(self._forces)
        if self._gravity.any():
            forces.append((GRAVITY, self.arrays["mass"][:, None] * self._gravity))
        return Driving(list(self._tractions), forces, *self._held.prescribed(), self._held.led(self.arrays["v"]), None, None)

    def renew_totals(self) -> None:
        """Sum the stored energy of the film. It has no momentum, and its substeps do not limit the time step of the run."""
        self._show(self.geometry.operators(self.arrays["x"]))

    def _show(self, o: Operators) -> None:
        self._fields.show(o)
        self.totals.stored = self.balance.stored_energy(o, self.arrays["part_mass"])

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped` if the velocities could not be computed, values are not finite, or the film is too thin. n_steps,
        time: steps and time [s] of the run, for the message.
        """
        if self._steps.fault is not None:
            text = f"step {n_steps}, time {time:.6g} s: film {self.name} {self._steps.fault}"
            raise RunStopped(text, step=n_steps, time=time, body=self.name)

    def work(self) -> StepWork:
        return self._work

    # checkpoint

    def state_arrays(self) -> dict[str, np.ndarray]:
        kept = {f"{part}.{name}": array for part, of in self._stateful().items() for name, array in of.state_arrays().items()}
        return {**self.arrays, "elapsed": np.array([self._elapsed]), **kept}

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        number = self.arrays["id"]
        self.restore({name: array[number] if len(array) == len(number) else array for name, array in state.items()})
        self.renew_totals()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        self._elapsed = float(arrays["elapsed"][0])
        for part, of in self._stateful().items():
            of.restore({name.removeprefix(f"{part}."): array for name, array in arrays.items() if name.startswith(f"{part}.")})

    def _stateful(self) -> "dict[str, FilmGeometry | FilmSolver]":
        """Return the geometry and the solver of the film, whose arrays a checkpoint contains in addition to the nodes."""
        return {"geometry": self.geometry, "solver": self.balance.solver}

    # results

    def cells(self) -> Cells:
        return self.geometry.cells().renumbered(self.arrays["id"])

    @property
    def field_names(self) -> list[str]:
        return list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """Return a field of the results at the nodes, in the order of the nodes in the initial shape; fields of elements are
        averaged by area.
        """
        try:
            return self.stored_field(name)[self.order()]
        except KeyError:
            raise self.no_field(name) from None

    def stored_field(self, name: str) -> np.ndarray:
        return self._fields.field(name)

    def pressed_areas(self) -> np.ndarray:
        """Return ∫ N_I n dA around each node I [m²], shape (n, 3), with its shape function N_I and the normal n of the film."""
        o = self.geometry.operators(self.arrays["x"])
        return in_space(self.balance.vector_areas(o), self.geometry.axes)[self.order()]

    def surface_areas(self) -> np.ndarray:
        return self._fields.areas(self.geometry.operators(self.arrays["x"]))[self.order()]

    def volumes(self) -> np.ndarray:
        """Return zeros: a film has no volume."""
        return np.zeros(self.n_points)

    def kinetic_energies(self) -> np.ndarray:
        """Return zeros: the inertia of a film is neglected."""
        return np.zeros(self.n_points)
