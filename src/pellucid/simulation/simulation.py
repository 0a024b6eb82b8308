"""Simulation of a case: bodies, velocity fields, conditions, and the time loop."""

import time as wall_clock
import warnings
from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.bodies.transfer_loss import contact_lag_work, return_heat, separate_force_buffers, transfer_work
from pellucid.case.spec import required
from pellucid.conditions.active import ActiveConditions
from pellucid.conditions.support import on_each_face
from pellucid.contact.contact_energy import ContactEnergy
from pellucid.energy import (
    CONTACT,
    DAMPING,
    INFLOW_ENERGY,
    OUTFLOW_ENERGY,
    TRANSFER,
    AngularBalance,
    EnergyBudget,
    energy_at_stake,
    total_work,
)
from pellucid.errors import RunStopped, UsageError
from pellucid.grid.implicit_viscosity import CHANNELS
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import TRANSFERS, Flip, VelocityTransfer
from pellucid.jit import set_threads
from pellucid.named import Named
from pellucid.parts.capabilities import LosesPoints, ShowsStart, TakesGravity
from pellucid.parts.families import GridBody
from pellucid.parts.relaxable import Relaxable
from pellucid.progress import Progress
from pellucid.ranks.domain import NOWHERE, domain
from pellucid.set_up.behind_walls import with_room_behind_walls
from pellucid.set_up.first_look import refuse, warnings_of
from pellucid.simulation.assembly import build_bodies, work_layout, worthwhile_threads
from pellucid.simulation.clock import Clock
from pellucid.simulation.contacts import contacts_of, may_touch_by_surfaces
from pellucid.simulation.light_nodes import small_masses
from pellucid.simulation.node_contacts import node_contacts
from pellucid.simulation.observer import Observer
from pellucid.simulation.ranks import SharedSlabs, idle, interrupted
from pellucid.simulation.schemes import SCHEMES
from pellucid.simulation.settling import SETTLING, SettlingClock, settle
from pellucid.simulation.stages import Stages
from pellucid.simulation.start import Standings, load_state
from pellucid.simulation.start_overlaps import find_start_overlaps
from pellucid.simulation.steady import SteadyClock
from pellucid.simulation.threads import ThreadChoice, numbers_up_to
from pellucid.simulation.timing import time_stages
from pellucid.simulation.watch import Watch, free_axes
from pellucid.state import of_owner, with_owner
from pellucid.step.limit import StepLimit, time_to_fall
from pellucid.system.interrupts import signals_caught
from pellucid.system.processes import free_cores

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.case.stages import SettleCase

CLOCK = "-clock"  # owner of the clock's arrays in a checkpoint; no body can have this name
CONTACT_SURFACES = "-contact"  # owner of the arrays of surfaces in contact in a checkpoint
NODES = "-nodes."  # owner of the nodal arrays of a velocity field in a checkpoint, followed by its name
PROGRESS_INTERVAL = 0.2  # s of wall time


