"""Fields of a meshless solid at its nodes, as results show them."""

from typing import Any

import numpy as np

from pellucid.bodies.meshless_solid.forces import PACKS, Solid, deformation_gradients
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES
from pellucid.materials.law import cauchy_stress, energy, volumetric_energy, volumetric_stress
from pellucid.tensors import determinant

MOTION = ("id", "position", "velocity", "mass")
FIELDS = (*MOTION, "density", "pressure", "stress", "strain_energy")


@kernel(inner=True)
def _fields_block(block, solid, stress, stored):
    corners, nq, averaged = solid.corners, solid.n_points, len(solid.block_volume) > 0
    start = solid.blocks.first[block]
    for point in range(LANES * PACKS * block, min(LANES * PACKS * (block + 1), nq * len(stored))):
        pack, lane, cell = point // LANES, point % LANES, point // nq
        at, w = 9 * LANES * pack + lane, solid.weights[point]
        F = (
            solid.deformation[at],
            solid.deformation[at + LANES],
            solid.deformation[at + 2 * LANES],
            solid.deformation[at + 3 * LANES],
            solid.deformation[at + 4 * LANES],
            solid.deformation[at + 5 * LANES],
            solid.deformation[at + 6 * LANES],
            solid.deformation[at + 7 * LANES],
            solid.deformation[at + 8 * LANES],
        )
        s = cauchy_stress(solid.law, F)
        stored[cell] += w * energy(solid.law, F)
        extra = 0.0
        if averaged:
            J = determinant(F)
            stored[cell] -= w * volumetric_energy(solid.law, J)
            extra -= volumetric_stress(solid.law, J)
            for entry in range(corners.first[pack], corners.first[pack + 1]):
                node = solid.blocks.nodes[start + corners.place[entry] // LANES]
                extra += corners.numbers[LANES * entry + lane] / w * solid.mean_stress[node]
        for k in range(6):
            stress[cell, k] += (s[k] + (extra if k < 3 else 0.0)) / nq


@kernel()
def _fields(n, solid, stress, stored):
    parallel_for(_fields_block, n, solid, stress, stored)


def nodal_field(name: str, mesh: SimplexMesh, solid: Solid, law: Any, density: float) -> np.ndarray:
    """Density [kg/m³], Cauchy stress, pressure [Pa], strain energy of unit mass [J/kg] or of the node [J], `stored_energy`.

    Means over the cells about a node by their volumes; energies are shared out to the corners of the cells.
    """
    if name == "density":
        if len(solid.block_volume):
            return density / solid.volume_ratio
        return density / _mean(mesh, np.linalg.det(deformation_gradients(solid, len(mesh.cells)).mean(axis=1)))
    stress, stored = np.zeros((len(mesh.cells), 6)), np.zeros(len(mesh.cells))
    _fields(len(solid.sums), Bundle(solid), stress, stored)
    if name in ("strain_energy", "stored_energy"):
        energies = np.bincount(mesh.cells.ravel(), np.repeat(stored, 4) / 4.0, len(mesh.nodes))
        if len(solid.block_volume):
            energies += solid.volume * np.array([volumetric_energy(law, J) for J in solid.volume_ratio.tolist()])
        about = np.bincount(mesh.cells.ravel(), np.repeat(mesh.volumes, 4) / 4.0, len(mesh.nodes))
        return energies if name == "stored_energy" else energies / (density * about)
    components = np.stack([_mean(mesh, stress[:, k]) for k in range(6)], axis=1)
    return -components[:, :3].mean(axis=1) if name == "pressure" else components


def _mean(mesh: SimplexMesh, of_cells: np.ndarray) -> np.ndarray:
    """The mean of a quantity of the cells about each node by their volumes, shape (n,)."""
    corners, volumes = mesh.cells.ravel(), np.repeat(mesh.volumes, 4)
    sums = np.bincount(corners, np.repeat(of_cells, 4) * volumes, len(mesh.nodes))
    return np.asarray(sums / np.bincount(corners, volumes, len(mesh.nodes)))
