"""The balance of mass, momentum and energy: one table of works from the kernels to `history.csv`, and one place that sums it.

Every kernel that does work on behalf of a cause adds it to the column of that cause in a row of works [J]. A row begins with
the columns of the nodes' own kernels; those behind them belong to the conditions of the run, see `WorkLayout`.
"""

from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from typing import NamedTuple, Protocol

import numpy as np

INTERNAL, GRAVITY, SUPPORT, MOTION, CONTACT, ABSORBED, IMPACT, DAMPING, VISCOUS, FIRST_LOAD = range(10)
"""Columns of a row of works that kernels of nodes and bodies fill; INTERNAL is the work of internal forces, which exchanges
kinetic and stored energy. From FIRST_LOAD on come those of the channels of external forces."""


class Channel(NamedTuple):
    """External work or loss: its name in `history.csv`, which ends in `_work`, `_heat` or `_energy`, and its sign."""

    name: str
    sign: float = 1.0
    """-1 where it counts energy that leaves."""


GRAVITY_WORK, SUPPORT_WORK, MOTION_WORK, CONTACT_WORK = map(
    Channel, ("gravity_work", "support_work", "motion_work", "contact_work")
)
ABSORBED_ENERGY, IMPACT_HEAT, DAMPING_HEAT, VISCOUS_HEAT = (
    Channel(name, -1.0) for name in ("absorbed_energy", "impact_heat", "damping_heat", "viscous_heat")
)
FIXED_COLUMNS: Mapping[Channel, int] = {
    GRAVITY_WORK: GRAVITY,
    SUPPORT_WORK: SUPPORT,
    MOTION_WORK: MOTION,
    CONTACT_WORK: CONTACT,
    ABSORBED_ENERGY: ABSORBED,
    IMPACT_HEAT: IMPACT,
    DAMPING_HEAT: DAMPING,
    VISCOUS_HEAT: VISCOUS,
}
"""Of the channels that kernels of nodes and bodies fill."""
ALWAYS: Mapping[Channel, int] = {channel: FIXED_COLUMNS[channel] for channel in (GRAVITY_WORK, SUPPORT_WORK)}
"""The channels that every history shows."""


class WorkLayout:
    """Which column of a row of works each channel of a run has, and how many supports have impulses.

    loads: the channels of external forces, each with an array at the nodes and the columns from FIRST_LOAD on; others: those of
    work that conditions or kernels count. channels: those of both that the history shows, in its order, with their columns.
    Raises ValueError where two channels have one name.
    """

    def __init__(self, loads: Iterable[Channel] = (), others: Iterable[Channel] = (), n_supports: int = 0) -> None:
        loads, others = dict.fromkeys(loads), dict.fromkeys(others)
        own = [*loads, *(channel for channel in others if channel not in FIXED_COLUMNS and channel not in loads)]
        names = [channel.name for channel in (*FIXED_COLUMNS, *own)]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"two channels of the energy balance have the name {repeated[0]}")
        self.n_loads, self.n_columns, self.n_supports = len(loads), FIRST_LOAD + len(own), n_supports
        columns = {channel: FIRST_LOAD + number for number, channel in enumerate(own)}
        fixed = {channel: column for channel, column in FIXED_COLUMNS.items() if channel in others}
        self.channels: Mapping[Channel, int] = {**ALWAYS, **columns, **fixed}

    def column(self, channel: Channel) -> int:
        """The column of a channel of this run."""
        return self.channels[channel]

    def no_work(self) -> "StepWork":
        """No work, in a row with all columns."""
        return no_work(self.n_columns, self.n_supports)


class StepWork(NamedTuple):
    """Work and impulses of a step."""

    works: np.ndarray  # (columns,) [J]; a row may leave out its last columns, in which nothing was done
    gravity_mass: float  # of the nodes on which gravity acts [kg]
    reactions: np.ndarray  # (supports + 1, 3) impulses of the supports, in the last row those across thin axes [N s]
    impulse: np.ndarray  # (3,) of all other external actions [N s]
    motions: Mapping[str, np.ndarray]  # impulses of prescribed motions by name, shape (3,) [N s]


def no_work(columns: int, n_supports: int) -> StepWork:
    """No work, in a row with so many columns."""
    return StepWork(np.zeros(columns), 0.0, np.zeros((n_supports + 1, 3)), np.zeros(3), {})


def row_length(columns: int, n_impulses: int) -> int:
    """Length of what a kernel sums: the columns of works, the mass on which gravity acts, impulses of three components."""
    return columns + 1 + 3 * n_impulses


