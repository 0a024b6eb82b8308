"""Equations of state: their functions at a point, all linear in the energy, P = A(ρ) + B(ρ) e, and the base of their models."""

from abc import abstractmethod
from math import inf
from typing import Any

from pellucid.jit import generic
from pellucid.materials.law import Law
from pellucid.model import Model


@generic
def pressure_line(eos: Any, density: float) -> tuple[float, float]:
    """A(ρ) [Pa] and B(ρ) [kg/m³] of P = A + B e."""


@generic
def lowest_pressure(eos: Any) -> float:
    """The pressure below which the fluid pulls apart [Pa]; -inf where it bears any tension."""


def any_tension(eos):
    """`lowest_pressure` of a fluid that never pulls apart."""
    return -inf


def limited_tension(eos):
    """`lowest_pressure` of a law that holds it."""
    return eos.p_min


@generic
def sound_speed(eos: Any, density: float, energy: float) -> float:
    """Adiabatic sound speed [m/s]."""


class EquationOfStateModel(Model):
    """An equation of state: the user's parameters, and its law. A new one is a subclass with a `kind` of its own."""

    kind: str

    @abstractmethod
    def law(self, density: float, pressure: float) -> Law:
        """The law as kernels take it, of a fluid with this density [kg/m³] and pressure [Pa] at the start."""
