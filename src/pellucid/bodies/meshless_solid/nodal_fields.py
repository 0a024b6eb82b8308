"""Fields of a meshless solid at its nodes, as results show them."""

from typing import Any

import numpy as np

from pellucid.bodies.meshless_solid.forces import CELLS, Solid
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.materials.law import cauchy_stress, energy, volumetric_energy, volumetric_stress
from pellucid.tensors import determinant

MOTION = ("id", "position", "velocity", "mass")
FIELDS = (*MOTION, "density", "pressure", "stress", "strain_energy")


@kernel(inner=True)
def _fields_block(block, solid, stress, stored):
    blocks, nq, averaged = solid.blocks, len(solid.shares), len(solid.block_volume) > 0
    start = blocks.first[block]
    for cell in range(CELLS * block, min(CELLS * (block + 1), len(solid.weights))):
        stored[cell] = 0.0
        for k in range(6):
            stress[cell, k] = 0.0
        for q in range(nq):
            F = solid.deformation[cell, q]
            F = (F[0], F[1], F[2], F[3], F[4], F[5], F[6], F[7], F[8])
            s = cauchy_stress(solid.law, F)
            stored[cell] += solid.weights[cell] * energy(solid.law, F)
            extra = 0.0
            if averaged:
                J = determinant(F)
                stored[cell] -= solid.weights[cell] * volumetric_energy(solid.law, J)
                extra -= volumetric_stress(solid.law, J)
                for corner in range(4):
                    extra += solid.shares[q, corner] * solid.mean_stress[blocks.nodes[start + solid.corners[cell, corner]]]
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
        ratio = solid.volume_ratio if len(solid.block_volume) else _mean(mesh, solid, np.linalg.det(_deformation(solid)))
        return density / ratio
    stress, stored = np.zeros((len(mesh.cells), 6)), np.zeros(len(mesh.cells))
    _fields(len(solid.sums), Bundle(solid), stress, stored)
    if name in ("strain_energy", "stored_energy"):
        energies = np.bincount(mesh.cells.ravel(), np.repeat(stored, 4) / 4.0, len(mesh.nodes))
        if len(solid.block_volume):
            energies += solid.volume * np.array([volumetric_energy(law, J) for J in solid.volume_ratio.tolist()])
        about = np.bincount(mesh.cells.ravel(), np.repeat(mesh.volumes, 4) / 4.0, len(mesh.nodes))
        return energies if name == "stored_energy" else energies / (density * about)
    components = np.stack([_mean(mesh, solid, stress[:, k]) for k in range(6)], axis=1)
    return -components[:, :3].mean(axis=1) if name == "pressure" else components


def _deformation(solid: Solid) -> np.ndarray:
    return solid.deformation.mean(axis=1).reshape(-1, 3, 3)


def _mean(mesh: SimplexMesh, solid: Solid, of_cells: np.ndarray) -> np.ndarray:
    """The mean of a quantity of the cells about each node by their volumes, shape (n,)."""
    corners, volumes = mesh.cells.ravel(), np.repeat(mesh.volumes, 4)
    sums = np.bincount(corners, np.repeat(of_cells, 4) * volumes, len(mesh.nodes))
    return np.asarray(sums / np.bincount(corners, volumes, len(mesh.nodes)))
