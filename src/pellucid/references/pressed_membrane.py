"""Spherical membrane filled with liquid and compressed between two smooth rigid plates.

The values are interpolated in a table from `validation/cells-oocyte-between-plates`: a compressible neo-Hookean sheet with
a Poisson's ratio of 0.49, stretched by 2 % at the start. The displacement is counted for one plate from first contact. The
plates touch the faces of the sheet, half a thickness away from its mid-surface.
"""

from typing import NamedTuple

import numpy as np

from pellucid.references.finite_elements import read

POISSON_RATIO, INFLATION = 0.49, 0.02


class PressedSphere(NamedTuple):
    """A spherical membrane filled with liquid, inflated and then compressed between two plates: Young's modulus [Pa], and
    thickness and radius [m] of the inflated sphere before compression. The methods return reference values."""

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
