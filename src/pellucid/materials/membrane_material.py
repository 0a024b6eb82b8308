"""The interface of materials of membranes in plane stress, whatever their law."""

from abc import abstractmethod

import numpy as np

from pellucid.materials.contract import BodyMaterial
from pellucid.materials.damage import Elastodamage, Undamaged
from pellucid.materials.law import Law
from pellucid.registry import Family


class MembraneMaterial(BodyMaterial):
    """A material of membranes. A new one is a subclass with its own `kind`."""

    @abstractmethod
    def law(self, thickness: float) -> Law:
        """The law as kernels take it, of a membrane of this thickness at rest [m]."""

    @abstractmethod
    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves at the start [m/s]. The thickness [m] matters only for
        surface moduli."""

    @property
    def plane_poisson_ratio(self) -> float:
        """Poisson's ratio in the plane at the start: 1 of a film that resists changes of its area alone."""
        pressure, shear = self.wave_speeds()
        return 1.0 - 2.0 * (shear / pressure) ** 2 if pressure > 0.0 else 1.0

    @property
    def direction(self) -> np.ndarray | None:
        """Along which, seen on the surface, the first of the axes at rest lies, shape (3,); None where any will do."""
        return None

    def damage_law(self) -> Elastodamage | Undamaged:
        """The law of damage as kernels take it."""
        return Undamaged()

    @property
    def damage_radius(self) -> float | None:
        """Over which damage follows a mean of the strain [m]; none where it follows that at the point, or never."""
        return None

    def recoverable_energy(self, shape: np.ndarray) -> np.ndarray | None:
        """Return the recoverable energy of points with these in-plane shapes, (n, 4), [J/kg], shape (n,); None if all
        energy is recoverable, or if losses are recorded."""
        return None


MEMBRANE_MATERIALS = Family("material of a membrane", MembraneMaterial)
"""The kinds that a case can name: the list is in `pellucid.materials`."""
