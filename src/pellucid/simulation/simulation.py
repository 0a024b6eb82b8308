"""Simulation of a case: bodies, velocity fields, conditions, and the time loop."""

import time as wall_clock
import warnings
from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.transfer_loss import TransferHeat, separate_force_buffers
from pellucid.case.spec import required
from pellucid.energy import total_work
from pellucid.errors import RunStopped, UsageError
from pellucid.grid.actions import NodalActions
from pellucid.grid.full_cells import cell_pressures
from pellucid.grid.implicit_viscosity import implicit_viscosity
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import TRANSFERS, VelocityTransfer
from pellucid.jit import set_threads
from pellucid.parts.capabilities import Relaxable, ShowsStart, TakesGravity
from pellucid.parts.families import GridBody
from pellucid.progress import Progress
from pellucid.ranks.domain import domain
from pellucid.set_up.behind_walls import with_room_behind_walls
from pellucid.set_up.first_look import refuse, warnings_of
from pellucid.simulation.assembly import activate_conditions, build_bodies, work_layout, worthwhile_threads
from pellucid.simulation.clock import Clock
from pellucid.simulation.contacts import contact_parts
from pellucid.simulation.light_nodes import small_masses
from pellucid.simulation.observer import Observer
from pellucid.simulation.ranks import SharedSlabs, idle, interrupted
from pellucid.simulation.schemes import SCHEMES
from pellucid.simulation.settling import settle
from pellucid.simulation.simulation_state import SimulationState
from pellucid.simulation.stages import Stages
from pellucid.simulation.start import Standings, load_state
from pellucid.simulation.steady import SteadyClock
from pellucid.simulation.threads import ThreadChoice, numbers_up_to
from pellucid.simulation.timing import time_stages
from pellucid.simulation.watch import Watch
from pellucid.step.limit import StepLimit, time_to_fall
from pellucid.step.part import AtEachStep
from pellucid.system.interrupts import signals_caught
from pellucid.system.processes import free_cores

if TYPE_CHECKING:
    from pellucid.case import Case

PROGRESS_INTERVAL = 0.2  # s of wall time


