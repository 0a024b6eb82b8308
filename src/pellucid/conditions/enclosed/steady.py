"""Enclosed gas or liquid, and given volumes of membranes, in equilibria with a factored stiffness.

The contents of a volume V have the potential Ψ(V) = -∫p dV with the gauge pressure p. The nodes at x bear the forces p ∂V/∂x,
and the stiffness gets -dp/dV ∂V/∂x ∂V/∂xᵀ - p ∂²V/∂x². A given volume V* is enforced by an augmented Lagrangian (Hestenes
1969, J. Optim. Theory Appl. 4, 303): p = p_h + κ (V* - V) with a held pressure p_h, which takes the value of p where the forces
balance, until V is V*. No large stiffness is needed.
"""

from abc import abstractmethod
from collections.abc import Mapping
from copy import copy
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.conditions.enclosed.active import ActiveEnclosed
from pellucid.conditions.enclosed.contents import Contents
from pellucid.conditions.enclosed.given_volume import ActiveVolume, GivenVolume
from pellucid.conditions.enclosed.volume import EnclosedVolume
from pellucid.energy import FIRST_LOAD
from pellucid.parts.annotations import Assembly
from pellucid.parts.elastic_system import Content, VolumeRates
from pellucid.smooth_step import smooth_step
from pellucid.step.part import AddedStiffness, StepPart

if TYPE_CHECKING:
    from pellucid.conditions.enclosed.model import Enclosed

FIRM = 100.0
"""Stiffness κ of a given volume over that of the membrane: the held pressure is then exact to a hundredth after each
correction, and κ affects the search little."""
CHANGED = 8.0  # ratio of stiffnesses of the membrane from which κ is chosen again
LEAST_VOLUME = 0.1  # of the largest given volume: least volume for which the first κ is chosen; a membrane may start flat
LEAST_STIFFNESS = 1e-6  # of the membrane, over modulus times volume divided by the square of the enclosed volume
MOST_CORRECTIONS = 12  # of the held pressure in a step
EXACT = 1e-13  # error of a volume, relative to the volume, that is rounding


class VolumeLoad(StepPart):
    """A pressure in a membrane that depends on the enclosed volume, in equilibria; implements
    `pellucid.parts.elastic_system.VolumePressure`.

    Part of the step: `begin` sets the time of the loads of the equilibrium that is sought, `end` makes it the last one.
    """

    body: str
    """Name of the membrane."""
    row: int
    """Index of the pressure among the nodal arrays of loads of the membrane."""
    _space: EnclosedVolume
    _rates = 0.0, 0.0  # derivatives of the volume with respect to the share of the step, at its start and end [m³]

    def prepare(self, end: float, stiffness: float) -> None:
        """Set the end time of the loads [s] and modulus times volume of the membrane [J], before the first step."""

    def measure(self, places: np.ndarray, areas: np.ndarray) -> float:
        return self._space.enclosed(places, areas)

    @property
    def sign(self) -> float:
        return self._space.sign

    @abstractmethod
    def begin_with(self, pressure: float) -> None: ...

    @abstractmethod
    def at(self, volume: float, share: float) -> Content: ...

    def start(self) -> None:
        """Nothing to start."""

    def corrects(self, volume: float, tolerance: float) -> bool:
        return False

    def done(self) -> float | None:
        return None

    def compliance(self, volume: float, share: float) -> tuple[float, float] | None:
        return None

    def travel(self, before: float, after: float, leaving: VolumeRates | None, arriving: VolumeRates | None) -> float:
        pressures = self.at(before, 0.0).pressure, self.at(after, 1.0).pressure
        first, last = _both_known(leaving, arriving, VolumeRates(after - before, pressures[1] - pressures[0]))
        self._rates = first.volume, last.volume
        return 0.5 * (pressures[0] + pressures[1]) + 0.125 * (first.pressure - last.pressure)

    def _swept(self, pressures: tuple[float, float, float], before: float, after: float) -> float:
        """Return ∫p dV over the step [J] by Simpson's rule, with an error of fourth order in the step. pressures: at start,
        middle and end of the step [Pa]; before, after: volumes [m³]."""
        first, last = self._rates
        middle = 1.5 * (after - before) - 0.25 * (first + last)
        return (pressures[0] * first + 4.0 * pressures[1] * middle + pressures[2] * last) / 6.0

    def try_out(self) -> None:
        """Nothing to try: the body is at rest."""

    def added_stiffness(self) -> AddedStiffness | None:
        return None


