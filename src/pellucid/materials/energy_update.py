"""The energy equation of a fluid point over a step. Source: Gan et al. 2011, eqs. 25–31, with the limit put right.

With `conservative`, the default, the energy has grown by the work of the forces that moved the nodes when the stress is found
(`pellucid.grid.velocities`): its sum with the kinetic energy is kept to rounding. The others integrate the work of the stress
by themselves. The paper's iteration converges to backward Euler, e = e_k + dt/ρ σ(e):D: `closed` solves that exactly (P is
linear in e), `iterated` by Newton's method for any equation of state. `explicit` takes the old stress (York's order,
figure 10).
Backward Euler heats a fluid that a wave passes by dt²/2 K (tr D)²/ρ a step, forward Euler cools it so; `midpoint`, the mean of
both, does neither: it is for waves in liquids over many steps.
"""

from math import nan
from typing import Any, NamedTuple

from pellucid.jit import default_function, generic, point_function, pointwise
from pellucid.materials.eos.equation import lowest_pressure, pressure_line


class ConservativeEnergy(NamedTuple):
    """The energy has grown already, by the work of the forces that moved the nodes: see `pellucid.grid.velocities`."""

    unused: int = 0  # a NamedTuple without fields has no compiled type


class ClosedEnergy(NamedTuple):
    """Backward Euler, solved exactly."""

    unused: int = 0


class ExplicitEnergy(NamedTuple):
    """Forward Euler with the old stress."""

    unused: int = 0


class IteratedEnergy(NamedTuple):
    """Backward Euler, by Newton's method."""

    tolerance: float = 1e-12  # relative to the energy scale of the step
    limit: int = 50


class MidpointEnergy(NamedTuple):
    """The mean of old and new stress, solved exactly."""

    unused: int = 0


ENERGY_UPDATES = {
    "conservative": ConservativeEnergy(),
    "closed": ClosedEnergy(),
    "explicit": ExplicitEnergy(),
    "iterated": IteratedEnergy(),
    "midpoint": MidpointEnergy(),
}


@generic
def new_energy(
    mode: Any, eos: Any, energy: float, density: float, trD: float, old_work: float, other_work: float, dt: float
) -> float:
    """Specific energy at the end of the step [J/kg]; nan where an iteration does not converge or the step compresses more
    than backward Euler can follow.

    density: at the end of the step; old_work: dt/ρ σ_k:D [J/kg]; other_work: dt/ρ (τ - q I):D, the part without P [J/kg].
    """


@generic
def energy_of_pressure(
    mode: Any, eos: Any, energy: float, density: float, trD: float, old_work: float, other_work: float, dt: float
) -> float:
    """The specific energy at the end of the step that goes with the density there [J/kg], of what `new_energy` gave."""


@default_function(energy_of_pressure)
def _same(mode, eos, energy, density, trD, old_work, other_work, dt):
    return energy


@pointwise
def pressure(eos, density, energy):
    """P [Pa], not below the tension that the fluid bears."""
    A, B = pressure_line(eos, density)
    return max(A + B * energy, lowest_pressure(eos))


@point_function(new_energy, ConservativeEnergy)
def _conservative(mode, eos, energy, density, trD, old_work, other_work, dt):
    return energy


@point_function(new_energy, ExplicitEnergy)
def _explicit(mode, eos, energy, density, trD, old_work, other_work, dt):
    return energy + old_work


@pointwise
def _backward_euler(eos, energy, density, trD, other_work, dt):
    A, B = pressure_line(eos, density)
    s = dt * trD * (1.0 / density)
    if s * B <= -1.0:
        return nan
    e = (energy + other_work - s * A) / (1.0 + s * B)
    if A + B * e < lowest_pressure(eos):
        e = energy + other_work - s * lowest_pressure(eos)
    return e


@point_function(new_energy, ClosedEnergy)
def _closed(mode, eos, energy, density, trD, old_work, other_work, dt):
    return _backward_euler(eos, energy, density, trD, other_work, dt)


@point_function(energy_of_pressure, ConservativeEnergy)
def _ahead(mode, eos, energy, density, trD, old_work, other_work, dt):
    """The work along the mean velocities of the nodes, which belong to half steps, is that up to the middle of the step, where
    the density is that of its end: the second half is still to come. Without it sound would grow."""
    return _backward_euler(eos, energy, density, trD, 0.5 * other_work, 0.5 * dt)


@point_function(new_energy, MidpointEnergy)
def _midpoint(mode, eos, energy, density, trD, old_work, other_work, dt):
    A, B = pressure_line(eos, density)
    growth = 1.0 + dt * trD  # the change of specific volume is dt tr D times that at the start of the step
    s = 0.5 * dt * trD / (density * growth)
    if growth <= 0.0 or s * B <= -1.0:
        return nan
    known = energy + 0.5 * (old_work + other_work) / growth
    e = (known - s * A) / (1.0 + s * B)
    if A + B * e < lowest_pressure(eos):
        e = known - s * lowest_pressure(eos)
    return e


@point_function(new_energy, IteratedEnergy)
def _iterated(mode, eos, energy, density, trD, old_work, other_work, dt):
    s = dt * trD / density
    e = energy
    scale = abs(energy) + abs(old_work) + abs(other_work)
    for _ in range(mode.limit):
        P = pressure(eos, density, e)
        step = 1e-6 * (abs(e) + scale) + 1e-300
        slope = (pressure(eos, density, e + step) - P) / step
        if s * slope <= -1.0:
            return nan
        change = (energy + other_work - s * P - e) / (1.0 + s * slope)
        e += change
        if abs(change) <= mode.tolerance * (abs(e) + scale):
            return e
    return nan
