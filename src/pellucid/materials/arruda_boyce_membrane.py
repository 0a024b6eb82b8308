"""Arruda-Boyce surface, W = μ Σ_k c_k (I^k - 3^k)/n^(k-1), c = 1/2, 1/20, 11/1050, 19/7000, 519/673750: chains of n links.

I = λ₁² + λ₂² + (λ₁λ₂)⁻². The law uses the first five terms of the series of the inverse Langevin function, so the chains do
not lock at any stretch. μ is not the shear modulus at rest: G = 2μ Σ_k k c_k (3/n)^(k-1), K = 3G. Source: Arruda & Boyce
1993, J. Mech. Phys. Solids 41, 389, eq. 16.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function, pointwise
from pellucid.materials.derivatives import partial_derivatives
from pellucid.materials.surface_law import incompressible, invariant_excess, stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter

C1, C2, C3, C4, C5 = 1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673750.0


@incompressible
class ArrudaBoyceSurface(NamedTuple):
    """Parameters of the Arruda-Boyce law: modulus μ [N/m] and the number n of links of a chain."""

    mu: float
    n: float


class ArrudaBoyceMembraneMaterial(SurfaceMembraneMaterial):
    """Arruda-Boyce surface, chains of n links that stiffen as they straighten, for rubber and the zona pellucida; at rest
    G = 1.0851 μ for n = 8, 1.2923 μ for n = 3, and K = 3G."""

    kind: Literal["arruda-boyce-membrane"] = "arruda-boyce-membrane"
    rubber_modulus: float = parameter("N/m", "rubber modulus μ, smaller than the shear modulus at rest", gt=0)
    links: float = parameter("", "number n of links in a chain; the material stiffens near the stretch √n", ge=1)

    def elastic_law(self) -> ArrudaBoyceSurface:
        return ArrudaBoyceSurface(self.rubber_modulus, self.links)


@point_function(stretch_energy, ArrudaBoyceSurface)
def _energy(law, a, b):
    return law.mu * _series(invariant_excess(a, b), 1.0 / law.n)


@pointwise
def _series(excess: float, inverse: float) -> float:
    """Return W/μ from I - 3 and 1/n."""
    # with x = I/n and y = 3/n: I^k - 3^k over n^(k-1) is (I - 3) (x^(k-1) + x^(k-2) y + ... + y^(k-1))
    x, y = inverse * (3.0 + excess), inverse * 3.0
    s2 = x + y
    s3 = x * s2 + y * y
    s4 = x * s3 + y * y * y
    s5 = x * s4 + y * y * y * y
    return excess * (C1 + C2 * s2 + C3 * s3 + C4 * s4 + C5 * s5)


@partial_derivatives(_series)
def _series_slope(excess, inverse):
    x = inverse * (3.0 + excess)
    return (C1 + x * (2.0 * C2 + x * (3.0 * C3 + x * (4.0 * C4 + x * 5.0 * C5))),)
