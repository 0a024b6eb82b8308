"""Pressures in a membrane of elements that depend on the enclosed volume, at trial positions of its nodes."""

import numpy as np

from pellucid.bodies.membrane_elements.surface import ElementSurface
from pellucid.parts.elastic_system import VolumePressure

DIFFERENCE = 1e-4  # displacement for a difference of volumes, over the shortest edge
OF_LIDS = 1e-5  # part of the change of a volume that is no error of the difference


class EnclosedPressures:
    """The pressures in a membrane that depend on its enclosed volume. Positions of nodes [m] have the shape (n, 3); a share is
    0 for the loads of the last equilibrium, 1 for those of the equilibrium that is sought."""

    def __init__(self, surface: ElementSurface) -> None:
        self._surface = surface
        self.all: list[VolumePressure] = []

    def depends_on_lids(self, one: VolumePressure, position: np.ndarray, free: np.ndarray) -> bool:
        """Return True if lids over the rims of an open membrane change their volume with displacements of free components, so
        that the pressure on the membrane alone is not its derivative. free: mask of these components, shape (n, 3)."""
        direction = np.where(free, np.random.default_rng(0).standard_normal(position.shape), 0.0)
        step = DIFFERENCE * self._surface.shortest_edge()
        ahead, behind = (self.volume(one, position + way * step * direction) for way in (1.0, -1.0))
        outwards = self.outwards(one, position)
        wrong = (ahead - behind) / (2.0 * step) - float(np.sum(outwards * direction))
        return abs(wrong) > OF_LIDS * float(np.abs(outwards * direction).sum())

    def outwards(self, one: VolumePressure, position: np.ndarray) -> np.ndarray:
        """Return the derivatives of the volume with respect to the positions of the nodes [m²], shape (n, 3)."""
        return one.sign * self._surface.slopes(position)[1]

    def volume(self, one: VolumePressure, position: np.ndarray) -> float:
        """Return the enclosed volume [m³]."""
        order = np.argsort(self._surface.number)
        return one.measure(position[order], self._surface.slopes(position)[1][order])

    def at(self, position: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the potential of all pressures [J] and their forces on the nodes [N], shape (n, 3)."""
        energy, force = 0.0, np.zeros_like(position)
        for one in self.all:
            content = one.at(self.volume(one, position), 1.0)
            energy += content.energy
            force += content.pressure * self.outwards(one, position)
        return energy, force

    def force(self, one: VolumePressure, position: np.ndarray, share: float) -> np.ndarray:
        """Return the forces of one pressure on the nodes [N], shape (n, 3)."""
        return one.at(self.volume(one, position), share).pressure * self.outwards(one, position)

    def pressure_growth(self, one: VolumePressure, position: np.ndarray) -> float:
        """Return the growth of a pressure from share 0 to 1 in the same volume [Pa]."""
        volume = self.volume(one, position)
        return one.at(volume, 1.0).pressure - one.at(volume, 0.0).pressure

    def growth(self, position: np.ndarray) -> np.ndarray:
        """Return the growth of the forces on the nodes from share 0 to 1 with the nodes held [N], shape (n, 3)."""
        grown = np.zeros_like(position)
        for one in self.all:
            grown += self.pressure_growth(one, position) * self.outwards(one, position)
        return grown

    def along_normals(self, position: np.ndarray, share: float) -> float:
        """Return the sum of the pressures along the normals of the membrane [Pa]."""
        return sum(one.sign * one.at(self.volume(one, position), share).pressure for one in self.all)

    def springs(self, position: np.ndarray, share: float) -> list[tuple[float, np.ndarray]]:
        """Return the stiffness -dp/dV of each pressure [Pa/m³] and the derivatives of its volume [m²], shape (n, 3)."""
        stiff = ((one.at(self.volume(one, position), share).stiffness, one) for one in self.all)
        return [(stiffness, self.outwards(one, position)) for stiffness, one in stiff if stiffness > 0.0]
