"""Exact solution of the Riemann problem of ideal gases.

Two uniform states are in contact at x = 0. For t > 0 the solution depends on x/t alone: a wave (shock or rarefaction fan)
runs into each state, and a contact separates the gases between the waves, with the same pressure p* and velocity u* on both
sides.
Source: E. F. Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, 3rd ed., chapter 4. Here each gas may have its
own gamma.
"""

from dataclasses import dataclass, replace
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

FLOAT_LIMIT = 1e-15


class VacuumError(ValueError):
    """Error for two gas states between which a vacuum opens, so that there is no star region (the region between the waves)."""


@dataclass(frozen=True)
class GasState:
    """Uniform state of an ideal gas on one side of a Riemann problem: density [kg/m³], velocity [m/s], pressure [Pa] and
    ratio of specific heats."""

    density: float  # [kg/m³]
    velocity: float  # [m/s]
    pressure: float  # [Pa]
    gamma: float = 1.4  # ratio of specific heats

    def __post_init__(self) -> None:
        if self.gamma <= 1.0:
            raise ValueError(f"gamma = {self.gamma}: an ideal gas needs gamma > 1")
        if self.density <= 0.0 or self.pressure <= 0.0:
            raise VacuumError(f"density {self.density} and pressure {self.pressure} must both be positive")

    @property
    def sound_speed(self) -> float:
        """Speed of sound [m/s]."""
        return sqrt(self.gamma * self.pressure / self.density)

    def mirrored(self) -> "GasState":
        """Return the state of the mirror image of the gas: density and pressure are equal, the velocity changes sign."""
        return replace(self, velocity=-self.velocity)


class Wave(NamedTuple):
    """A wave (shock or rarefaction fan) that runs into one of the two gases: speeds of head and tail [m/s], and density
    behind the wave [kg/m³]."""

    head: float  # speed of the head [m/s]
    tail: float  # speed of the tail [m/s]; equal to `head` for a shock
    density: float  # density behind the wave [kg/m³]

    def mirrored(self) -> "Wave":
        """Return the mirror image of the wave: both speeds change sign, the density is equal."""
        return Wave(-self.head, -self.tail, self.density)


