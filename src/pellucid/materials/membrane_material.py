"""The interface of materials of membranes in plane stress, whatever their law."""

from abc import abstractmethod

import numpy as np

from pellucid.materials.contract import BodyMaterial
from pellucid.materials.damage import Elastodamage, Undamaged
from pellucid.materials.law import Law
from pellucid.materials.membrane import initial_shape, plane_diffusivity, wave_in_shape
from pellucid.registry import Family


class MembraneMaterial(BodyMaterial):
    """A material of membranes. A new one is a subclass with its own `kind`."""

    @abstractmethod
    def law(self) -> Law:
        """The law as kernels take it."""

    def damage_law(self) -> Elastodamage | Undamaged:
        """The law of damage as kernels take it."""
        return Undamaged()

    @property
    def damage_radius(self) -> float | None:
        """Over which damage follows a mean of the strain [m]; none where it follows that at the point, or never."""
        return None

    def recoverable_energy(self, shape: np.ndarray) -> np.ndarray | None:
        """What points of in-plane shapes, (n, 4), can give back of the work of their stress [J/kg], shape (n,); None where
        that is all, or damage tells."""
        return None

    def signals(self, length: float) -> tuple[float, float]:
        """Speed of waves in the plane [m/s] and kinematic viscosity [m²/s] at the start, in cells of the given length [m]."""
        law, density = self.law(), self.density
        return wave_in_shape(law, initial_shape(law), density), plane_diffusivity(law, initial_shape(law), density)


MEMBRANE_MATERIALS = Family("material of a membrane", MembraneMaterial)
"""The kinds that a case can name: the list is in `pellucid.materials`."""
