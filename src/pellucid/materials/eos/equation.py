"""Equations of state: functions at a point, with the pressure linear in the specific energy, P = A(ρ) + B(ρ) e, and the
base class of the data models."""

from abc import abstractmethod
from math import inf
from typing import Any

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
