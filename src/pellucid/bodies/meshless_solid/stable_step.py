"""Estimate of the largest natural frequency of a solid in its present state, by power iteration; it limits the time step of
central differences.

The iteration continues during a run: one iteration every `INTERVAL` steps, starting from the vector of the last one, and one in
each step while the frequency grows, for example while a solid is compressed.
"""

from collections.abc import Callable, Mapping

import numpy as np

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
