"""Internal forces of a meshless solid in a time step that conserves energy and angular momentum.

A step takes the nodes from x₀ to x₁, and the deformation gradients from F₀ to F₁. With F_m = (F₀ + F₁)/2 and any symmetric
stress S, the forces f_a = -Σ_q w F_m S ∇p_a have no torque about the positions in the middle of the step, and their work in the
step is -Σ_q w S : (E₁ - E₀), with the strains E = (FᵀF - I)/2 (Simo & Tarnow 1992, J. Appl. Math. Phys. 43, 757). Here S is the
mean of ∂W/∂E along the straight path of the strains from E₀ to E₁, so that this work is the change of the strain energy W. The
mean is computed with the two points of Gauss' rule; the remaining error is of fifth order in E₁ - E₀.

Energies depend on C = FᵀF only. The stress at C is that of the deformation gradient U with C = UᵀU, an upper triangle: with
P(U) = ∂W/∂F at F = U, S = U⁻¹ P(U), and F_m S = (F_m U⁻¹) P(U). This also holds if the volume ratio is averaged, with det U.

A material with history variables adds its viscous stress in the middle of the path, C = (F₀ᵀF₀ + F₁ᵀF₁)/2. Its states are
advanced over Δt/2 from F₀ to V F₀, with the symmetric V for which (V F₀)ᵀ V F₀ = C: without rotation, so that a rotation of the
body causes no viscous stress. At the end of the step the states are advanced over Δt in the same way, and turned with the body.
"""

from collections.abc import Mapping
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
    components,
    deform,
    displacements,
)
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.loops import parallel_for
from pellucid.jit.vector import LANES, load, store, total
from pellucid.tensors import cofactor, determinant, full, multiply

SHARES = 0.5 - sqrt(3.0) / 6.0, 0.5 + sqrt(3.0) / 6.0  # of the path of the strains: Gauss' points, with equal weights
MIDDLE, END = 0.5, 1.0  # shares for viscous stresses, and for the states at the end of the step
ROOTS = 6  # iterations of a square root: digits double in each
FULL, SIX = [0, 5, 4, 5, 1, 3, 4, 3, 2], [0, 4, 8, 5, 2, 1]  # of xx, yy, zz, yz, xz, xy all nine, and of nine these


class SolidInStep(NamedTuple):
    """A meshless solid on the way from the start to the end of a time step."""

    solid: Bundle  # as in `pellucid.bodies.meshless_solid.forces`; its displacements are those of the end of the step
    start: np.ndarray  # deformation gradients at the start, 9 × LANES numbers per pack
    turns: np.ndarray  # F_m U⁻¹ of the points, or F_m (V F₀)⁻¹, 9 × LANES numbers per pack


@kernel(inner=True)
def _tensor(s, first, i):
    """Return a tensor of point i of a batch, whose components are in the columns from `first` on of the work array s."""
    at = first * COLUMN + i
    return (
        s[at],
        s[at + COLUMN],
        s[at + 2 * COLUMN],
        s[at + 3 * COLUMN],
        s[at + 4 * COLUMN],
        s[at + 5 * COLUMN],
        s[at + 6 * COLUMN],
        s[at + 7 * COLUMN],
        s[at + 8 * COLUMN],
    )


@kernel(inner=True)
def _keep(s, first, i, A):
    """Write a tensor of point i of a batch to the columns from `first` on of the work array s."""
    at = first * COLUMN + i
    s[at] = A[0]
    s[at + COLUMN] = A[1]
    s[at + 2 * COLUMN] = A[2]
    s[at + 3 * COLUMN] = A[3]
    s[at + 4 * COLUMN] = A[4]
    s[at + 5 * COLUMN] = A[5]
    s[at + 6 * COLUMN] = A[6]
    s[at + 7 * COLUMN] = A[7]
    s[at + 8 * COLUMN] = A[8]


@kernel(inner=True)
def _columns_to_pack(s, first, k, numbers, pack):
    """Copy the tensors of pack k of a batch from the columns of the work array s to an array, 9 × LANES numbers per pack."""
    for d in range(9):
        store(numbers, (9 * pack + d) * LANES, load(s, (first + d) * COLUMN + k * LANES))


