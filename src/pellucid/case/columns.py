"""Look up the columns of the history that plots and checks may name, and their units, before a run."""

from collections.abc import Iterator
from typing import Any

from pellucid.case.probe import Probe, other_columns
from pellucid.findings import Finding, Path, hint, listed
from pellucid.parts.condition import Condition, conditions_in_case
from pellucid.parts.part import Parts

UNITS = {
    "time": "s",
    "dt": "s",
    "step": "",
    "energy_error": "",
    "inflow_points": "",
    "inflow_mass": "kg",
    "outflow_points": "",
    "outflow_mass": "kg",
}
MOMENTUM, ENERGY = "kg m/s", "J"


def unit_of(name: str, parts: Parts) -> str | None:
    """Return the SI unit of the column `name` of the history, "" for a dimensionless number; None if the history of a case
    with the given parts (tables of the case) has no column with this name."""
    probe = parts.named(Probe, name)
    if probe is not None:
        return probe.unit
    if name in UNITS:
        return UNITS[name]
    for condition in conditions_in_case(parts):
        if name in condition.columns():
            return condition.columns()[name]
    if name.startswith("momentum_"):
        return MOMENTUM
    return ENERGY if name in other_columns(parts) else None


def beyond_end(time: float, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding at `path` if a time [s] is later than the end of the run. parts: the parts of the case."""
    clock: Any = parts.sections["time"].items[0]
    if hasattr(clock, "passed") and clock.passed(time):
        yield Finding(path, f"{time:g} s is later than time.end = {clock.end:g} s", "Set a time up to time.end.")


def unknown_column(name: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding at `path` if the history will have no column `name`; no finding while a probe or condition is invalid.
    parts: the parts of the case."""
    sound = parts.are_sound(Probe) and parts.are_sound(Condition)
    if sound and unit_of(name, parts) is None:
        names = [*parts.names(Probe), "time", *other_columns(parts)]
        told = [column for condition in conditions_in_case(parts) for column in condition.columns()]
        text = f"not a column of the history; available probes: {listed(parts.names(Probe)) or 'none'}"
        text += f"; other columns: {', '.join([*told, 'time', 'energies'])}"
        yield Finding(path, text, hint(name, names) or "Add a [[probe]] with this name.")
