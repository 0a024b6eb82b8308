"""Flows and diffusion: the collapse of a column of water, drops in a shear flow, diffusing concentrations."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from math import exp, sqrt

import numpy as np
from numpy.typing import ArrayLike

from pellucid.references import Array, Case


def martin_moyce(quantity: str) -> tuple[Array, Array]:
    """Return times and values of a measured curve, shape (n,) each, for n² = 2: `front` (times T = n t sqrt(g/a), front Z =
    x/a) or `height` (times tau = t sqrt(g/a), height at the wall H = y/(n² a)).

    a: initial width of the column, n²: ratio of its height to its width. The start of the flow could not be observed in the
    experiment: each series is shifted in time so that all agree at Z = 1.44.
    """
    text = files("pellucid.references").joinpath("martin_moyce_1952.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    pairs = np.array([(float(row["time"]), float(row["value"])) for row in rows if row["quantity"] == quantity])
    return pairs[:, 0], pairs[:, 1]


@dataclass(frozen=True)
class Column:
    """A water column that collapses at a wall: initial width and height [m], and gravity [m/s²], which convert times and
    lengths of a run to the dimensionless numbers of the measurements (`martin_moyce`)."""

    width: float  # initial width a [m]
    height: float  # initial height [m]
    gravity: float  # g [m/s²]

    @classmethod
    def of(cls, case: Case) -> "Column":
        """Build the column of a case whose first body is a box, with gravity along -y."""
        lower, upper = case.body[0].bounds()
        return cls(float(upper[0] - lower[0]), float(upper[1] - lower[1]), -case.gravity[1])

    @property
    def aspect(self) -> float:
        """n², the ratio of the initial height to the initial width of the column."""
        return self.height / self.width

    def front_time(self, time: ArrayLike) -> Array:
        """Return the dimensionless times T = n t sqrt(g/a) of times t [s]."""
        return np.asarray(time, dtype=float) * sqrt(self.aspect * self.gravity / self.width)

    def height_time(self, time: ArrayLike) -> Array:
        """Return the dimensionless times tau = t sqrt(g/a) of times t [s]."""
        return np.asarray(time, dtype=float) * sqrt(self.gravity / self.width)

    def ritter(self, time: ArrayLike) -> Array:
        """Return the front position x/a = 1 + 2T of a frictionless thin sheet (shallow water) at times [s], an upper bound for
        all columns; T: dimensionless time of `front_time`."""
        return 1.0 + 2.0 * self.front_time(time)


SHAPIRA_HABER = 5.6996  # in the middle between the plates


def drop_deformation(capillary: float, ratio: float, confinement: float = 0.0) -> float:
    """Return Taylor's deformation (L - B)/(L + B) of a drop in a steady shear flow; L and B: largest and smallest diameter.

    capillary: viscosity of the outer fluid times shear rate times radius, divided by surface tension. ratio: viscosity of
    the drop divided by the viscosity of the outer fluid. confinement: radius divided by the distance of two plates; the
    drop is midway between them.
    Taylor 1934, Proc. R. Soc. Lond. A 146, 501, with the rotation of the drop by Cox 1969, J. Fluid Mech. 37, 601, eq. 5.5,
    and the plates by Shapira & Haber 1990, Int. J. Multiphase Flow 16, 305.
    """
    small = capillary * (19.0 * ratio + 16.0) / (16.0 * ratio + 16.0) / sqrt(1.0 + (0.95 * ratio * capillary) ** 2)
    return small * (1.0 + SHAPIRA_HABER * (1.0 + 2.5 * ratio) / (1.0 + ratio) * confinement**3)


def drop_approach(capillary: float, ratio: float, strain: float) -> float:
    """Return the deformation (L - B)/(L + B) of an initially spherical drop after a strain (shear rate times time), as a
    share of the steady deformation, without inertia.

    capillary: viscosity of the outer fluid times shear rate times radius, divided by surface tension. ratio: viscosity of
    the drop divided by the viscosity of the outer fluid. The relaxation rate of an ellipsoid is used: Rallison 1984, Annu.
    Rev. Fluid Mech. 16, 45.
    """
    rate = 40.0 * (ratio + 1.0) / ((2.0 * ratio + 3.0) * (19.0 * ratio + 16.0)) / capillary
    return 1.0 - exp(-rate * strain)


TERMS = 200


def between_zero_ends(start: Callable[[Array], Array], length: float, spread: float, x: Array) -> Array:
    """Return the concentration at positions x [m] on a bar from 0 to `length` [m] with the initial concentration `start`.

    spread: diffusivity times time [m²]. Fourier series of Benet 2015, eq. 4.38, with integrals by Gauss quadrature;
    accurate to round-off once the highest term has decayed.
    """
    wave = np.arange(1, TERMS + 1) * np.pi / length
    points, weights = np.polynomial.legendre.leggauss(10)  # in as many parts as the highest wave has half-waves
    y = (length / TERMS * (np.arange(TERMS)[:, None] + 0.5 * (points + 1.0))).ravel()
    parts = np.sin(np.outer(wave, y)) @ (np.tile(weights, TERMS) * start(y)) / TERMS
    return np.sin(np.outer(x, wave)) @ (parts * np.exp(-(wave**2) * spread))


def harmonic_decay(degree: int, radius: float, diffusivity: float) -> float:
    """Return the decay rate of the concentration of a spherical harmonic of degree l on a sphere, l (l + 1) D/R² [1/s], with
    the radius R [m] and the diffusivity D [m²/s]."""
    return degree * (degree + 1) * diffusivity / radius**2
