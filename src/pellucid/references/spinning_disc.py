"""Linear elastic disc in plane strain, unstressed at rest, that suddenly starts to spin.

In the rotating frame a radial load ρω²r appears at t = 0. The disc oscillates radially (breathes) about its static state:
u(r,t) = u_s(r) - Σ c_n J₁(k_n r) cos(ω_n t), ω_n = k_n sqrt((λ+2μ)/ρ), with k_n from the free rim. Valid for small strains,
(ωR)² ρ/E << 1.
"""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import j0, j1

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.materials.elastic import ElasticMaterial
from pellucid.references.annotations import Array, Case


@dataclass(frozen=True)
class SpinningDisc:
    """A disc that suddenly starts to spin, the reference of a case: radius [m], elastic constants, density [kg/m³], angular
    velocity [rad/s], and number of radial modes in the sum."""

    radius: float  # R [m]
    density: float  # ρ [kg/m³]
    young_modulus: float  # E [Pa]
    poisson_ratio: float
    angular_velocity: float  # ω [rad/s]
    modes: int = 20  # number of radial modes in the sum

    @classmethod
    def of(cls, case: Case) -> "SpinningDisc":
        """Build the disc of a case with one body, a cylinder along z."""
        body = case.body[0]
        cylinder = body.shape.cylinder if isinstance(body, MaterialPointsCase) else None
        material: object = body.material
        if not isinstance(body, MaterialPointsCase) or cylinder is None or not isinstance(material, ElasticMaterial):
            raise ValueError(f"body {body.name!r} must be an elastic cylinder")
        return cls(cylinder.radius, material.density, material.young_modulus, material.poisson_ratio, body.angular_velocity[2])

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's λ and μ [Pa]."""
        mu = 0.5 * self.young_modulus / (1.0 + self.poisson_ratio)
        return 2.0 * mu * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio), mu

    @cached_property
    def _static(self) -> tuple[float, float]:
        """Coefficients a and b of the static displacement u_s = a r - b r³, which balances the centrifugal force with a
        free rim."""
        lam, mu = self.lame
        b = self.density * self.angular_velocity**2 / (8.0 * (lam + 2.0 * mu))
        return b * self.radius**2 * (2.0 * lam + 3.0 * mu) / (lam + mu), b

    @cached_property
    def breathing(self) -> tuple[Array, Array, Array]:
        """Return the wave numbers k_n [rad/m], amplitudes c_n [m] and angular frequencies ω_n [rad/s] of the radial
        vibration modes."""
        lam, mu = self.lame
        modulus = lam + 2.0 * mu

        def rim_stress(z: float) -> float:  # σ_rr at the rim for u = J1(kr), z = kR, times R
            return modulus * z * float(j0(z)) - 2.0 * mu * float(j1(z))

        grid = np.linspace(0.5, np.pi * (self.modes + 1.5), 80 * (self.modes + 2))
        values = [rim_stress(z) for z in grid]
        roots = [
            brentq(rim_stress, low, high, xtol=1e-13)
            for low, high, f, g in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True)
            if f * g < 0.0
        ][: self.modes]
        k = np.array(roots) / self.radius
        a, b = self._static

        def share(q: float) -> float:
            """Return the coefficient [m] of the mode J₁(qr) in the expansion of the static displacement; q: wave number
            [rad/m]."""
            overlap = quad(lambda r: r * (a * r - b * r**3) * float(j1(q * r)), 0.0, self.radius, limit=400)[0]
            return float(overlap / quad(lambda r: r * float(j1(q * r)) ** 2, 0.0, self.radius, limit=400)[0])

        amplitude = np.array([share(q) for q in k])
        return k, amplitude, k * sqrt(modulus / self.density)

    def displacement(self, r: ArrayLike, time: float) -> Array:
        """Return the radial displacement [m] at radii r [m] and a time [s]."""
        a, b = self._static
        r = np.asarray(r, dtype=float)
        k, c, w = self.breathing
        return np.asarray(a * r - b * r**3 - np.sum(c * np.cos(w * time) * j1(k * r[..., None]), axis=-1))

    def stresses(self, r: ArrayLike, time: float | None = None) -> tuple[Array, Array]:
        """Return radial and hoop stress [Pa] at radii r > 0 [m] and a time [s]; without a time, the stresses of the static
        state (without oscillation)."""
        a, b = self._static
        r = np.asarray(r, dtype=float)
        stretch, hoop = a - 3.0 * b * r**2, a - b * r**2
        if time is not None:
            k, c, w = self.breathing
            swing, kr = c * np.cos(w * time), k * r[..., None]
            stretch = stretch - np.sum(swing * (k * j0(kr) - j1(kr) / r[..., None]), axis=-1)
            hoop = hoop - np.sum(swing * j1(kr) / r[..., None], axis=-1)
        lam, mu = self.lame
        bulk = lam * (stretch + hoop)
        return np.asarray(bulk + 2.0 * mu * stretch), np.asarray(bulk + 2.0 * mu * hoop)

    def mean_stress(self, times: ArrayLike) -> Array:
        """Return the mean over the disc of σxx + σyy [Pa] at times [s]: 4 (λ+μ) u(R)/R, by Gauss's theorem."""
        lam, mu = self.lame
        instants = np.atleast_1d(np.asarray(times, dtype=float))
        rim = np.array([float(self.displacement(self.radius, t)) for t in instants])
        return 4.0 * (lam + mu) * rim / self.radius

    @property
    def static_mean_stress(self) -> float:
        """Mean of σxx + σyy [Pa] in the static state; by the virial theorem ρω²R²/2 (twice the kinetic energy)."""
        return 0.5 * self.density * (self.angular_velocity * self.radius) ** 2
