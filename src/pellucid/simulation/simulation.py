"""A case that runs: bodies, velocity fields, conditions, and the only time loop."""

import signal
import time as wall_clock
import warnings
from collections.abc import Mapping, Sequence
from math import hypot, inf, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.transfer_loss import contact_lag_work, return_heat, separate_force_buffers, transfer_work
from pellucid.case.spec import required
from pellucid.conditions.active import ActiveConditions, layout_of
from pellucid.conditions.symmetry import symmetry_planes
from pellucid.contact.contact_energy import ContactEnergy
from pellucid.contact.pairs import NO_CONTACT, ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.energy import (
    CONTACT,
    CONTACT_WORK,
    DAMPING_HEAT,
    OUTFLOW_ENERGY,
    TRANSFER,
    TRANSFER_HEAT,
    EnergyBudget,
    energy_at_stake,
    total_work,
)
from pellucid.errors import Interrupted, RunStopped, UsageError
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import TRANSFERS, Flip
from pellucid.jit import set_threads
from pellucid.jit.joint import joint_region
from pellucid.named import Named
from pellucid.parts.families import GridBody, NodalBody
from pellucid.parts.step_limit import StepLimit
from pellucid.progress import Progress
from pellucid.set_up.first_look import refuse, warnings_of
from pellucid.simulation.assembly import (
    build_bodies,
    cell_pressures,
    may_touch_by_surfaces,
    pairs_of,
    surfaces_of,
    worthwhile_threads,
)
from pellucid.simulation.clock import Clock
from pellucid.simulation.light_nodes import small_masses
from pellucid.simulation.observer import Observer
from pellucid.simulation.schemes import SCHEMES
from pellucid.simulation.settling import SETTLING, SettlingClock, settle
from pellucid.simulation.start import load_state
from pellucid.simulation.steady import SteadyClock
from pellucid.simulation.threads import ThreadChoice, numbers_up_to
from pellucid.simulation.timing import time_verbs
from pellucid.simulation.walls import wall_contacts
from pellucid.simulation.watch import Watch
from pellucid.state import of_owner, with_owner
from pellucid.system.interrupts import signals_caught
from pellucid.system.processes import free_cores

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.case.stages import SettleCase

CLOCK = "-clock"  # owner of the clock's arrays in a checkpoint; no body is called so
NODES = "-nodes."  # the same of the nodes of a velocity field, before its name
PROGRESS_INTERVAL = 0.2  # s of wall time


