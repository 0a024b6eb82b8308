"""A case set in motion: bodies, grid, conditions, and the only time loop."""

import hashlib
import os
import signal
import threading
import time as wall_clock
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import hypot, inf, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.membrane_elements.overlong import overlong
from pellucid.bodies.membrane_elements.surface import ElementBody
from pellucid.conditions.environment import Environment
from pellucid.contact.pairs import ContactPairs
from pellucid.energy import EnergyBudget
from pellucid.errors import Interrupted, RunStopped
from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import total_work
from pellucid.grid.velocity_transfer import TRANSFERS
from pellucid.jit import set_threads
from pellucid.simulation.assembly import build_velocity_fields, pairs_of, refuse_overlaps
from pellucid.simulation.clock import Clock
from pellucid.simulation.schemes import SCHEMES

if TYPE_CHECKING:
    from pellucid.case import Case

SMALL_MASS = 1e-4  # of the lightest point: nodes with less do not strain points by their internal forces
POINTS_PER_THREAD = 10_000  # at least; smaller shares cost more to hand out than they save
WATCHED = 100  # steps between looks at the elements that touch other bodies
SETTLED = 200  # steps after which the energy error is judged; before, there is too little energy to compare with
PROGRESS_INTERVAL = 0.2  # s of wall time


def kernel_key(case: "Case") -> str:
    """Names the kernels that a case needs, to tell whether they are compiled already."""
    laws = sorted({_law_kinds(body) for body in case.body})
    fields = sorted((body.kind, body.field) for body in case.body)
    conditions = f"{bool(case.motion)} {bool(case.pressure)} {bool(case.absorbing)} {fields}"
    kinds = f"{case.grid.functions} {case.grid.thin()} {case.time.transfer} {case.time.scheme} {laws} {conditions}"
    return hashlib.sha256(kinds.encode()).hexdigest()[:16]


def _law_kinds(body: Any) -> tuple[str, ...]:
    material = body.material
    eos, damage = getattr(material, "eos", None), getattr(material, "damage", None)
    how = "" if damage is None else "local" if damage.radius is None else "nonlocal"
    return (material.kind, getattr(material, "energy_update", ""), getattr(eos, "kind", ""), how)


