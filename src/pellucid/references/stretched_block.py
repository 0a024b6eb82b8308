"""Neo-Hookean block stretched along one axis with free sides; the state is homogeneous and follows from one equation for
the lateral stretch.

Two energies: "coupled" μ/2 (I₁-3) - μ ln J + λ/2 (ln J)² and "decoupled" μ/2 (J^(-2/3) I₁-3) + κ/2 (J-1)², with I₁ = 2a² +
s² and J = a²s for the stretches s along the axis and a across it.
"""

from math import log
from typing import Literal, NamedTuple


class Stretched(NamedTuple):
    """Homogeneous state of a stretched block with free sides, as `stretched` returns it: lateral stretch, energy per
    initial volume [J/m³] and axial force per initial area [Pa]."""

    lateral: float  # stretch across the axis
    energy: float  # strain energy per initial volume [J/m³]
    stress: float  # axial force per initial area [Pa]


def stretched(form: Literal["coupled", "decoupled"], young_modulus: float, poisson_ratio: float, stretch: float) -> Stretched:
    """Compute the homogeneous state (`Stretched`) of a block with free sides, with Young's modulus [Pa] and Poisson's ratio
    < 0.5, at a stretch along its axis.

    form: strain energy, "coupled": μ/2 (I₁-3) - μ ln J + λ/2 (ln J)², or "decoupled": μ/2 (J^(-2/3) I₁-3) + κ/2 (J-1)².
    """
    mu = young_modulus / (2.0 * (1.0 + poisson_ratio))
    bulk = young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    state = _coupled if form == "coupled" else _decoupled
    low, high = min(1.0, 1.0 / stretch), max(1.0, 1.0 / stretch)  # the lateral stress rises with a between these
    for _ in range(100):
        lateral = 0.5 * (low + high)
        low, high = (lateral, high) if state(mu, bulk, lateral, stretch)[0] < 0.0 else (low, lateral)
    _, energy, stress = state(mu, bulk, lateral, stretch)
    return Stretched(lateral, energy, stress)


def _coupled(mu: float, bulk: float, a: float, s: float) -> tuple[float, float, float]:
    """Return a value with the sign of the lateral stress, the energy per initial volume [J/m³], and the axial force per initial
    area [Pa], for shear and bulk modulus [Pa], lateral stretch a and axial stretch s."""
    lam, ln_J = bulk - 2.0 * mu / 3.0, log(a * a * s)
    energy = 0.5 * mu * (2.0 * a * a + s * s - 3.0) - mu * ln_J + 0.5 * lam * ln_J**2
    return mu * (a * a - 1.0) + lam * ln_J, energy, (mu * (s * s - 1.0) + lam * ln_J) / s


def _decoupled(mu: float, bulk: float, a: float, s: float) -> tuple[float, float, float]:
    """For the decoupled energy, return a value with the sign of the lateral stress, the energy per initial volume [J/m³],
    and the axial force per initial area [Pa]; mu, bulk: shear and bulk modulus [Pa]; a, s: lateral and axial stretch."""
    J, trace = a * a * s, 2.0 * a * a + s * s
    shear, pressure = mu * J ** (-2.0 / 3.0), bulk * (J - 1.0) * J
    energy = 0.5 * (shear * trace - 3.0 * mu) + 0.5 * bulk * (J - 1.0) ** 2
    return shear * (a * a - trace / 3.0) + pressure, energy, (shear * (s * s - trace / 3.0) + pressure) / s
