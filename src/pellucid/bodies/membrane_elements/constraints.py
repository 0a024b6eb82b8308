"""Penalty springs on the area of a membrane and on the volume that it encloses.

The energies of the whole membrane are k_A (A - A₀)²/2A₀ and k_V (V - V₀)²/2V₀, with the initial values A₀ and V₀. They
correspond to a uniform tension k_A (A - A₀)/A₀ and a pressure -k_V (V - V₀)/V₀ inside. Source: Fedosov, Caswell &
Karniadakis 2010, Biophys. J. 98, 2215, eq. 4, which also has local penalties. The largest eigenfrequency ω of a spring k (Q
- Q₀)²/2Q₀ between nodes of masses m belongs to its only mode, ∂Q/∂x: ω² = k/Q₀ Σ |∂Q/∂x|²/m.
"""

from math import hypot, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements.mesh import ElementMesh
from pellucid.geometry.meshes.enclosure import signed_volume
from pellucid.step.limit import NO_LIMIT, StepLimit

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.surface import ElementSurface


class Kept(NamedTuple):
    """Penalty on the change of a quantity Q of the whole membrane, its area or enclosed volume. A volume is negative if the
    normals point inwards.
    """

    stiffness: float  # k [N/m] for the area, [Pa] for the volume
    initial: float  # Q₀ [m²] or [m³]

    def force(self, value: float) -> float:
        """Return k (Q - Q₀)/|Q₀| for the present value Q, with stiffness k and initial value Q₀: a tension [N/m] for the area,
        a pressure [Pa] for the volume."""
        return self.stiffness * (value - self.initial) / abs(self.initial)

    def energy(self, value: float) -> float:
        """Return the energy of the penalty spring on area or volume, k (Q - Q₀)²/2|Q₀| [J], for the present value Q, with
        stiffness k and initial value Q₀.
        """
        return 0.5 * self.force(value) * (value - self.initial)

    def eigenvalue(self, slope: np.ndarray, mass: np.ndarray) -> float:
        """Return the squared eigenfrequency ω² of the nodes on the penalty spring of area or volume Q [1/s²].

        slope: derivatives ∂Q/∂x with respect to the nodal positions, shape (n, 3) [m] for the area, [m²] for the volume; mass:
        nodal masses [kg], shape (n,).
        """
        return self.stiffness / abs(self.initial) * float((np.einsum("ni,ni->n", slope, slope) / mass).sum())


class Swings(NamedTuple):
    """Half the eigenfrequencies [1/s] of the oscillations of the nodes on the penalty springs of area and of volume, each
    alone; 0 if there is no such spring."""

    area: float = 0.0  # [1/s]
    volume: float = 0.0  # [1/s]

    @property
    def rate(self) -> float:
        """Upper bound of half the largest eigenfrequency of the nodes on both penalty springs (area and volume) [1/s]."""
        return hypot(self.area, self.volume)

    def limit(self) -> StepLimit:
        """Return the largest stable time step for the oscillations of the nodes on the penalty springs of area and volume, and
        which of the two springs limits it.
        """
        if self.rate <= 0.0:
            return NO_LIMIT
        what = "volume" if self.volume > self.area else "area"
        text = (
            f"it oscillates on its {what} penalty, which limits the step to "
            f"{1.0 / self.rate:.3g} s; a smaller {what}_stiffness allows longer"
        )
        return StepLimit(1.0 / self.rate, "spring", f"{text} steps")