def step_work(sums: np.ndarray, columns: int) -> StepWork:
    """Sums of such rows, with the impulses of the supports and thin axes first and that of loads and absorbing faces last."""
    impulses = sums[columns + 1 :].reshape(-1, 3)
    return StepWork(sums[:columns], float(sums[columns]), impulses[:-1], impulses[-1], {})


def total_work(parts: Sequence[StepWork], columns: int) -> StepWork:
    """The sum over several parts, added in their order, in a row with so many columns."""
    gravity_mass, reactions, impulse = parts[0].gravity_mass, parts[0].reactions, parts[0].impulse
    works = np.zeros(columns)
    works[: len(parts[0].works)] = parts[0].works
    motions: dict[str, np.ndarray] = {}
    for part in parts[1:]:
        works[: len(part.works)] += part.works
        gravity_mass = gravity_mass + part.gravity_mass
        reactions, impulse = reactions + part.reactions, impulse + part.impulse
    for part in parts:
        for name, given in part.motions.items():
            motions[name] = motions[name] + given if name in motions else given
    return StepWork(works, gravity_mass, reactions, impulse, motions)


class Totals:
    """Sums over a body: its state as a whole, renewed in each step.

    kinetic [J]; momentum, shape (3,), and momentum_size, Σ m|v| [kg m/s]; stored: internal or strain energy in all, and of it
    those `parts` that have an entry of their own [J]; heating: power of the artificial viscosity [W]; rate: the reciprocal of
    the largest stable step [1/s].
    """

    def __init__(self) -> None:
        self.kinetic = self.stored = self.heating = self.rate = self.momentum_size = 0.0
        self.momentum = np.zeros(3)
        self.parts: dict[str, float] = {}

    def to_data(self) -> dict[str, object]:
        """What a checkpoint keeps."""
        return {**vars(self), "momentum": self.momentum.tolist(), "parts": dict(self.parts)}

    def restore(self, data: Mapping[str, object]) -> None:
        """Go on from a checkpoint."""
        vars(self).update({**data, "momentum": np.array(data["momentum"])})


class Balanced(Protocol):
    """What the balance reads of a body: its totals, its mass [kg], and whether it stores "internal" or "strain" energy."""

    totals: Totals

    @property
    def mass(self) -> float: ...

    @property
    def energy_kind(self) -> str: ...


