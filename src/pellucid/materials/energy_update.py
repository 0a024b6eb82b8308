"""The energy equation of a fluid point over a step. Source: Gan et al. 2011, eqs. 25–31, with the limit corrected.

With `conservative`, the default, the internal energy has already received the work of the nodal forces when the stress is
computed (`pellucid.grid.velocities`): the sum of internal and kinetic energy is conserved to rounding. The other options
integrate the work of the stress σ with the rate of deformation D. The iteration of the paper converges to backward Euler, e
= e_k + dt/ρ σ(e):D, where e_k is the specific energy at the start of the step: `closed` solves it exactly (the pressure P
is linear in e), `iterated` by Newton's method for any equation of state. `explicit` uses the old stress (York's order,
figure 10).

In a wave, backward Euler heats a fluid with the bulk modulus K by dt²/2 K (tr D)²/ρ per step, and forward Euler cools it by
the same amount. `midpoint`, the mean of both, has neither error; it suits waves in liquids over many steps.
"""

from math import nan
from typing import Any, NamedTuple

from pellucid.jit import default_function, generic, point_function, pointwise
from pellucid.materials.eos.equation import lowest_pressure, pressure_line


class ConservativeEnergy(NamedTuple):
    """Option `conservative` of the energy update of a fluid: no update in the law, since the internal energy already
    includes the work of the nodal forces (`pellucid.grid.velocities`)."""

    unused: int = 0  # a NamedTuple without fields has no compiled type


class ClosedEnergy(NamedTuple):
    """Option `closed` of the energy update of a fluid: backward Euler for the internal energy, solved exactly."""

    unused: int = 0


class ExplicitEnergy(NamedTuple):
    """Option `explicit` of the energy update of a fluid: forward Euler for the internal energy, with the stress at the
    start of the step."""

    unused: int = 0


class IteratedEnergy(NamedTuple):
    """Option `iterated` of the energy update of a fluid: backward Euler for the internal energy, solved by Newton's method."""

    tolerance: float = 1e-12  # largest change in the last iteration, relative to the sum of energies and works
    limit: int = 50  # largest number of iterations


class MidpointEnergy(NamedTuple):
    """Option `midpoint` of the energy update of a fluid: the internal energy changes by the work of the mean of the
    stresses at the start and the end of the step, solved exactly."""

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
    """Return the specific energy at the end of the step [J/kg]; nan if an iteration does not converge or the compression in
    the step is too large for backward Euler.

    mode: option of the energy update, such as `ClosedEnergy`; eos: equation of state; energy: specific energy before the
    update [J/kg]; density: at the end of the step [kg/m³]; trD: volume rate tr D [1/s]; old_work: work dt/ρ σ_k:D of the
    stress σ_k at the start of the step [J/kg]; other_work: work dt/ρ (τ - q I):D of the viscous stress τ and the artificial
    pressure q, i.e. without the pressure P [J/kg]; dt: step [s].

    """


@generic
def energy_of_pressure(
    mode: Any, eos: Any, energy: float, density: float, trD: float, old_work: float, other_work: float, dt: float
) -> float:
    """Return the specific energy [J/kg] from which the pressure at the end of the step is computed, when the density is
    known; energy: result of `new_energy`; other arguments: as in `new_energy`."""


@default_function(energy_of_pressure)
def _same(mode, eos, energy, density, trD, old_work, other_work, dt):
    return energy


@pointwise
def pressure(eos, density, energy):
    """Return the pressure P [Pa] at a density [kg/m³] and a specific energy [J/kg], limited from below by `lowest_pressure`;
    eos: equation of state."""
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
    """Return the specific energy advanced by half a step [J/kg]; arguments as in `new_energy`. The conservative energy
    includes work up to the middle of the step, since it uses mean nodal velocities, whereas the density is at the end of
    the step. Without this correction sound waves would grow."""
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