class SteadyEnclosed(VolumeLoad, ActiveEnclosed):  # type: ignore[misc]
    """A gas or liquid in a membrane, in equilibria.

    The mass follows the inflator over the time of the loads. The pressure outside begins where the gauge pressure balances the
    tension of the membrane, and changes smoothly to its value over all of this time, as gravity grows. Stiff contents have a
    volume W of their own, which an augmented Lagrangian equates to the volume V in the membrane, as for given volumes:
    p = p_h + κ (W - V).
    """

    def __init__(self, enclosed: "Enclosed", assembly: Assembly) -> None:
        super().__init__(enclosed, assembly)
        self.body = enclosed.body
        self.row = assembly.load_column(enclosed.body, enclosed.load_channel()) - FIRST_LOAD
        self._end, self._spring = 1.0, 0.0
        self._excess = 0.0  # pressure outside at the start, beyond its value [Pa]
        self._trial, self._trial_time = self.contents, 0.0  # with the mass of the equilibrium that is sought, and its time
        self._brought = 0.0, 0.0  # mass [kg] and ∫T dm [K kg] of the inflow in the step
        self._middle = 0.0  # gauge pressure in the middle of the step [Pa]
        self._filled, self._acting = self._now.volume, 0.0  # volume W [m³] and gauge pressure [Pa] of the last equilibrium
        self._holds = [0.0, 0.0]  # held pressures at the last equilibrium and at that which is sought [Pa]
        self._corrections = 0

    def prepare(self, end: float, stiffness: float) -> None:
        self._end = end
        spring = FIRM * stiffness / self._now.volume**2
        self._spring = spring if self.contents.stiffness(self._now.volume) > spring else 0.0

    def begin_with(self, pressure: float) -> None:
        self._acting = self._holds[0] = pressure
        self._excess = self.contents.pressure(self._now.volume) - self._model.outside - pressure

    def _outside(self, time: float) -> float:
        """Return the pressure outside at a time of the loads [s]."""
        return self._model.outside + (1.0 - smooth_step(time / self._end)) * self._excess

    @property
    def _gauge(self) -> float:
        return self._acting

    def begin(self, time: float, dt: float) -> None:
        if time == self._trial_time and time != self._time:
            return
        self._trial_time, self._trial, self._brought = time, self.contents, (0.0, 0.0)
        if self._model.inflator is not None and time > self._time:
            self._brought = self._model.inflator.given(self._time, time)
            self._trial = copy(self.contents)
            self._trial.take_in(*self._brought, self._filled)

    def start(self) -> None:
        self._holds[1], self._corrections = self._acting, 0

    def _with_loads(self, share: float) -> tuple[Contents, float]:
        """Return the contents with the mass at the start (share 0) or end (share 1) of the step, in the volume of the last
        equilibrium, and the pressure outside [Pa]."""
        contents, time = (self.contents, self._time) if share == 0.0 else (self._trial, self._trial_time)
        return copy(contents), self._outside(time)

    def _own_volume(self, volume: float, share: float) -> float:
        """Return the volume W of the contents [m³] for a volume in the membrane [m³]."""
        if self._spring == 0.0:
            return volume
        contents, outside = self._with_loads(share)
        contents.expand(self._filled, volume)
        return contents.volume_on_spring(self._spring, volume, outside + self._holds[int(share)])

    def at(self, volume: float, share: float) -> Content:
        if volume <= 0.0:
            return Content(inf, 0.0, 0.0)
        contents, outside = self._with_loads(share)
        own = self._own_volume(volume, share)
        heat, stiffness = contents.expand(self._filled, own), max(contents.stiffness(own), 0.0)
        energy = contents.energy - heat + outside * own
        if self._spring == 0.0:
            return Content(energy, contents.pressure(own) - outside, stiffness)
        beyond, held = own - volume, self._holds[int(share)]
        energy += (held + 0.5 * self._spring * beyond) * beyond
        return Content(energy, held + self._spring * beyond, stiffness * self._spring / (stiffness + self._spring))

    def corrects(self, volume: float, tolerance: float) -> bool:
        beyond, pressure = self._own_volume(volume, 1.0) - volume, self.at(volume, 1.0).pressure
        wrong = self._spring * abs(beyond) > tolerance * abs(pressure) and abs(beyond) > EXACT * volume
        if not wrong or self._corrections >= MOST_CORRECTIONS:
            return False
        self._holds[1] = pressure
        self._corrections += 1
        return True

    def compliance(self, volume: float, share: float) -> tuple[float, float] | None:
        if self._spring == 0.0:
            return None
        pressures = []
        for end in (0.0, 1.0):
            contents, outside = self._with_loads(end)
            contents.expand(self._filled, volume)
            pressures.append(contents.pressure(volume) - outside)
        contents, _ = self._with_loads(share)
        contents.expand(self._filled, volume)
        stiffness = contents.stiffness(volume)
        return (pressures[1] - pressures[0]) / stiffness, 1.0 / stiffness

    def travel(self, before: float, after: float, leaving: VolumeRates | None, arriving: VolumeRates | None) -> float:
        self._middle = super().travel(before, after, leaving, arriving)
        return self._middle

    def _changes(self, volume: float) -> dict[str, float]:
        """Return works and heat of the step to a volume [m³] in J, by the name of their channel."""
        before, held = self._now.volume, self.contents
        outside = self._outside(self._time), self._outside(self._trial_time)
        mean, against = 0.5 * (outside[0] + outside[1]), outside[0] * (volume - before)
        if outside[0] != outside[1]:
            against = self._swept((outside[0], mean, outside[1]), before, volume)
        contents, _ = self._with_loads(1.0)
        heat = contents.expand(self._filled, self._own_volume(volume, 1.0))
        energy = contents.energy - held.energy
        works = {"outside_work": against, "enclosed_energy": energy, "enclosed_heat": heat}
        mass, warmth = self._brought
        if mass > 0.0:  # what the contents exchange follows from their work
            ends = self._acting + outside[0], self._middle + mean, self.at(volume, 1.0).pressure + outside[1]
            given = done = energy + self._swept(ends, before, volume)
            if self._model.gas is not None:
                given, _ = copy(held).take_in(mass, warmth, before)
            works |= {"inflator_energy": given, "enclosed_heat": done - given}
        return works

    def done(self) -> float:
        works = self._changes(self._space.now().volume)
        return works.get("inflator_energy", 0.0) + works["enclosed_heat"] - works["enclosed_energy"] - works["outside_work"]

    def end(self, dt: float) -> None:
        space = self._space.now()
        self._check(space)
        self._works = self._changes(space.volume)
        own, contents, acting = self._own_volume(space.volume, 1.0), self._trial, self.at(space.volume, 1.0).pressure
        contents = copy(contents)
        contents.expand(self._filled, own)
        self.contents = self._trial = contents
        self._now, self._time, self._filled, self._acting = space, self._trial_time, own, acting
        self._holds[0] = self._holds[1]

    def columns(self) -> Mapping[str, float]:
        pressure = self._acting + self._outside(self._time)
        return {**super().columns(), f"{self._model.name}_pressure": pressure}

    def state_numbers(self) -> dict[str, Any]:
        own = {"time": self._time, "excess": self._excess, "filled": self._filled, "acting": self._acting}
        return super().state_numbers() | own | {"held": self._holds[0]}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        super().restore(numbers)
        self._time, self._excess = numbers["time"], numbers["excess"]
        self._filled, self._acting, self._holds[0] = numbers["filled"], numbers["acting"], numbers["held"]
        self._trial, self._trial_time = self.contents, self._time


