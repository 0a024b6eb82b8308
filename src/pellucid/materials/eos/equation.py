"""The functions of an equation of state at a point. All of ours are linear in the specific energy: P = A(ρ) + B(ρ) e."""

from typing import Any

from pellucid.jit import generic


@generic
def pressure_line(eos: Any, density: float) -> tuple[float, float]:
    """A(ρ) [Pa] and B(ρ) [kg/m³] of P = A + B e."""


@generic
def lowest_pressure(eos: Any) -> float:
    """The pressure below which the fluid pulls apart [Pa]; -inf where it bears any tension."""


@generic
def sound_speed(eos: Any, density: float, energy: float) -> float:
    """Adiabatic sound speed [m/s]."""
