"""What every law answers, pointwise: kernels and plain Python call the same functions.

A law is a NamedTuple of numbers; the state of a point under it is a NamedTuple too (`FluidState`, `HypoelasticState`, ...),
and every state has a `stress` (Cauchy, 6-tuple xx, yy, zz, yz, xz, xy) [Pa].
"""

from typing import Any

from pellucid.jit import generic
from pellucid.tensors import Tensor

AT_REST = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@generic
def update(law: Any, state: Any, density: float, L: Tensor, dt: float, length: float) -> Any:
    """The state after a step dt [s] with velocity gradient L [1/s].

    density: at the end of the step [kg/m³]; length: that of a grid cell [m], for artificial viscosity.
    """


@generic
def volume_growth(law: Any, L: Tensor, dt: float) -> float:
    """Volume after the step over volume before, consistent with what the law makes of L."""


@generic
def signal_speed(law: Any, state: Any, density: float, L: Tensor, length: float) -> float:
    """Fastest signal relative to the material [m/s], artificial viscosity included: it bounds the step."""


@generic
def diffusivity(law: Any, density: float) -> float:
    """Kinematic viscosity (2μ + λ)/ρ of plane waves [m²/s]."""


@generic
def stored_energy(law: Any, state: Any, density: float) -> float:
    """Internal or strain energy of unit mass [J/kg]."""


@generic
def artificial_heating(law: Any, state: Any, density: float, L: Tensor, length: float) -> float:
    """Power of the artificial viscosity on unit mass [W/kg]; part of the internal energy's rate, recorded apart."""
