"""Exact motions and shapes of fluid films: circles, spheres, tethers, shapes of vesicles.

A circle of film of radius R(t) with the viscosities μ and λ and the surface pressure p = a (ρ - ρ₀) at the density ρ grows
by (2μ+λ) R' = P R² + a(ρ - ρ₀) R with ρR constant, a sphere by 2(μ+λ) R' = P R²/2 + a(ρ - ρ₀) R with ρR² constant (Benet
2015, eqs. 6.67 and 7.48, with the follower load P; a dead load per unit initial area is P ρ/ρ(0)).
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


class Growing(NamedTuple):
    """A circle or sphere of fluid film that grows or shrinks, with the surface pressure a (ρ - ρ₀) at the areal density ρ."""

    sphere: bool  # True for a sphere, False for a circle
    radius: float  # initial radius [m]
    density: float  # initial areal density [kg/m²]
    rest_density: float  # ρ₀, areal density without surface pressure [kg/m²]
    stiffness: float  # a, coefficient of the equation of state [N m/kg]
    viscosity: float  # μ, shear viscosity [N s/m]
    dilatational_viscosity: float  # λ [N s/m]
    pressure: float = 0.0  # P, inner pressure [Pa]
    dead: bool = False  # True for a load per unit initial area, False for a follower load

    def densities(self, radius: np.ndarray) -> np.ndarray:
        """Return the density ρ [kg/m²] at radii [m]."""
        return np.asarray(self.density * (self.radius / radius) ** (2 if self.sphere else 1))

    def speed(self, radius: np.ndarray) -> np.ndarray:
        """Return the radial velocity R' [m/s] at radii [m]."""
        density = self.densities(radius)
        pressure = self.pressure * (density / self.density if self.dead else 1.0)
        within = self.stiffness * (density - self.rest_density) * radius
        if self.sphere:
            return np.asarray((0.5 * pressure * radius**2 + within) / (2.0 * (self.viscosity + self.dilatational_viscosity)))
        return np.asarray((pressure * radius**2 + within) / (2.0 * self.viscosity + self.dilatational_viscosity))

    def radii(self, times: np.ndarray) -> np.ndarray:
        """Return the radius R [m] at ascending times [s] from 0, accurate to ten digits."""
        end = max(float(times[-1]), 1e-300)
        found = solve_ivp(lambda t, r: self.speed(r), (0.0, end), [self.radius], "DOP853", times, rtol=1e-11, atol=1e-13)
        return np.asarray(found.y[0])


class Tether(NamedTuple):
    """A tether (a tube of film that a force pulls out of a film under tension): force [N] and radius [m]."""

    force: float  # force along the tube [N]
    radius: float  # radius of the tube [m]


def tether(tension: float, rigidity: float, pressure: float = 0.0) -> Tether:
    """Return force and radius of a tether for tension σ [N/m], bending rigidity κ [J] and pressure P inside [Pa].

    Across a tube σ/r - κ/(2r³) = P, along it F = 2πrσ + πκ/r - πr²P; with P = 0, F = 2π√(2κσ) and r = √(κ/2σ) (Derényi,
    Jülicher & Prost 2002).
    """
    thin = sqrt(rigidity / (2.0 * tension))
    r = thin
    if pressure > 0.0:
        r = brentq(lambda r: tension / r - rigidity / (2.0 * r**3) - pressure, 0.5 * thin, 1.7 * thin, xtol=1e-14)
    return Tether(2.0 * pi * r * tension + pi * rigidity / r - pi * r * r * pressure, r)


SHAPE_ENERGIES = {
    ("prolate", 0.95): 1.09556,
    ("prolate", 0.90): 1.18964,
    ("prolate", 0.80): 1.38744,
    ("prolate", 0.70): 1.64327,
    ("prolate", 0.65): 1.82793,
    ("oblate", 0.80): 1.45254,
    ("oblate", 0.65): 1.82623,
    ("oblate", 0.60): 1.95568,
    ("stomatocyte", 0.59): 1.979,
}
"""Bending energy, divided by 8πκ, of vesicles without spontaneous curvature, by branch and reduced volume. From numerical
solutions of the shape equations (of Seifert, Berndl & Lipowsky 1991, Phys. Rev. A 44, 1182), accurate to five digits
(`validation/benet2015-vesicle-shapes`), for the stomatocyte to three."""


def curve_mode_rate(waves: int, pressure: float, rigidity: float, drag: float, radius: float) -> float:
    """Return the decay rate [1/s] of a small disturbance of the radius with n waves around a circle of inextensible film, with
    the same drag in all directions.

    ω = S/(ζ (1 + 1/n²)), S = (n² - 1)(P/R + κ (n² - 1)/R⁴) with the radius R [m], the inner pressure P [Pa], the bending
    rigidity κ [J/m] and the drag ζ [Pa s/m]. Linear theory: r = R + u cos nφ causes the normal force -S u, and without stretch
    the tangential velocity is 1/n of the normal velocity. Errors are of the order of (u/R)².
    """
    square = waves * waves
    stiffness = (square - 1) * (pressure / radius + rigidity * (square - 1) / radius**4)
    return stiffness / (drag * (1.0 + 1.0 / square))


def sphere_mode_rate(degree: int, rigidity: float, viscosity: float, dilatational: float, radius: float) -> float:
    """Return the decay rate [1/s] of a small disturbance of the radius of a spherical film, a spherical harmonic of degree l,
    without drag, tension and pressure.

    ω = κ L ((2μ + λ) L - 2μ)/(4μ (μ + λ) R⁴), L = l (l + 1), with the bending rigidity κ [J], the viscosities μ, λ
    (dilatational) [N s/m] and the radius R [m] (linear theory). Errors are of the order of the amplitude divided by R.
    """
    L = degree * (degree + 1)
    drag = 4.0 * viscosity * (viscosity + dilatational) * radius**4
    return rigidity * L * ((2.0 * viscosity + dilatational) * L - 2.0 * viscosity) / drag