@kernel(inner=True)
def _pack_to_columns(numbers, pack, s, first, k):
    for d in range(9):
        store(s, (first + d) * COLUMN + k * LANES, load(numbers, (9 * pack + d) * LANES))


@kernel(inner=True)
def _squared(A, B, share):
    """Return xx, yy, zz, yz, xz, xy of C = (1 - s) AᵀA + s BᵀB."""
    a, b = 1.0 - share, share
    return (
        a * (A[0] * A[0] + A[3] * A[3] + A[6] * A[6]) + b * (B[0] * B[0] + B[3] * B[3] + B[6] * B[6]),
        a * (A[1] * A[1] + A[4] * A[4] + A[7] * A[7]) + b * (B[1] * B[1] + B[4] * B[4] + B[7] * B[7]),
        a * (A[2] * A[2] + A[5] * A[5] + A[8] * A[8]) + b * (B[2] * B[2] + B[5] * B[5] + B[8] * B[8]),
        a * (A[1] * A[2] + A[4] * A[5] + A[7] * A[8]) + b * (B[1] * B[2] + B[4] * B[5] + B[7] * B[8]),
        a * (A[0] * A[2] + A[3] * A[5] + A[6] * A[8]) + b * (B[0] * B[2] + B[3] * B[5] + B[6] * B[8]),
        a * (A[0] * A[1] + A[3] * A[4] + A[6] * A[7]) + b * (B[0] * B[1] + B[3] * B[4] + B[6] * B[7]),
    )


@kernel(inner=True)
def _triangle(C):
    """Return the upper triangle U with UᵀU = C, and U⁻¹."""
    xx, yy, zz, yz, xz, xy = C
    p = sqrt(xx)
    q, r = xy / p, xz / p
    s = sqrt(yy - q * q)
    t = (yz - q * r) / s
    v = sqrt(zz - r * r - t * t)
    inverse = 1.0 / p, -q / (p * s), (q * t - r * s) / (p * s * v), 0.0, 1.0 / s, -t / (s * v), 0.0, 0.0, 1.0 / v
    return (p, q, r, 0.0, s, t, 0.0, 0.0, v), inverse


@kernel(inner=True)
def _inverse(A):
    C, over = cofactor(A), 1.0 / determinant(A)
    return (
        over * C[0],
        over * C[3],
        over * C[6],
        over * C[1],
        over * C[4],
        over * C[7],
        over * C[2],
        over * C[5],
        over * C[8],
    )


@kernel(inner=True)
def _stretched(A, C):
    """Return V A with a symmetric V and (V A)ᵀ V A = C, and its inverse: V² = A⁻ᵀ C A⁻¹, by Newton's iteration."""
    back = _inverse(A)
    up = back[0], back[3], back[6], back[1], back[4], back[7], back[2], back[5], back[8]
    B = multiply(up, multiply(full(C), back))
    V = (
        0.5 * (B[0] + 1.0),
        0.5 * B[1],
        0.5 * B[2],
        0.5 * B[3],
        0.5 * (B[4] + 1.0),
        0.5 * B[5],
        0.5 * B[6],
        0.5 * B[7],
        0.5 * (B[8] + 1.0),
    )
    for _ in range(ROOTS):
        Q = multiply(_inverse(V), B)
        V = (
            0.5 * (V[0] + Q[0]),
            0.5 * (V[1] + Q[1]),
            0.5 * (V[2] + Q[2]),
            0.5 * (V[3] + Q[3]),
            0.5 * (V[4] + Q[4]),
            0.5 * (V[5] + Q[5]),
            0.5 * (V[6] + Q[6]),
            0.5 * (V[7] + Q[7]),
            0.5 * (V[8] + Q[8]),
        )
    G = multiply(V, A)
    return G, _inverse(G)