class EnergyBudget:
    """Energies and momentum after each step, against external work and losses, the `channels` of the run with their columns.

    The error of the energy has two causes that are kept apart: `transfer`, kinetic energy lost or won when velocities go
    between points and grid (walls included), and `time_integration`, the work of internal forces on the grid that the
    points' stored energy does not show. Both are of the method and vanish under refinement.
    """

    def __init__(
        self, bodies: Sequence[Balanced], gravity: tuple[float, float, float], channels: Mapping[Channel, int] = ALWAYS
    ) -> None:
        self.gravity = np.array(gravity)
        self.channels = channels
        self.kinetic, self.stored = self._energies(bodies)
        self.initial = {"kinetic": self.kinetic, "stored": self.stored, "mass": self._mass(bodies)}
        self.initial_momentum = self._momentum(bodies)
        self.impulse = np.zeros(3)
        self.sums = {channel.name: 0.0 for channel in self.channels}
        self.transfer = self.time_integration = self.artificial_heat = 0.0
        self.support_impulses: list[list[float]] = []
        self.named_impulses: dict[str, list[float]] = {}
        self.energy_scale = self.kinetic
        self.momentum_scale = sum(body.totals.momentum_size for body in bodies)

    def record(
        self,
        bodies: Sequence[Balanced],
        done: StepWork,
        contact_impulses: Mapping[str, np.ndarray],
        dt: float,
        weight: float = 1.0,
    ) -> None:
        """Add a step: the bodies at its end, its work, and the impulses of named contacts, (3,) each [N s].

        weight: what its impulses count in the reactions, where the time of the loads is not that of the steps.
        """
        kinetic, stored = self._energies(bodies)
        internal, external = float(done.works[INTERNAL]), 0.0
        for channel, column in self.channels.items():
            amount = float(done.works[column])
            self.sums[channel.name] += amount
            external += channel.sign * amount
        self.transfer += kinetic - self.kinetic - (internal + external)
        self.time_integration += stored - self.stored + internal
        self.artificial_heat += dt * sum(body.totals.heating for body in bodies)
        self.kinetic, self.stored = kinetic, stored
        self._record_impulses(done, contact_impulses, dt, weight)
        exchanged = abs(stored - self.initial["stored"]) + sum(abs(amount) for amount in self.sums.values())
        self.energy_scale = max(self.energy_scale, kinetic + exchanged)
        size = sum(body.totals.momentum_size for body in bodies)
        self.momentum_scale = max(self.momentum_scale, size, float(np.abs(self.impulse).max()))

    def _record_impulses(self, done: StepWork, contacts: Mapping[str, np.ndarray], dt: float, weight: float) -> None:
        self.impulse += done.reactions.sum(axis=0) + dt * done.gravity_mass * self.gravity + done.impulse
        so_far = self.support_impulses or [[0.0, 0.0, 0.0]] * len(done.reactions)
        self.support_impulses = (np.array(so_far) + weight * done.reactions).tolist()
        for name, impulse in done.motions.items():
            self.impulse += impulse
            self._add_named(name, weight * impulse)
        for name, impulse in contacts.items():
            self._add_named(name, weight * impulse)

    def _add_named(self, name: str, impulse: np.ndarray) -> None:
        self.named_impulses[name] = (np.array(self.named_impulses.get(name, (0.0, 0.0, 0.0))) + impulse).tolist()

    def reactions(self, support_names: Sequence[str | None]) -> dict[str, np.ndarray]:
        """Impulses so far [N s], shape (3,), of motions, and of the supports and contacts that have a name.

        Those of supports of one name add up.
        """
        result = {name: np.array(impulse) for name, impulse in self.named_impulses.items()}
        for name, impulse in zip(support_names, self.support_impulses, strict=False):
            if name is not None:
                result[name] = result.get(name, np.zeros(3)) + np.array(impulse)
        return result

    def energies(self, bodies: Sequence[Balanced]) -> dict[str, float]:
        """The balance [J]: kinetic, internal and strain energy, with parts of the latter that have entries of their own (work
        against hourglass modes, energy that damage took); the work of each channel; heat of the artificial viscosity,
        which is part of the internal energy; the two errors of the method."""
        stored = {"internal": 0.0, "strain": 0.0}
        for body in bodies:
            stored[body.energy_kind] += body.totals.stored
            for name, part in body.totals.parts.items():
                stored[body.energy_kind] -= part
                stored[name] = stored.get(name, 0.0) + part
        return {
            "kinetic": self.kinetic,
            **stored,
            **self.sums,
            "artificial_heat": self.artificial_heat,
            "transfer_error": self.transfer,
            "time_integration_error": self.time_integration,
        }

    def energy_error(self) -> float:
        """Energy that no channel explains, relative to the largest energy that moved so far."""
        change = self.kinetic - self.initial["kinetic"] + self.stored - self.initial["stored"]
        error = change - sum(channel.sign * self.sums[channel.name] for channel in self.channels)
        return float(error / self.energy_scale) if self.energy_scale > 0.0 else 0.0

    def conservation(self, bodies: Sequence[Balanced]) -> dict[str, float]:
        """Relative errors of mass, momentum (by Σ m|v|) and energy."""
        lost = np.abs(self._momentum(bodies) - self.initial_momentum - self.impulse).max()
        return {
            "mass": abs(self._mass(bodies) - self.initial["mass"]) / self.initial["mass"],
            "momentum": float(lost / self.momentum_scale) if self.momentum_scale > 0.0 else 0.0,
            "energy": self.energy_error(),
        }

    def state_numbers(self) -> dict[str, object]:
        """What a checkpoint keeps."""
        arrays = {"initial_momentum": self.initial_momentum.tolist(), "impulse": self.impulse.tolist()}
        return deepcopy({name: value for name, value in vars(self).items() if name not in ("gravity", "channels")} | arrays)

    def restore(self, numbers: Mapping[str, object]) -> None:
        """Go on from a checkpoint."""
        arrays = {name: np.array(numbers[name]) for name in ("initial_momentum", "impulse")}
        vars(self).update({**deepcopy(dict(numbers)), **arrays})

    @staticmethod
    def _energies(bodies: Sequence[Balanced]) -> tuple[float, float]:
        return sum(body.totals.kinetic for body in bodies), sum(body.totals.stored for body in bodies)

    @staticmethod
    def _momentum(bodies: Sequence[Balanced]) -> np.ndarray:
        return np.asarray(sum(body.totals.momentum for body in bodies))

    @staticmethod
    def _mass(bodies: Sequence[Balanced]) -> float:
        return float(sum(body.mass for body in bodies))
