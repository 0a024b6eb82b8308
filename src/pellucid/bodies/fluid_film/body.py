"""Fluid films: bodies with their own nodes whose velocities follow from a balance of forces without inertia (Benet 2015)."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, StepDone
from pellucid.bodies.fluid_film.conditions.held_nodes import HeldNodes
from pellucid.bodies.fluid_film.forms.film_forces import in_space
from pellucid.bodies.fluid_film.nodal_fields import FIELDS, NodalFields
from pellucid.bodies.fluid_film.solvers.contract import FilmSolver
from pellucid.bodies.fluid_film.surfaces.contract import FilmGeometry
from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.energy import DAMPING, FIRST_LOAD, GRAVITY, INTERNAL, SUPPORT, VISCOUS, StepWork, Totals, no_work
from pellucid.errors import RunStopped
from pellucid.geometry.meshes.cells import Cells
from pellucid.parts.capabilities import (
    Membrane,
    NodalSupport,
    ShowsStart,
    TakesExternalForces,
    TakesGravity,
    TakesNormalMotions,
    TakesSupports,
    TakesTractions,
)
from pellucid.parts.families import NodalBody
from pellucid.parts.placement import Placement
from pellucid.parts.surface_load import ActingTraction, Traction

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase


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
            "id": case.numbers(),
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
        self._fields = NodalFields(self.balance, self.arrays, case.is_around)
        self._held = HeldNodes(n, self.geometry.axes, case.is_around)
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