@kernel(inner=True)
def _mean(A, B):
    return (
        0.5 * (A[0] + B[0]),
        0.5 * (A[1] + B[1]),
        0.5 * (A[2] + B[2]),
        0.5 * (A[3] + B[3]),
        0.5 * (A[4] + B[4]),
        0.5 * (A[5] + B[5]),
        0.5 * (A[6] + B[6]),
        0.5 * (A[7] + B[7]),
        0.5 * (A[8] + B[8]),
    )


@kernel(inner=True)
def _part_way(share, s):
    """Replace F₀ and F₁ of a batch of points in the work array s by U and F_m U⁻¹, after a share of the path of the strains."""
    for i in range(COLUMN):  # columns a constant apart, and no other array: the compiler takes several points at a time
        A, F = _tensor(s, 0, i), _tensor(s, 9, i)
        U, inverse = _triangle(_squared(A, F, share))
        _keep(s, 0, i, U)
        _keep(s, 9, i, multiply(_mean(A, F), inverse))


@kernel(inner=True)
def _part_way_of_states(share, s):
    """The same with V F₀ instead of U."""
    for i in range(COLUMN):
        A, F = _tensor(s, 0, i), _tensor(s, 9, i)
        G, inverse = _stretched(A, _squared(A, F, share))
        _keep(s, 0, i, G)
        _keep(s, 9, i, multiply(_mean(A, F), inverse))


