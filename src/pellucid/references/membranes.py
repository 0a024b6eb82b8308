"""Membranes and vesicles: bags under pressure, a pressed sphere, growth, tethers and relaxation of vesicles."""

from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize

from pellucid.references.finite_elements import read

PAPER_BAG = 0.2055
"""Volume of the inextensible flat bag, divided by the cube of its side."""
SIDE, HEIGHT, POISSON_RATIO_OF_BAG = 1.0, 0.1, 0.3


def bag_at_rest(pressure: float) -> dict[str, float]:
    """Return `volume` [m³], `height` [m] (half of the full height), `half_width` [m] in the middle of an edge and at a
    `corner`, for a bag with unit side.

    pressure: p/(E t) [1/m], with the pressure p, Young's modulus E and the thickness t. Raises ValueError outside the range
    of the table, 0.01 to 0.1 per metre.

    The table is for the domed bag of `lian2014/airbag`, an elastic sheet with Poisson's ratio 0.3 that carries no compression,
    by minimization of its energy: `validation/lian2014-airbag/bag.py`. For the inextensible flat bag, the "paper bag problem",
    the volume below follows from a construction by Andrew Kepert (https://en.wikipedia.org/wiki/Paper_bag_problem); the maximum
    volume is not known exactly.
    """
    table = read("inflated_bag")
    known = table["pressure"]
    if not known[0] <= pressure <= known[-1]:
        raise ValueError(
            f"p/(E t) = {pressure:g}/m is not between {known[0]:g}/m and {known[-1]:g}/m, the range of the reference table"
        )
    return {name: float(np.interp(pressure, known, column)) for name, column in table.items() if name != "pressure"}


POISSON_RATIO, INFLATION = 0.49, 0.02


class PressedSphere(NamedTuple):
    """A spherical membrane filled with liquid, inflated and then compressed between two plates: Young's modulus [Pa], and
    thickness and radius [m] of the inflated sphere before compression. The methods return reference values.

    The values are interpolated in a table from `validation/cells-oocyte-between-plates`: a compressible neo-Hookean sheet with
    a Poisson's ratio of 0.49, stretched by 2 % at the start. The displacement is counted for one plate from first contact. The
    plates touch the faces of the sheet, half a thickness away from its mid-surface.
    """

    young_modulus: float  # [Pa]
    thickness: float  # thickness of the inflated sheet, before compression [m]
    radius: float  # radius of the inflated sphere, before compression [m]

    def force(self, displacement: float) -> float:
        """Return the force [N] on one plate that has moved by `displacement` [m] since first contact."""
        return self._interpolate("force", displacement) * self.young_modulus * self.thickness * self.radius

    def pressure(self, displacement: float) -> float:
        """Return the pressure of the liquid relative to the outside [Pa] when one plate has moved by `displacement` [m] since
        first contact."""
        return self._interpolate("pressure", displacement) * self.young_modulus * self.thickness / self.radius

    def equator(self, displacement: float) -> float:
        """Return the largest radius of the mid-surface [m] when one plate has moved by `displacement` [m] since contact."""
        return self._interpolate("equator", displacement) * self.radius

    def _interpolate(self, name: str, displacement: float) -> float:
        """Return the dimensionless column `name` of the table at the displacement of one plate [m]. Raises ValueError outside
        the table."""
        from scipy.interpolate import PchipInterpolator

        table = read("pressed_membrane")
        known, last = table["displacement"], float(table["displacement"][-1])
        if not 0.0 <= displacement <= last * self.radius:
            raise ValueError(
                f"a displacement of {displacement:g} m is not between 0 and {last:g} radii, the range of the reference table"
            )
        return float(PchipInterpolator(known, table[name])(np.float64(displacement / self.radius)))


CONES = 12
"""Number of cones from pole to equator."""
NEWTON = 30


