"""Data models of inflators and vents of enclosed gases and liquids."""

from functools import cached_property
from itertools import pairwise

import numpy as np

from pellucid.conditions.signals.time_table import check_order, read_rows
from pellucid.findings import listed
from pellucid.model import InputFile, Model, check, parameter


class Inflator(Model):
    """Inflow over time: linear between given times, zero before the first and after the last."""

    times: tuple[float, ...] | None = parameter("s", "times of the table, in increasing order", None, min_length=2)
    mass_flows: tuple[float, ...] | None = parameter("kg/s", "mass inflow rate at each time", None)
    temperatures: tuple[float, ...] | None = parameter("K", "temperature of the inflowing gas at each time", None)
    path: InputFile | None = parameter(
        "",
        "alternative: a CSV file with the columns time [s], mass flow [kg/s] and, for a gas, temperature [K]; a header row "
        "is allowed",
        None,
    )

    @check
    def _is_a_function(self) -> None:
        if (self.path is None) == (self.times is None) or (self.times is None) != (self.mass_flows is None):
            raise ValueError("give either `times`, `mass_flows` and, for a gas, `temperatures`, or `path`")
        lists = [values for values in (self.times, self.mass_flows, self.temperatures) if values is not None]
        if len({len(values) for values in lists}) > 1:
            numbers = listed([str(len(values)) for values in lists])
            raise ValueError(f"{numbers} times, mass flows and temperatures; give the same number of each")
        check_order(self.times or ())
        if min(self._rows[1]) < 0.0:
            raise ValueError(f"mass flow {min(self._rows[1]):g} kg/s: an inflator cannot have outflow; use a vent")
        if self._rows[2] and min(self._rows[2]) <= 0.0:
            raise ValueError(f"temperature {min(self._rows[2]):g} K must be above 0; give kelvins")

    @cached_property
    def _rows(self) -> tuple[tuple[float, ...], ...]:
        """Times [s], mass flow rates [kg/s] and temperatures [K] (empty if not given)."""
        if self.path is not None:
            rows = read_rows(self.path, "mass flow [kg/s]", "temperature [K]").T.tolist()
            return tuple(map(tuple, (*rows, ()) if len(rows) == 2 else rows))
        return self.times or (), self.mass_flows or (), self.temperatures or ()

    @property
    def has_temperatures(self) -> bool:
        """True if the temperatures of the inflowing gas are given."""
        return len(self._rows[2]) > 0

    def given(self, start: float, end: float) -> tuple[float, float]:
        """Return the mass of the inflow between the times `start` and `end` [s], in kg, and the integral ∫T dm of its
        temperature T over its mass m [K kg] (0 if no temperatures are given), both integrated exactly."""
        times, flows, temperatures = self._rows
        inner = [time for time in times if start < time < end]
        mass = warmth = 0.0
        for first, last in pairwise([start, *inner, end]):
            if first < times[0] or last > times[-1] or last <= first:
                continue
            instants = (first, 0.5 * (first + last), last)
            flow = np.interp(instants, times, flows)
            warm = np.interp(instants, times, temperatures) if temperatures else np.zeros(3)
            weights = (last - first) / 6.0 * np.array((1.0, 4.0, 1.0))  # Simpson's rule, exact for cubics
            mass += float(np.sum(weights * flow))
            warmth += float(np.sum(weights * flow * warm))
        return mass, warmth


class Vent(Model):
    """An opening through which gas or liquid flows out against the outside pressure."""

    area: float = parameter("m^2", "area A of the opening", gt=0)
    coefficient: float = parameter("", "discharge coefficient: factor on the area A", 1.0, gt=0, le=1)
    opens_at: float = parameter(
        "Pa",
        "gauge pressure inside at which the vent opens permanently; default: open from the start",
        0.0,
        ge=0,
    )
