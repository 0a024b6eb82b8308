"""The largest frequency of a solid about its present state, by power iteration: it bounds the step of central differences.

The iteration goes on during a run: one every `INTERVAL` steps, from the vector that the last one left, and one in each step
while the frequency grows, as it does where a solid is crushed.
"""

from collections.abc import Callable, Mapping

import numpy as np

ITERATIONS = 30  # at first, from a vector without preference
INTERVAL = 20  # steps between iterations while the frequency does not grow
GROWING = 0.003  # relative growth of the frequency in an iteration after which the next step has one too
SMALL = 1e-7  # of the extent of the solid: the displacement with which forces are differenced

Forces = Callable[[np.ndarray, np.ndarray, float], None]
"""Fills internal forces [N] at displacements [m], both of shape (n, 3), that are reached in the time of a frequency [rad/s]."""


class PowerIteration:
    """The fastest mode so far of nodes with an inertia [kg], shape (n,), that move where `free`, shape (n, 3).

    extent: of the solid [m]. With v of unit length by the inertia M, the frequency is the root of the length of M⁻¹ K v, which
    never passes the largest eigenvalue and is nearer to it than vᵀ K v.

    Viscous forces: central differences with C by the velocity of half a step before, M a = -K u - C v, are stable for
    4 M - dt² K - 2 dt C ≥ 0. With s = 2/dt the bound is where s² is the largest eigenvalue of M⁻¹ (K + s C): the stiffness in a
    displacement that takes the time 1/s. So it is found with the vector; an error in s is halved, at least, each time.
    For one mode of damping ratio ξ it is dt = 2/ω (√(1 + ξ²) - ξ).
    """

    def __init__(
        self, inertia: np.ndarray, free: np.ndarray, extent: float, shift: Callable[[np.ndarray], np.ndarray] | None = None
    ) -> None:
        """shift: by what forces [N], shape (n, 3), change before they meet the inertia, where they do."""
        self._inertia, self.free, self._extent, self._shift = inertia[:, None], free, extent, shift
        self._vector = self._without_preference()
        self._scale = 1.0
        self._waits, self._renewing = INTERVAL, 0
        self.frequency = 0.0
        """The largest angular frequency that was found last [rad/s]."""

    def _without_preference(self) -> np.ndarray:
        return np.asarray(np.random.default_rng(0).standard_normal(self.free.shape) * self.free / np.sqrt(self._inertia))

    def renew(self) -> None:
        """Look for the fastest mode from the start, with an iteration in each of the coming steps; until it is found, the
        frequency does not fall."""
        self._vector, self._waits, self._renewing = self._without_preference(), 0, ITERATIONS

    def is_due(self) -> bool:
        """Return True if the coming step has an iteration; called once in each."""
        self._waits -= 1
        return self._waits <= 0

    def trial(self) -> np.ndarray:
        """Return the trial displacement of the nodes [m], shape (n, 3)."""
        self._vector /= self._size(self._vector) or 1.0
        self._scale = SMALL * self._extent / (float(abs(self._vector).max()) or 1.0)
        return self._scale * self._vector

    def learn(self, resistance: np.ndarray) -> None:
        """Update the estimate from the resisting forces [N], shape (n, 3). Forces that are not finite are ignored."""
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
        """Return the arrays that the next iteration depends on."""
        return {"fastest_mode": self._vector, "frequency": np.array([self.frequency, self._waits, self._renewing])}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of a checkpoint."""
        self._vector = arrays["fastest_mode"].copy()
        self.frequency = float(arrays["frequency"][0])
        self._waits, self._renewing = (int(number) for number in arrays["frequency"][1:])


def converge(
    iteration: PowerIteration, forces: Forces, displacement: np.ndarray, start: float = 0.0, renewed: int = ITERATIONS
) -> None:
    """The first iterations about displacements [m], shape (n, 3), after which forces must be found again.

    start: what forces are told of the frequency at first; renewed: the iterations after which they are told what was found.
    """
    here, there, told = np.empty_like(displacement), np.empty_like(displacement), start
    for number in range(ITERATIONS):
        if number % renewed == 0:
            told = iteration.frequency or told
            forces(displacement, here, told)
        forces(displacement + iteration.trial(), there, told)
        iteration.learn(here - there)
