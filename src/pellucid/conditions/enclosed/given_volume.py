"""Prescribed volumes of membranes as functions of time, and the pressure that enforces them."""

from collections.abc import Mapping
from functools import cached_property
from math import hypot, sqrt
from typing import Any

from pellucid.conditions.enclosed.volume import EnclosedVolume
from pellucid.conditions.signals.time_table import check_order, read_rows
from pellucid.model import InputFile, Model, check, parameter
from pellucid.parts.annotations import Assembly
from pellucid.step.part import AddedStiffness, StepPart

SHARE = 0.25
"""Oscillation frequency of the enclosed volume on the spring that enforces the prescribed volume, as a fraction of the
highest frequency of the membrane. Used if the stiffness is not given."""
DAMPING = 1.0
"""Damping ratio of the oscillation of the enclosed volume (1: critical damping)."""


class GivenVolume(Model):
    """Prescribed volume as a function of time: monotone cubic interpolation (PCHIP), constant before the first and after
    the last time."""

    times: tuple[float, ...] | None = parameter("s", "times of the table, in increasing order", None, min_length=2)
    volumes: tuple[float, ...] | None = parameter("m^3", "volume at each time", None)
    ratios: tuple[float, ...] | None = parameter("", "alternative: volume at each time divided by the initial volume", None)
    path: InputFile | None = parameter(
        "", "alternative: a CSV file with the columns time [s] and volume [m³]; a header row is allowed", None
    )

    @check
    def _is_a_function(self) -> None:
        lists = [values for values in (self.volumes, self.ratios) if values is not None]
        if (self.path is None) == (self.times is None) or len(lists) != (self.times is not None):
            raise ValueError(
                "give either `times` with `volumes` or `ratios`, such as { times = [0, 1], ratios = [1, 2] }, or `path`"
            )
        if self.times is not None:
            if len(self.times) != len(lists[0]):
                raise ValueError(f"{len(self.times)} times and {len(lists[0])} volumes; give the same number of both")
            check_order(self.times)
        if min(self.rows[1]) < 0.0:
            raise ValueError(f"{min(self.rows[1]):g}: an enclosed volume cannot be negative")
        if self.ratios is not None and min(self.ratios) == 0.0:
            raise ValueError("0: the enclosed volume cannot become zero; give ratios above 0")

    @cached_property
    def rows(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times [s], and the prescribed volumes [m³] or their ratios to the initial volume."""
        if self.path is not None:
            times, volumes = read_rows(self.path, "volume [m3]").T.tolist()
            return tuple(times), tuple(volumes)
        return self.times or (), self.ratios or self.volumes or ()

    def at(self, time: float, start: float) -> tuple[float, float]:
        """Return the prescribed volume [m³] and its rate [m³/s] at a time [s]; start: initial volume of the membrane [m³]."""
        (times, _), unit = self.rows, 1.0 if self.ratios is None else start
        within = min(max(time, times[0]), times[-1])
        volume, rate = (float(curve(within)) for curve in self._curves)
        return unit * volume, unit * rate if times[0] <= time <= times[-1] else 0.0

    def spring(self, stiffness: float | None, start: float, rate: float, mobility: float) -> float:
        """Return the spring constant κ [Pa/m³] (pressure per difference of volumes) that enforces the volume. It follows
        from `stiffness`, i.e. κ times the largest volume [Pa]; if `stiffness` is None, from `rate`, the inverse of the
        membrane's own stable step [1/s]. start: initial volume [m³]; mobility: second time derivative of the volume per
        unit pressure [m⁴/kg]."""
        if stiffness is not None:
            return stiffness / (max(self.rows[1]) * (1.0 if self.ratios is None else start))
        return (SHARE * 2.0 * rate) ** 2 / mobility

    @cached_property
    def _curves(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        curve = PchipInterpolator(*self.rows)
        return curve, curve.derivative()


class ActiveVolume(StepPart):
    """Pressure p = κ (V* - V) + c (V*' - V') that enforces the prescribed volume V* of a membrane in a run: a stiff spring
    κ, and a damper c for the oscillation of the volume V with the mass of the membrane; ' is the rate in time.

    The pressure is stored only for the history; the next step computes it from the position of the membrane.
    """

    def __init__(self, body: str, given: GivenVolume, stiffness: float | None, channel: str, assembly: Assembly) -> None:
        """body: name of the membrane; given: prescribed volume; stiffness: spring constant κ times the largest prescribed
        volume [Pa], or None: chosen from the step limit of the membrane; channel: entry of the energy balance for the work
        of the pressure."""
        self._body, self._given, self._stiffness = body, given, stiffness
        self._space = EnclosedVolume(body, (), assembly, channel)
        self._now = self._space.now()
        self._start = self._now.volume
        self._spring, self._damper, self._pressure = 0.0, 0.0, 0.0
        self._time, self._passing = 0.0, 0.0

    def try_out(self) -> None:
        """Choose the spring constant if no stiffness is given, and the damping coefficient."""
        mobility = self._space.mobility(self._now)
        self._spring = self._given.spring(self._stiffness, self._start, self._space.bodies[0].totals.rate, mobility)
        self._damper = critical(self._spring, mobility)
        self._pressure = self._at(0.0, moving=False)

    def _at(self, time: float, moving: bool) -> float:
        volume, rate = self._given.at(time, self._start)
        rate = rate if moving else 0.0
        return self._spring * (volume - self._now.volume) + self._damper * (rate - self._space.growth(self._now))

    def begin(self, time: float, dt: float) -> None:
        self._time, self._passing = time, dt
        self._space.press(self._now, self._at(time, moving=dt > 0.0))

    def end(self, dt: float) -> None:
        self._now = self._space.now()
        self._pressure = self._at(self._time + self._passing, moving=self._passing > 0.0)

    def added_stiffness(self) -> AddedStiffness:
        rate = bound_of_spring(self._spring, self._damper, self._space.mobility(self._now))
        return self._space.added_stiffness(rate, "its given volume")

    def warnings(self, energy_scale: float) -> Mapping[str, str]:
        """Return a warning about holes in the membrane through which no flow is computed."""
        if not (failed := self._now.failed[0]):
            return {}
        text = (
            f"membrane {self._body} has failed at {failed} of its {len(self._now.areas[0])} points, and its given volume is "
            "maintained as if it had no holes; use an [[enclosed]] gas or liquid, which flows out through them, or end the run "
            "before"
        )
        return {"holes": text}

    def columns(self) -> Mapping[str, float]:
        return {f"{self._body}_pressure": self._pressure, f"{self._body}_volume": self._now.volume}

    def state_numbers(self) -> dict[str, Any]:
        chosen = {"spring": self._spring, "damper": self._damper, "start": self._start}
        return {"pressure": self._pressure, **chosen}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._pressure, self._start = numbers["pressure"], numbers["start"]
        self._spring, self._damper = numbers["spring"], numbers["damper"]
        self._now = self._space.now()


def bound_of_spring(spring: float, damper: float, mobility: float) -> float:
    """Return the inverse of the largest stable step [1/s] of an enclosed volume that oscillates on a spring (constant in
    Pa/m³) and a damper (coefficient in Pa s/m³); mobility: second time derivative of the volume per unit pressure [m⁴/kg]."""
    damped = 0.5 * damper * mobility
    return 0.5 * (damped + hypot(damped, sqrt(spring * mobility)))


def critical(spring: float, mobility: float) -> float:
    """Return the damping coefficient [Pa s/m³] for the damping ratio `DAMPING` of an enclosed volume that oscillates on a
    spring (constant in Pa/m³); mobility: second time derivative of the volume per unit pressure [m⁴/kg]."""
    return 2.0 * DAMPING * sqrt(spring / mobility)


def start_fault(given: GivenVolume, start: float) -> str | None:
    """Return a text that describes the fault if the prescribed volume `given` at time 0 differs by more than a tenth from
    the initial volume `start` of the membrane [m³], else None."""
    if given.ratios is not None:
        return None
    first, largest = given.at(0.0, start)[0], max(given.rows[1])
    if abs(first - start) <= 0.1 * max(largest, start):
        return None
    return f"{first:.4g} m3 at t = 0, but the membrane encloses {start:.4g} m3: its pressure would jump"
