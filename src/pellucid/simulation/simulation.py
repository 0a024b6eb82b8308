"""Simulation of a case: bodies, velocity fields, conditions, and the time loop."""

import time as wall_clock
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.membrane_elements.forces_ahead import forces_ahead
from pellucid.bodies.transfer_loss import TransferHeat, separate_force_buffers
from pellucid.case.sections import parts_of
from pellucid.case.spec import required
from pellucid.energy import EnergyBudget, StepWork, energy_at_stake, total_work
from pellucid.errors import UsageError
from pellucid.grid.actions import NodalActions
from pellucid.grid.consistent_mass import consistent_mass
from pellucid.grid.even_points import even_points
from pellucid.grid.full_cells import cell_pressures
from pellucid.grid.implicit_viscosity import implicit_viscosity
from pellucid.grid.lattice import Grid
from pellucid.grid.plane_impulses import plane_impulses
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import TRANSFERS, VelocityTransfer
from pellucid.jit import set_threads
from pellucid.parts.capabilities import Relaxable, ShowsStart, TakesGravity
from pellucid.parts.families import GridBody
from pellucid.progress import Progress
from pellucid.ranks.domain import NOWHERE, domain
from pellucid.set_up.behind_walls import with_room_behind_walls
from pellucid.set_up.even_densities import advice_on_even_densities
from pellucid.set_up.first_look import refuse, warnings_of
from pellucid.set_up.smoothing import smoothing_warnings
from pellucid.simulation.assembly import (
    Standings,
    activate_conditions,
    build_bodies,
    load_state,
    work_layout,
    worthwhile_threads,
)
from pellucid.simulation.clock import Clock
from pellucid.simulation.contacts import contact_parts
from pellucid.simulation.factored import steady_clock
from pellucid.simulation.implicit import implicit_clock
from pellucid.simulation.light_nodes import small_masses
from pellucid.simulation.loop import Observer
from pellucid.simulation.ranks import SharedSlabs, idle
from pellucid.simulation.settling import SETTLING, SettlingClock, settle
from pellucid.simulation.stages import SCHEMES, Stages, time_stages
from pellucid.simulation.threads import ThreadChoice, numbers_up_to
from pellucid.simulation.watch import Watch, free_axes
from pellucid.state import of_owner, with_owner
from pellucid.step.limit import StepLimit, time_to_fall
from pellucid.step.part import AtEachStep
from pellucid.system.processes import free_cores

if TYPE_CHECKING:
    from pellucid.case import Case

PROGRESS_INTERVAL = 0.2  # s of wall time
CLOCK = "-clock"  # owner of the clock's arrays in a checkpoint; no body can have this name
PARTS = "-parts"  # owner of the arrays of the parts of a step in a checkpoint
NODES = "-nodes."  # owner of the nodal arrays of a velocity field in a checkpoint, followed by its name


