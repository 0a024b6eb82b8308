"""Internal forces of a meshless solid in total-Lagrangian form.

F = I + Σ u_a ⊗ ∇p_a and f_a = -Σ_q w_q P(F_q) ∇p_a(q) over quadrature points of the cells, with gradients with respect to
the reference configuration, computed once (Horton et al. 2010, Int. J. Numer. Methods Biomed. Eng. 26, 977; Mountris et al.
2019, section 4). Nearly incompressible solids would lock. Their volume ratio is therefore averaged around the corners a of
the cells, with the linear functions N_a, J̄_a = Σ_q w N_a J / V_a, V_a = Σ_q w N_a, and the volumetric part U(J) of the
energy is evaluated at J̄_a, with the volume V_a each: P = ∂W/∂F + (Σ_a N_a U'(J̄_a) - U'(J)) cof F. (The average nodal
pressure of Bonet & Burton 1998, Commun. Numer. Methods Eng. 14, 437, for linear tetrahedra.)
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.solid import (
    BATCH,
    CHUNK,
    COLUMN,
    COLUMNS,
    ENERGY,
    LEAST_J,
    LOST,
    NODAL,
    PACKS,
    RATIO,
    STORED,
    STRESS,
    WEIGHT,
    Elastic,
    Solid,
    deform,
    deform_block,
    displacements,
    pull,
)
from pellucid.jit import generic, kernel, point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.loops import parallel_for
from pellucid.jit.vector import LANES, load, splat, spread, store, total
from pellucid.materials.law import energy_and_stress, volumetric_energy, volumetric_stress
from pellucid.tensors import cofactor, determinant


@generic
def find_stresses(points: Any, first: int, n: int, solid: Any, dt: float, keep: bool, averaged: bool, s: Any) -> float:
    """Compute the stresses of a batch of n packs (of four quadrature points each), starting with pack `first`.

    points: material points with their law; solid: `SolidInKernels`; dt: length of the step that ended with the present
    deformation gradients [s]; keep: True to store the new states of the material; averaged: True if the volume ratio is
    averaged; s: work array of columns. Reads the deformation gradients and weights from the columns, and writes to them stored
    energy and first Piola-Kirchhoff stress P, both times the weights, and the volume ratio. Returns the energy dissipated so
    far at these points [J].
    """


@kernel(inner=True)
def gradient_at(s, i):
    """Return the deformation gradient of point i of a batch, nine components, from the columns of the work array s."""
    return (
        s[i],
        s[COLUMN + i],
        s[2 * COLUMN + i],
        s[3 * COLUMN + i],
        s[4 * COLUMN + i],
        s[5 * COLUMN + i],
        s[6 * COLUMN + i],
        s[7 * COLUMN + i],
        s[8 * COLUMN + i],
    )


@kernel(inner=True)
def keep_stress(s, i, law, averaged, F, J, stored, P):
    """Store, for point i of a batch, the energy per unit volume and P, both times its weight, and the volume ratio in the
    columns of the work array s. If the volume ratio is averaged, the volumetric part of the law is evaluated at the mean.

    law: hyperelastic law; F, J: deformation gradient and its determinant; stored: energy per unit volume [J/m³]; P: first
    Piola-Kirchhoff stress [Pa].
    """
    w, extra = s[WEIGHT * COLUMN + i], 0.0
    if averaged:
        stored -= volumetric_energy(law, J)
        extra = s[NODAL * COLUMN + i] - w * volumetric_stress(law, J)
    C = cofactor(F)
    s[STRESS * COLUMN + i] = w * P[0] + extra * C[0]
    s[(STRESS + 1) * COLUMN + i] = w * P[1] + extra * C[1]
    s[(STRESS + 2) * COLUMN + i] = w * P[2] + extra * C[2]
    s[(STRESS + 3) * COLUMN + i] = w * P[3] + extra * C[3]
    s[(STRESS + 4) * COLUMN + i] = w * P[4] + extra * C[4]
    s[(STRESS + 5) * COLUMN + i] = w * P[5] + extra * C[5]
    s[(STRESS + 6) * COLUMN + i] = w * P[6] + extra * C[6]
    s[(STRESS + 7) * COLUMN + i] = w * P[7] + extra * C[7]
    s[(STRESS + 8) * COLUMN + i] = w * P[8] + extra * C[8]
    s[STORED * COLUMN + i] = w * stored
    s[RATIO * COLUMN + i] = J


@kernel(inner=True)
def _elastic_stresses(law, averaged, s):
    """Compute the stresses of a batch of points with a hyperelastic law. Writes to the columns of the work array s: stored
    energy and first Piola-Kirchhoff stress, times the weights, and the volume ratio. averaged: True if the volume ratio is
    averaged.
    """
    for i in range(COLUMN):  # columns a constant apart, and no other array: the compiler takes several points at a time
        F = gradient_at(s, i)
        stored, P = energy_and_stress(law, F)
        keep_stress(s, i, law, averaged, F, determinant(F), stored, P)


@point_function(find_stresses, Elastic)
def _find_stresses(points, first, n, solid, dt, keep, averaged, s):
    _elastic_stresses(points.law, averaged, s)
    return 0.0


@kernel(inner=True)
def _average_chunk(chunk, solid):
    """Compute the averaged volume ratios of a chunk of nodes, and their volumetric energies and stresses; all are stored in
    the mesh of `solid` (`SolidInKernels`).
    """
    mesh, law = solid.mesh, solid.law
    blocks, least, stored = mesh.blocks, np.inf, 0.0
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mesh.volume))):
        volume = 0.0
        for place in range(blocks.node_first[a], blocks.node_first[a + 1]):
            volume += mesh.block_volume[blocks.places[place]]
        J = mesh.volume_ratio[a] = volume / mesh.volume[a]
        least = min(least, J)
        stored += mesh.volume[a] * volumetric_energy(law, J)
        mesh.mean_stress[a] = volumetric_stress(law, J)
    mesh.node_sums[chunk, ENERGY], mesh.node_sums[chunk, LEAST_J] = stored, least


@kernel(inner=True)
def fill_batch(first, n, mesh, averaged, mean, u, s):
    """Copy deformation gradients, weights and averaged volumetric stresses of n packs, starting with pack `first`, to the
    columns of the work array s.

    mesh: data of `Solid`; averaged: True if the volume ratio is averaged; mean, u: mean volumetric stresses [Pa] and
    displacements [m] of the nodes of the block.
    """
    corners = mesh.corners
    for k in range(n):
        pack, here = first + k, 9 * LANES * (first + k)
        store(s, WEIGHT * COLUMN + k * LANES, load(mesh.weights, LANES * pack))
        if averaged:
            extra = splat(0.0)
            for entry in range(corners.first[pack], corners.first[pack + 1]):
                extra += spread(mean, corners.place[entry] // LANES) * load(corners.numbers, LANES * entry)
            store(s, NODAL * COLUMN + k * LANES, extra)
        else:
            deform(pack, mesh, u, mesh.deformation, here, LANES)
        for i in range(9):
            store(s, i * COLUMN + k * LANES, load(mesh.deformation, here + i * LANES))


@kernel(inner=True, allocates=True)
def mean_stresses(start, m, mesh):
    """Return the mean volumetric stresses [Pa] of the m nodes of a block (a group of packs of quadrature points); zero unless
    the volume ratio is averaged. start: index of the first of these nodes in the node list of the blocks; mesh: data of
    `Solid`.
    """
    mean = np.zeros(m)
    if len(mesh.block_volume) > 0:
        for k in range(m):
            mean[k] = mesh.mean_stress[mesh.blocks.nodes[start + k]]
    return mean


@kernel(inner=True)
def pull_batch(first, n, mesh, s, f, found):
    """Add to `f` the forces on the nodes of a block [N] that follow from the stresses of n packs (four quadrature points each)
    in the columns of the work array s, starting with pack `first`.

    mesh: data of `Solid`; found: receives the sum of the energies of the points, LANES numbers, and the smallest volume ratio
    of the block so far.
    """
    for k in range(n):
        pull(first + k, mesh, s, STRESS * COLUMN + k * LANES, f)
        store(found, 0, load(found, 0) + load(s, STORED * COLUMN + k * LANES))
        for lane in range(LANES):
            found[LANES] = min(found[LANES], s[RATIO * COLUMN + k * LANES + lane])


@kernel(inner=True, allocates=True)
def _force_block(block, solid, dt, keep):
    """Compute the forces that the points of a block (group of packs that one thread processes) exert on its nodes; also the
    deformation gradients, unless the volume ratio is averaged.

    solid: a `SolidInKernels`, in whose mesh the results are stored; dt: length of the step that ended with the present
    displacements [s]; keep: True to store the new states of the material.
    """
    mesh = solid.mesh
    blocks, averaged = mesh.blocks, len(mesh.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u = displacements(start, m, mesh)
    f, mean, s = np.zeros(LANES * m), mean_stresses(start, m, mesh), np.zeros(COLUMNS * COLUMN)
    found, lost, end = np.zeros(LANES + 1), 0.0, min(PACKS * (block + 1), len(mesh.corners.first) - 1)
    found[LANES] = np.inf
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        call_kernel(fill_batch, first, n, mesh, averaged, mean, u, s)
        lost += find_stresses(solid.points, first, n, solid, dt, keep, averaged, s)
        call_kernel(pull_batch, first, n, mesh, s, f, found)
    for k in range(m):
        for d in range(3):
            mesh.block_force[start + k, d] = f[LANES * k + d]
    mesh.sums[block, ENERGY], mesh.sums[block, LEAST_J], mesh.sums[block, LOST] = total(load(found, 0)), found[LANES], lost


@kernel(inner=True)
def _add_blocks(chunk, mesh, force):
    """Sum the forces of all blocks on a chunk of the nodes into `force` [N], shape (n, 3). mesh: data of `Solid`."""
    blocks = mesh.blocks
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(force))):
        for d in range(3):
            force[a, d] = 0.0
        for place in range(blocks.node_first[a], blocks.node_first[a + 1]):
            for d in range(3):
                force[a, d] += mesh.block_force[blocks.places[place], d]


class SolidInKernels(NamedTuple):
    """A meshless solid as argument of `internal_forces`: its law and material points, separate from its mesh. Most kernels use
    only the mesh and are therefore compiled once for all laws.
    """

    law: Any  # hyperelastic law
    points: Any  # material points, see `find_stresses`
    mesh: Bundle  # of `Solid` without law and points


def in_kernels(solid: Solid) -> Bundle:
    """Bundle the law, the material points and the mesh of a meshless solid as argument of `internal_forces`."""
    return Bundle(SolidInKernels(solid.law, solid.points, Bundle(solid._replace(law=(), points=()))))


@kernel()
def _deform(n_blocks, mesh):
    parallel_for(deform_block, n_blocks, mesh)


@kernel()
def average_volumes(chunks, solid):
    """Compute the averaged volume ratios of the nodes, and their volumetric energies and stresses, for `internal_forces`."""
    parallel_for(_average_chunk, chunks, solid)


@kernel()
def _find_forces(n_blocks, solid, dt, keep):
    parallel_for(_force_block, n_blocks, solid, dt, keep)


@kernel()
def sum_blocks(chunks, mesh, force):
    """Sum the forces of all blocks on the nodes into `force` [N], shape (n, 3). mesh: data of `Solid`."""
    parallel_for(_add_blocks, chunks, mesh, force)


def internal_forces(n_blocks: int, chunks: int, solid: Bundle, dt: float, keep: bool, force: np.ndarray) -> None:
    """Compute the internal nodal forces `force` [N], shape (n, 3), the deformation gradients, and the energies and smallest
    volume ratios of the blocks (groups of quadrature points).

    n_blocks, chunks: numbers of blocks and of chunks of nodes; solid: from `in_kernels`, with the nodal displacements; dt:
    length of the step that ended with these displacements [s]; keep: True to store the new states of the material.
    """
    if len(solid.mesh.block_volume) > 0:
        _deform(n_blocks, solid.mesh)
        average_volumes(chunks, solid)
    _find_forces(n_blocks, solid, dt, keep)
    sum_blocks(chunks, solid.mesh, force)
