"""Drops with surface tension in a shear flow without inertia: small deformations, with or without plates."""

from math import exp, sqrt

SHAPIRA_HABER = 5.6996  # in the middle between the plates


def deformation(capillary: float, ratio: float, confinement: float = 0.0) -> float:
    """Return Taylor's deformation (L - B)/(L + B) of a drop in a steady shear flow; L and B: largest and smallest diameter.

    capillary: viscosity of the outer fluid times shear rate times radius, divided by surface tension. ratio: viscosity of
    the drop divided by the viscosity of the outer fluid. confinement: radius divided by the distance of two plates; the
    drop is midway between them.
    Taylor 1934, Proc. R. Soc. Lond. A 146, 501, with the rotation of the drop by Cox 1969, J. Fluid Mech. 37, 601, eq. 5.5,
    and the plates by Shapira & Haber 1990, Int. J. Multiphase Flow 16, 305.
    """
    small = capillary * (19.0 * ratio + 16.0) / (16.0 * ratio + 16.0) / sqrt(1.0 + (0.95 * ratio * capillary) ** 2)
    return small * (1.0 + SHAPIRA_HABER * (1.0 + 2.5 * ratio) / (1.0 + ratio) * confinement**3)


def approach(capillary: float, ratio: float, strain: float) -> float:
    """Return the deformation (L - B)/(L + B) of an initially spherical drop after a strain (shear rate times time), as a
    share of the steady deformation, without inertia.

    capillary: viscosity of the outer fluid times shear rate times radius, divided by surface tension. ratio: viscosity of
    the drop divided by the viscosity of the outer fluid. The relaxation rate of an ellipsoid is used: Rallison 1984, Annu.
    Rev. Fluid Mech. 16, 45.
    """
    rate = 40.0 * (ratio + 1.0) / ((2.0 * ratio + 3.0) * (19.0 * ratio + 16.0)) / capillary
    return 1.0 - exp(-rate * strain)
