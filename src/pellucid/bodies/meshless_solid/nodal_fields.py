"""Fields of a meshless solid at its nodes, for results."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.forces import find_stresses
from pellucid.bodies.meshless_solid.solid import COLUMN, PACKS, STORED, STRESS, WEIGHT, Solid, deformation_gradients
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import kernel, point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES
from pellucid.materials.law import cauchy_stress, energy, volumetric_energy, volumetric_stress
from pellucid.tensors import determinant

MOTION = ("id", "position", "velocity", "mass")
FIELDS = (*MOTION, "density", "pressure", "stress", "strain_energy")
LOST = "dissipated_energy"  # a field of viscous solids


class AtPoints(NamedTuple):
    """Values at the n quadrature points, computed without averaging of volume ratios: Cauchy stress [Pa], shape (n, 6); strain
    energy and, for laws that compute it, dissipated energy per unit reference volume [J/m³], shape (n,).
    """

    stress: np.ndarray  # Cauchy stress
    stored: np.ndarray  # strain energy
    lost: np.ndarray | None = None  # dissipated energy


@kernel(inner=True)
def _deformation(solid, point):
    at = 9 * LANES * (point // LANES) + point % LANES
    return (
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


@parallel_loop()
def _elastic(block, solid, stress, stored):
    for point in range(LANES * PACKS * block, min(LANES * PACKS * (block + 1), len(stored))):
        F = _deformation(solid, point)
        s = cauchy_stress(solid.law, F)
        stored[point] = energy(solid.law, F)
        for k in range(6):
            stress[point, k] = s[k]


def elastic_points(solid: Solid, n: int) -> AtPoints:
    """Return Cauchy stresses and strain energies of a hyperelastic solid at its n quadrature points, from their deformation
    gradients.
    """
    found = AtPoints(np.zeros((n, 6)), np.zeros(n))
    _elastic(len(solid.sums), Bundle(solid), found.stress, found.stored)
    return found


@parallel_loop()
def _fields(block, solid, of_stress, of_stored, stress, stored):
    corners, nq, averaged = solid.corners, solid.n_points, len(solid.block_volume) > 0
    start = solid.blocks.first[block]
    for point in range(LANES * PACKS * block, min(LANES * PACKS * (block + 1), nq * len(stored))):
        pack, lane, cell, w = point // LANES, point % LANES, point // nq, solid.weights[point]
        stored[cell] += w * of_stored[point]
        extra = 0.0
        if averaged:
            J = determinant(_deformation(solid, point))
            stored[cell] -= w * volumetric_energy(solid.law, J)
            extra -= volumetric_stress(solid.law, J)
            for entry in range(corners.first[pack], corners.first[pack + 1]):
                node = solid.blocks.nodes[start + corners.place[entry] // LANES]
                extra += corners.numbers[LANES * entry + lane] / w * solid.mean_stress[node]
        for k in range(6):
            stress[cell, k] += (of_stress[point, k] + (extra if k < 3 else 0.0)) / nq


def nodal_field(
    name: str, mesh: SimplexMesh, solid: Solid, at_points: Callable[[int], AtPoints], law: Any, density: float
) -> np.ndarray:
    """Return a field at the nodes, by name: density [kg/m³], shape (n,), Cauchy stress [Pa], shape (n, 6), pressure [Pa],
    strain energy per unit mass [J/kg], `stored_energy` of the node [J], or dissipated energy per unit mass [J/kg].

    at_points: function that returns stresses and energies at a number of quadrature points; law: the hyperelastic law;
    density: at rest [kg/m³]. Values are volume-weighted averages over the cells around a node; energies are distributed among
    the corners of the cells.
    """
    if name == "density":
        if len(solid.block_volume):
            return density / solid.volume_ratio
        return density / _mean(mesh, np.linalg.det(deformation_gradients(solid, len(mesh.cells)).mean(axis=1)))
    found = at_points(solid.n_points * len(mesh.cells))
    if name == LOST and found.lost is not None:
        return _mean(mesh, found.lost.reshape(len(mesh.cells), -1).mean(axis=1)) / density
    stress, stored = np.zeros((len(mesh.cells), 6)), np.zeros(len(mesh.cells))
    _fields(len(solid.sums), Bundle(solid), found.stress, found.stored, stress, stored)
    if name in ("strain_energy", "stored_energy"):
        energies = np.bincount(mesh.cells.ravel(), np.repeat(stored, 4) / 4.0, len(mesh.nodes))
        if len(solid.block_volume):
            energies += solid.volume * np.array([volumetric_energy(law, J) for J in solid.volume_ratio.tolist()])
        about = np.bincount(mesh.cells.ravel(), np.repeat(mesh.volumes, 4) / 4.0, len(mesh.nodes))
        return energies if name == "stored_energy" else energies / (density * about)
    components = np.stack([_mean(mesh, stress[:, k]) for k in range(6)], axis=1)
    return -components[:, :3].mean(axis=1) if name == "pressure" else components


def _mean(mesh: SimplexMesh, of_cells: np.ndarray) -> np.ndarray:
    """Return the volume-weighted average at each node, shape (n,), of a cell quantity, shape (cells,)."""
    corners, volumes = mesh.cells.ravel(), np.repeat(mesh.volumes, 4)
    sums = np.bincount(corners, np.repeat(of_cells, 4) * volumes, len(mesh.nodes))
    return np.asarray(sums / np.bincount(corners, volumes, len(mesh.nodes)))


ROWS = ((0, 5, 4), (5, 1, 3), (4, 3, 2))  # indices of the rows of a symmetric tensor in its components xx, yy, zz, yz, xz, xy


class Prestressed(NamedTuple):
    """Material points of a solid with an initial stress S₀ [Pa], shape (lanes, 6), that is added to the stress of the law.
    Lanes are the entries of SIMD packs, one for each point and padding at the end.

    It is a constant second Piola-Kirchhoff stress S₀ of the points in the reference configuration: P = P(F) + F S₀. At rest it
    equals the Cauchy stress. It rotates with the material, and is the derivative of the energy S₀ : E with E = (FᵀF - I)/2.
    """

    points: Any  # points without the initial stress, see `find_stresses`
    stress: np.ndarray  # components xx, yy, zz, yz, xz, xy of S₀


def prestressed(solid: Solid, stress: np.ndarray | None) -> Solid:
    """Return the solid with an initial stress of its points [Pa], shape (n, 6); the solid itself if stress is None."""
    if stress is None:
        return solid
    lanes = np.zeros((len(solid.weights), 6))
    lanes[: len(stress)] = stress
    return solid._replace(points=Prestressed(solid.points, lanes))


@point_function(find_stresses, Prestressed)
def _find_stresses(points, first, n, solid, dt, keep, averaged, s):
    lost = find_stresses(points.points, first, n, solid, dt, keep, averaged, s)
    for i in range(n * LANES):
        p = LANES * first + i
        xx, yy, zz, yz, xz, xy = (
            points.stress[p, 0],
            points.stress[p, 1],
            points.stress[p, 2],
            points.stress[p, 3],
            points.stress[p, 4],
            points.stress[p, 5],
        )
        w, twice = s[WEIGHT * COLUMN + i], -(xx + yy + zz)
        for row in range(3):
            a, b, c = s[3 * row * COLUMN + i], s[(3 * row + 1) * COLUMN + i], s[(3 * row + 2) * COLUMN + i]
            x, y, z = a * xx + b * xy + c * xz, a * xy + b * yy + c * yz, a * xz + b * yz + c * zz
            s[(STRESS + 3 * row) * COLUMN + i] += w * x
            s[(STRESS + 3 * row + 1) * COLUMN + i] += w * y
            s[(STRESS + 3 * row + 2) * COLUMN + i] += w * z
            twice += a * x + b * y + c * z
        s[STORED * COLUMN + i] += 0.5 * w * twice
    return lost


def with_prestress(found: AtPoints, solid: Solid, F: np.ndarray) -> AtPoints:
    """Return stresses and energies of n quadrature points with the contributions of the initial stress, if there is one.

    found: stresses and energies of the material law; solid: data of `Solid`; F: deformation gradients, shape (n, 3, 3).
    """
    if not isinstance(solid.points, Prestressed):
        return found
    S = solid.points.stress[: len(F)][:, np.array(ROWS)]
    sigma = F @ S @ F.transpose(0, 2, 1) / np.linalg.det(F)[:, None, None]
    strain = 0.5 * (F.transpose(0, 2, 1) @ F - np.eye(3))
    six = sigma[:, (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)]
    return found._replace(stress=found.stress + six, stored=found.stored + np.einsum("pij,pij->p", S, strain))
