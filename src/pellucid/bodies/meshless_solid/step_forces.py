"""Internal forces of a meshless solid in a time step that conserves energy and angular momentum.

A step takes the nodes from x₀ to x₁, and the deformation gradients from F₀ to F₁. With F_m = (F₀ + F₁)/2 and any symmetric
stress S, the forces f_a = -Σ_q w F_m S ∇p_a have no torque about the positions in the middle of the step, and their work in the
step is -Σ_q w S : (E₁ - E₀), with the strains E = (FᵀF - I)/2 (Simo & Tarnow 1992, J. Appl. Math. Phys. 43, 757). Here S is the
mean of ∂W/∂E along the straight path of the strains from E₀ to E₁, so that this work is the change of the strain energy W. The
mean is computed with the two points of Gauss' rule; the remaining error is of fifth order in E₁ - E₀.

Energies depend on C = FᵀF only. The stress at C is that of the deformation gradient U with C = UᵀU, an upper triangle: with
P(U) = ∂W/∂F at F = U, S = U⁻¹ P(U), and F_m S = (F_m U⁻¹) P(U). This also holds if the volume ratio is averaged, with det U.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.forces import (
    average_volumes,
    fill_batch,
    find_stresses,
    mean_stresses,
    pull_batch,
    sum_blocks,
)
from pellucid.bodies.meshless_solid.solid import (
    BATCH,
    COLUMN,
    COLUMNS,
    ENERGY,
    LEAST_J,
    LOST,
    PACKS,
    STRESS,
    Solid,
    deform,
    displacements,
)
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.loops import parallel_for
from pellucid.jit.vector import LANES, load, total
from pellucid.tensors import determinant, multiply

SHARES = 0.5 - sqrt(3.0) / 6.0, 0.5 + sqrt(3.0) / 6.0  # of the path of the strains: Gauss' points, with equal weights


class SolidInStep(NamedTuple):
    """A meshless solid on the way from the start to the end of a time step."""

    solid: Bundle  # as in `pellucid.bodies.meshless_solid.forces`; its displacements are those of the end of the step
    start: np.ndarray  # deformation gradients at the start, 9 × LANES numbers per pack
    turns: np.ndarray  # F_m U⁻¹ of the points, 9 × LANES numbers per pack


@kernel(inner=True)
def _tensor(numbers, at):
    """Return a tensor of a point; at: index of its first component, the others are LANES apart."""
    return (
        numbers[at],
        numbers[at + LANES],
        numbers[at + 2 * LANES],
        numbers[at + 3 * LANES],
        numbers[at + 4 * LANES],
        numbers[at + 5 * LANES],
        numbers[at + 6 * LANES],
        numbers[at + 7 * LANES],
        numbers[at + 8 * LANES],
    )


@kernel(inner=True)
def _part_way(A, B, share):
    """Return the upper triangle U with UᵀU = (1 - s) AᵀA + s BᵀB, and (A + B)/2 U⁻¹."""
    a, b = 1.0 - share, share
    xx = a * (A[0] * A[0] + A[3] * A[3] + A[6] * A[6]) + b * (B[0] * B[0] + B[3] * B[3] + B[6] * B[6])
    yy = a * (A[1] * A[1] + A[4] * A[4] + A[7] * A[7]) + b * (B[1] * B[1] + B[4] * B[4] + B[7] * B[7])
    zz = a * (A[2] * A[2] + A[5] * A[5] + A[8] * A[8]) + b * (B[2] * B[2] + B[5] * B[5] + B[8] * B[8])
    xy = a * (A[0] * A[1] + A[3] * A[4] + A[6] * A[7]) + b * (B[0] * B[1] + B[3] * B[4] + B[6] * B[7])
    xz = a * (A[0] * A[2] + A[3] * A[5] + A[6] * A[8]) + b * (B[0] * B[2] + B[3] * B[5] + B[6] * B[8])
    yz = a * (A[1] * A[2] + A[4] * A[5] + A[7] * A[8]) + b * (B[1] * B[2] + B[4] * B[5] + B[7] * B[8])
    p = sqrt(xx)
    q, r = xy / p, xz / p
    s = sqrt(yy - q * q)
    t = (yz - q * r) / s
    v = sqrt(zz - r * r - t * t)
    U = p, q, r, 0.0, s, t, 0.0, 0.0, v
    inverse = (
        0.5 / p,
        -0.5 * q / (p * s),
        0.5 * (q * t - r * s) / (p * s * v),
        0.0,
        0.5 / s,
        -0.5 * t / (s * v),
        0.0,
        0.0,
        0.5 / v,
    )
    F = (A[0] + B[0], A[1] + B[1], A[2] + B[2], A[3] + B[3], A[4] + B[4], A[5] + B[5], A[6] + B[6], A[7] + B[7], A[8] + B[8])
    return U, multiply(F, inverse)


@kernel(inner=True)
def _deform_block(block, step, share):
    """Compute U and F_m U⁻¹ at the points of a block after a share of the path of the strains, the contributions of the points
    to the volumes around the nodes, and the smallest volume ratio at the end of the step."""
    mesh = step.solid.mesh
    first, end, corners = mesh.blocks.first[block], mesh.blocks.first[block + 1], mesh.corners
    u, volume = displacements(first, end - first, mesh), mesh.block_volume[first:end]
    volume[:] = 0.0
    least = np.inf
    for pack in range(PACKS * block, min(PACKS * (block + 1), len(corners.first) - 1)):
        here = 9 * LANES * pack
        deform(pack, mesh, u, mesh.deformation, here, LANES)
        for lane in range(LANES):
            at = here + lane
            F = _tensor(mesh.deformation, at)
            least = min(least, determinant(F))
            U, turn = _part_way(_tensor(step.start, at), F, share)
            for k in range(9):
                mesh.deformation[at + k * LANES] = U[k]
                step.turns[at + k * LANES] = turn[k]
            if len(volume) > 0:
                J = determinant(U)
                for entry in range(corners.first[pack], corners.first[pack + 1]):
                    volume[corners.place[entry] // LANES] += J * corners.numbers[LANES * entry + lane]
    mesh.sums[block, LEAST_J] = least


@kernel(inner=True, allocates=True)
def _force_block(block, step):
    """Compute the forces that the points of a block exert on its nodes, with P = F_m U⁻¹ P(U)."""
    solid = step.solid
    mesh = solid.mesh
    blocks, averaged = mesh.blocks, len(mesh.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u, f, mean, s = np.zeros(0), np.zeros(LANES * m), mean_stresses(start, m, mesh), np.zeros(COLUMNS * COLUMN)
    found, end = np.zeros(LANES + 1), min(PACKS * (block + 1), len(mesh.corners.first) - 1)
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        call_kernel(fill_batch, first, n, mesh, True, mean, u, s)
        find_stresses(solid.points, first, n, solid, 0.0, False, averaged, s)
        for i in range(n * LANES):
            at = 9 * LANES * (first + i // LANES) + i % LANES
            Q, to = _tensor(step.turns, at), STRESS * COLUMN + i
            P = (
                s[to],
                s[to + COLUMN],
                s[to + 2 * COLUMN],
                s[to + 3 * COLUMN],
                s[to + 4 * COLUMN],
                s[to + 5 * COLUMN],
                s[to + 6 * COLUMN],
                s[to + 7 * COLUMN],
                s[to + 8 * COLUMN],
            )
            turned = multiply(Q, P)
            for k in range(9):
                s[to + k * COLUMN] = turned[k]
        call_kernel(pull_batch, first, n, mesh, s, f, found)
    for k in range(m):
        for d in range(3):
            mesh.block_force[start + k, d] = f[LANES * k + d]
    mesh.sums[block, ENERGY], mesh.sums[block, LOST] = total(load(found, 0)), 0.0


@kernel()
def _deform(n_blocks, step, share):
    parallel_for(_deform_block, n_blocks, step, share)


@kernel()
def _find_forces(n_blocks, step):
    parallel_for(_force_block, n_blocks, step)


class StepForces:
    """Internal forces of a meshless solid in a time step.

    solid: data of the solid; bundle: the same for kernels, as in its forces.
    """

    def __init__(self, solid: Solid, bundle: Bundle) -> None:
        self._solid = solid
        numbers = np.zeros_like(solid.deformation), np.zeros_like(solid.deformation)
        self._start = numbers[0]
        self._step = Bundle(SolidInStep(bundle, *numbers))
        self._bundle = bundle
        self._parts = np.zeros((len(SHARES), *solid.displacement.shape))

    def begin(self) -> None:
        """Store the state of the last forces as the start of a step."""
        self._start[:] = self._solid.deformation

    def find(self, displacement: np.ndarray, force: np.ndarray) -> bool:
        """Compute the internal forces `force` [N], shape (n, 3), in a step that ends with nodal displacements [m], shape
        (n, 3). Returns False if a point is inverted at its end."""
        solid = self._solid
        solid.displacement[:] = displacement
        blocks, chunks, is_sound = len(solid.sums), len(solid.node_sums), True
        for part, share in zip(self._parts, SHARES, strict=True):
            _deform(blocks, self._step, share)
            if len(solid.block_volume):
                average_volumes(chunks, self._bundle)
            _find_forces(blocks, self._step)
            sum_blocks(chunks, self._bundle.content.mesh, part)
            is_sound = is_sound and bool(solid.sums[:, LEAST_J].min() > 0.0)
        np.multiply(self._parts[0] + self._parts[1], 0.5, out=force)
        return is_sound
