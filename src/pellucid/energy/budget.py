"""Balance of mass, momentum and energy of a run, computed from the totals of the bodies and the work of the steps, balance of
the angular momentum of bodies without external forces, and the energy at stake at the start of a run, which its bodies
could release."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from pellucid.energy.works import (
    ALWAYS,
    INFLOW_ENERGY,
    INTERNAL,
    ONLY_TAKE,
    OUTFLOW_ENERGY,
    Channel,
    Passed,
    StepWork,
)
from pellucid.findings import Named

GIVEN = "bodies", "gravity", "channels", "angular", "is_complete"
"""Names of the attributes of the balance that a checkpoint does not store, or stores elsewhere."""

ARRAYS = "initial_momentum", "impulse", "exchanged", "left_momentum", "entered_momentum"
"""Names of the arrays of the balance, which a checkpoint stores as lists."""

ISOLATED = 1e-9  # relative to the largest Σ m|v|: smaller sums of impulses are rounding
FIRST_JUDGED = 200  # steps after which the energy error is judged; before, too little energy may have moved to compare with


class Totals:
    """Sums over the points or nodes of a body, computed in each step.

    Attributes: kinetic [J]; momentum, shape (3,), and momentum_size, Σ m|v| [kg m/s]; affine: kinetic energy of the affine
    fields of APIC, included in `kinetic` [J]; stored: total internal or strain energy [J]; parts: components of `stored`
    that are separate entries of the balance, by name [J]; half_power: half the power of the internal forces at the end of
    the step, negative if points are strained before the momentum equation [W], see `EnergyBudget`; heating: power of the
    artificial viscosity [W]; rate: reciprocal of the largest stable step [1/s].
    """

    def __init__(self) -> None:
        self.kinetic = self.affine = self.stored = self.half_power = self.heating = self.rate = self.momentum_size = 0.0
        self.momentum = np.zeros(3)
        self.parts: dict[str, float] = {}

    def give(self, left: Passed, affine: float) -> None:
        """Subtract the momentum and energies of points that left the body. left: sums over these points. affine: part of
        their kinetic energy that belongs to the affine velocity fields of APIC [J]."""
        self.kinetic, self.affine = self.kinetic - left.kinetic, self.affine - affine
        self.stored, self.half_power = self.stored - left.stored, self.half_power - left.half_power
        self.momentum = self.momentum - left.momentum

    def take(self, entered: Passed, size: float) -> None:
        """Add the momentum and energies of points that entered the body. entered: sums over these points. size: sum Σ m|v|
        over these points [kg m/s]."""
        self.kinetic, self.stored = self.kinetic + entered.kinetic, self.stored + entered.stored
        self.momentum, self.momentum_size = self.momentum + entered.momentum, self.momentum_size + size

    def to_data(self) -> dict[str, object]:
        """Return the sums over the points of the body for a checkpoint, as JSON data."""
        return {**vars(self), "momentum": self.momentum.tolist(), "parts": dict(self.parts)}

    def restore(self, data: Mapping[str, object]) -> None:
        """Restore the sums over the points from a checkpoint; data: as returned by `to_data`."""
        vars(self).update({**data, "momentum": np.array(data["momentum"])})


class Balanced(Protocol):
    """Interface of a body for the balances: totals, mass [kg], kind of stored energy ("internal" or "strain"),
    `angular_momentum` about a point [m], shape (3,), and `stored_field`, which returns `mass` [kg], shape (n,), and `position`
    [m], shape (n, 3), of the points."""

    totals: Totals

    @property
    def mass(self) -> float: ...

    @property
    def energy_kind(self) -> str: ...
    def angular_momentum(self, about: np.ndarray) -> "AngularMomentum": ...
    def stored_field(self, name: str) -> np.ndarray: ...


class EnergyBudget:
    """Energies and momentum of the `bodies` after each step, compared with the external work and losses. The `channels` of the
    run (causes of work, see `Channel`) are given with their columns in a row of works. `turns`: axes (0 to 2) about which all
    bodies can rotate.

    Velocities and stresses of a step are half a step apart. The forces f of the new stress would change the kinetic energy in
    this half step by f·v Δt/2. This energy is exchanged with the stored energy and back. `staggering` is the sum of its
    changes, positive if the velocities are ahead of the stresses (for symplectic Euler schemes this is the modified energy:
    Hairer, Lubich & Wanner 2006, Geometric Numerical Integration, section IX.3).

    The remaining error is split by its two causes. `transfer` is the kinetic energy lost or gained in transfers of velocity
    between points and grid, except the work and heat that other entries contain. `time_integration` is the difference between
    the change of the stored energy and the work of the internal forces. Both are errors of the method and vanish under
    refinement. Their sum is compared with `energy_scale`: the largest energy that moved so far (kinetic energy plus all energy
    exchanged since the start), at least the energy `at_stake` at the start [J].
    """

    def __init__(
        self,
        bodies: Sequence[Balanced],
        gravity: tuple[float, float, float],
        channels: Mapping[Channel, int] = ALWAYS,
        at_stake: float = 0.0,
        turns: Sequence[int] = (),
    ) -> None:
        self.bodies = bodies
        self.gravity = np.array(gravity)
        self.channels = channels
        self.angular = AngularBalance(bodies, turns) if turns else None
        self.is_complete = True
        """True if the balance includes all works of the last step; False after a step in which a body stopped the run."""
        self.kinetic, self.stored, self.half_power, _, self.momentum_scale = self._sums()
        self.stored_by_kind = self._stored_by_kind()
        self.initial = {"kinetic": self.kinetic, "stored": self.stored, "mass": self._mass()}
        self.initial_momentum = self._momentum()
        self.impulse, self.exchanged = np.zeros(3), np.zeros(3)
        self.sums = {channel.name: 0.0 for channel in self.channels}
        self.staggering = self.transfer = self.time_integration = self.artificial_heat = 0.0
        self.named_impulses: dict[str, list[float]] = {}
        self.turning_impulses: dict[str, list[float]] = {}
        self.moved, self.at_stake = self.kinetic, at_stake
        self.left_points, self.left_mass, self.left_stored = 0, 0.0, 0.0
        self.entered_points, self.entered_mass, self.entered_stored = 0, 0.0, 0.0
        self.left_momentum, self.entered_momentum = np.zeros(3), np.zeros(3)

    def record(self, done: StepWork, named_impulses: Mapping[str, np.ndarray], dt: float, weight: float = 1.0) -> None:
        """Add a step to the balance, with the bodies in the state at its end.

        done: work and impulses of the step. named_impulses: impulses of named supports and contacts by name, shape (3,) each
        [N s]. dt: length of the step [s]. weight: factor on the impulses in the reactions if the time of the loads differs from
        the time of the steps.
        """
        kinetic, stored, half_power, heating, size = self._sums()
        works = done.works.tolist()
        internal, external = works[INTERNAL], 0.0
        passed = {OUTFLOW_ENERGY: self.left_stored, INFLOW_ENERGY: self.entered_stored}
        exchanged = abs(stored + self.left_stored - self.entered_stored - self.initial["stored"])
        for channel, column in self.channels.items():
            amount = works[column]
            self.sums[channel.name] = so_far = self.sums[channel.name] + amount
            external += channel.sign * amount
            internal += amount if channel.sign == 0.0 else 0.0
            # energy stored in points that leave or enter does not count as energy that moved
            if channel.sign != 0.0:
                exchanged += abs(so_far - passed.get(channel, 0.0))
        self.transfer += kinetic - self.kinetic - (internal + external)
        staggering = dt * (half_power - self.half_power)
        self.time_integration += stored - self.stored + staggering + internal
        self.artificial_heat += dt * heating
        self.kinetic, self.stored, self.half_power = kinetic, stored, half_power
        self.stored_by_kind = self._stored_by_kind()
        self.staggering += staggering
        self._record_impulses(done, named_impulses, dt, weight)
        self.moved = max(self.moved, kinetic + exchanged)
        self.momentum_scale = max(self.momentum_scale, size, float(self.exchanged.max()))
        self.is_complete = True

    def let_go(self, left: Passed, dt: float) -> None:
        """Add to the balance the mass, momentum and energy of points that left a body, which no longer has them, after a step
        was recorded. left: sums over these points. dt: length of the step [s].

        The staggering energy of the points is also removed, so that no error changes.
        """
        staggered = dt * left.half_power
        self.kinetic, self.stored, self.half_power, _, _ = self._sums()
        self.stored_by_kind = self._stored_by_kind()
        self.staggering -= staggered
        self.sums[OUTFLOW_ENERGY.name] += left.kinetic + left.stored + staggered
        self.impulse -= left.momentum
        self.exchanged += np.abs(left.momentum)
        self.left_momentum += left.momentum
        self.left_points += left.points
        self.left_mass += left.mass
        self.left_stored += left.stored

    def let_in(self, entered: Passed) -> None:
        """Add to the balance the mass, momentum and energy of points that entered a body, which already has them, after a step
        was recorded. entered: sums over these points."""
        self.kinetic, self.stored, self.half_power, _, _ = self._sums()
        self.stored_by_kind = self._stored_by_kind()
        self.sums[INFLOW_ENERGY.name] += entered.kinetic + entered.stored
        self.impulse += entered.momentum
        self.exchanged += np.abs(entered.momentum)
        self.entered_momentum += entered.momentum
        self.entered_points += entered.points
        self.entered_mass += entered.mass
        self.entered_stored += entered.stored

    def _record_impulses(self, done: StepWork, named: Mapping[str, np.ndarray], dt: float, weight: float) -> None:
        others = (dt * done.gravity_mass * self.gravity, done.impulse, *done.motions.values())
        impulses = np.concatenate((done.reactions, others))
        self.impulse += impulses.sum(axis=0)
        self.exchanged += np.abs(impulses).sum(axis=0)
        for sums, given in (
            (self.named_impulses, done.motions),
            (self.named_impulses, named),
            (self.turning_impulses, done.turning),
        ):
            for name, impulse in given.items():
                before = sums.get(name, [0.0, 0.0, 0.0])
                sums[name] = [so_far + more for so_far, more in zip(before, (weight * impulse).tolist(), strict=True)]

    @property
    def outflow(self) -> dict[str, float]:
        """Number and mass [kg] of the points that left through outflows; empty if the case has none."""
        return {"points": self.left_points, "mass": self.left_mass} if OUTFLOW_ENERGY in self.channels else {}

    @property
    def inflow(self) -> dict[str, float]:
        """Number and mass [kg] of the points that entered through inflows; empty if the case has none."""
        return {"points": self.entered_points, "mass": self.entered_mass} if INFLOW_ENERGY in self.channels else {}

    def reactions(self) -> dict[str, np.ndarray]:
        """Return the total impulses since the start on the bodies [N s], shape (3,), of motions and of named supports and
        contacts, by name."""
        reactions = {name: np.array(impulse) for name, impulse in self.named_impulses.items()}
        return Named("this simulation has no reaction of", reactions)

    def angular_reactions(self) -> dict[str, np.ndarray]:
        """Return, by the name of each prescribed motion of a rigid body, the angular impulse that it has exerted on the body
        so far, about the centre of mass of the body [N m s], shape (3,)."""
        turning = {name: np.array(impulse) for name, impulse in self.turning_impulses.items()}
        return Named("this simulation has no torque of", turning)

    def energies(self) -> dict[str, float]:
        """Return the entries of the balance at the end of the last recorded step by name [J].

        The entries are: kinetic, internal and strain energy, with separate entries for components of the strain energy (work
        against hourglass modes, energy dissipated by damage); the work or heat of each channel (cause of external work or
        loss); heat of the artificial viscosity, which is part of the internal energy; the staggering energy; the two errors of
        the method.
        """
        entries = {
            "kinetic": self.kinetic,
            **self.stored_by_kind,
            **self.sums,
            "artificial_heat": self.artificial_heat,
            "staggering": self.staggering,
            "transfer_error": self.transfer,
            "time_integration_error": self.time_integration,
        }
        return Named("the energy balance has no entry", entries)

    @property
    def energy_scale(self) -> float:
        """Reference of the energy error [J]: the largest energy that moved so far (kinetic energy plus all energy exchanged
        since the start), at least the energy that the bodies could release at the start."""
        return max(self.moved, self.at_stake)

    @property
    def made(self) -> float:
        """Energy that the bodies gained from channels that can only remove energy (contact, velocity transfer, friction)
        [J]; such a gain is an error of the method."""
        channels = (channel for channel in ONLY_TAKE if channel in self.channels)
        return sum(max(channel.sign * self.sums[channel.name], 0.0) for channel in channels)

    def energy_error(self) -> float:
        """Return the relative error of the energy balance: the change of energy that no channel (cause of external work or
        loss) explains plus `made`, divided by `energy_scale`.

        The scale is the largest energy that moved so far, but at least the strain and potential energy at the start, with an
        allowance for the rounding of the internal energy and of the energy of small strains (`energy_at_stake`).
        """
        change = self.kinetic - self.initial["kinetic"] + self.stored - self.initial["stored"] + self.staggering
        error = change - sum(channel.sign * self.sums[channel.name] for channel in self.channels)
        return float((error + self.made) / self.energy_scale) if self.energy_scale > 0.0 else 0.0

    @property
    def is_isolated(self) -> bool:
        """True if no impulse from outside has acted on the bodies so far, apart from rounding."""
        return bool(np.all(self.exchanged <= ISOLATED * self.momentum_scale))

    def lost_entries(self) -> list[str]:
        """Return the names of the entries of the balance that are not finite."""
        entries = {"kinetic": self.kinetic, "stored": self.stored, **self.sums, "staggering": self.staggering}
        return [name for name, amount in entries.items() if not isfinite(amount)]

    def conservation(self) -> dict[str, float]:
        """Return the relative errors of mass, momentum and energy by name. Momentum is included only if the impulses of the
        last step are known, and angular momentum only if no external action has affected the bodies.

        The error of momentum is relative to the larger of Σ m|v| and the sum of the magnitudes of all external impulses.
        These impulses may cancel, but their rounding errors grow with their magnitudes.
        """
        lost = np.abs(self._momentum() - self.initial_momentum - self.impulse).max()
        brought = self.initial["mass"] + self.entered_mass
        errors = {
            "mass": abs(self._mass() + self.left_mass - brought) / brought,
            "momentum": float(lost / self.momentum_scale) if self.momentum_scale > 0.0 else 0.0,
            "energy": self.energy_error(),
        }
        if not self.is_complete:
            del errors["momentum"]
        elif self.angular is not None and self.is_isolated:
            errors["angular_momentum"] = self.angular.error()
        return Named("this simulation has no conservation error of", errors)

    def state_numbers(self) -> dict[str, object]:
        """Return the state of the balance for a checkpoint, as JSON data."""
        arrays = {name: vars(self)[name].tolist() for name in ARRAYS}
        own = {name: value for name, value in vars(self).items() if name not in GIVEN}
        angular = self.angular.state_numbers() if self.angular is not None else {}
        return deepcopy(own | arrays | {"angular_momentum": angular})

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Restore the state of the balance from the data of `state_numbers`."""
        arrays = {name: np.array(numbers[name]) for name in ARRAYS}
        own = {name: value for name, value in numbers.items() if name != "angular_momentum"}
        vars(self).update({**deepcopy(own), **arrays})
        if self.angular is not None:
            self.angular.restore(numbers["angular_momentum"])
        self.is_complete = True

    def _sums(self) -> tuple[float, float, float, float, float]:
        """Return sums over all bodies: kinetic energy and stored energy [J], half the power of the internal forces [W],
        power of the artificial viscosity [W], and Σ m|v| over the points [kg m/s]."""
        totals = [body.totals for body in self.bodies]
        rows = ((of.kinetic, of.stored, of.half_power, of.heating, of.momentum_size) for of in totals)
        kinetic, stored, half_power, heating, size = (sum(numbers) for numbers in zip(*rows, strict=True))
        return kinetic, stored, half_power, heating, size

    def _stored_by_kind(self) -> dict[str, float]:
        stored = {"internal": 0.0, "strain": 0.0}
        for body in self.bodies:
            stored[body.energy_kind] += body.totals.stored
            for name, part in body.totals.parts.items():
                stored[body.energy_kind] -= part
                stored[name] = stored.get(name, 0.0) + part
        return stored

    def _momentum(self) -> np.ndarray:
        return np.asarray(sum(body.totals.momentum for body in self.bodies))

    def _mass(self) -> float:
        return float(sum(body.mass for body in self.bodies))


