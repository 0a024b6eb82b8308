"""A sphere of membrane filled with liquid and pressed between two smooth rigid plates.

The values are those of a table that `validation/cells-oocyte-between-plates` writes: a compressible neo-Hookean sheet with a
Poisson's ratio of 0.49, stretched by 2 % at the start. The displacement is that of one plate from first touch on. The faces of
the sheet touch; they stay half a thickness away from its mid-surface.
"""

from typing import NamedTuple

import numpy as np

from pellucid.references.finite_elements import read

POISSON_RATIO, INFLATION = 0.49, 0.02


class PressedSphere(NamedTuple):
    """Young's modulus [Pa]; thickness and radius [m] at the start, when the sheet is stretched by the inflation."""

    young_modulus: float
    thickness: float
    radius: float

    def force(self, displacement: float) -> float:
        """Force on one plate [N]."""
        return self._interpolate("force", displacement) * self.young_modulus * self.thickness * self.radius

    def pressure(self, displacement: float) -> float:
        """Pressure of the liquid above that outside [Pa]."""
        return self._interpolate("pressure", displacement) * self.young_modulus * self.thickness / self.radius

    def equator(self, displacement: float) -> float:
        """Radius of the widest circle of the mid-surface [m]."""
        return self._interpolate("equator", displacement) * self.radius

    def _interpolate(self, name: str, displacement: float) -> float:
        """Raises ValueError outside of the table."""
        from scipy.interpolate import PchipInterpolator

        table = read("pressed_membrane")
        known, last = table["displacement"], float(table["displacement"][-1])
        if not 0.0 <= displacement <= last * self.radius:
            raise ValueError(f"a displacement of {displacement:g} m is not between 0 and {last:g} radii")
        return float(PchipInterpolator(known, table[name])(np.float64(displacement / self.radius)))
