"""Springs that keep the area of a membrane, and the volume that it encloses, near those at the start.

Energies k_A (A - A₀)²/2A₀ and k_V (V - V₀)²/2V₀ of the whole membrane: an even tension k_A (A - A₀)/A₀ in its surface and a
pressure -k_V (V - V₀)/V₀ behind it. Source: Fedosov, Caswell & Karniadakis 2010, Biophys. J. 98, 2215, eq. 4, which has them
beside local ones.

The largest eigenfrequency that a spring k (Q - Q₀)²/2Q₀ gives nodes of masses m is that of its only mode, ∂Q/∂x:
ω² = k/Q₀ Σ |∂Q/∂x|²/m.
"""

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements import geometry
from pellucid.bodies.membrane_elements.mesh import ElementMesh
from pellucid.geometry.algorithms.enclosure import signed_volume
from pellucid.jit.loops import parallel_loop

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.model import MembraneElementsCase
    from pellucid.bodies.membrane_elements.surface import ElementSurface

CHUNK = 512


class Kept(NamedTuple):
    """A quantity of the whole membrane that a spring keeps; a volume is negative where normals point inwards."""

    stiffness: float
    initial: float

    def force(self, value: float) -> float:
        """k (Q - Q₀)/|Q₀|."""
        return self.stiffness * (value - self.initial) / abs(self.initial)

    def energy(self, value: float) -> float:
        """k (Q - Q₀)²/2|Q₀| [J]."""
        return 0.5 * self.force(value) * (value - self.initial)

    def eigenvalue(self, slope: np.ndarray, mass: np.ndarray) -> float:
        """ω² [1/s²] for the slopes ∂Q/∂x of the nodes, shape (n, 3), and their masses [kg], shape (n,)."""
        return self.stiffness / abs(self.initial) * float((np.einsum("ni,ni->n", slope, slope) / mass).sum())


class Constraints(NamedTuple):
    """What is kept of a membrane of triangles; a stiffness of 0 keeps nothing."""

    area: Kept
    volume: Kept

    @classmethod
    def of(cls, case: "MembraneElementsCase", mesh: ElementMesh, vertices: np.ndarray) -> "Constraints":
        """Those of a case, from its mesh at the start."""
        volume = signed_volume(vertices, mesh.corners[:, :3]) if case.volume_stiffness else 1.0
        return cls(Kept(case.area_stiffness, float(mesh.areas(vertices).sum())), Kept(case.volume_stiffness, volume))

    def add_forces(self, surface: "ElementSurface", position: np.ndarray, target: np.ndarray) -> None:
        """Add the forces of both at the nodes [N], shape (n, 3), for nodes at these positions [m], as they are stored."""
        area, volume, growth, outwards = self._measured(surface, position)
        if self.area.stiffness > 0.0:
            target -= self.area.force(area) * growth
        if self.volume.stiffness > 0.0:
            target -= self.volume.force(volume) * outwards

    def energy_and_rate(self, surface: "ElementSurface", position: np.ndarray) -> tuple[float, float]:
        """What both have stored [J], and half the largest eigenfrequency that they give the nodes [1/s], or more."""
        area, volume, growth, outwards = self._measured(surface, position)
        mass = surface.node_mass[surface.number]
        rate = 0.5 * sqrt(self.area.eigenvalue(growth, mass) + self.volume.eigenvalue(outwards, mass))
        return self.area.energy(area) + self.volume.energy(volume), rate

    def drifts(self, surface: "ElementSurface", position: np.ndarray) -> dict[str, float]:
        """How far area and volume, where they are kept, are from those at the start, over these."""
        area, volume, _, _ = self._measured(surface, position)
        drifts = {"area_drift": (self.area, area), "volume_drift": (self.volume, volume)}
        return {name: value / kept.initial - 1.0 for name, (kept, value) in drifts.items() if kept.stiffness > 0.0}

    def _measured(self, surface: "ElementSurface", position: np.ndarray) -> tuple[float, float, np.ndarray, np.ndarray]:
        """Area [m²] and volume [m³], and their slopes with the positions of the nodes, shape (n, 3)."""
        growth, outwards = surface.area_slopes(position), surface.vector_areas(position)
        # both are homogeneous functions of the positions, of the second and the third degree
        about = position - position.mean(axis=0)
        area, volume = 0.5 * np.einsum("ni,ni", growth, about), np.einsum("ni,ni", outwards, about) / 3.0
        return float(area), float(volume), growth, outwards


@parallel_loop()
def area_slopes(chunk, corners, x, slopes):
    """∂A/∂x at the corners of each triangle [m], shape (m, 4, 3); corners: their nodes, shape (m, 4), the last one idle."""
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(corners))):
        chi, psi = geometry.edges(x, corners, e)
        at_b, at_c = geometry.area_slopes(chi, psi)
        for d in range(3):
            slopes[e, 1, d], slopes[e, 2, d] = at_b[d], at_c[d]
            slopes[e, 0, d] = -(at_b[d] + at_c[d])