@dataclass(frozen=True)
class RiemannSolution:
    """Exact solution of a Riemann problem, as `solve` returns it: both initial states, pressure [Pa] and velocity [m/s]
    between the waves, and both waves. `sample` evaluates the fields."""

    left: GasState  # initial state for x < 0
    right: GasState  # initial state for x > 0
    pressure: float  # pressure p* between the waves [Pa]
    velocity: float  # velocity u* between the waves [m/s]
    left_wave: Wave  # wave into the left gas
    right_wave: Wave  # wave into the right gas

    def sample(self, speed: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Return the fields at x/t = `speed` [m/s] of any shape.

        The fields are density [kg/m^3], velocity [m/s], pressure [Pa] and internal_energy [J/kg], each of the same shape.
        """
        xi = np.asarray(speed, dtype=float)
        from_left = _one_side(self.left, self.left_wave, self.pressure, self.velocity, xi)
        from_right = _one_side(self.right.mirrored(), self.right_wave.mirrored(), self.pressure, -self.velocity, -xi)
        in_left_gas = xi < self.velocity
        density, pressure = (np.where(in_left_gas, a, b) for a, b in zip(from_left[::2], from_right[::2], strict=True))
        velocity = np.where(in_left_gas, from_left[1], -from_right[1])
        gamma = np.where(in_left_gas, self.left.gamma, self.right.gamma)
        energy = pressure / ((gamma - 1.0) * density)
        return {"density": density, "velocity": velocity, "pressure": pressure, "internal_energy": energy}


def solve(left: GasState, right: GasState) -> RiemannSolution:
    """Compute the solution for two gas states: the star region (between the waves) and the waves.

    Raises VacuumError if a vacuum opens between them.
    """
    reach = sum(2.0 * gas.sound_speed / (gas.gamma - 1.0) for gas in (left, right))
    if right.velocity - left.velocity >= reach:
        parting = right.velocity - left.velocity
        raise VacuumError(
            f"a vacuum would form: the states separate at {parting:g} m/s, but must separate at less than {reach:g} m/s"
        )
    pressure = _star_pressure(left, right)
    velocity = left.velocity - _velocity_change(left, pressure)[0]
    right_wave = _wave(right.mirrored(), pressure).mirrored()
    return RiemannSolution(left, right, pressure, velocity, _wave(left, pressure), right_wave)


def _star_pressure(left: GasState, right: GasState) -> float:
    """Return the pressure between the waves [Pa], the root of f(p) = f_L(p) + f_R(p) + u_R - u_L with `_velocity_change` f_L,
    f_R. f is increasing and concave, so Newton's method from below never overshoots."""

    def mismatch(p: float) -> tuple[float, float]:
        (f_left, df_left), (f_right, df_right) = _velocity_change(left, p), _velocity_change(right, p)
        return f_left + f_right + right.velocity - left.velocity, df_left + df_right

    pressure = min(left.pressure, right.pressure)
    while mismatch(pressure)[0] > 0.0:
        pressure *= 0.1
    for _ in range(200):
        value, slope = mismatch(pressure)
        change = -value / slope
        pressure += change
        if abs(change) <= FLOAT_LIMIT * pressure:
            break
    return pressure


def _velocity_change(gas: GasState, pressure: float) -> tuple[float, float]:
    """Return the velocity change f across the wave from `gas` to the pressure behind it [m/s], and its derivative with respect
    to this pressure [m/(s Pa)]."""
    gamma = gas.gamma
    if pressure > gas.pressure:  # shock: Rankine-Hugoniot
        a, b = 2.0 / ((gamma + 1.0) * gas.density), (gamma - 1.0) / (gamma + 1.0) * gas.pressure
        root = sqrt(a / (pressure + b))
        return (pressure - gas.pressure) * root, root * (1.0 - 0.5 * (pressure - gas.pressure) / (pressure + b))
    ratio = pressure / gas.pressure  # fan: constant entropy and Riemann invariant
    change = 2.0 * gas.sound_speed / (gamma - 1.0) * (ratio ** ((gamma - 1.0) / (2.0 * gamma)) - 1.0)
    return change, ratio ** (-(gamma + 1.0) / (2.0 * gamma)) / (gas.density * gas.sound_speed)


def _wave(gas: GasState, pressure: float) -> Wave:
    """Return the wave that runs into the *left* gas state; pressure: pressure behind it, in the star region [Pa]."""
    gamma, ratio = gas.gamma, pressure / gas.pressure
    if ratio > 1.0:
        g = (gamma - 1.0) / (gamma + 1.0)
        speed = gas.velocity - gas.sound_speed * sqrt((gamma + 1.0) / (2.0 * gamma) * (ratio - 1.0) + 1.0)
        return Wave(speed, speed, gas.density * (ratio + g) / (g * ratio + 1.0))
    star_sound = gas.sound_speed * ratio ** ((gamma - 1.0) / (2.0 * gamma))
    star_velocity = gas.velocity - _velocity_change(gas, pressure)[0]
    head, tail = gas.velocity - gas.sound_speed, star_velocity - star_sound
    return Wave(head, tail, gas.density * ratio ** (1.0 / gamma))


def _one_side(
    gas: GasState, wave: Wave, star_pressure: float, star_velocity: float, xi: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return density [kg/m^3], velocity [m/s] and pressure [Pa] at x/t = xi [m/s] on the left of the contact, each of the shape
    of xi. gas: left state; wave: left wave."""
    gamma, sound = gas.gamma, gas.sound_speed
    star = (np.full(xi.shape, wave.density), np.full(xi.shape, star_velocity), np.full(xi.shape, star_pressure))
    inside = (xi >= wave.head) & (xi < wave.tail)
    # within the fan the invariant u + 2c/(gamma-1) and u - c = x/t give c, and constant entropy the rest
    inner = np.where(inside, xi, wave.head)
    fan_sound = (2.0 * sound + (gamma - 1.0) * (gas.velocity - inner)) / (gamma + 1.0)
    compression = (fan_sound / sound) ** (2.0 / (gamma - 1.0))
    fan = (gas.density * compression, inner + fan_sound, gas.pressure * compression**gamma)
    outer = (gas.density, gas.velocity, gas.pressure)
    density, velocity, pressure = (
        np.where(xi < wave.head, o, np.where(inside, f, s)) for o, f, s in zip(outer, fan, star, strict=True)
    )
    return density, velocity, pressure