@kernel(inner=True, allocates=True)
def _deform_block(block, step, share, of_states):
    """Compute U and F_m U⁻¹ at the points of a block after a share of the path of the strains, the contributions of the points
    to the volumes around the nodes, and the smallest volume ratio at the end of the step; V F₀ instead of U if `of_states`."""
    mesh = step.solid.mesh
    begin, stop, corners = mesh.blocks.first[block], mesh.blocks.first[block + 1], mesh.corners
    u, volume, s = displacements(begin, stop - begin, mesh), mesh.block_volume[begin:stop], np.ones(18 * COLUMN)
    volume[:] = 0.0
    least, end = np.inf, min(PACKS * (block + 1), len(corners.first) - 1)
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        for k in range(n):
            _pack_to_columns(step.start, first + k, s, 0, k)
            deform(first + k, mesh, u, s, 9 * COLUMN + k * LANES, COLUMN)
        for i in range(n * LANES):
            least = min(least, determinant(_tensor(s, 9, i)))
        if of_states:
            _part_way_of_states(share, s)
        else:
            _part_way(share, s)
        for k in range(n):
            _columns_to_pack(s, 0, k, mesh.deformation, first + k)
            _columns_to_pack(s, 9, k, step.turns, first + k)
            if len(volume) > 0:
                J = determinant(components(s, k * LANES, COLUMN))
                for entry in range(corners.first[first + k], corners.first[first + k + 1]):
                    volume[corners.place[entry] // LANES] += total(J * load(corners.numbers, LANES * entry))
    mesh.sums[block, LEAST_J] = least


@kernel(inner=True)
def _turn_stresses(s):
    """Multiply the stresses of a batch of points in the work array s by the tensors in its last columns."""
    for i in range(COLUMN):
        _keep(s, STRESS, i, multiply(_tensor(s, COLUMNS, i), _tensor(s, STRESS, i)))


@kernel(inner=True, allocates=True)
def _force_block(block, step, dt, keep):
    """Compute the forces that the points of a block exert on its nodes, with P = F_m U⁻¹ P(U); dt: time over which states are
    advanced [s]; keep: True to store them."""
    solid = step.solid
    mesh = solid.mesh
    blocks, averaged = mesh.blocks, len(mesh.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u, f, mean, s = np.zeros(0), np.zeros(LANES * m), mean_stresses(start, m, mesh), np.zeros((COLUMNS + 9) * COLUMN)
    found, end = np.zeros(LANES + 1), min(PACKS * (block + 1), len(mesh.corners.first) - 1)
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        call_kernel(fill_batch, first, n, mesh, True, mean, u, s)
        find_stresses(solid.points, first, n, solid, dt, keep, averaged, s)
        for k in range(n):
            _pack_to_columns(step.turns, first + k, s, COLUMNS, k)
        _turn_stresses(s)
        call_kernel(pull_batch, first, n, mesh, s, f, found)
    for k in range(m):
        for d in range(3):
            mesh.block_force[start + k, d] = f[LANES * k + d]
    mesh.sums[block, ENERGY], mesh.sums[block, LOST] = total(load(found, 0)), 0.0


@kernel()
def _deform(n_blocks, step, share, of_states):
    parallel_for(_deform_block, n_blocks, step, share, of_states)


@kernel()
def _find_forces(n_blocks, step, dt, keep):
    parallel_for(_force_block, n_blocks, step, dt, keep)


class StepForces:
    """Internal forces of a meshless solid in a time step.

    solid: data of the solid; elastic: the same for kernels, with its hyperelastic law; viscous: with history variables; None
    without; states: arrays of the history variables by name, with a row for each lane of the packs.
    """

    def __init__(self, solid: Solid, elastic: Bundle, viscous: Bundle | None, states: Mapping[str, np.ndarray]) -> None:
        self._solid, self._bundle, self._states = solid, elastic, states
        numbers = np.zeros_like(solid.deformation), np.zeros_like(solid.deformation)
        self._start = numbers[0]
        self._step = Bundle(SolidInStep(elastic, *numbers))
        self._viscous = None if viscous is None else Bundle(SolidInStep(viscous, *numbers))
        self._parts = np.zeros((2, *solid.displacement.shape))
        self._blocks, self._chunks, self._dt = len(solid.sums), len(solid.node_sums), 0.0

    def begin(self, dt: float) -> None:
        """Store the state of the last forces as the start of a step dt [s]."""
        self._start[:] = self._solid.deformation
        self._dt = dt

    def find(self, displacement: np.ndarray, force: np.ndarray) -> bool:
        """Compute the internal forces `force` [N], shape (n, 3), in a step that ends with nodal displacements [m], shape
        (n, 3). Returns False if a point is inverted at its end."""
        solid, parts = self._solid, self._parts
        solid.displacement[:] = displacement
        for part, share in zip(parts, SHARES, strict=True):
            _deform(self._blocks, self._step, share, False)
            if len(solid.block_volume):
                average_volumes(self._chunks, self._bundle)
            self._find(self._step, 0.0, part)
        np.multiply(parts[0] + parts[1], 0.5, out=force)
        if self._viscous is not None:
            _deform(self._blocks, self._step, MIDDLE, True)
            self._find(self._viscous, 0.5 * self._dt, parts[0])
            self._find(self._step, 0.0, parts[1])
            force += parts[0] - parts[1]
        return bool(solid.sums[:, LEAST_J].min() > 0.0)

    def _find(self, step: Bundle, dt: float, force: np.ndarray, keep: bool = False) -> None:
        _find_forces(self._blocks, step, dt, keep)
        sum_blocks(self._chunks, self._bundle.content.mesh, force)

    def advance_states(self, displacement: np.ndarray, gradient: np.ndarray) -> None:
        """Advance the history variables to the end of the step.

        displacement: of the nodes at the end [m], shape (n, 3); gradient: deformation gradients there, shape (lanes, 3, 3).
        """
        if self._viscous is None:
            return
        self._solid.displacement[:] = displacement
        _deform(self._blocks, self._step, END, True)
        unturned = in_rows(self._solid.deformation)
        self._find(self._viscous, self._dt, self._parts[0], keep=True)
        turn = np.einsum("nij,njk->nik", gradient, np.linalg.inv(unturned))
        for array in self._states.values():
            if array.shape[1:] == (6,):
                tensor = array[:, FULL].reshape(-1, 3, 3)
                array[:] = np.einsum("nij,njk,nlk->nil", turn, tensor, turn).reshape(-1, 9)[:, SIX]
        self._states["deformation_gradient"][:] = gradient.reshape(-1, 9)


def in_rows(numbers: np.ndarray) -> np.ndarray:
    """Return the tensors of all lanes of the packs, shape (lanes, 3, 3), as a copy."""
    return numbers.reshape(-1, 9, LANES).swapaxes(1, 2).reshape(-1, 3, 3)
