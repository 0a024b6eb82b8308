"""Estimate of the largest natural frequency of a solid in its present state, by power iteration; it limits the time step of
central differences. In a relaxation, an inertia against changes of volume reduces this frequency.

The iteration continues during a run: one iteration every `INTERVAL` steps, starting from the vector of the last one, and one in
each step while the frequency grows, for example while a solid is compressed.
"""

from collections.abc import Callable, Mapping

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from pellucid.bodies.meshless_solid.solid import PACKS, Solid, components, nodes_of_entries
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, total
from pellucid.materials.law import volumetric_stress
from pellucid.tensors import cofactor

ITERATIONS = 30  # number of iterations from a random vector
INTERVAL = 20  # steps between iterations while the frequency does not grow
GROWING = 0.003  # relative growth of the frequency in an iteration after which the next step has one too
SMALL = 1e-7  # trial displacement for differences of forces, relative to the extent of the solid

Forces = Callable[[np.ndarray, np.ndarray, float], None]
"""Function that computes internal forces [N] at displacements [m], both of shape (n, 3), which are reached within the
reciprocal of a frequency [rad/s]."""


class PowerIteration:
    """Estimates the largest natural frequency of nodes with an inertia [kg], shape (n,), and the vector of its mode. free:
    mask of the components that are not prescribed, shape (n, 3); extent: size of the solid [m].

    For a vector v of unit length in the norm of the inertia M, and the stiffness K, the estimate is the square root of the
    norm of M⁻¹ K v. The square of the estimate never exceeds the largest eigenvalue of M⁻¹ K and is closer to this
    eigenvalue than vᵀ K v.

    Viscous forces: central differences with C at the velocity half a step before, M a = -K u - C v, are stable for 4 M -
    dt² K - 2 dt C ≥ 0. With s = 2/dt, the limit is reached when s² is the largest eigenvalue of M⁻¹ (K + s C): the
    stiffness for a displacement that takes the time 1/s. s is therefore computed together with the vector; each iteration
    at least halves an error in s. For one mode of damping ratio ξ the limit is dt = 2/ω (√(1 + ξ²) - ξ).
    """

    def __init__(
        self, inertia: np.ndarray, free: np.ndarray, extent: float, shift: Callable[[np.ndarray], np.ndarray] | None = None
    ) -> None:
        """inertia: inertia of the nodes [kg], shape (n,); free: mask of the components that are not prescribed, shape (n, 3);
        extent: size of the solid [m]; shift: function that returns an addition to forces [N], shape (n, 3), before they are
        divided by the inertia; None for no addition.
        """
        self._inertia, self.free, self._extent, self._shift = inertia[:, None], free, extent, shift
        self._vector = self._without_preference()
        self._scale = 1.0
        self._waits, self._renewing = INTERVAL, 0
        self.frequency = 0.0
        """Latest estimate of the largest angular frequency [rad/s]."""

    def _without_preference(self) -> np.ndarray:
        return np.asarray(np.random.default_rng(0).standard_normal(self.free.shape) * self.free / np.sqrt(self._inertia))

    def renew(self) -> None:
        """Restart the search for the mode of highest frequency, with an iteration in each of the coming steps; the frequency
        does not decrease until the search is complete.
        """
        self._vector, self._waits, self._renewing = self._without_preference(), 0, ITERATIONS

    def is_due(self) -> bool:
        """Return True if the coming step includes a power iteration; call this once per step."""
        self._waits -= 1
        return self._waits <= 0

    def trial(self) -> np.ndarray:
        """Return the small trial displacement of the nodes for the next power iteration [m], shape (n, 3)."""
        self._vector /= self._size(self._vector) or 1.0
        self._scale = SMALL * self._extent / (float(abs(self._vector).max()) or 1.0)
        return self._scale * self._vector

    def learn(self, resistance: np.ndarray) -> None:
        """Update the estimate of the frequency from the forces that resist the trial displacement [N], shape (n, 3). Forces
        that are not finite are ignored.
        """
        if self._shift is not None:
            resistance = resistance + self._shift(resistance)
        vector = self.free * resistance / (self._scale * self._inertia)
        square = self._size(vector)
        if not np.isfinite(square):
            return
        before, self.frequency = self.frequency, float(np.sqrt(square))
        if self._renewing:
            self._renewing, self.frequency = self._renewing - 1, max(before, self.frequency)
        self._waits = 1 if self._renewing or self.frequency > (1.0 + GROWING) * before else INTERVAL
        self._vector = vector

    def _size(self, vector: np.ndarray) -> float:
        return float(np.sqrt(np.sum(self._inertia * vector * vector)))

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for a checkpoint: vector and counters on which the next iteration depends."""
        return {"fastest_mode": self._vector, "frequency": np.array([self.frequency, self._waits, self._renewing])}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore vector, frequency and counters of the iteration from the arrays of a checkpoint (see `state_arrays`)."""
        self._vector = arrays["fastest_mode"].copy()
        self.frequency = float(arrays["frequency"][0])
        self._waits, self._renewing = (int(number) for number in arrays["frequency"][1:])