class Simulation:
    """Everything that moves. `step()` once, or `run(recorder)` to the end."""

    def __init__(self, case: "Case", threads: int | None = None, timed: bool = False) -> None:
        self.case = case
        transfer = TRANSFERS[case.time.transfer](case.time.flip_fraction)
        self.velocity_fields = build_velocity_fields(case, transfer)
        built = {body.name: body for velocity_field in self.velocity_fields for body in velocity_field.bodies}
        self.bodies = [built[body.name] for body in case.body]
        self.threads = set_threads(threads or self._worthwhile_threads())
        refuse_overlaps(case, self.velocity_fields)
        rigid = [body.name for body in case.body if getattr(body, "rigid", False)]
        self.environment = Environment(self.velocity_fields, case.support, case.motion, rigid, case.absorbing, case.pressure)
        small_mass = SMALL_MASS * min(float(body.points.mass.min()) for body in self.bodies)
        for velocity_field, outside in zip(self.velocity_fields, self.environment.outsides, strict=True):
            velocity_field.act(outside, case.gravity, small_mass, transfer.flip)
        self.contact_pairs = ContactPairs(pairs_of(self.velocity_fields, case.contact), len(case.support) + 1)
        self.touching = len(self.contact_pairs) > 0
        self._support_names = [support.name for support in case.support]
        pull = hypot(*case.gravity)
        self.clock = Clock(case.time, sqrt(2.0 * case.grid.cell / pull) if pull > 0.0 else inf)
        works = (*self.environment.works, "contact") if self.touching else self.environment.works
        self.ledger = EnergyBudget(self.bodies, case.gravity, works)
        self._scheme = SCHEMES[case.time.scheme]
        self._warned: set[str] = set()
        self.timers: dict[str, float] = {}
        self.clock.next_step(self.bodies)  # an unstable fixed step is an error of the case
        if timed:
            self._time_verbs()

    def _worthwhile_threads(self) -> int:
        """Threads that a body of this size keeps busy."""
        points = sum(body.n_points for body in self.bodies)
        return max(1, min(os.cpu_count() or 1, points // POINTS_PER_THREAD))

    # the verbs of a step that concern the nodes

    def meet(self) -> None:
        """Find where velocity fields touch."""
        self.contact_pairs.find()

    def advance(self, dt: float) -> None:
        """Move the nodes, let those that touch push each other, and keep what they did."""
        works = [velocity_field.advance(dt) for velocity_field in self.velocity_fields]
        self.work = [
            work for work, velocity_field in zip(works, self.velocity_fields, strict=True) if not velocity_field.own_nodes
        ]
        self.contact = self.contact_pairs.resolve(self.case.gravity, dt)
        self.work.append(self.contact.nodes)

    def project(self) -> None:
        """Nodal velocities of the momentum mapped last."""
        for velocity_field in self.velocity_fields:
            velocity_field.project()
        self.contact_pairs.project()

    def sort(self) -> None:
        """Sort the bodies whose points left_slab."""
        for body in self.bodies:
            body.sort_if_needed()

    def record(self, dt: float) -> None:
        """Book the step."""
        own = [body for velocity_field in self.velocity_fields if velocity_field.own_nodes for body in velocity_field.bodies]
        on_bodies = self.contact_pairs.work() + sum(body.contact_work for body in own)
        self.contact = self.contact._replace(work=self.contact.work + on_bodies)
        work = total_work([*self.work, *(body.own_work(len(self.case.support)) for body in own)])
        self.ledger.record(self.bodies, work, self.environment.collect(), self.contact, dt)

    def step(self) -> None:
        """One step. Raises RunStopped, naming the point, where the state is no longer possible."""
        dt = self.clock.next_step(self.bodies)
        self.sort()
        self.environment.begin(self.time, dt)
        self._scheme(self, dt)
        self.clock.advance(dt)
        for body in self.bodies:
            body.check(self.clock.n_steps, self.clock.time)
        self.record(dt)
        self._check_energy()
        self._check_elements()

    def run(self, recorder: Any, until: float | None = None, progress: Any = None) -> None:
        """Step until the end of the case or `until` [s]. SIGTERM and Ctrl-C write a checkpoint and raise Interrupted."""
        shown = 0.0
        with _signals() as caught:
            recorder.begin(self)
            if progress:
                progress.begin("running", self.case.time.end if until is None else until)
            try:
                while not self.clock.finished(until):
                    self.step()
                    recorder.after_step(self)
                    if caught:
                        recorder.checkpoint(self)
                        raise Interrupted(by_keyboard=caught[0] == signal.SIGINT)
                    now = wall_clock.monotonic()
                    if progress and now - shown > PROGRESS_INTERVAL:
                        shown = now
                        self._show(progress)
                recorder.end(self)
            except RunStopped as error:
                recorder.failed(self, error)
                raise

    def _show(self, progress: Any) -> None:
        points = sum(body.n_points for body in self.bodies)
        error = self.ledger.energy_error()
        progress.update(step=self.n_steps, time=self.time, dt=self.dt, points=points, energy_error=error)

    def _check_energy(self) -> None:
        error = abs(self.ledger.energy_error())
        if self.n_steps < SETTLED or error < self.case.energy.warn:
            return
        books = self.ledger.sums
        causes = f"transfer {books['transfer']:.3g} J, time integration {books['time_integration']:.3g} J"
        text = f"step {self.n_steps}, time {self.time:.6g} s: the energy error is {100 * error:.2g} % ({causes})"
        if error >= self.case.energy.stop:
            raise RunStopped(
                f"{text}, above energy.stop = {100 * self.case.energy.stop:g} %; use a smaller step, a finer grid, or raise "
                f"energy.stop if the loss is meant"
            )
        self._warn("energy", f"{text}, above energy.warn = {100 * self.case.energy.warn:g} %")

    def _check_elements(self) -> None:
        if not self.touching or self.n_steps % WATCHED or "elements" in self._warned:
            return
        for body, nodes in self.contact_pairs.touching():
            text = overlong(body, nodes) if isinstance(body, ElementBody) else None
            if text is not None:
                return self._warn("elements", f"step {self.n_steps}, time {self.time:.6g} s: {text}")

    def _warn(self, what: str, text: str) -> None:
        """Warn of this once in a run."""
        if what not in self._warned:
            self._warned.add(what)
            warnings.warn(text, stacklevel=3)

    # what others ask

    @property
    def grid(self) -> Grid:
        """The grid of the first velocity field, which in most cases is the only one."""
        return self.velocity_fields[0].grid

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time

    @property
    def n_steps(self) -> int:
        """Steps done."""
        return self.clock.n_steps

    @property
    def dt(self) -> float:
        """Length of the last step [s]."""
        return self.clock.dt

    def energies(self) -> dict[str, float]:
        """The energy ledger [J]."""
        return self.ledger.energies(self.bodies)

    def momentum(self) -> np.ndarray:
        """Total momentum [kg m/s], shape (3,)."""
        return np.asarray(sum(body.momentum() for body in self.bodies))

    def reactions(self) -> dict[str, np.ndarray]:
        """Impulses so far of the supports and motions that have a name, on what they hold [N s], shape (3,)."""
        return self.ledger.reactions(self._support_names)

    def conservation(self) -> dict[str, float]:
        """Relative errors of mass, momentum and energy."""
        return self.ledger.conservation(self.bodies)

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Every array that the next step depends on."""
        arrays: dict[str, np.ndarray] = {}
        for body in self.bodies:
            arrays |= {f"{body.name}/{name}": array for name, array in body.arrays.items()}
            arrays |= {f"{body.name}/elements/{name}": array for name, array in body.element_arrays.items()}
            for name in ("first", "layer", "left_slab"):
                arrays[f"{body.name}/slabs/{name}"] = getattr(body.slabs, name)
        return arrays

    def state_numbers(self) -> dict[str, Any]:
        """Every number that the next step depends on, for JSON."""
        return {
            "clock": self.clock.state_numbers(),
            "ledger": self.ledger.state_numbers(),
            "bodies": {body.name: body.sums for body in self.bodies},
            "warned": sorted(self._warned),
        }

    def restore(self, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
        """Go on from a checkpoint, bit for bit."""
        for body in self.bodies:
            for name in body.arrays:
                body.arrays[name] = np.ascontiguousarray(arrays[f"{body.name}/{name}"])
            for name in body.element_arrays:
                body.element_arrays[name] = np.ascontiguousarray(arrays[f"{body.name}/elements/{name}"])
            body.bind()
            body.restore_slabs(*(arrays[f"{body.name}/slabs/{name}"] for name in ("first", "layer", "left_slab")))
            body.sums = dict(numbers["bodies"][body.name])
        self.clock.restore(numbers["clock"])
        self.ledger.restore(numbers["ledger"])
        self._warned = set(numbers["warned"])

    def _time_verbs(self) -> None:
        parts = {"sort": "sort", "meet": "contact", "advance": "grid", "project": "grid", "record": "reductions"}
        for verb, part in parts.items():
            setattr(self, verb, self._timed(part, getattr(self, verb)))
        for verb in ("clear_inertia", "clear_momentum", "clear_force"):
            setattr(self.velocity_fields, verb, self._timed("grid", getattr(self.velocity_fields, verb)))
        body_parts = {
            "particle_to_grid": "scatter",
            "update_velocities": "velocities",
            "update_stress": "gradients and law",
            "move": "move",
        }
        for body in self.bodies:
            for verb, part in body_parts.items():
                setattr(body, verb, self._timed(part, getattr(body, verb)))

    def _timed(self, part: str, verb: Callable[..., None]) -> Callable[..., None]:
        def timed(*arguments: Any, **named: Any) -> None:
            start = wall_clock.perf_counter()
            verb(*arguments, **named)
            self.timers[part] = self.timers.get(part, 0.0) + wall_clock.perf_counter() - start

        return timed


@contextmanager
def _signals() -> Iterator[list[int]]:
    """Collect SIGTERM and SIGINT instead of dying in the middle of a step; only the main thread can."""
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught
        return
    numbers = (signal.SIGTERM, signal.SIGINT)
    previous = {number: signal.signal(number, lambda n, _: caught.append(n)) for number in numbers}
    try:
        yield caught
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