class Simulation:
    """Simulation of a case. Call `step()` for one step, or iterate over it for the whole case; `pellucid.recorded` also stores
    results.

    Attributes: bodies: bodies in the order of the case; velocity_fields: velocity fields of the grid; budget: balances of
    mass, momentum and energy, and reactions; parts: everything that acts in a step besides bodies and grid, such as
    conditions, contact and pressures of full cells, e.g. `parts.only(SurfacePairs)`; begun: True after the first step.
    """

    def __init__(
        self,
        case: "Case",
        threads: int | None = None,
        timed: bool = False,
        start: Mapping[str, Mapping[str, np.ndarray]] | None = None,
    ) -> None:
        """case: the case; threads: number of threads, None to choose it during the run; timed: True to measure the wall-clock
        times of the stages of a step; start: arrays of bodies that start in the state of an earlier run, by body and sorted
        by point number."""
        domain.leave()  # that of another simulation
        self.case = case = with_room_behind_walls(required(case))
        transfer = TRANSFERS[case.time.transfer](case.time.flip_fraction)
        layout = self._layout = work_layout(case)
        self.velocity_fields, built = build_bodies(case, transfer, layout.n_loads)
        if case.start is not None and start is None:
            raise UsageError("A case with [start] requires the state of the earlier run.\n    Run it with pellucid.run.")
        start = start or {}
        load_state(built, start)
        self.bodies = [built[body.name][0] for body in case.body]
        self._on_grid: dict[VelocityField, list[GridBody]] = {}
        for body, field in built.values():
            if isinstance(body, GridBody) and field is not None:
                self._on_grid.setdefault(field, []).append(body)
                body.even_settings = partial(advice_on_even_densities, case, [body.name])
        numbers = (
            numbers_up_to(min(1 + free_cores(), max(1, set_threads(None) // domain.group.here)))
            if threads is None
            else [set_threads(threads)]
        )
        self.thread_choice = ThreadChoice(numbers, worthwhile_threads(self.bodies), set_threads)
        standing = Standings(self.bodies, start.keys())
        refuse(case, standing, start.keys())
        self.actions = [NodalActions(field, layout.n_loads) for field in self.velocity_fields]
        self.parts = activate_conditions(case, built, self.actions, layout)
        separate_force_buffers(self._on_grid.values())
        self._set_actions(transfer)
        if case.steady is not None and not case.steady.is_factored(parts_of(case)):
            for body in self.bodies:  # before parts whose springs are as stiff as steps allow
                if isinstance(body, Relaxable):
                    body.begin_relaxing(case.steady.mass_scaling)
        for field, bodies in self._on_grid.items():
            cells = cell_pressures(field, bodies)
            self.parts.add(cells)
            solvers = implicit_viscosity(field, bodies, layout, cells)
            self.parts.add(solvers)
            self.parts.add(forces_ahead(bodies, solvers))
            self.parts.add(even_points(field, bodies, layout.n_supports))
            self.parts.add(plane_impulses(field, bodies, layout.n_supports))
            if case.time.mass_matrix == "consistent":
                self.parts.add(consistent_mass(field, bodies, layout), first=True)
        self.parts.add(contact_parts(case, built, self.velocity_fields, layout, start))
        if self._on_grid:
            self.parts.add([TransferHeat(self._on_grid, self.parts, case.time.scheme != "usf")])
        if (amplitude := case.gravity_amplitude) is not None:
            self.parts.add([AtEachStep(lambda time: self._share_gravity(amplitude.at(time)))])
        self.stages = Stages(self.bodies, self.velocity_fields, self._on_grid, self.parts)
        self._scheme = SCHEMES[case.time.scheme]
        self.clock = self._clock()
        self.begin_balance()
        self.begun, self._settled = False, dict[str, Any]()
        own_steps = all(body.has_own_step for body in case.body) and not self._on_grid
        self._watch = Watch(case, own_steps)
        self.timers: dict[str, float] = {}
        self._shared: SharedSlabs | None = None
        self._shown = 0.0
        for text in warnings_of(case, standing, start.keys()):
            warnings.warn(text, stacklevel=2)
        if (without_work := idle(domain.group.size, self.velocity_fields)) is not None:
            warnings.warn(without_work, stacklevel=2)
        dt = self.clock.next_step(self.bodies)  # an unstable fixed step is an error of the case
        for text in smoothing_warnings(case, self._on_grid, dt):
            warnings.warn(text, stacklevel=2)
        if own_steps:
            self._begin(dt)
            for own in self.bodies:
                if isinstance(own, ShowsStart):
                    own.show_start(dt)
        if timed:
            time_stages(self, self.timers)

    def _set_actions(self, transfer: VelocityTransfer) -> None:
        """Pass supports, gravity and external actions to the velocity fields, after all conditions are built; transfer:
        velocity transfer of the case."""
        case = self.case
        small = small_masses(case, self.bodies, {field: self._on_grid.get(field, []) for field in self.velocity_fields})
        for actions in self.actions:
            field = actions.field
            field.set_actions(actions.supports, actions.external(), case.gravity, small[field], transfer.flip)

    def _clock(self) -> Clock:
        case = self.case
        if case.steady:
            return steady_clock(case, case.steady, self.bodies, self.parts, self.works_on_grid)
        if case.time.method == "implicit":
            return implicit_clock(case, self.bodies, self.parts)
        pull = case.largest_gravity
        longest = time_to_fall(case.grid.cell, pull) if pull > 0.0 and case.grid_or_none else inf
        return Clock(case.time, longest, case.longest_step, self.parts)

    def begin_balance(self) -> None:
        """Start the balances of mass, momentum and energy with the present state as reference."""
        speeds = [0.0 if model.is_rigid else model.waves_at_start()[0] for model in self.case.body]
        at_stake = energy_at_stake(self.bodies, self.case.gravity, speeds) + self.parts.at_stake()
        given = self._layout.channels, at_stake, free_axes(self.case)
        self.budget = EnergyBudget(self.bodies, self.case.gravity, *given)
        self.parts.run("begin_balance")

    def record(self, dt: float) -> None:
        """Add the works and impulses of a completed step dt [s] to the balances of energy and momentum."""
        own = [body.work() for body in self.stages.nodal_bodies if not self.clock.counts(body)]
        done = total_work([self.clock.works_of_step(self.works_on_grid()), *own], self._layout.n_columns)
        self.parts.run("balance", done)
        self.budget.record(done, self.parts.impulses(), dt, self.clock.weight)

    def works_on_grid(self) -> StepWork:
        """Return the works and impulses of the bodies on the grid, and of parts of the step, in the last step."""
        heats = (body.work() for body in self.stages.grid_bodies)
        works = [*self.stages.works, *self.parts.works(), *(heat for heat in heats if heat is not None)]
        return total_work(works, self._layout.n_columns) if works else self._layout.no_work()

    def step(self) -> None:
        """Advance one time step. Raises RunStopped, naming the point, if the state becomes invalid."""
        self.advance_bodies()
        self.begun = True
        self._watch.energy(self.budget, self.clock, self.bodies)
        self._watch.angular_momentum(self.budget, self.clock)
        self._watch.volumes(self._on_grid, self.clock)
        self._watch.gaps(self._on_grid, self.clock)
        self._watch.states(self.bodies, self.clock)
        self._watch.approaches(self.bodies, self.clock)
        self._watch.parts(self.parts, self.budget, self.clock)

    def __iter__(self) -> Iterator["Simulation"]:
        """Advance to the end of the case, and yield this `Simulation` after each step, for user-defined loops.

        Before the first step bodies settle if the case has [settle]. Raises RunStopped like `step`. See `pellucid.recorded`
        for loops that store results.
        """
        if not self.begun:
            self.settle()
        while not self.clock.finished(None):
            self.step()
            yield self

    def advance_bodies(self) -> None:
        """Advance one time step without checking the energy balance."""
        dt = self.clock.next_step(self.bodies)
        if domain.group.size > 1 and self.velocity_fields:
            self._shared = self._shared or SharedSlabs(self.bodies)  # from the first step on, in balance
            self._shared.balance()
        self.stages.sort()
        dt = self.clock.carry_out(dt, self._begin, partial(self._scheme, self.stages))
        self.clock.advance(dt)
        self.budget.is_complete = False
        for body in self.bodies:
            body.check(self.clock.n_steps, self.clock.progress())
        self.parts.run("check", self.clock.n_steps, self.clock.progress())
        self.parts.end(dt)
        self.record(dt)
        for left in self.parts.leave():
            self.budget.let_go(left, dt)
        for entered in self.parts.enter(self.clock.n_steps, self.clock.progress()):
            self.budget.let_in(entered)

    def _share_gravity(self, share: float) -> None:
        for field in self.velocity_fields:
            field.share_gravity(share)
        for body in self.bodies:
            if isinstance(body, TakesGravity):
                body.share_gravity(share)

    def settle(self, caught: Sequence[int] = (), progress: Progress | None = None, keeper: Observer | None = None) -> None:
        """Bring the bodies to rest before the first step if the case has [settle]; arguments as in
        `pellucid.simulation.settling.settle`."""
        self._settled = settle(self, caught, progress, keeper)

    def _begin(self, dt: float) -> None:
        """Prepare the bodies for the coming step dt [s], and apply loads and prescribed motions."""
        for body in self.bodies:
            body.begin(dt)
        self.clock.pace(dt)
        time, passing = self.clock.span(dt)
        self.stages.begin(time, passing)

    def step_limit(self) -> tuple[StepLimit, str]:
        """Return the limit of the stable step in the present state, and the name of the limiting body; an empty name if no
        body limits it."""
        return self.clock.limit(self.bodies)

    def show(self, progress: Progress | None) -> None:
        """Report the progress of the run, at most once in PROGRESS_INTERVAL seconds of wall-clock time."""
        now = wall_clock.monotonic()
        if progress is None or now - self._shown < PROGRESS_INTERVAL:
            return
        self._shown = now
        points = sum(body.n_told for body in self.bodies)
        error = self.budget.energy_error()
        clock = self.clock
        now_at, search = clock.progress(), clock.search()
        progress.update(step=clock.n_steps, time=now_at, dt=clock.dt, points=points, energy_error=error, search=search)

    # values for results

    @property
    def grid(self) -> Grid:
        """Grid of the first velocity field; most cases have a single velocity field. Raises ValueError if the case has no
        grid."""
        if not self.velocity_fields:
            raise ValueError("this case has no grid")
        return self.velocity_fields[0].grid

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time

    @property
    def threads(self) -> int:
        """Number of threads in use."""
        return self.thread_choice.chosen

    @property
    def n_steps(self) -> int:
        """Number of steps done."""
        return self.clock.n_steps

    @property
    def dt(self) -> float:
        """Length of the last step [s]."""
        return self.clock.dt

    def momentum(self) -> np.ndarray:
        """Return the total momentum [kg m/s], shape (3,)."""
        return np.asarray(sum(body.totals.momentum for body in self.bodies))

    def facts(self) -> dict[str, Any]:
        """Return entries for the summary of the run, by name: clock (such as steps of a steady analysis), settling, inflow
        and outflow, and parts of the step, as far as the case has them."""
        momenta = {"inflow": self.budget.entered_momentum, "outflow": self.budget.left_momentum}
        passed = {
            name: {**counts, "momentum": momenta[name].tolist()}
            for name, counts in (("inflow", self.budget.inflow), ("outflow", self.budget.outflow))
            if counts
        }
        return self.clock.facts() | self._settled | passed | self.parts.facts()

    def kinetic_energy(self) -> float:
        """Return the kinetic energy of all bodies [J]."""
        return sum(body.totals.kinetic for body in self.bodies)

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return every array that affects the next step, by name, for a checkpoint."""
        owners = {body.name: body.state_arrays() for body in self.bodies} | {CLOCK: self.clock.state_arrays()}
        owners[PARTS] = self.parts.state_arrays()
        owners |= {NODES + field.name: field.state_arrays() for field in self.velocity_fields}
        return {name: array for owner, own in owners.items() for name, array in with_owner(owner, own).items()}

    def spread_arrays(self) -> list[str]:
        """Return the names of the state arrays whose points are distributed among processes."""
        spread = (body for body in self.bodies if isinstance(body, GridBody) and body.storage.shared.is_spread)
        return [name for body in spread for name in with_owner(body.name, body.arrays)]

    def state_numbers(self) -> dict[str, Any]:
        """Return every number that affects the next step, in a form that JSON can store."""
        return {
            "clock": self.clock.state_numbers(),
            "balance": self.budget.state_numbers(),
            "bodies": {body.name: body.totals.to_data() for body in self.bodies},
            "parts": self.parts.state_numbers(),
            "warned": sorted(self._watch.warned),
            "settled": self._settled,
        }

    def restore(self, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Restore a checkpoint bit for bit. Raises UsageError for a checkpoint of an earlier version, which stored other data;
        arrays, numbers: as returned by `state_arrays` and `state_numbers`."""
        with domain.joining(NOWHERE):
            lacking = sorted(self.state_arrays().keys() - arrays.keys())
        if lacking or numbers.keys() != self.state_numbers().keys():
            without = f" (it has no `{lacking[0]}`)" if lacking else ""
            text = f"the checkpoint was written by another version of pellucid{without}"
            raise UsageError(f"{text}.\n    Resume it with that version, or start a new run.")
        self.clock.ready(numbers["clock"])
        for body in self.bodies:
            body.restore(of_owner(body.name, arrays))
            body.totals.restore(numbers["bodies"][body.name])
        self.parts.restore(numbers["parts"], of_owner(PARTS, arrays))
        for field in self.velocity_fields:
            field.restore(of_owner(NODES + field.name, arrays))
        settles = SETTLING in numbers["clock"]
        if settles and self.case.settle is not None:
            self.clock = SettlingClock(self.case.settle, self.clock, self.case.body)
        self.clock.restore(numbers["clock"], of_owner(CLOCK, arrays))
        self.budget.restore(numbers["balance"])
        self._watch.warned = set(numbers["warned"])
        self.begun, self._settled = not settles, dict(numbers["settled"])
