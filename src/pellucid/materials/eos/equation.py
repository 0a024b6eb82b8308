"""Equations of state: functions at a point, with the pressure linear in the specific energy, P = A(ρ) + B(ρ) e, the base class
of the data models, and isentropic columns of fluid at rest under gravity: dp/ds = ρ g along the depth s.

In a column, with dp = c² dρ and de = p/ρ² dρ, the density and the specific energy follow from d(ln ρ)/ds = g/c² and de/ds =
p g/(ρ c²) (Batchelor 1967, An Introduction to Fluid Dynamics, section 1.4, for a fluid of uniform entropy).
"""

from abc import abstractmethod
from math import exp, inf
from typing import Any

import numpy as np

from pellucid.jit import generic
from pellucid.materials.law import Law
from pellucid.model import Model


@generic
def pressure_line(eos: Any, density: float) -> tuple[float, float]:
    """Return A(ρ) [Pa] and B(ρ) [kg/m³] at a density ρ [kg/m³], which define the pressure P = A + B e as a function of the
    specific energy e."""


@generic
def lowest_pressure(eos: Any) -> float:
    """Return the smallest possible pressure [Pa] of the equation of state `eos`, below which the fluid separates; -inf if
    the fluid carries any tension."""


def any_tension(eos):
    """Return -inf, as implementation of `lowest_pressure` for a fluid that carries any tension."""
    return -inf


def limited_tension(eos):
    """Return the parameter `p_min` [Pa], as implementation of `lowest_pressure` for a law with this parameter."""
    return eos.p_min


@generic
def sound_speed(eos: Any, density: float, energy: float) -> float:
    """Return the adiabatic sound speed [m/s] at a density [kg/m³] and a specific energy [J/kg]."""


class EquationOfStateModel(Model):
    """Base of equations of state: user's parameters and law. A new one is a subclass with its own `kind`."""

    kind: str

    @abstractmethod
    def law(self, density: float, pressure: float) -> Law:
        """Return the equation of state, as a NamedTuple of its parameters for the kernels, for a fluid with this initial
        density [kg/m³] and pressure [Pa]."""


RELATIVE, ABSOLUTE = 1e-11, 1e-14  # of a step of the integration; ln ρ of a stiff liquid hardly changes
SLOWEST = 1e-3  # of the sound speed at the level: there the column ends, as an adiabatic atmosphere does at its top


class ColumnEnds(ValueError):
    """Raised if the fluid has no state at a requested depth.

    depth: the last depth with a state [m].
    """

    def __init__(self, depth: float, reason: str) -> None:
        super().__init__(reason)
        self.depth = depth  # [m], the last at which it has one


def states_at_rest(eos: Law, density: float, energy: float, gravity: float, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the densities [kg/m³] and specific energies [J/kg], each of shape (n,), of an isentropic fluid column at rest
    under gravity, at depths [m], shape (n,), in any order.

    eos: equation of state; density, energy: values at depth 0; gravity: magnitude [m/s²]. Depths are negative above this
    level. Raises ColumnEnds if there is no state at a depth.

    """
    found = np.empty((2, len(depth)))
    for side in (depth >= 0.0, depth < 0.0):
        if side.any():
            found[:, side] = _one_way(eos, density, energy, gravity, depth[side])
    return density * np.exp(found[0]), found[1]


def _one_way(eos: Law, density: float, energy: float, gravity: float, depth: np.ndarray) -> np.ndarray:
    """Return ln ρ/ρ₀ and the specific energy [J/kg], shape (2, n), at depths [m], shape (n,), that are all positive or all
    negative. eos: equation of state; density, energy: ρ₀ [kg/m³] and specific energy [J/kg] at depth 0; gravity: magnitude
    [m/s²]."""
    from scipy.integrate import solve_ivp  # models of cases stay light without it

    speed = sound_speed(eos, density, energy)
    slowest = SLOWEST * speed
    rounding = 1e-12 * density * speed**2

    def surplus(log_density: float, e: float) -> float:
        A, B = pressure_line(eos, density * exp(log_density))
        return A + B * e - lowest_pressure(eos)

    def slope(_: float, state: np.ndarray) -> tuple[float, float]:
        x, e = state
        rho = density * exp(x)
        A, B = pressure_line(eos, rho)
        # beyond the end of the column, where the integration only looks for it, the slope stays finite
        rate = gravity / max(sound_speed(eos, rho, e), slowest) ** 2
        return rate, (A + B * e) / rho * rate

    def pulls_apart(_: float, state: np.ndarray) -> float:
        return min(surplus(*state) + rounding, 1e300)

    def ends(_: float, state: np.ndarray) -> float:
        return sound_speed(eos, density * exp(state[0]), state[1]) - slowest

    for event in (pulls_apart, ends):
        event.terminal = True  # type: ignore[attr-defined]
    last = float(depth[np.argmax(np.abs(depth))])
    if last == 0.0:
        return np.tile([[0.0], [energy]], len(depth))
    limits = (ABSOLUTE, ABSOLUTE * max(abs(energy), speed**2))
    found: Any = solve_ivp(
        slope,
        (0.0, last),
        (0.0, energy),
        method="DOP853",
        rtol=RELATIVE,
        atol=limits,
        dense_output=True,
        events=(pulls_apart, ends),
    )
    if found.status == 1:
        which = 0 if len(found.t_events[0]) else 1
        reason = ("its pressure falls to its smallest possible value", "its density falls to zero")[which]
        raise ColumnEnds(float(found.t_events[which][0]), reason)
    if found.status != 0:
        raise ColumnEnds(float(found.t[-1]), "its equation of state has no state at rest")
    return np.asarray(found.sol(depth))