class Constraints(NamedTuple):
    """Penalty springs on area and enclosed volume of a membrane of triangles; a spring with the stiffness 0 is off."""

    area: Kept  # penalty on the total area
    volume: Kept  # penalty on the enclosed volume

    @classmethod
    def of(cls, area_stiffness: float, volume_stiffness: float, mesh: ElementMesh, vertices: np.ndarray) -> "Constraints":
        """Build the penalties from their stiffnesses, k_A [N/m] and k_V [Pa], and the initial mesh. vertices: initial nodal
        positions [m], shape (n, 3).
        """
        volume = signed_volume(vertices, mesh.corners[:, :3]) if volume_stiffness else 1.0
        return cls(Kept(area_stiffness, float(mesh.areas(vertices).sum())), Kept(volume_stiffness, volume))

    def add_forces(self, surface: "ElementSurface", position: np.ndarray, target: np.ndarray) -> None:
        """Add the nodal forces of both penalties [N] to `target`, shape (n, 3).

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        area, volume, growth, outwards = self._measured(surface, position)
        if self.area.stiffness > 0.0:
            target -= self.area.force(area) * growth
        if self.volume.stiffness > 0.0:
            target -= self.volume.force(volume) * outwards

    def tensions(self, surface: "ElementSurface", position: np.ndarray) -> tuple[float, float]:
        """Return the tension of the penalty on the area [N/m], and minus the pressure of that on the volume [Pa].

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        area, volume, _, _ = self._measured(surface, position)
        return self.area.force(area), self.volume.force(volume)

    def springs(self, surface: "ElementSurface", position: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Return for each penalty its stiffness k/|Q₀| and the derivatives ∂Q/∂x of its quantity Q, shape (n, 3): the stiffness
        of the nodes is k/|Q₀| ∂Q/∂x ∂Q/∂x, besides that of its tension or pressure.

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        kept = zip((self.area, self.volume), surface.slopes(position), strict=True)
        return [(each.stiffness / abs(each.initial), slope) for each, slope in kept if each.stiffness > 0.0]

    def energy_and_swings(self, surface: "ElementSurface", position: np.ndarray) -> tuple[float, Swings]:
        """Return the stored energy of both penalties [J] and half the eigenfrequencies of the nodes on their springs [1/s].

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        area, volume, growth, outwards = self._measured(surface, position)
        swings = self.swings(growth, outwards, surface.node_mass[surface.number])
        return self.area.energy(area) + self.volume.energy(volume), swings

    def swings(self, growth: np.ndarray, outwards: np.ndarray, mass: np.ndarray) -> Swings:
        """Return half the angular eigenfrequencies of the nodes on the penalty springs of area and volume [1/s], which limit
        the step.

        growth, outwards: derivatives of area [m] and enclosed volume [m²] with respect to the nodal positions, shape (n, 3);
        mass: nodal masses [kg], shape (n,).
        """
        return Swings(0.5 * sqrt(self.area.eigenvalue(growth, mass)), 0.5 * sqrt(self.volume.eigenvalue(outwards, mass)))

    def drifts(self, surface: "ElementSurface", position: np.ndarray) -> dict[str, float]:
        """Return the relative changes of area and enclosed volume since the start, by name, for the quantities with a penalty.

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        area, volume, _, _ = self._measured(surface, position)
        drifts = {"area_drift": (self.area, area), "volume_drift": (self.volume, volume)}
        return {name: value / kept.initial - 1.0 for name, (kept, value) in drifts.items() if kept.stiffness > 0.0}

    def _measured(self, surface: "ElementSurface", position: np.ndarray) -> tuple[float, float, np.ndarray, np.ndarray]:
        """Return the area [m²], the enclosed volume [m³], and their derivatives with respect to the nodal positions [m], [m²],
        shape (n, 3).

        surface: elements of the membrane; position: nodal positions in storage order [m], shape (n, 3).
        """
        growth, outwards = surface.slopes(position)
        # both are homogeneous functions of the positions, of the second and the third degree
        about = position - position.mean(axis=0)
        area, volume = 0.5 * np.einsum("ni,ni", growth, about), np.einsum("ni,ni", outwards, about) / 3.0
        return float(area), float(volume), growth, outwards


def slopes_of(mesh: ElementMesh, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of area [m] and enclosed volume [m²] with respect to the nodal positions, shape (n, 3) each, for
    a mesh of triangles with nodes at these positions [m], shape (n, 3). Computes the same values as the kernels of a run, but
    without compilation.
    """
    corners = position[mesh.corners[:, :3]]
    chi, psi = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(chi, psi)
    unit = normal / np.linalg.norm(normal, axis=1)[:, None]
    at_b, at_c = 0.5 * np.cross(psi, unit), 0.5 * np.cross(unit, chi)
    growth = np.zeros_like(position)
    for corner, slope in zip(mesh.corners.T, (-at_b - at_c, at_b, at_c), strict=False):
        np.add.at(growth, corner, slope)
    return growth, mesh.at_nodes(0.5 * normal)
