"""Strong explosions: the similarity solution for energy released at a point or on a line in a cold ideal gas.

The shock is at R = (E t²/(α ρ₀))^(1/(n+2)) in n dimensions. Behind it u = Ṙ U(ξ), ρ = ρ₀ G(ξ), p = ρ₀ Ṙ² P(ξ) with ξ = r/R.
Source: L. I. Sedov, Similarity and Dimensional Methods in Mechanics (1959), chapter IV; G. I. Taylor, Proc. R. Soc. A 201
(1950) 159-174. Here the balances of mass, momentum, entropy and energy are integrated from the shock inwards.
"""

from dataclasses import dataclass
from functools import cache
from math import pi
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from pellucid.references.annotations import Array

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.geometry.shapes.contract import Geometry

INNERMOST = 1e-3  # ξ, within which there is less than 1e-12 of the mass and 1e-5 of the energy, which is added
MEASURE = {1: 2.0, 2: 2.0 * pi, 3: 4.0 * pi}  # of the unit sphere's surface; of a plane, on both its sides


@dataclass(frozen=True)
class Similarity:
    """The self-similar solution of an explosion: the energy constant α, and profiles along ξ = r/R (radius over shock
    radius)."""

    alpha: float  # α
    xi: Array  # (n,) ξ, ascending from INNERMOST to 1
    velocity: Array  # (n,) dimensionless velocity U
    density: Array  # (n,) dimensionless density G
    pressure: Array  # (n,) dimensionless pressure P


@cache
def similarity(dimensions: int, gamma: float) -> Similarity:
    """Compute the self-similar solution of a plane (1), cylindrical (2) or spherical (3) explosion in a gas with the ratio γ of
    specific heats."""
    from scipy.integrate import solve_ivp

    n = dimensions
    slowing = -0.5 * n  # R R̈/Ṙ² where R grows as t^(2/(n+2))

    def slope(x: float, state: Array) -> list[float]:
        """Return the derivatives with respect to ln ξ of the dimensionless velocity U, the logarithms of density G and
        pressure P, and the enclosed energy."""
        xi, U, G, P = np.exp(x), state[0], np.exp(state[1]), np.exp(state[2])
        w = U - xi
        # w ln G' + U' = -(n-1) U/ξ;  w U' + P/G ln P' = -slowing U;  ln P' - γ ln G' = -2 slowing/w
        system = np.array([[1.0, w, 0.0], [w, 0.0, P / G], [0.0, -gamma, 1.0]])
        dU, dG, dP = np.linalg.solve(system, [-(n - 1) * U / xi, -slowing * U, -2.0 * slowing / w])
        energy = (0.5 * G * U**2 + P / (gamma - 1.0)) * xi ** (n - 1)
        return [xi * dU, xi * dG, xi * dP, xi * energy]

    shock = [2.0 / (gamma + 1.0), np.log((gamma + 1.0) / (gamma - 1.0)), np.log(2.0 / (gamma + 1.0)), 0.0]
    # even in r about the front, where density changes fastest
    xi = np.linspace(1.0, INNERMOST, 20001)
    found = solve_ivp(slope, (0.0, np.log(INNERMOST)), shock, method="DOP853", rtol=1e-11, atol=1e-13, t_eval=np.log(xi))
    U, log_density, log_pressure, energy = found.y[:, ::-1]
    pressure = np.exp(log_pressure)
    within = -energy[0] + pressure[0] / (gamma - 1.0) * INNERMOST**n / n  # at the centre the pressure is even
    alpha = MEASURE[n] * (2.0 / (n + 2.0)) ** 2 * within
    return Similarity(float(alpha), xi[::-1], U, np.exp(log_density), pressure)


@dataclass(frozen=True)
class Blast:
    """An explosion in a cold ideal gas, the reference of a case: number of dimensions, released energy [J; J/m for a line],
    density [kg/m³] and ratio of specific heats of the gas."""

    dimensions: int  # 1 plane, 2 cylindrical, 3 spherical
    energy: float  # released energy [J; J/m for a line]
    density: float  # density of the cold gas [kg/m³]
    gamma: float  # γ, ratio of specific heats

    @classmethod
    def of(cls, case: "Case") -> "Blast":
        """Build the blast of a case. The first body must be the hot gas, a cylinder or ball that may be cut by planes of
        symmetry; the second body is the cold gas."""
        hot, cold = case.body
        x, y, z = (not thin for thin in case.thin)
        active, material = (x, y, z), cast(Any, hot.material)
        energy = cast("Geometry", hot.occupied()).measure(active) * material.pressure / (material.eos.gamma - 1.0)
        return cls(sum(active), energy, cold.material.density, material.eos.gamma)

    def radius(self, time: Any) -> Array:
        """Return the radius of the shock [m] at times [s] of any shape."""
        n = self.dimensions
        alpha = similarity(n, self.gamma).alpha
        return np.asarray((self.energy * np.square(time) / (alpha * self.density)) ** (1.0 / (n + 2)))

    def at(self, radius: Array, time: float) -> dict[str, Array]:
        """Return density [kg/m³], radial velocity [m/s] and pressure [Pa] by name at radii [m] of any shape and a time [s]; the
        gas ahead of the shock is at rest with zero pressure."""
        front = float(self.radius(time))
        speed = 2.0 / (self.dimensions + 2.0) * front / time
        profiles, xi = similarity(self.dimensions, self.gamma), radius / front
        inside = {"density": (self.density, profiles.density), "velocity": (speed, profiles.velocity)}
        inside["pressure"] = (self.density * speed**2, profiles.pressure)
        outside = {"density": self.density, "velocity": 0.0, "pressure": 0.0}
        return {
            name: np.where(xi <= 1.0, scale * np.interp(xi, profiles.xi, values), outside[name])
            for name, (scale, values) in inside.items()
        }
