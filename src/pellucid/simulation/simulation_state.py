"""The state of a simulation: bodies, clock, parts of the step and balances, as results read them, and checkpoints."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.touch import OverlappingStart
from pellucid.energy import INFLOW_ENERGY, OUTFLOW_ENERGY, AngularBalance, EnergyBudget, WorkLayout, energy_at_stake
from pellucid.errors import UsageError
from pellucid.findings import Named
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.ranks.domain import NOWHERE, domain
from pellucid.simulation.clock import Clock
from pellucid.simulation.settling import SETTLING, SettlingClock
from pellucid.simulation.threads import ThreadChoice
from pellucid.simulation.watch import Watch, free_axes
from pellucid.state import of_owner, with_owner
from pellucid.step.part import StepParts

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.case.stages import SettleCase

CLOCK = "-clock"  # owner of the clock's arrays in a checkpoint; no body can have this name
PARTS = "-parts"  # owner of the arrays of the parts of a step in a checkpoint
NODES = "-nodes."  # owner of the nodal arrays of a velocity field in a checkpoint, followed by its name


class SimulationState:
    """State of a simulation, see `pellucid.Simulation`: values that results read, balances and checkpoints."""

    case: "Case"
    bodies: list[Body]
    """Bodies in the order of the case."""
    velocity_fields: Sequence[VelocityField]
    parts: StepParts
    """Everything that acts in a step besides bodies and grid: conditions, contact, pressures of full cells and others."""
    clock: Clock
    budget: EnergyBudget
    _layout: WorkLayout
    _threads: ThreadChoice
    _watch: Watch
    _turning: AngularBalance | None
    _begun: bool
    _settled: dict[str, Any]

    def begin_balance(self) -> None:
        """Start the balances of mass, momentum and energy with the present state as reference."""
        speeds = [0.0 if model.is_rigid else model.waves_at_start()[0] for model in self.case.body]
        at_stake = energy_at_stake(self.bodies, self.case.gravity, speeds) + self.parts.at_stake()
        self.budget = EnergyBudget(self.bodies, self.case.gravity, self._layout.channels, at_stake)
        self.parts.run("begin_balance")
        turns = free_axes(self.case)
        self._turning = AngularBalance(self.bodies, turns) if turns else None
        self._balanced_step = self.n_steps

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
        return Named("this simulation has no reaction of", self.budget.reactions())

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
    def contact_pairs(self) -> ContactPairs:
        """The part of the step that computes contact on the nodes of the grid."""
        return self.parts.of(ContactPairs)[0]

    @property
    def surface_pairs(self) -> SurfacePairs:
        """The part of the step that computes contact by surfaces."""
        return self.parts.of(SurfacePairs)[0]

    @property
    def node_contacts(self) -> Sequence[str]:
        """Messages about solids and membranes that are in contact on the nodes of the grid, and the reasons."""
        return self.contact_pairs.reasons

    @property
    def start_overlaps(self) -> Sequence[OverlappingStart]:
        """Bodies that start closer to each other than the contact distance."""
        return self.surface_pairs.start_overlaps

    @property
    def condition_states(self) -> Mapping[str, float]:
        """Values that conditions write to the history, such as the pressure of an enclosed gas, by column name."""
        return self.parts.columns()

    def facts(self) -> dict[str, Any]:
        """Return entries for the summary of the run, by name: clock (such as steps of a steady analysis), settling, inflow
        and outflow, and parts of the step, as far as the case has them."""
        momenta = {"inflow": self.budget.entered_momentum, "outflow": self.budget.left_momentum}
        passed = {
            name: {**counts, "momentum": momenta[name].tolist()}
            for name, counts in (("inflow", self.inflow), ("outflow", self.outflow))
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
        spread = (body for body in self.bodies if isinstance(body, PointsOnGrid) and body.shared.is_spread)
        return [name for body in spread for name in with_owner(body.name, body.arrays)]

    def state_numbers(self) -> dict[str, Any]:
        """Return every number that affects the next step, in a form that JSON can store."""
        return {
            "clock": self.clock.state_numbers(),
            "balance": self.budget.state_numbers(),
            "angular_momentum": self._turning.state_numbers() if self._turning is not None else {},
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
        for body in self.bodies:
            body.restore(of_owner(body.name, arrays))
            body.totals.restore(numbers["bodies"][body.name])
        self.parts.restore(numbers["parts"], of_owner(PARTS, arrays))
        for field in self.velocity_fields:
            field.restore(of_owner(NODES + field.name, arrays))
        settles = SETTLING in numbers["clock"]
        if settles and self.case.settle is not None:
            self.clock = self.settling_clock(self.case.settle)
        self.clock.restore(numbers["clock"], of_owner(CLOCK, arrays))
        self.budget.restore(numbers["balance"])
        if self._turning is not None:
            self._turning.restore(numbers["angular_momentum"])
        self._watch.warned = set(numbers["warned"])
        self._begun, self._settled = not settles, dict(numbers["settled"])
        self._balanced_step = self.n_steps

    def settling_clock(self, settle: "SettleCase") -> SettlingClock:
        """Return a clock for settling, which counts steps while the time of the loads stays at 0; settle: the table
        [settle]."""
        return SettlingClock(settle, self.clock, self.case.body)