def converge(
    iteration: PowerIteration, forces: Forces, displacement: np.ndarray, start: float = 0.0, renewed: int = ITERATIONS
) -> None:
    """Perform the first `ITERATIONS` power iterations around nodal displacements [m], shape (n, 3); `iteration` stores the
    estimated largest frequency.

    forces: function that computes the internal forces for three arguments: displacements [m], array for the result [N], and
    a frequency ω [rad/s], where the displacements are reached within the time 1/ω; start: ω in the first iterations;
    renewed: number of iterations after which ω is replaced by the current estimate. The internal forces of the body must be
    computed again afterwards.
    """
    here, there, told = np.empty_like(displacement), np.empty_like(displacement), start
    for number in range(ITERATIONS):
        if number % renewed == 0:
            told = iteration.frequency or told
            forces(displacement, here, told)
        forces(displacement + iteration.trial(), there, told)
        iteration.learn(here - there)


SOFT = 100.0  # smallest ratio of U'' to the shear modulus for which the factors save time
MOST_NODES = 10_000  # largest number of nodes, with factors of some seconds and some 100 MB
WORN = 1.0  # change of a deformation gradient, over √(shear modulus / U''), after which B is recomputed
CALMS = 0.9  # smallest ratio of `rate` between steps
CALM = 0.1  # ratio of `rate` to the largest frequency below which it no longer limits the step
STRAIN = 1e-6  # strain of the finite difference for U''


def pays(solid: Solid, shear: float) -> bool:
    """Return True if a solid of this shear modulus [Pa] relaxes faster with an inertia against changes of volume."""
    return len(solid.block_volume) > 0 and len(solid.volume) <= MOST_NODES and stiffness_of_volume(solid) > SOFT * shear


