"""Fields at the nodes of a film for the results: positions, velocities, masses, and averages of element fields."""

import numpy as np

from pellucid.bodies.fluid_film.forms.film_forces import FilmForces, in_space
from pellucid.bodies.fluid_film.forms.virtual_power import bending_energies
from pellucid.bodies.fluid_film.surfaces.operators import Operators

FIELDS = ("id", "position", "velocity", "mass", "areal_density", "tension", "curvature", "distance")


class NodalFields:
    """Computes nodal fields of a fluid film for the stored results. forces: forces and densities of the film; arrays:
    arrays of the film, of which `position`, `velocity` and `mass` are updated here; is_around: True for a surface of
    revolution."""

    def __init__(self, forces: FilmForces, arrays: dict[str, np.ndarray], is_around: bool) -> None:
        self._forces, self._arrays, self._is_around = forces, arrays, is_around
        cells = forces.geometry.cells()
        self._corners = cells.lines if len(cells.lines) else cells.triangles

    def show(self, o: Operators) -> None:
        """Update the positions [m], velocities [m/s] and masses [kg] at the nodes in the results. o: geometry of the film at
        its present positions.
        """
        arrays, geometry = self._arrays, self._forces.geometry
        arrays["position"][:] = in_space(geometry.places(arrays["x"]), geometry.axes)
        self.show_velocities(arrays["v"])
        density = self._forces.at_points(self._forces.densities(o, arrays["part_mass"]))
        arrays["mass"][:] = self._shared(o.area * density)

    def show_velocities(self, v: np.ndarray) -> None:
        """Update the velocities of the film at its nodes. v: velocities of the nodes (of a Loop surface: control points) [m/s],
        shape (n, d)."""
        geometry = self._forces.geometry
        self._arrays["velocity"][:] = in_space(geometry.places(v), geometry.axes)

    def field(self, name: str) -> np.ndarray:
        """Return the field of this name at the nodes; fields of elements are averaged by area over the elements around each
        node.
        """
        arrays, forces = self._arrays, self._forces
        if name == "kinetic_energy":
            return np.zeros(len(arrays["mass"]))
        if name in arrays:
            return arrays[name]
        if name == "distance":
            return self._distances()
        o = forces.geometry.operators(arrays["x"])
        if name == "curvature":
            return self._at_nodes(o.area, o.curvature)
        if name == "bending_energy":
            return self._shared(bending_energies(o, forces.physics))
        density = forces.densities(o, arrays["part_mass"])
        if name == "areal_density":
            return self._at_nodes(o.area, forces.at_points(density))
        if name == "tension":
            return self._at_nodes(o.area, forces.at_points(-forces.material.pressure(density)))
        raise KeyError(name)

    def areas(self, o: Operators) -> np.ndarray:
        """Return the area of the film that belongs to each node [m²], shape (n,). o: geometry of the film at its present
        positions.
        """
        return self._shared(o.area)

    def _distances(self) -> np.ndarray:
        """Return the distances of the nodes from the centre of mass [m]; for a surface of revolution the centre is on the
        axis."""
        places, mass = self._forces.geometry.places(self._arrays["x"]), self._arrays["mass"]
        centre = mass @ places / float(mass.sum())
        if self._is_around:
            centre[0] = 0.0
        return np.asarray(np.linalg.norm(places - centre, axis=1))

    def _shared(self, of_points: np.ndarray) -> np.ndarray:
        """Distribute values at the quadrature points of the elements, `of_points`, shape (e, q), equally among the corners of
        each element, and return the sums at the nodes, shape (n,).
        """
        corners = self._corners
        share = np.repeat(of_points.sum(axis=1) / corners.shape[1], corners.shape[1])
        return np.bincount(corners.ravel(), share, len(self._arrays["mass"]))

    def _at_nodes(self, area: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the area-weighted averages at the nodes, shape (n,), of values at the quadrature points.

        area: areas of the quadrature points [m²]; values: any quantity there; shape (e, q) both.
        """
        return np.asarray(self._shared(area * values) / self._shared(area))