def least_energy(radius: float, half_width: float, thickness: float, young_modulus: float, poisson_ratio: float) -> float:
    """Return the minimum energy [J] of a spherical skin of a radius [m] and thickness [m] that is filled with incompressible
    liquid and spread to a half width [m].

    The skin is rubber that wrinkles instead of carrying compression (compressible neo-Hookean, plane stress) and is spherical
    at rest. Its meridian is a chain of cones, symmetric about the equator, whose positions minimize the energy at a given
    volume and width. No code is shared with the membranes of the program.
    """
    E, nu, q = young_modulus, poisson_ratio, half_width / radius
    lam, mu = nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu)  # over E
    angle = np.linspace(0.0, 0.5 * np.pi, CONES + 1)
    rim, height = np.sin(angle), np.cos(angle)
    length, middle = np.hypot(np.diff(rim), np.diff(height)), 0.5 * (rim[1:] + rim[:-1])
    area = 2.0 * np.pi * middle * length
    volume = _volume(rim, height)

    def places(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.concatenate([[0.0], x[: CONES - 1], [q]]), np.concatenate([x[CONES - 1 :], [0.0]])

    def energy(x: np.ndarray) -> float:
        r, z = places(x)
        along = np.hypot(np.diff(r), np.diff(z)) / length
        return float(np.sum(area * _density(along, 0.5 * (r[1:] + r[:-1]) / middle, lam, mu)))

    start = np.concatenate([q * rim[1:-1], height[:-1] / q**2])
    same_volume: Any = {"type": "eq", "fun": lambda x: _volume(*places(x)) / volume - 1.0}
    options: Any = {"maxiter": 500, "ftol": 1e-9}
    found = minimize(energy, start, method="SLSQP", constraints=[same_volume], options=options)
    if not found.success:
        raise ValueError(f"no equilibrium shape of the bag was found for a half width of {q:.3g} radii: {found.message}")
    return float(2.0 * E * thickness * radius**2 * found.fun)  # both halves


def _volume(r: np.ndarray, z: np.ndarray) -> float:
    return float(np.sum(np.pi / 3.0 * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2) * (z[:-1] - z[1:])))


def _density(first: np.ndarray, second: np.ndarray, lam: float, mu: float) -> np.ndarray:
    """Return the strain energy per initial volume [J/m³] for two principal stretches in the plane of the skin, minimized over
    wrinkling and the free thickness. lam, mu: Lamé's constants [Pa]."""
    major, minor = np.maximum(np.maximum(first, second), 1.0), np.minimum(first, second)
    minor = np.maximum(minor, np.sqrt(_squared(major, lam, mu, 1.0)))  # the natural width
    third = np.sqrt(_squared(major * minor, lam, mu, 0.5))
    J = np.log(major * minor * third)
    return np.asarray(0.5 * mu * (major**2 + minor**2 + third**2 - 3.0) - mu * J + 0.5 * lam * J**2)


def _squared(stretched: np.ndarray, lam: float, mu: float, power: float) -> np.ndarray:
    """Return the solution c of μ (c - 1) + λ ln(stretched c^power) = 0: the square of the stress-free principal stretches.

    stretched: product of the given stretches. power: 0.5 for one stress-free direction, 1 for two.
    """
    y = np.zeros_like(stretched)
    for _ in range(NEWTON):
        y -= (mu * (np.exp(y) - 1.0) + lam * (np.log(stretched) + power * y)) / (mu * np.exp(y) + lam * power)
    return np.asarray(np.exp(y))


class Growing(NamedTuple):
    """A circle or sphere of fluid film that grows or shrinks, with the surface pressure a (ρ - ρ₀) at the areal density ρ.

    A circle of film of radius R(t) with the viscosities μ and λ and the surface pressure p = a (ρ - ρ₀) at the density ρ grows
    by (2μ+λ) R' = P R² + a(ρ - ρ₀) R with ρR constant, a sphere by 2(μ+λ) R' = P R²/2 + a(ρ - ρ₀) R with ρR² constant (Benet
    2015, eqs. 6.67 and 7.48, with the follower load P; a dead load per unit initial area is P ρ/ρ(0)).
    """

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