class Simulation(SimulationState):
    """Simulation of a case. Call `step()` for one step, or `run(recorder)` for the whole case. The attribute `bodies` lists
    the bodies in the order of the case."""

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
        numbers = (
            numbers_up_to(min(1 + free_cores(), max(1, set_threads(None) // domain.group.here)))
            if threads is None
            else [set_threads(threads)]
        )
        self._threads = ThreadChoice(numbers, worthwhile_threads(self.bodies), set_threads)
        standing = Standings(self.bodies, start.keys())
        refuse(case, standing, start.keys())
        self.actions = [NodalActions(field, layout.n_loads) for field in self.velocity_fields]
        self.parts = activate_conditions(case, built, self.actions, layout)
        separate_force_buffers(self._on_grid.values())
        self._set_actions(transfer)
        if case.steady is not None:  # before parts whose springs are as stiff as steps allow
            for body in self.bodies:
                if isinstance(body, Relaxable):
                    body.begin_relaxing(case.steady.mass_scaling)
        for field, bodies in self._on_grid.items():
            self.parts.add(cell_pressures(field, bodies))
            self.parts.add(implicit_viscosity(field, bodies, layout))
        self.parts.add(contact_parts(case, built, self.velocity_fields, layout, start))
        if self._on_grid:
            self.parts.add([TransferHeat(self._on_grid, self.parts, case.time.scheme != "usf")])
        if (amplitude := case.gravity_amplitude) is not None:
            self.parts.add([AtEachStep(lambda time: self._share_gravity(amplitude.at(time)))])
        self.stages = Stages(self.bodies, self.velocity_fields, self._on_grid, self.parts)
        self._scheme = SCHEMES[case.time.scheme]
        self.clock = self._clock()
        self.begin_balance()
        self._begun, self._settled = False, dict[str, Any]()
        own_steps = all(body.has_own_step for body in case.body) and not self._on_grid
        self._watch = Watch(case.energy, own_steps, case.grid_or_none is not None, case.time.transfer)
        self.timers: dict[str, float] = {}
        self._shared: SharedSlabs | None = None
        self._shown = 0.0
        for text in warnings_of(case, standing, start.keys()):
            warnings.warn(text, stacklevel=2)
        if (without_work := idle(domain.group.size, self.velocity_fields)) is not None:
            warnings.warn(without_work, stacklevel=2)
        dt = self.clock.next_step(self.bodies)  # an unstable fixed step is an error of the case
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
            return SteadyClock(case.steady, case.time, self.bodies, case.body, self.parts)
        pull = case.largest_gravity
        longest = time_to_fall(case.grid.cell, pull) if pull > 0.0 and case.grid_or_none else inf
        most = case.output.rows_every(case.time.end) if any(body.has_own_step for body in case.body) else inf
        return Clock(case.time, longest, most, self.parts)

    def record(self, dt: float) -> None:
        """Add the works and impulses of a completed step dt [s] to the balances of energy and momentum."""
        heats = (body.work() for body in self.stages.grid_bodies)
        own = [*(heat for heat in heats if heat is not None), *(body.work() for body in self.stages.nodal_bodies)]
        done = total_work([*self.stages.works, *self.parts.works(), *own], self._layout.n_columns)
        self.parts.run("balance", done)
        self.budget.record(self.bodies, done, self.parts.impulses(), dt, self.clock.weight)
        self._balanced_step = self.n_steps

    def step(self) -> None:
        """Advance one time step. Raises RunStopped, naming the point, if the state becomes invalid."""
        self.advance_bodies()
        self._begun = True
        self._watch.energy(self.budget, self.clock, self.bodies)
        if self._turning is not None and self.budget.is_isolated:
            self._watch.angular_momentum(self._turning, self.bodies, self.clock)
        self._watch.volumes(self._on_grid, self.clock)
        self._watch.states(self.bodies, self.clock)
        self._watch.approaches(self.bodies, self.clock)
        self._watch.parts(self.parts, self.budget, self.clock)

    def __iter__(self) -> Iterator["Simulation"]:
        """Advance to the end of the case, and yield this `Simulation` after each step, for user-defined loops.

        Before the first step bodies settle if the case has [settle]. Raises RunStopped like `step`. See `pellucid.recorded`
        for loops that store results.
        """
        if not self._begun:
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
        self._begin(dt)
        self._scheme(self.stages, dt)
        self.clock.advance(dt)
        for body in self.bodies:
            body.check(self.clock.n_steps, self.clock.progress())
        self.parts.run("check", self.clock.n_steps, self.clock.progress())
        self.parts.end(dt)
        self.record(dt)
        for left in self.parts.leave():
            self.budget.let_go(self.bodies, left, dt)
        for entered in self.parts.enter(self.clock.n_steps, self.clock.progress()):
            self.budget.let_in(self.bodies, entered)

    def _share_gravity(self, share: float) -> None:
        for field in self.velocity_fields:
            field.share_gravity(share)
        for body in self.bodies:
            if isinstance(body, TakesGravity):
                body.share_gravity(share)

    def stop_bodies(self) -> None:
        """Set all velocities of the bodies to zero."""
        for body in self.bodies:
            body.come_to_rest()

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

    def run(self, recorder: Observer, until: float | None = None, progress: Progress | None = None) -> None:
        """Compute steps until the end of the case or `until` [s] of simulated time; recorder: object that stores the
        results; progress: display of the progress. SIGTERM and Ctrl-C write a checkpoint and raise Interrupted."""
        for _ in self.recorded(recorder, until, progress):
            pass

    def recorded(
        self, recorder: Observer, until: float | None = None, progress: Progress | None = None
    ) -> Iterator["Simulation"]:
        """Advance like `run`, with the same arguments, and yield this `Simulation` after each step. If the loop ends early,
        the stored results end at the last step of the loop."""
        with signals_caught() as caught:
            try:
                if not self._begun:
                    self._settle_and_begin(recorder, caught, progress)
                else:
                    recorder.begin(self)
                if progress:
                    progress.begin("running", self.case.time.end if until is None else until)
                while not self.clock.finished(until):
                    if self.clock.is_last_try:
                        recorder.checkpoint(self)
                    self._threads.before_step()
                    self.step()
                    self._threads.after_step()
                    recorder.after_step(self)
                    if self.clock.missed is not None:
                        recorder.keep_last(self)
                        raise RunStopped(self.clock.missed, step=self.n_steps, time=self.time)
                    if signals := domain.caught(caught):
                        recorder.checkpoint(self)
                        raise interrupted(signals)
                    self.show(progress)
                    yield self
                recorder.end(self)
                if signals := domain.caught(caught):
                    raise interrupted(signals)
            except GeneratorExit:
                recorder.end(self)
                raise
            except RunStopped as error:
                domain.group.agree_on(error)  # what follows asks all processes
                recorder.failed(self, error)
                raise

    def _settle_and_begin(self, recorder: Observer, caught: Sequence[int], progress: Progress | None) -> None:
        """Let the bodies settle if the case has [settle], and start recording. If settling fails, the state at the failure
        is recorded; an error of this recording does not replace the error that stopped the settling.

        recorder: object that stores the results; caught: signals received so far.
        """
        try:
            self.settle(caught, progress, recorder)
        except RunStopped as error:
            self.begin_balance()  # that of the settling lacks what the bodies lost when they were stopped
            try:
                recorder.begin(self)
            except Exception as trouble:
                error.add_note(f"The state at the stop could not be recorded: {trouble}")
            raise
        recorder.begin(self)

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
        progress.update(step=self.n_steps, time=self.clock.progress(), dt=self.dt, points=points, energy_error=error)
