"""Nodal forces of a film, computed from its density, bending, viscosity and surface tractions."""

from collections.abc import Sequence

import numpy as np

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, NodalSums, SharedRows
from pellucid.bodies.fluid_film.forms.virtual_power import FilmPhysics, Forms, Tension, bending_energies, forms
from pellucid.bodies.fluid_film.surfaces.contract import FilmGeometry
from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.materials.lipid_film import LipidFilm
from pellucid.parts.surface_load import SurfacePoints, Traction


class FilmForces:
    """Computes the nodal forces of a film.

    geometry: interpolation between the nodes; material: equation of state of the film; physics: viscosities, bending rigidity
    and drag; initial_density: surface density at the start [kg/m²]. The mass of the film is given for its parts [kg], shape
    (parts,); a part is the piece of the film that belongs to a node or an element.
    """

    def __init__(self, geometry: FilmGeometry, material: LipidFilm, physics: FilmPhysics, initial_density: float) -> None:
        self.initial_density = initial_density
        self.geometry, self.material, self.physics = geometry, material, physics
        self._sums = NodalSums(geometry.nodes, *geometry.held.shape)

    def part_areas(self, o: Operators) -> np.ndarray:
        """Return the areas of the parts of the film [m²], shape (parts,). o: operators of the film at the present positions."""
        shares = self.geometry.shares
        areas = np.einsum("eq,qc->ec", o.area, shares.share)
        return np.bincount(shares.part.ravel(), areas.ravel())

    def densities(self, o: Operators, mass: np.ndarray) -> np.ndarray:
        """Return the surface densities of the parts of the film [kg/m²], shape (parts,).

        o: operators of the film at the present positions; mass: masses of the parts [kg], shape (parts,).
        """
        return np.asarray(mass / self.part_areas(o))

    def at_points(self, parts: np.ndarray) -> np.ndarray:
        """Interpolate values of the parts of the film, shape (parts,), to the quadrature points of its elements, shape (e,
        q).
        """
        shares = self.geometry.shares
        return np.asarray(parts[shares.part] @ shares.share.T)

    def stored_energy(self, o: Operators, mass: np.ndarray) -> float:
        """Return the energy of compression and bending of the film [J].

        o: operators of the film at the present positions; mass: masses of its parts [kg], shape (parts,).
        """
        compressed = float(np.sum(mass * self.material.stored_energy(self.densities(o, mass))))
        return compressed + float(bending_energies(o, self.physics).sum())

    def forms(self, o: Operators, mass: np.ndarray, ahead: float) -> Forms:
        """Return resistance, stiffness and forces of the film's elements (see `Forms`).

        o: operators of the film at the present positions; mass: masses of its parts [kg]; ahead: time over which pressure,
        tension and curvature are assumed to change with the motion [s]; the stiffness is the resistance due to these
        changes.
        """
        density = self.densities(o, mass)
        pressure, stiffness = self.material.pressure(density), density * self.material.pressure_slope(density)
        return forms(o, self.physics, Tension(self.at_points(pressure), self.at_points(stiffness)), ahead)

    def internal_force(self, o: Operators, mass: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return the internal force on the nodes [N], shape (n, d): viscous and elastic forces, and drag.

        o: operators of the film at the present positions; mass: masses of its parts [kg]; velocity: nodal velocities [m/s],
        shape (n, d).
        """
        parts = self.forms(o, mass, 0.0)
        return np.asarray(self._sums.gathered(parts.force) - self._sums.gathered(self._felt(parts.resistance, velocity)))

    def _felt(self, squares: Sequence[ElementRows | SharedRows], velocity: np.ndarray) -> list[ElementRows]:
        """Return the forces with which viscosity, drag or stiffness oppose nodal velocities [m/s], shape (n, d), as linear
        forms whose sums at the nodes are forces [N]. squares: the resistance or stiffness, written as a sum of squares of
        linear forms.
        """
        whole = (square.of_components(velocity.shape[1]) for square in squares)
        return [ElementRows(square.rows, square.factor * self._sums.rates(square, velocity)) for square in whole]

    def traction_force(self, o: Operators, mass: np.ndarray, traction: Traction, after: float) -> np.ndarray:
        """Return the nodal forces of a traction (force per unit area) [N], shape (n, d).

        o: operators of the film at the present positions; mass: masses of its parts [kg]; after: time since the start of the
        step of the run [s].
        """
        axes = list(self.geometry.axes)
        ratio = self.at_points(self.densities(o, mass)) / self.initial_density
        points = SurfacePoints(in_space(o.position, axes), in_space(o.normal, axes), ratio)
        on_area = o.area[..., None] * traction(points, after)[..., axes]
        return self._sums.summed(np.einsum("eqd,eqmd->emd", on_area, o.value))

    def vector_areas(self, o: Operators) -> np.ndarray:
        """Return ∫ N_I n dA around each node I [m²], shape (n, d), with its shape function N_I and the outward normal n of the
        film.

        o: operators of the film at the present positions.
        """
        return self._sums.summed(o.volume_rate().sum(axis=1))


def in_space(vectors: np.ndarray, axes: Sequence[int]) -> np.ndarray:
    """Return vectors with d components along `axes` as vectors in space, shape (..., 3); the other components are 0."""
    result = np.zeros((*vectors.shape[:-1], 3))
    result[..., list(axes)] = vectors
    return result