class Simulation:
    """A case that is built. `step()` once, or `run(recorder)` to the end.

    bodies: in the order of the case; of these `grid_bodies` have their unknowns on the grid, `nodal_bodies` nodes of their own.
    """

    def __init__(
        self,
        case: "Case",
        threads: int | None = None,
        timed: bool = False,
        start: Mapping[str, Mapping[str, np.ndarray]] | None = None,
    ) -> None:
        """start: arrays of the bodies that go on from an earlier run, by name and in the order of the numbers of the points."""
        self.case = case = required(case)
        transfer = TRANSFERS[case.time.transfer](case.time.flip_fraction)
        several = case.grid_or_none is not None and len({body.field for body in case.body}) > 1
        touching = (several and may_touch_by_surfaces(case)) or (case.grid_or_none is not None and len(case.wall) > 0)
        columns = [*([CONTACT_WORK] if several else []), *([DAMPING_HEAT] if case.steady else [])]
        columns += [TRANSFER_HEAT] if case.grid_or_none is not None else []
        others = [*columns, *(channel for body in case.body for channel in body.channels())]
        layout = self._layout = layout_of(case, others, touching=touching)
        self._columns = layout.n_columns
        self.velocity_fields, built = build_bodies(case, transfer, layout.n_loads)
        if case.start is not None and start is None:
            raise UsageError("a case with [start] needs the state of the earlier run: run it with pellucid.run")
        start = start or {}
        load_state(built, start)
        self.bodies = [built[body.name][0] for body in case.body]
        self.grid_bodies = [body for body in self.bodies if isinstance(body, GridBody)]
        self._on_grid: dict[VelocityField, list[GridBody]] = {}
        for body, field in built.values():
            if isinstance(body, GridBody) and field is not None:
                self._on_grid.setdefault(field, []).append(body)
        self.nodal_bodies = [body for body in self.bodies if isinstance(body, NodalBody)]
        numbers = numbers_up_to(min(1 + free_cores(), set_threads(None))) if threads is None else [set_threads(threads)]
        self._threads = ThreadChoice(numbers, worthwhile_threads(self.bodies), set_threads)
        standing = {body.name: body.standing(body.name in start) for body in self.bodies}
        refuse(case, standing, start.keys())
        self.conditions = ActiveConditions(case, built, self.velocity_fields, layout)
        separate_force_buffers(self._on_grid.values())
        self._cell_pressures = cell_pressures(self._on_grid)
        mapped_again = isinstance(transfer, Flip) and case.time.scheme == "musl"
        self._mapped_again = [
            field for field, group in self._on_grid.items() if mapped_again and not any(body.keeps_heat for body in group)
        ]
        if touching:
            for actions in self.conditions.actions:
                actions.take_loads()
        small = small_masses(case, self.bodies, {field: self._on_grid.get(field, []) for field in self.velocity_fields})
        for actions in self.conditions.actions:
            field = actions.field
            field.set_actions(actions.supports, actions.external(), case.gravity, small[field], transfer.flip)
        pull = hypot(*case.gravity) * (case.gravity_amplitude.largest if case.gravity_amplitude else 1.0)
        column, courant = layout.surface_contact, case.time.courant
        touch = built.keys() if several else {body.name for wall in case.wall for body in wall.touching(case.body)}
        surfaces = surfaces_of(case, built, touch, column)
        pairs, surface_pairs = pairs_of(self.velocity_fields, built, case.contact, surfaces, pull, courant)
        planes = symmetry_planes(case.support, case.grid) if surface_pairs else []
        walls = wall_contacts(case, built, surfaces, column, pull)
        self.surface_pairs = SurfacePairs([*surface_pairs, *walls], planes)
        for body in self.bodies:
            body.bound_by_contact(self.surface_pairs.surfaces)
        self.contact_pairs = ContactPairs(pairs, len(case.support), layout.n_loads)
        self.has_contact = len(pairs) > 0
        self._contact = NO_CONTACT
        self._without_heat = {field for field, group in self._on_grid.items() if not all(body.keeps_heat for body in group)}
        self._support_names = [support.name for support in case.support]
        longest = sqrt(2.0 * case.grid.cell / pull) if pull > 0.0 and case.grid_or_none else inf
        most = case.output.rows_every(case.time.end) if any(body.has_own_step for body in case.body) else inf
        clock = Clock(case.time, longest, most)
        self.clock = SteadyClock(case.steady, case.time, self.bodies, case.body) if case.steady else clock
        self._channels = layout.channels
        self.begin_balance()
        self._begun, self._settled = False, dict[str, Any]()
        self._scheme = SCHEMES[case.time.scheme]
        own_steps = all(body.has_own_step for body in case.body) and not self.grid_bodies
        self._watch = Watch(case.energy, own_steps, case.grid_or_none is not None, case.time.transfer)
        self.timers: dict[str, float] = {}
        self._shown = 0.0
        for text in warnings_of(case, standing, start.keys()):
            warnings.warn(text, stacklevel=2)
        dt = self.clock.next_step(self.bodies)  # an unstable fixed step is an error of the case
        if own_steps:
            self._begin(dt)
            for own in self.nodal_bodies:
                own.show_start(dt)
        if timed:
            time_verbs(self, self.timers)

    # the verbs of a step that concern the nodes

    def clear(self) -> None:
        """Set mass, momentum and forces of the nodes to zero, and sums over cells."""
        for field in self.velocity_fields:
            field.clear()
        for pressure in self._cell_pressures:
            pressure.clear()

    def find_pressures(self) -> None:
        """Find the mean pressures of full cells, and their forces on the nodes."""
        for pressure in self._cell_pressures:
            pressure.find_pressures()

    def find_shifts(self, dt: float) -> None:
        """Find what the volumes of points lack of the growth of full cells, and its work."""
        for pressure in self._cell_pressures:
            pressure.find_shifts(dt)

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum (where `inertia`) and internal forces (where `force`) of the bodies on the grid to the nodes."""
        with joint_region:
            for body in self.grid_bodies:
                joint_region.make_room()
                body.particle_to_grid(inertia, force)

    def update_velocities(self, dt: float, remap: bool) -> None:
        """New velocities of the bodies on the grid; where `remap`, their momentum back on the nodes."""
        with joint_region:
            for body in self.grid_bodies:
                joint_region.make_room()
                body.begin_velocities(dt, remap)
        for body in self.grid_bodies:
            body.end_velocities(remap)

    def update_stress(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses of the bodies on the grid; where `move`, new positions."""
        with joint_region:
            for body in self.grid_bodies:
                joint_region.make_room()
                body.begin_stress(dt, move)
        for body in self.grid_bodies:
            body.end_stress(dt, move)

    def detect_contact(self, dt: float) -> None:
        """Find where velocity fields touch in this step."""
        self.contact_pairs.detect(dt)

    def advance(self, dt: float) -> None:
        """Advance the momentum of the nodes, then apply the impulses of conditions and of contact."""
        for field in self.velocity_fields:
            field.advance(dt, counted=not self.conditions.give_impulses)
        self.conditions.act_on_nodes(dt)
        if self.has_contact:
            self.contact_pairs.resolve()
        works = [field.works(dt) for field in self.velocity_fields]
        self._works = [work for work in works if work is not None]
        for pressure in self._cell_pressures:
            pressure.find_growth()
        if self.has_contact:
            self._contact = self.contact_pairs.work()
            self._works.append(self._contact.work)

    def project(self, dt: float | None = None) -> None:
        """Nodal velocities of the momentum mapped last; dt: of the step [s] in which it was advanced, None before."""
        for field in self.velocity_fields:
            field.project(dt, counted=dt is not None and field in self._without_heat)
        self.contact_pairs.project(self._mapped_again)

    def give_second_impulses(self, dt: float) -> None:
        """Let bodies have the impulses by which contact stopped the approach of what was mapped again."""
        if self.has_contact:
            self._contact = self._contact.add(self.contact_pairs.give_second(dt))
            self._works[-1] = self._contact.work

    def sort(self) -> None:
        """Sort the points of bodies that need it."""
        for body in self.grid_bodies:
            body.sort_if_needed()

    def record(self, dt: float) -> None:
        """Add the step to the balance of energy and momentum."""
        heats = (body.work() for body in self.grid_bodies)
        own = [*(heat for heat in heats if heat is not None), *(body.work() for body in self.nodal_bodies)]
        last = self.case.time.scheme != "usf"
        lost = [transfer_work(field, bodies, dt, last) for field, bodies in self._on_grid.items()]
        if self.has_contact:
            lost.append(contact_lag_work(self.contact_pairs))
        won = -sum(float(work.works[TRANSFER]) for work in lost)
        if won > 0.0:
            lost += return_heat(self.grid_bodies, won)
        done = total_work([*self._works, *self.conditions.works(), *lost, *own], self._columns)
        done = self._layout.with_surface_contact(done, self.surface_pairs.external_work())
        self.surface_pairs.energy.add_work(float(done.works[CONTACT]))
        impulses = self._contact.impulses | self.surface_pairs.impulses()
        self.budget.record(self.bodies, done, impulses, dt, self.clock.weight)
        self._balanced_step = self.n_steps

    def begin_balance(self) -> None:
        """Count mass, momentum and energy from the state as it is."""
        speeds = [0.0 if model.is_rigid else model.material.wave_speeds()[0] for model in self.case.body]
        at_stake = energy_at_stake(self.bodies, self.case.gravity, speeds)
        self.budget = EnergyBudget(self.bodies, self.case.gravity, self._channels, at_stake)
        self.surface_pairs.energy = ContactEnergy()
        self._balanced_step = self.n_steps

    def step(self) -> None:
        """One step. Raises RunStopped, naming the point, where the state is no longer possible."""
        self.advance_bodies()
        self._begun = True
        self._watch.energy(self.budget, self.clock, self.bodies)
        self._watch.volumes(self._on_grid, self.clock)
        self._watch.states(self.bodies, self.clock)
        if self.has_contact:
            self._watch.contact(self.contact_pairs, self.clock)
        else:  # beside impulses of contact on nodes, which have no balance of their own
            self._watch.contact_energy(self.surface_pairs.energy, self.budget, self.clock)

    def advance_bodies(self) -> None:
        """One step, of which the energy balance is not judged."""
        dt = self.clock.next_step(self.bodies)
        self.sort()
        self._begin(dt)
        self._scheme(self, dt)
        self.clock.advance(dt)
        for body in self.bodies:
            body.check(self.clock.n_steps, self.clock.progress())
        self.record(dt)
        for body in self.grid_bodies:
            if left := body.let_leave():
                self.budget.let_go(self.bodies, left, dt)

    def _share_gravity(self, share: float) -> None:
        for field in self.velocity_fields:
            field.share_gravity(share)
        for body in self.nodal_bodies:
            body.share_gravity(share)

    def stop_bodies(self) -> None:
        """Take all velocity from the bodies."""
        for body in self.bodies:
            body.come_to_rest()

    def settle(self, caught: Sequence[int] = (), progress: Progress | None = None, keeper: Observer | None = None) -> None:
        """Before the first step: bring the bodies to rest, where the case has [settle]; see `pellucid.simulation.settling`."""
        self._settled = settle(self, caught, progress, keeper)

    def settling_clock(self, settle: "SettleCase") -> SettlingClock:
        """For the steps before the clock starts."""
        return SettlingClock(settle, self.clock, self.case.body)

    def _begin(self, dt: float) -> None:
        """What acts over the coming step."""
        for body in self.bodies:
            body.begin(dt)
        self.clock.pace(dt)
        time, passing = self.clock.span(dt)
        self.conditions.begin(time, passing)
        self.surface_pairs.act(dt, self.clock.dt, time, passing)
        if self.case.gravity_amplitude is not None:
            self._share_gravity(self.case.gravity_amplitude.at(time))

    def run(self, recorder: Observer, until: float | None = None, progress: Progress | None = None) -> None:
        """Step until the end of the case or `until` [s]. SIGTERM and Ctrl-C write a checkpoint and raise Interrupted."""
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
                    if caught:
                        recorder.checkpoint(self)
                        raise Interrupted(by_keyboard=caught[0] == signal.SIGINT)
                    self.show(progress)
                recorder.end(self)
                if caught:
                    raise Interrupted(by_keyboard=caught[0] == signal.SIGINT)
            except RunStopped as error:
                recorder.failed(self, error)
                raise

    def _settle_and_begin(self, recorder: Observer, caught: Sequence[int], progress: Progress | None) -> None:
        """What is recorded begins with the bodies at rest; with what there is where these cannot be brought to it, and what
        cannot be recorded of that does not hide why."""
        try:
            self.settle(caught, progress, recorder)
        except RunStopped as error:
            self.begin_balance()  # that of the settling lacks what the bodies lost when they were stopped
            try:
                recorder.begin(self)
            except Exception as trouble:
                error.add_note(f"the state in which it stopped could not be recorded: {trouble}")
            raise
        recorder.begin(self)

    def step_limit(self) -> tuple[StepLimit, str]:
        """What bounds the stable step of the state as it is, and the name of the body, none where it is no body."""
        return self.clock.limit(self.bodies)

    def show(self, progress: Progress | None) -> None:
        """How far it is, now and then."""
        now = wall_clock.monotonic()
        if progress is None or now - self._shown < PROGRESS_INTERVAL:
            return
        self._shown = now
        points = sum(body.n_points for body in self.bodies)
        error = self.budget.energy_error()
        progress.update(step=self.n_steps, time=self.clock.progress(), dt=self.dt, points=points, energy_error=error)

    # state and results

    @property
    def grid(self) -> Grid:
        """The grid of the first velocity field, which in most cases is the only one."""
        if not self.velocity_fields:
            raise ValueError("this case has no grid")
        return self.velocity_fields[0].grid

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time

    @property
    def threads(self) -> int:
        """Threads in use."""
        return self._threads.chosen

    @property
    def n_steps(self) -> int:
        """Steps done."""
        return self.clock.n_steps

    @property
    def dt(self) -> float:
        """Length of the last step [s]."""
        return self.clock.dt

    def energies(self) -> dict[str, float]:
        """The energy balance [J], by entry."""
        return Named("the energy balance has no entry", self.budget.energies())

    @property
    def is_balanced(self) -> bool:
        """Whether the balance has all works of the steps done; not of a step in which a body stopped the run."""
        return self._balanced_step == self.n_steps

    def momentum(self) -> np.ndarray:
        """Total momentum [kg m/s], shape (3,)."""
        return np.asarray(sum(body.totals.momentum for body in self.bodies))

    def reactions(self) -> dict[str, np.ndarray]:
        """Impulses so far of the supports and motions that have a name, on what they constrain [N s], shape (3,)."""
        reactions = self.budget.reactions(self._support_names)
        return Named("this simulation has no reaction of", reactions)

    def angular_reactions(self) -> dict[str, np.ndarray]:
        """Angular impulses so far of the motions of rigid bodies about their centres of mass [N m s], shape (3,), by name."""
        turning = {name: np.array(impulse) for name, impulse in self.budget.turning_impulses.items()}
        return Named("this simulation has no torque of", turning)

    def conservation(self) -> dict[str, float]:
        """Relative errors of mass, momentum and energy; of momentum only where the impulses of the last step are known too."""
        errors = self.budget.conservation(self.bodies)
        known = {name: error for name, error in errors.items() if self.is_balanced or name != "momentum"}
        return Named("this simulation has no conservation error of", known)

    @property
    def outflow(self) -> dict[str, float]:
        """Number and mass [kg] of the points that left; empty where none may."""
        if OUTFLOW_ENERGY not in self._channels:
            return {}
        return {"points": self.budget.left_points, "mass": self.budget.left_mass}

    def facts(self) -> dict[str, Any]:
        """What the summary tells of the analysis."""
        return self.clock.facts() | self._settled | ({"outflow": self.outflow} if self.outflow else {})

    def kinetic_energy(self) -> float:
        """Of all bodies [J]."""
        return sum(body.totals.kinetic for body in self.bodies)

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Every array that the next step depends on."""
        owners = {body.name: body.state_arrays() for body in self.bodies} | {CLOCK: self.clock.state_arrays()}
        owners |= {NODES + field.name: field.state_arrays() for field in self.velocity_fields}
        return {name: array for owner, own in owners.items() for name, array in with_owner(owner, own).items()}

    def state_numbers(self) -> dict[str, Any]:
        """Every number that the next step depends on, for JSON."""
        return {
            "clock": self.clock.state_numbers(),
            "balance": self.budget.state_numbers(),
            "surface_contact": self.surface_pairs.state_numbers(),
            "bodies": {body.name: body.totals.to_data() for body in self.bodies},
            "warned": sorted(self._watch.warned),
            "settled": self._settled,
        }

    def restore(self, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Go on from a checkpoint, bit for bit. Raises UsageError for one of an earlier version, which kept other things."""
        lacking = sorted(self.state_arrays().keys() - arrays.keys())
        if lacking or numbers.keys() != self.state_numbers().keys():
            without = f" (it has no `{lacking[0]}`)" if lacking else ""
            text = f"the checkpoint was written by another version of pellucid{without}"
            raise UsageError(f"{text}: go on with that one, or start the run again")
        for body in self.bodies:
            body.restore(of_owner(body.name, arrays))
            body.totals.restore(numbers["bodies"][body.name])
        for field in self.velocity_fields:
            field.restore(of_owner(NODES + field.name, arrays))
        settles = SETTLING in numbers["clock"]
        if settles and self.case.settle is not None:
            self.clock = self.settling_clock(self.case.settle)
        self.clock.restore(numbers["clock"], of_owner(CLOCK, arrays))
        self.budget.restore(numbers["balance"])
        self.surface_pairs.restore(numbers["surface_contact"])
        self._watch.warned = set(numbers["warned"])
        self._begun, self._settled = not settles, dict(numbers["settled"])
        self._balanced_step = self.n_steps