class SteadyVolume(VolumeLoad, ActiveVolume):  # type: ignore[misc]
    """A given volume of a membrane as a function of the time of the loads, in equilibria; arguments as for `ActiveVolume`."""

    def __init__(self, body: str, given: GivenVolume, channel: str, assembly: Assembly) -> None:
        super().__init__(body, given, None, channel, assembly)
        self.body, self.row = body, assembly.load_column(body, channel) - FIRST_LOAD
        self._target = self._start
        self._held = 0.0  # in the equilibrium that is sought [Pa]; at the last one the pressure itself
        self._scale, self._corrections = 0.0, 0

    def prepare(self, end: float, stiffness: float) -> None:
        self._scale = stiffness
        largest = max(self._given.rows[1]) * (1.0 if self._given.ratios is None else self._start)
        self._spring = FIRM * self._scale / max(self._start, LEAST_VOLUME * largest) ** 2

    def begin_with(self, pressure: float) -> None:
        self._pressure = pressure

    def begin(self, time: float, dt: float) -> None:
        self._target = self._given.at(time, self._start)[0]

    def start(self) -> None:
        self._held, self._corrections = self._pressure, 0

    def at(self, volume: float, share: float) -> Content:
        held, target = (self._pressure, self._now.volume) if share == 0.0 else (self._held, self._target)
        beyond = target - volume
        energy = 0.5 * self._spring * beyond**2 + held * beyond
        return Content(energy, held + self._spring * beyond, self._spring)

    def corrects(self, volume: float, tolerance: float) -> bool:
        beyond, moved = self._target - volume, abs(self._target - self._start)
        if abs(beyond) <= max(tolerance * moved, EXACT * self._target) or self._corrections >= MOST_CORRECTIONS:
            return False
        self._held += self._spring * beyond
        self._corrections += 1
        return True

    def compliance(self, volume: float, share: float) -> tuple[float, float]:
        return self._target - self._now.volume, 0.0

    def end(self, dt: float) -> None:
        before, pressure, now = self._now.volume, self._pressure, self._space.now()
        self._pressure, self._now = self.at(now.volume, 1.0).pressure, now
        stiffness = max(abs(self._pressure), LEAST_STIFFNESS * self._scale / now.volume) / now.volume
        if now.volume != before:
            stiffness = max(stiffness, abs((self._pressure - pressure) / (now.volume - before)))
        if not 1.0 / CHANGED < self._spring / (FIRM * stiffness) < CHANGED:
            self._spring = FIRM * stiffness


def _both_known(first: VolumeRates | None, last: VolumeRates | None, change: VolumeRates) -> tuple[VolumeRates, VolumeRates]:
    """Return the derivatives at the start and the end of a step; if one is not known, volume and pressure are quadratic.
    change: changes in the step."""
    if first is None:
        first = change if last is None else _other_end(last, change)
    return first, _other_end(first, change) if last is None else last


def _other_end(known: VolumeRates, change: VolumeRates) -> VolumeRates:
    return VolumeRates(2.0 * change.volume - known.volume, 2.0 * change.pressure - known.pressure)
