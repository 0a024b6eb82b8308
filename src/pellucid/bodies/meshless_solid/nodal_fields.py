"""Fields of a meshless solid at its nodes, as results show them."""

from typing import Any

import numpy as np

from pellucid.bodies.meshless_solid.forces import Solid
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.materials.law import cauchy_stress, energy

FIELDS = ("id", "position", "velocity", "mass", "density", "pressure", "stress", "strain_energy", "kinetic_energy")


def nodal_field(name: str, mesh: SimplexMesh, solid: Solid, law: Any, density: float) -> np.ndarray:
    """Density [kg/m³], Cauchy stress, pressure [Pa], or strain energy of unit mass [J/kg], of F averaged about the nodes."""
    F = _average(mesh, solid)
    J = np.linalg.det(F)
    if name == "density":
        return density / J
    points = [tuple(point.ravel().tolist()) for point in F]
    if name == "strain_energy":
        return np.array([energy(law, point) for point in points]) / density
    stress = np.array([cauchy_stress(law, point) for point in points])
    return -stress[:, :3].mean(axis=1) if name == "pressure" else stress


def _average(mesh: SimplexMesh, solid: Solid) -> np.ndarray:
    """The mean deformation gradient of the cells about each node by their volumes, shape (n, 3, 3)."""
    n = len(mesh.nodes)
    whole = solid.weights * len(solid.shares)
    of_cells = solid.deformation.mean(axis=1) * whole[:, None]
    corners = mesh.cells.ravel()
    volume = np.bincount(corners, np.repeat(whole, 4), n)
    sums = np.stack([np.bincount(corners, np.repeat(of_cells[:, k], 4), n) for k in range(9)], axis=1)
    return np.asarray((sums / volume[:, None]).reshape(n, 3, 3))