class Simulation:
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
        layout = self._layout = work_layout(case, may_touch_by_surfaces(case))
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
        self._losing_points = [body for body in self.bodies if isinstance(body, LosesPoints)]
        numbers = (
            numbers_up_to(min(1 + free_cores(), max(1, set_threads(None) // domain.group.here)))
            if threads is None
            else [set_threads(threads)]
        )
        self._threads = ThreadChoice(numbers, worthwhile_threads(self.bodies), set_threads)
        standing = Standings(self.bodies, start.keys())
        refuse(case, standing, start.keys())
        self.conditions = ActiveConditions(case, built, self.velocity_fields, layout)
        separate_force_buffers(self._on_grid.values())
        self._set_actions(transfer)
        if case.steady is not None:  # before contact, whose springs are as stiff as steps allow
            for body in self.bodies:
                if isinstance(body, Relaxable):
                    body.begin_relaxing(case.steady.mass_scaling)
        self.contact_pairs, self.surface_pairs = contacts_of(case, built, self.velocity_fields, layout)
        self.start_overlaps = find_start_overlaps(self.surface_pairs, case, start)
        self.node_contacts = node_contacts(case, built, self.contact_pairs)
        remaps = isinstance(transfer, Flip) and case.time.scheme == "musl"
        acting = self.conditions, self.contact_pairs
        self.stages = Stages(self.bodies, self.velocity_fields, self._on_grid, *acting, remaps)
        self._scheme = SCHEMES[case.time.scheme]
        self.clock = self._clock()
        self._support_names = [support.name for support in on_each_face(case.support)]
        self.begin_balance()
        self._begun, self._settled = False, dict[str, Any]()
        own_steps = all(body.has_own_step for body in case.body) and not self._on_grid
        self._watch = Watch(case.energy, own_steps, case.grid_or_none is not None, case.time.transfer)
        self.timers: dict[str, float] = {}
        self._shared: SharedSlabs | None = None
        self._shown = 0.0
        for text in warnings_of(case, standing, start.keys()):
            warnings.warn(text, stacklevel=2)
        for overlap in self.start_overlaps:
            if len(overlap.between) > 1:  # within one body, as beside a rim or a fold, nothing acts later for it elsewhere
                warnings.warn(overlap.text, stacklevel=2)
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
        for actions in self.conditions.actions:
            if self._layout.surface_contact is not None:
                actions.take_loads()
            field = actions.field
            field.set_actions(actions.supports, actions.external(), case.gravity, small[field], transfer.flip)

    def _clock(self) -> Clock:
        case = self.case
        if case.steady:
            return SteadyClock(case.steady, case.time, self.bodies, case.body, self.surface_pairs)
        pull = case.largest_gravity
        longest = time_to_fall(case.grid.cell, pull) if pull > 0.0 and case.grid_or_none else inf
        most = case.output.rows_every(case.time.end) if any(body.has_own_step for body in case.body) else inf
        return Clock(case.time, longest, most)

    def record(self, dt: float) -> None:
        """Add the works and impulses of a completed step dt [s] to the balances of energy and momentum."""
        heats = (body.work() for body in self.stages.grid_bodies)
        own = [*(heat for heat in heats if heat is not None), *(body.work() for body in self.stages.nodal_bodies)]
        last = self.case.time.scheme != "usf"
        lost = [transfer_work(field, bodies, dt, last) for field, bodies in self._on_grid.items()]
        on_nodes = self.stages.works
        if self.contact_pairs:
            lost.append(contact_lag_work(self.contact_pairs))
            on_nodes = [*on_nodes, self.contact_pairs.done.work]
        won = -sum(float(work.works[TRANSFER]) for work in lost)
        if won > 0.0:
            lost += return_heat(self.stages.grid_bodies, won)
        own += [viscosity.work([self._layout.column(heat) for heat in CHANNELS]) for viscosity in self.stages.viscosities]
        done = total_work([*on_nodes, *self.conditions.works(), *lost, *own], self._layout.n_columns)
        done = self._layout.with_surface_contact(done, self.surface_pairs.external_work())
        self.surface_pairs.energy.add_work(float(done.works[CONTACT]))
        if (lent := self.surface_pairs.lent) != 0.0:  # on the way to a steady state, like what its damping takes
            done.works[CONTACT] -= lent
            done.works[DAMPING] -= lent
        impulses = self.contact_pairs.done.impulses | self.surface_pairs.impulses() | self.conditions.impulses()
        self.budget.record(self.bodies, done, impulses, dt, self.clock.weight)
        self._balanced_step = self.n_steps

    def begin_balance(self) -> None:
        """Start the balances of mass, momentum and energy with the present state as reference."""
        speeds = [0.0 if model.is_rigid else model.waves_at_start()[0] for model in self.case.body]
        at_stake = energy_at_stake(self.bodies, self.case.gravity, speeds) + self.conditions.at_stake()
        self.budget = EnergyBudget(self.bodies, self.case.gravity, self._layout.channels, at_stake)
        self.surface_pairs.energy = ContactEnergy()
        turns = free_axes(self.case)
        self._turning = AngularBalance(self.bodies, turns) if turns else None
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
        self._watch.conditions(self.conditions, self.clock)
        if self.contact_pairs:
            self._watch.contact(self.contact_pairs, self.clock)
        else:  # beside impulses of contact on nodes, which have no balance of their own
            self._watch.surfaces(self.surface_pairs, self.clock)
            if self.case.steady is None:  # of whose damping the energy of contact knows nothing
                self._watch.contact_energy(self.surface_pairs.energy, self.budget, self.clock)

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
        for viscosity in self.stages.viscosities:
            viscosity.check(self.clock.n_steps, self.clock.progress())
        self.conditions.end(dt)
        self.record(dt)
        for body in self._losing_points:
            if left := body.let_leave():
                self.budget.let_go(self.bodies, left, dt)
        for entered in self.conditions.enter(self.clock.n_steps, self.clock.progress()):
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

    def settling_clock(self, settle: "SettleCase") -> SettlingClock:
        """Return a clock for settling, which counts steps while the time of the loads stays at 0; settle: the table
        [settle]."""
        return SettlingClock(settle, self.clock, self.case.body)

    def _begin(self, dt: float) -> None:
        """Prepare the bodies for the coming step dt [s], and apply conditions, contact between surfaces and variable
        gravity."""
        for body in self.bodies:
            body.begin(dt)
        self.clock.pace(dt)
        time, passing = self.clock.span(dt)
        self.conditions.begin(time, passing)
        self.surface_pairs.act(dt, self.clock.dt, time, passing)
        if self.case.gravity_amplitude is not None:
            self._share_gravity(self.case.gravity_amplitude.at(time))

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
        limit, name = self.clock.limit(self.bodies)
        of_condition = self.conditions.step_limit()
        return (of_condition, "") if of_condition.step <= limit.step < inf else (limit, name)

    def show(self, progress: Progress | None) -> None:
        """Report the progress of the run, at most once in PROGRESS_INTERVAL seconds of wall-clock time."""
        now = wall_clock.monotonic()
        if progress is None or now - self._shown < PROGRESS_INTERVAL:
            return
        self._shown = now
        points = sum(body.n_told for body in self.bodies)
        error = self.budget.energy_error()
        progress.update(step=self.n_steps, time=self.clock.progress(), dt=self.dt, points=points, energy_error=error)

    # state and results

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
        return self._threads.chosen

    @property
    def n_steps(self) -> int:
        """Number of steps done."""
        return self.clock.n_steps

    @property
    def dt(self) -> float:
        """Length of the last step [s]."""
        return self.clock.dt

    def energies(self) -> dict[str, float]:
        """Return the entries of the energy balance [J], by name, such as kinetic energy and works."""
        return Named("the energy balance has no entry", self.budget.energies())

    @property
    def is_balanced(self) -> bool:
        """True if the energy balance includes all works of the last step; False after a step in which a body stopped the
        run."""
        return self._balanced_step == self.n_steps

    def momentum(self) -> np.ndarray:
        """Return the total momentum [kg m/s], shape (3,)."""
        return np.asarray(sum(body.totals.momentum for body in self.bodies))

    def reactions(self) -> dict[str, np.ndarray]:
        """Return the total impulses so far of named supports and motions on the bodies that they constrain [N s], shape
        (3,), by name."""
        reactions = self.budget.reactions(self._support_names)
        return Named("this simulation has no reaction of", reactions)

    def angular_reactions(self) -> dict[str, np.ndarray]:
        """Return, by the name of each prescribed motion of a rigid body, the angular impulse that it has exerted on the body
        so far, about the centre of mass of the body [N m s], shape (3,)."""
        turning = {name: np.array(impulse) for name, impulse in self.budget.turning_impulses.items()}
        return Named("this simulation has no torque of", turning)

    def conservation(self) -> dict[str, float]:
        """Return the relative errors of mass, momentum and energy, by name. Momentum is included only if the impulses of
        the last step are known, and angular momentum only if no external action has affected the bodies."""
        errors = self.budget.conservation(self.bodies)
        known = {name: error for name, error in errors.items() if self.is_balanced or name != "momentum"}
        if self._turning is not None and self.budget.is_isolated and self.is_balanced:
            known["angular_momentum"] = self._turning.error(self.bodies)
        return Named("this simulation has no conservation error of", known)

    @property
    def outflow(self) -> dict[str, float]:
        """Number and mass [kg] of the points that left through outflows; empty if the case has none."""
        if OUTFLOW_ENERGY not in self._layout.channels:
            return {}
        return {"points": self.budget.left_points, "mass": self.budget.left_mass}

    @property
    def inflow(self) -> dict[str, float]:
        """Number and mass [kg] of the points that entered through inflows; empty if the case has none."""
        if INFLOW_ENERGY not in self._layout.channels:
            return {}
        return {"points": self.budget.entered_points, "mass": self.budget.entered_mass}

    @property
    def condition_states(self) -> Mapping[str, float]:
        """Values that conditions write to the history, such as the pressure of an enclosed gas, by column name."""
        return self.conditions.columns()

    def facts(self) -> dict[str, Any]:
        """Return entries for the summary of the run, by name: clock (such as steps of a steady analysis), settling, inflow
        and outflow, iterations of implicit viscosity, and overlaps at the start, as far as the case has them."""
        momenta = {"inflow": self.budget.entered_momentum, "outflow": self.budget.left_momentum}
        passed = {
            name: {**counts, "momentum": momenta[name].tolist()}
            for name, counts in (("inflow", self.inflow), ("outflow", self.outflow))
            if counts
        }
        solved = {viscosity.field.name: viscosity.facts() for viscosity in self.stages.viscosities}
        facts = self.clock.facts() | self._settled | passed
        overlaps = [overlap.facts() for overlap in self.start_overlaps]
        return facts | ({"implicit_viscosity": solved} if solved else {}) | ({"start_overlaps": overlaps} if overlaps else {})

    def kinetic_energy(self) -> float:
        """Return the kinetic energy of all bodies [J]."""
        return sum(body.totals.kinetic for body in self.bodies)

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return every array that affects the next step, by name, for a checkpoint."""
        owners = {body.name: body.state_arrays() for body in self.bodies} | {CLOCK: self.clock.state_arrays()}
        owners[CONTACT_SURFACES] = self.surface_pairs.state_arrays()
        owners |= {NODES + field.name: field.state_arrays() for field in self.velocity_fields}
        return {name: array for owner, own in owners.items() for name, array in with_owner(owner, own).items()}

    def spread_arrays(self) -> list[str]:
        """Return the names of the state arrays whose points are distributed among processes."""
        spread = (body for body in self.bodies if isinstance(body, PointsOnGrid) and body.shared.is_spread)
        return [name for body in spread for name in with_owner(body.name, body.arrays)]

    def state_numbers(self) -> dict[str, Any]:
        """Return every number that affects the next step, in a form that JSON can store."""
        return {
            "clock": self.clock.state_numbers(),
            "balance": self.budget.state_numbers(),
            "angular_momentum": self._turning.state_numbers() if self._turning is not None else {},
            "surface_contact": self.surface_pairs.state_numbers(),
            "bodies": {body.name: body.totals.to_data() for body in self.bodies},
            "conditions": self.conditions.state_numbers(),
            "warned": sorted(self._watch.warned),
            "settled": self._settled,
            "viscosity_rounds": [viscosity.rounds for viscosity in self.stages.viscosities],
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
        for body in self.bodies:
            body.restore(of_owner(body.name, arrays))
            body.totals.restore(numbers["bodies"][body.name])
        self.conditions.restore(numbers["conditions"])
        for field in self.velocity_fields:
            field.restore(of_owner(NODES + field.name, arrays))
        for viscosity, rounds in zip(self.stages.viscosities, numbers["viscosity_rounds"], strict=True):
            viscosity.rounds = list(rounds)
        settles = SETTLING in numbers["clock"]
        if settles and self.case.settle is not None:
            self.clock = self.settling_clock(self.case.settle)
        self.clock.restore(numbers["clock"], of_owner(CLOCK, arrays))
        self.budget.restore(numbers["balance"])
        if self._turning is not None:
            self._turning.restore(numbers["angular_momentum"])
        self.surface_pairs.restore(numbers["surface_contact"])
        self.surface_pairs.restore_arrays(of_owner(CONTACT_SURFACES, arrays))
        self._watch.warned = set(numbers["warned"])
        self._begun, self._settled = not settles, dict(numbers["settled"])
        self._balanced_step = self.n_steps
