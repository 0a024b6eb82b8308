"""Several bodies in contact as one system in the search for an equilibrium."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pellucid.parts.elastic_system import BodySystem, Trial


class JointSystem:
    """The `ElasticSystem` of several bodies in contact, whose nodes follow each other. Its factored stiffness is that of the
    bodies and of the springs of contact at their points, without the stiffness between two bodies.

    systems: systems of the bodies; exert: function that adds the contact forces at the present positions of the nodes to the
    loads of all bodies.
    """

    has_potential, has_contact, is_approximate = False, True, False

    def __init__(self, systems: Sequence[BodySystem], exert: Callable[[], None]) -> None:
        self._systems, self._exert = systems, exert
        self._ends = np.cumsum([len(system.rest) for system in systems])[:-1]
        self.rest = self._joined([system.rest for system in systems])
        self.rounding = sum(system.rounding for system in systems)
        self._renew: Callable[[float], None] = lambda share: None

    def _joined(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate(parts)

    def _each(self, values: np.ndarray) -> Iterator[tuple[BodySystem, np.ndarray]]:
        """Yield each system with its rows of values, shape (n, 3)."""
        return zip(self._systems, np.split(values, self._ends), strict=True)

    @property
    def position(self) -> np.ndarray:
        return self._joined([system.position for system in self._systems])

    @property
    def increment(self) -> np.ndarray:
        return self._joined([system.increment for system in self._systems])

    @property
    def tried(self) -> np.ndarray:
        return self._joined([system.tried for system in self._systems])

    @property
    def has_factors(self) -> bool:
        return all(system.has_factors for system in self._systems)

    @property
    def shift(self) -> float:
        return max(system.shift for system in self._systems)

    def begin(self, dt: float) -> None:
        for system in self._systems:
            system.begin(dt)

    def take_loads(self, renew: Callable[[float], None], follow: bool) -> None:
        self._renew = renew
        for system in self._systems:
            system.take_loads(renew, follow)

    def attempt(self, position: np.ndarray) -> Trial:
        for system, place in self._each(position):
            system.place(place)
        self._renew(1.0)
        self._exert()
        trials = [system.judge() for system in self._systems]
        residual = self._joined([trial.residual for trial in trials])
        size = sum(trial.size for trial in trials)
        return Trial(sum(trial.energy for trial in trials), residual, size, all(trial.is_valid for trial in trials))

    def factor(self) -> None:
        for system in self._systems:
            system.factor()

    def solve(self, force: np.ndarray) -> np.ndarray:
        return self._joined([system.solve(part) for system, part in self._each(force)])

    def follow(self, force: np.ndarray) -> np.ndarray:
        return self._joined([system.follow(part) for system, part in self._each(force)])

    def unstable_direction(self) -> None:
        return None

    def lowest_frequency(self) -> None:
        return None

    def corrects(self, tolerance: float) -> bool:
        corrected = [system.corrects(tolerance) for system in self._systems]  # of all, not up to the first
        return any(corrected)

    def aligned(self, position: np.ndarray) -> np.ndarray:
        return position  # contact may hold a body that nothing else holds

    def obstacle(self) -> str | None:
        return next((reason for system in self._systems if (reason := system.obstacle()) is not None), None)

    def accept(self, position: np.ndarray, dt: float, jumped: bool) -> None:
        for system, place in self._each(position):
            system.accept(place, dt, jumped)

    def reject(self) -> None:
        for system in self._systems:
            system.reject()
