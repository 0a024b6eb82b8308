"""Parts of a step: the interface of everything that acts in a step besides bodies and grid, e.g. a load, a support, contact or
the pressure of full cells, and the collection of the parts of a simulation."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from pellucid.energy import Passed, StepWork, Totals
from pellucid.state import Field, declare_field, of_owner, with_owner
from pellucid.step.limit import NO_LIMIT, Cause, StepLimit, tightest

WARNING_INTERVAL = 100  # steps between checks of the state of bodies and parts that may cause warnings


class AddedStiffness(NamedTuple):
    """Stiffness that a force of a part adds to the stiffness of bodies: the bodies oscillate faster than by themselves."""

    totals: Sequence[Totals]  # of the bodies
    rate: float  # inverse of the largest stable step if the bodies had no other stiffness [1/s]
    cause: Cause  # word for messages, see `StepLimit`
    reason: str  # what oscillates, as a sentence without the step


class StepPart:
    """A part of a step: base class whose methods are called at the stages of a step. A part defines the methods of those
    stages at which it acts.

    The state of a part is stored in arrays of a body, which checkpoints include, or in its own `state_numbers` and
    `state_arrays`. Arrays of a body are sorted with its points and move with them between processes.
    """

    point_fields: ClassVar[Mapping[str, Field]] = {}
    """Arrays that the part adds to the arrays of bodies, by name. A `Field` states their unit and meaning, whether results show
    them, and what happens to the value of a point that leaves the grid or continues from results without it."""

    def __init_subclass__(cls, **more: Any) -> None:
        """Declare the point arrays of a new class of parts. Raises TypeError if another field has one of these names."""
        super().__init_subclass__(**more)
        for name, field in cls.point_fields.items():
            declare_field(name, field, cls.__name__)

    # before the first step

    def try_out(self) -> None:
        """Raise CaseError if the part cannot act in this case. Called when all bodies are complete, before output is
        written."""

    def at_stake(self) -> float:
        """Return the energy that the part stores at the start and could release [J]. This energy is added to the reference
        with which the error of the energy balance is compared."""
        return 0.0

    def begin_balance(self) -> None:
        """Set the energies that the part sums over the steps to zero. Called when the energy balance of the run starts: before
        the first step, and again after settling."""

    # stages of a step, in the order of `STAGES`, which also lists the differences between the schemes

    def begin(self, time: float, dt: float) -> None:
        """Set forces or prescribed velocities for the step that begins at `time` [s].

        dt: increment of the time of the loads in this step [s]; 0 while bodies settle or are relaxed.
        """

    def exert_forces(self, dt: float) -> None:
        """Apply forces over the step dt [s] to the bodies that depend on the prescribed velocities of other parts."""

    def clear_nodes(self) -> None:
        """Reset the nodal arrays of the part to zero, before points are mapped to the nodes."""

    def before_forces(self) -> None:
        """Add forces to the nodes, before internal forces of the points are mapped to them."""

    def find_contact(self) -> None:
        """Find nodes that are in contact, after the mass of all bodies is mapped to the nodes."""

    def before_momentum(self, dt: float) -> None:
        """Add forces to the nodes over the step dt [s], after all other forces are mapped and before the momentum update."""

    def act_on_nodes(self, dt: float) -> None:
        """Apply impulses to the grid nodes, after their momentum was advanced by a step dt [s] and before contact.

        Use `VelocityField.add_impulses`, which also computes the work of the impulses.
        """

    pushed_fields: Sequence[object] | None = None
    """Velocity fields to which `act_on_nodes` may apply impulses; None for all. The works on the nodes of all other fields
    are computed in the loop that advances the momentum, which saves a loop over the nodes."""

    def stop_approach(self) -> None:
        """Apply impulses of contact to the grid nodes, after all other impulses."""

    def after_momentum(self) -> None:
        """Use the mean velocities of the nodes over the step, after all impulses."""

    def correct_strain_velocities(self, dt: float | None) -> None:
        """Correct the nodal velocities whose gradients strain the points, if they differ from those of the momentum update,
        i.e. with MUSL and USF. dt: step [s] if these velocities result from momentum that was mapped again at the end of the
        step (MUSL); None at the start of a step (USF)."""

    def before_stress(self, dt: float) -> None:
        """Use the sums over the points after the update of their velocities, before stresses are updated over the step dt
        [s]."""

    def check(self, n_steps: int, time: float) -> None:
        """Raise RunStopped if the part found an invalid state in step `n_steps`, which ended at `time` [s]."""

    def end(self, dt: float) -> None:
        """Update the state of the part after the bodies have completed the step dt [s] and computed their totals (sums of
        mass, momentum and energies).

        The part also adds to the totals what the bodies cannot compute: half the power of a force that stores energy.
        """

    def balance(self, done: StepWork) -> None:
        """Read or move works of the whole step, `done`, between entries of the energy balance, before they are recorded."""

    def leave(self) -> Sequence[Passed]:
        """Remove points from bodies after the energy balance of the step; return their number, mass, momentum and energy."""
        return ()

    def enter(self, n_steps: int, time: float) -> Sequence[Passed]:
        """Insert points into bodies after the energy balance of step `n_steps`, which ended at `time` [s]; return their number,
        mass, momentum and energy.

        The totals of the bodies already include these points.
        """
        return ()

    # results of the step

    def work(self) -> StepWork | None:
        """Return the works [J] and the impulse [N s] of the part over the step as a `StepWork`; None if the nodes or bodies
        on which the part acts compute these values."""
        return None

    def impulses(self) -> Mapping[str, np.ndarray]:
        """Return the impulses of the part over the step [N s], shape (3,) each, by the names under which probes read these
        impulses; empty if the nodes and bodies on which the part acts report them by name."""
        return {}

    def step_limit(self) -> StepLimit:
        """Return the limit of the stable time step that the part sets in the present state, with its reason; NO_LIMIT if
        there is none.

        Called before each step. The stable step is the smallest limit of the bodies and parts, and a step takes the fraction
        `time.courant` of it; a larger `time.step` is an error. All processes must return the same limit, and a resumed run
        the limit of the checkpoint. For a force that adds to the stiffness of a body, see `added_stiffness`.
        """
        return NO_LIMIT

    def longest_step(self) -> float:
        """Return the longest step [s] with which the part resolves the motion in time, if the clock chooses the step; infinite
        if the part does not limit it. A fixed `time.step` may be longer, up to `step_limit`."""
        return inf

    def added_stiffness(self) -> AddedStiffness | None:
        """Return the stiffness that a force of the part adds to that of bodies in the present state; None if there is none.

        Called after `try_out` and after `end`. The rates of the bodies, `Totals.rate`, then become the root of the sum of the
        squares of both rates. The part limits the time step if its rate exceeds those of the bodies.
        """
        return None

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return the warnings of the part about the last step, as texts for the user by topic; a run issues one warning of each
        topic. Called every WARNING_INTERVAL steps and after the last step.

        energy_scale: energy that the bodies have exchanged so far [J], with which errors of the energies of the part are
        compared; infinite in the first steps of a run, in which too little energy has been exchanged.
        """
        return {}

    def columns(self) -> Mapping[str, float]:
        """Return the current values of the columns that the part adds to the history (the table of values over time), by the
        names of `Condition.columns`, in SI units."""
        return {}

    def facts(self) -> Mapping[str, Any]:
        """Return entries of the part for the summary of the run, by name. Tables of the same name from several parts are
        joined."""
        return {}

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of the part for a checkpoint, by name."""
        return {}

    def state_numbers(self) -> dict[str, Any]:
        """Return the state of the part for a checkpoint, as JSON data."""
        return {}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Restore the state of the part from numbers of `state_numbers`, bit for bit."""

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the state of the part from arrays of `state_arrays`, bit for bit."""


STAGES = (
    "begin",
    "exert_forces",
    "clear_nodes",
    "before_forces",
    "find_contact",
    "before_momentum",
    "act_on_nodes",
    "stop_approach",
    "after_momentum",
    "correct_strain_velocities",
    "before_stress",
    "check",
    "end",
    "balance",
    "leave",
    "enter",
)
"""Stages of a step in the order of the scheme MUSL, as methods of `StepPart`. USL does not call `correct_strain_velocities`:
there the velocities of the momentum update strain the points. USF updates the stresses first, in the order `begin`,
`clear_nodes`, `exert_forces`, `find_contact`, `correct_strain_velocities`, `before_forces` and `before_momentum`; the others
follow as with MUSL."""


class AtEachStep(StepPart):
    """A part that calls a function of the time [s] at the beginning of each step."""

    def __init__(self, act: Callable[[float], object]) -> None:
        self._act = act

    def begin(self, time: float, dt: float) -> None:
        self._act(time)


Kind = TypeVar("Kind", bound=StepPart)


class StepParts:
    """The parts of the steps of a simulation, in the order in which they act within a stage."""

    def __init__(self, parts: Iterable[StepPart] = ()) -> None:
        self._all = list[StepPart]()
        self._at = dict[str, list[Any]]()
        self._governing = list[AddedStiffness]()
        self.add(parts)

    def add(self, parts: Iterable[StepPart], first: bool = False) -> None:
        """Add parts, which act after those added before, or before these if `first`."""
        self._all = [*parts, *self._all] if first else [*self._all, *parts]
        self._at.clear()

    def of(self, kind: type[Kind]) -> list[Kind]:
        """Return the parts of a class."""
        return [part for part in self._all if isinstance(part, kind)]

    def only(self, kind: type[Kind]) -> Kind:
        """Return the part of a class of which there is one, such as `SurfacePairs`. Raises ValueError otherwise."""
        (part,) = self.of(kind)
        return part

    def at(self, stage: str) -> Sequence[Any]:
        """Return the parts that define a method of `StepPart`, such as a stage."""
        if stage not in self._at:
            base = getattr(StepPart, stage)
            self._at[stage] = [part for part in self._all if getattr(type(part), stage) is not base]
        return self._at[stage]

    def run(self, stage: str, *arguments: Any) -> None:
        """Call the method of a stage of all parts that act at this stage."""
        for part in self.at(stage):
            getattr(part, stage)(*arguments)

    def try_out(self) -> None:
        """Raise CaseError if a part cannot act in this case, and add the stiffnesses of the parts to those of the bodies."""
        self._governing.clear()
        for part in self._all:
            part.try_out()
            self._stiffen(part)

    def end(self, dt: float) -> None:
        """Let the parts complete a step dt [s], and add their stiffnesses to those of the bodies."""
        self.run("end", dt)
        self._governing.clear()
        for part in self.at("added_stiffness"):
            self._stiffen(part)

    def _stiffen(self, part: StepPart) -> None:
        """Add the stiffness of a part to those of bodies; note it if it exceeds them and thus governs the step."""
        if (added := part.added_stiffness()) is None:
            return
        if all(added.rate > totals.rate for totals in added.totals):
            self._governing.append(added)
        for totals in added.totals:
            totals.rate = float(np.hypot(totals.rate, added.rate))

    def leave(self) -> Iterator[Passed]:
        """Let each part remove points from bodies; yield a record for each removal, see `StepPart.leave`."""
        for part in self.at("leave"):
            yield from part.leave()

    def enter(self, n_steps: int, time: float) -> Iterator[Passed]:
        """Let each part insert points into bodies; yield a record for each insertion, see `StepPart.enter`."""
        for part in self.at("enter"):
            yield from part.enter(n_steps, time)

    def works(self) -> list[StepWork]:
        """Return the works and impulses of the parts over the step; parts whose work nodes or bodies compute are left out."""
        return [work for part in self.at("work") if (work := part.work()) is not None]

    def step_limit(self) -> StepLimit:
        """Return the smallest limit of the time step that a part sets, by itself or by the stiffness that it adds to bodies,
        with its reason; `NO_LIMIT` if there is none."""
        limits = [part.step_limit() for part in self.at("step_limit")]
        for added in self._governing:
            step = 1.0 / added.totals[0].rate
            limits.append(StepLimit(step, added.cause, f"{added.reason}, which limits the step to {step:.3g} s"))
        return tightest(limits)

    def longest_step(self) -> float:
        """Return the smallest of the steps with which the parts resolve the motion in time [s], infinite without."""
        return min((part.longest_step() for part in self.at("longest_step")), default=inf)

    def at_stake(self) -> float:
        """Return the energy that the parts store at the start and could release [J]."""
        return float(sum(part.at_stake() for part in self.at("at_stake")))

    def warnings(self, energy_scale: float) -> dict[str, str]:
        """Return the warnings of all parts about the last step by topic and part; energy_scale: see `StepPart.warnings`."""
        found = dict[str, str]()
        for number, part in enumerate(self._all):
            found |= {f"part {number}: {topic}": text for topic, text in part.warnings(energy_scale).items()}
        return found

    def impulses(self) -> dict[str, np.ndarray]:
        """Return the named impulses of the parts over the step [N s], shape (3,), summed by name."""
        total: dict[str, np.ndarray] = {}
        for part in self.at("impulses"):
            for name, impulse in part.impulses().items():
                total[name] = total[name] + impulse if name in total else impulse
        return total

    def columns(self) -> dict[str, float]:
        """Return the values that the parts write to the history in SI units, by the name of the column."""
        return {name: value for part in self.at("columns") for name, value in part.columns().items()}

    def facts(self) -> dict[str, Any]:
        """Return the entries of the parts for the summary of the run, by name."""
        found: dict[str, Any] = {}
        for part in self.at("facts"):
            for name, entry in part.facts().items():
                found[name] = {**found[name], **entry} if isinstance(found.get(name), dict) else entry
        return found

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of all parts for a checkpoint, by name."""
        owned = (with_owner(str(i), part.state_arrays()) for i, part in enumerate(self._all))
        return {name: array for arrays in owned for name, array in arrays.items()}

    def state_numbers(self) -> list[dict[str, Any]]:
        """Return the state of each part for a checkpoint, as values by name."""
        return [dict(part.state_numbers()) for part in self._all]

    def restore(self, numbers: Sequence[Mapping[str, Any]], arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the states of the parts from the results of `state_numbers` and `state_arrays`."""
        for i, (part, own) in enumerate(zip(self._all, numbers, strict=True)):
            part.restore(own)
            part.restore_arrays(of_owner(str(i), arrays))