class VolumeInertia:
    """Inertia β Kᵥ against changes of volume (virtual mass), in addition to the masses M, for a solid with averaged volume
    ratio in a relaxation to a steady state; Kᵥ is the stiffness against changes of the volumes around the nodes .

    inertia: nodal masses M [kg], shape (n,); free: mask of the components that are not prescribed, shape (n, 3); shear:
    shear modulus at rest [Pa]; frequency: largest natural frequency with M alone [rad/s].

    The step of a relaxation is limited by the bulk modulus, but the motion to equilibrium is governed by the shear modulus.
    The number of steps is proportional to the square root of their ratio. Equilibria do not depend on inertia, so that the
    nodes get M + β Kᵥ instead of M, where Kᵥ = Bᵀ D B is the stiffness against changes of the volumes around the nodes, B =
    ∂(V_a J̄_a)/∂u, D = U''/V_a. No volumetric frequency then exceeds β^(-1/2). The effective forces are M (M + β Kᵥ)⁻¹ f = f -
    Bᵀ y, (1/(β D) + B M⁻¹ Bᵀ) y = B M⁻¹ f (Woodbury), with a matrix of one row per node, which is factored once, and again
    when the deformation has made it inaccurate.
    """

    def __init__(self, solid: Solid, inertia: np.ndarray, free: np.ndarray, shear: float, frequency: float) -> None:
        self._solid, self._inertia, self._free = solid, inertia[:, None], free
        self._found = VolumeRates(solid)
        self._bulk = stiffness_of_volume(solid)
        squared = frequency * frequency * min(1.0, 2.0 * shear / self._bulk)  # 1/β: squared frequency of shear alone
        self._compliance = squared * solid.volume / self._bulk
        self.displacement = np.zeros_like(free, float)
        """Nodal displacements at which the derivatives B of the volumes around the nodes were computed [m], shape (n, 3)."""
        self._alone, self.rate = 0.5 * frequency, 0.0
        """After a release of nodes, the rate at which B becomes inaccurate [1/s], which limits the step until it is small;
        otherwise 0."""
        self._tolerated = WORN * (shear / self._bulk) ** 0.5
        self.renew()

    def renew(self) -> None:
        """Recompute the derivatives B of the volumes around the nodes with respect to the nodal displacements in the present
        state, and factor the matrix of the effective forces again.
        """
        self.displacement[:] = self._solid.displacement
        self._deformation, self._change = self._solid.deformation.copy(), 0.0
        self._rates = self._found.find()
        self._rates.data *= self._free.ravel()[self._rates.indices]
        over = np.repeat(1.0 / self._inertia.ravel(), 3)
        system = sparse.diags_array(self._compliance) + (self._rates * over) @ self._rates.T
        self._factors: SuperLU = splu(sparse.csc_array(system), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def wears(self, dt: float, frequency: float) -> bool:
        """Return True if the solid has deformed so much that the volume derivatives B have become inaccurate. Called after each
        step dt [s]; frequency: present largest frequency [rad/s]."""
        before, self._change = self._change, float(abs(self._solid.deformation - self._deformation).max())
        if self.rate:
            wear = (self._change - before) / (self._tolerated * dt)
            self.rate = max(wear, CALMS * self.rate)
            if self.rate < CALM * frequency:
                self.rate = 0.0
        return self._change > self._tolerated

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return, for a checkpoint, the nodal displacements at which the volume derivatives B were computed, and indicators of
        their error."""
        return {"volume_inertia": self.displacement, "volume_wear": np.array([self._change, self.rate])}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of a checkpoint; the solid must have the displacements at which the volume derivatives B were
        computed."""
        self.renew()
        self._change, self.rate = arrays["volume_wear"].tolist()

    def release(self, free: np.ndarray) -> None:
        """Release constrained nodes. free: 1 for components of the nodes that are not prescribed, else 0, shape (n, 3). The
        time step is reduced to the limit without volume inertia, since released nodes accelerate suddenly.
        """
        self._free, self.rate = free, self._alone
        self.renew()

    def shift(self, force: np.ndarray) -> np.ndarray:
        """Return the addition to forces on the nodes [N], shape (n, 3), that turns them into effective forces for the nodal
        masses: with these forces the masses have the accelerations that the nodes have with the inertia against changes of
        volume."""
        y = self._factors.solve(self._rates @ (self._free * force / self._inertia).ravel())
        return np.asarray(-(self._rates.T @ y).reshape(-1, 3))


def stiffness_of_volume(solid: Solid) -> float:
    """Return the second derivative U'' of the volumetric energy of the solid's law at rest [Pa]."""
    higher, lower = (volumetric_stress(solid.law, 1.0 + strain) for strain in (STRAIN, -STRAIN))
    return float(higher - lower) / (2.0 * STRAIN)


@kernel(inner=True)
def _rates_of_pack(pack, block, solid, at, values):
    """Write the contributions of the points of a pack (four quadrature points) to the derivatives of the volumes around the
    nodes with respect to the nodal coefficients [m²] to `values`, one row for each pair of nodes, from row `at` on.

    block: the block of the pack; solid: data of `Solid`.
    """
    k = 9 * LANES * pack
    C, K = cofactor(components(solid.deformation, k, LANES)), solid.turns
    one, two, three = k, k + 3 * LANES, k + 6 * LANES
    gradients, corners = solid.gradients, solid.corners
    for entry in range(gradients.first[pack], gradients.first[pack + 1]):
        g = 3 * LANES * entry
        x, y, z = load(gradients.numbers, g), load(gradients.numbers, g + LANES), load(gradients.numbers, g + 2 * LANES)
        X = x + x * load(K, one) + y * load(K, two) + z * load(K, three)  # ∇p = Kᵀ g
        Y = y + x * load(K, one + LANES) + y * load(K, two + LANES) + z * load(K, three + LANES)
        Z = z + x * load(K, one + 2 * LANES) + y * load(K, two + 2 * LANES) + z * load(K, three + 2 * LANES)
        a, b = C[0] * X + C[1] * Y + C[2] * Z, C[3] * X + C[4] * Y + C[5] * Z
        c = C[6] * X + C[7] * Y + C[8] * Z
        for corner in range(corners.first[pack], corners.first[pack + 1]):
            share = load(corners.numbers, LANES * corner)
            values[at, 0], values[at, 1], values[at, 2] = total(share * a), total(share * b), total(share * c)
            at += 1


@parallel_loop()
def _find_rates(block, solid, first, values):
    for pack in range(PACKS * block, min(PACKS * (block + 1), len(first) - 1)):
        _rates_of_pack(pack, block, solid, first[pack], values)


class VolumeRates:
    """Computes B, the derivatives of the volumes around the nodes [m³] with respect to the nodal coefficients [m]: a matrix
    with a constant sparsity pattern.
    """

    def __init__(self, solid: Solid) -> None:
        self._solid, n = solid, len(solid.volume)
        gradients, corners = solid.gradients, solid.corners
        of_pack = np.diff(gradients.first), np.diff(corners.first)
        self._first = np.concatenate([[0], np.cumsum(of_pack[0] * of_pack[1])])
        pack = np.repeat(np.arange(len(of_pack[0])), of_pack[0] * of_pack[1])
        entry, corner = np.divmod(np.arange(int(self._first[-1])) - self._first[pack], of_pack[1][pack])
        row = nodes_of_entries(corners, solid.blocks)[corners.first[pack] + corner]
        column = nodes_of_entries(gradients, solid.blocks)[gradients.first[pack] + entry]
        pairs, self._place = np.unique(row * n + column, return_inverse=True)
        self._columns = (3 * (pairs % n)[:, None] + np.arange(3)).ravel()
        self._rows = 3 * np.searchsorted(pairs, np.arange(n + 1) * n)

    def find(self) -> sparse.csr_array:
        """Return the matrix B of the derivatives of the volumes around the nodes with respect to the nodal coefficients in
        the present state [m²], shape (n, 3 n)."""
        values, n = np.empty((int(self._first[-1]), 3)), len(self._solid.volume)
        _find_rates(len(self._solid.sums), Bundle(self._solid), self._first, values)
        sums = [np.bincount(self._place, values[:, d], len(self._columns) // 3) for d in range(3)]
        return sparse.csr_array((np.stack(sums, axis=1).ravel(), self._columns, self._rows), shape=(n, 3 * n))
