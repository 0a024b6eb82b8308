"""Base class of the materials of membranes in plane stress."""

from abc import abstractmethod

import numpy as np

from pellucid.materials.contract import BodyMaterial
from pellucid.materials.damage import Elastodamage, Undamaged
from pellucid.materials.law import Law
from pellucid.registry import Family


class MembraneMaterial(BodyMaterial):
    """Base of membrane materials. A new one is a subclass with its own `kind`."""

    @abstractmethod
    def law(self, thickness: float) -> Law:
        """Return the material law, as a NamedTuple of its parameters for the kernels, for a membrane of this thickness at
        rest [m]."""

    @abstractmethod
    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves at the start [m/s]. The thickness [m] matters only for
        surface moduli."""

    @property
    def plane_poisson_ratio(self) -> float:
        """In-plane Poisson's ratio in the initial state; 1 for a film that resists only changes of its area."""
        pressure, shear = self.wave_speeds()
        return 1.0 - 2.0 * (shear / pressure) ** 2 if pressure > 0.0 else 1.0

    @property
    def direction(self) -> np.ndarray | None:
        """Direction whose projection onto the surface is the first initial axis of anisotropic laws, shape (3,); None if the
        axes are arbitrary."""
        return None

    def damage_law(self) -> Elastodamage | Undamaged:
        """Return the damage law, as a NamedTuple of its parameters for the kernels; `Undamaged` without damage."""
        return Undamaged()

    @property
    def damage_radius(self) -> float | None:
        """Radius over which the strain that drives damage is averaged [m]; None for the strain at the point, or without
        damage."""
        return None

    def recoverable_energy(self, shape: np.ndarray) -> np.ndarray | None:
        """Return the energy per unit mass that points with given in-plane shapes, (n, 4), can give back [J/kg], shape (n,);
        None if all energy is recoverable, or if losses are recorded."""
        return None


MEMBRANE_MATERIALS = Family("material of a membrane", MembraneMaterial)
"""Kinds that a case can name, registered in `pellucid.materials`."""