class AngularMomentum(NamedTuple):
    """Angular momentum of bodies about a point, shape (3,), and the sum of the magnitudes Σ m |r| |v| over their points, where
    r is the position relative to this point."""

    vector: np.ndarray  # (3,) Σ m r × v, including the angular momentum of each point about its centre [N m s]
    size: float  # Σ m |r| |v| [N m s]


class AngularBalance:
    """Balance of the angular momentum of all bodies about their common centre of mass at the start.

    axes: axes (0 to 2) about which the bodies can rotate. The error is relative to the largest Σ m |r| |v| so far, summed over
    the points with the position r relative to this centre.
    """

    def __init__(self, bodies: Sequence[Balanced], axes: Sequence[int]) -> None:
        mass, moment = 0.0, np.zeros(3)
        for body in bodies:
            m = body.stored_field("mass")
            mass, moment = mass + float(np.sum(m)), moment + np.sum(m[:, None] * body.stored_field("position"), axis=0)
        self._bodies, self._axes, self._about = bodies, list(axes), moment / mass if mass > 0.0 else moment
        self._initial, self._scale = self._sum()

    def error(self) -> float:
        """Return the largest change of a component of the angular momentum since the start, relative to the largest Σ m |r|
        |v| so far, with the position r relative to the common centre of mass at the start; 0 if no point has moved."""
        now, size = self._sum()
        scale = max(self._scale, size)
        return float(np.abs(now - self._initial)[self._axes].max(initial=0.0) / scale) if scale > 0.0 else 0.0

    def observe(self) -> float:
        """Update the largest Σ m |r| |v|, the reference of the error, with the present state, and return the error, see
        `error`."""
        self._scale = max(self._scale, self._sum()[1])
        return self.error()

    def _sum(self) -> tuple[np.ndarray, float]:
        of_bodies = [body.angular_momentum(self._about) for body in self._bodies]
        return np.sum([one.vector for one in of_bodies], axis=0), sum(one.size for one in of_bodies)

    def state_numbers(self) -> dict[str, object]:
        """Return the state of the balance for a checkpoint, as JSON data."""
        return {"about": self._about.tolist(), "initial": self._initial.tolist(), "scale": self._scale}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Restore the state of the balance from the data of `state_numbers`."""
        self._about, self._initial = np.array(numbers["about"]), np.array(numbers["initial"])
        self._scale = float(numbers["scale"])


ROUNDING_SHARE = 1e-8
"""Fraction of the internal energy that counts as energy at stake, i.e. as part of the reference of the energy error. Most of
the internal energy of a fluid does not cause motion, and the part that is exchanged counts as energy that moved. But in a
case without motion, the rounding of sums must not count as an error: half a unit in the last place of double precision,
1.1e-16 in each step, adds up to 1e-10 of the internal energy in 1e6 steps that all round in the same direction. This is 1 %
of the energy at stake then."""

ROUNDING_STRAIN = 1e-7
"""Strain whose energy covers the rounding of the energy of small strains. Many laws compute this energy, or the pressure of a
liquid, as a difference of numbers of the size of the moduli, such as tr b - 3 - 2 ln J. Half a unit in the last place
of these numbers is about 5e-17 m c²: as much as a strain of 1e-8 stores. It is 1 % of the energy of this strain, m c²/2
times its square."""


def energy_at_stake(bodies: Sequence[Balanced], gravity: tuple[float, float, float], wave_speeds: Sequence[float]) -> float:
    """Return the energy that the bodies could release [J]: strain energy, potential energy above the lowest point of all
    bodies, and an allowance for the rounding of the stored energy.

    gravity: acceleration, shape (3,) [m/s²]. wave_speeds: speed of pressure waves in each body [m/s], 0 for a body without
    waves.
    """
    strain = 0.0
    for body, speed in zip(bodies, wave_speeds, strict=True):
        strain += 0.5 * float(body.stored_field("mass").sum()) * (speed * ROUNDING_STRAIN) ** 2
        if body.energy_kind == "strain":
            strain += abs(body.totals.stored)
    internal = sum(abs(body.totals.stored) for body in bodies if body.energy_kind != "strain")
    masses = [body.stored_field("mass") for body in bodies]
    heights = [-np.sum(body.stored_field("position") * gravity, axis=1) for body in bodies]  # times the acceleration [m²/s²]
    lowest = min(float(height.min()) for height in heights)
    # no matrix products: their rounding depends on the number of cores
    potential = sum(float(np.sum(mass * (height - lowest))) for mass, height in zip(masses, heights, strict=True))
    return strain + potential + ROUNDING_SHARE * internal
