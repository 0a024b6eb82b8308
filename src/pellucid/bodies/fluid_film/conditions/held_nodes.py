"""Prescribed velocities at nodes of a film: along axes of space by supports, or along the normal of the film by motions."""

from collections.abc import Sequence

import numpy as np

from pellucid.bodies.fluid_film.balance import StepDone
from pellucid.bodies.fluid_film.conditions.nodal_frames import Led
from pellucid.bodies.fluid_film.forms.film_forces import in_space
from pellucid.energy import INTERNAL, MOTION, SUPPORT, StepWork
from pellucid.errors import CaseError, Problem
from pellucid.parts.capabilities import NodalSupport
from pellucid.parts.support_precedence import find_owners


class HeldNodes:
    """Stores the prescribed velocities of n film nodes and records the work of prescribing them.

    axes: the d axes of space along which the film extends; is_around: True for a surface of revolution, on which forces
    perpendicular to the axis cancel.
    """

    def __init__(self, n: int, axes: Sequence[int], is_around: bool) -> None:
        self._n, self._axes, self._across = n, list(axes), 0.0 if is_around else 1.0
        self.supports: Sequence[NodalSupport] = ()
        self._owner = np.zeros((n, 3), np.int64)
        self.motions: Sequence[str] = ()
        self.numbers = np.zeros(n, np.int64)  # of each node: 1 + index of its motion, or 0 without a motion
        self.rates = np.zeros(0)  # of the motions along the normal [m/s]

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """Set the supports that prescribe velocities of nodes."""
        self.supports, self._owner = supports, find_owners(supports, self._n, may_leave=True)

    def check(self, name: str) -> None:
        """Raise CaseError if a node has both a support and a prescribed motion along the normal. name: name of the film."""
        for number, support in enumerate(self.supports):
            both = np.flatnonzero(self._constrained(number).any(axis=1) & (self.numbers > 0))
            if len(both):
                motion = self.motions[self.numbers[both[0]] - 1]
                text = f"{support.label} constrains {len(both)} of the nodes of film {name} that follow this motion"
                remedy = "move or shrink its `part` or the `where` of the support, so that they do not overlap"
                raise CaseError(Problem(text, f"motion.{motion}.part", remedy=remedy))

    def prescribed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a mask of the velocity components prescribed by supports and their values [m/s], shape (n, d) each."""
        known, velocity = np.zeros((self._n, len(self._axes)), bool), np.zeros((self._n, len(self._axes)))
        for number, support in enumerate(self.supports):
            chosen = self._constrained(number)
            known |= chosen
            velocity = np.where(chosen, np.array(support.velocity)[self._axes], velocity)
        return known, velocity

    def led(self, before: np.ndarray) -> Led:
        """Return the nodes with a prescribed velocity along the normal, and these velocities. before: nodal velocities in the
        previous step [m/s], shape (n, d).
        """
        return Led(self.numbers > 0, np.append(0.0, self.rates)[self.numbers], before)

    def no_work(self, columns: int) -> StepWork:
        """Return a `StepWork` (work and impulses of a step) with all entries zero. columns: length of its array of works."""
        motions = {name: np.zeros(3) for name in self.motions}
        return StepWork(np.zeros(columns), 0.0, np.zeros((len(self.supports) + 1, 3)), np.zeros(3), motions)

    def count(self, done: StepDone, dt: float, work: StepWork) -> None:
        """Add the work and the impulses of supports and motions in one substep of the film to `work`.

        done: velocities and forces of the substep; dt: its length [s].
        """
        for number in range(len(self.supports)):
            forces = np.where(self._constrained(number), done.prescribed, 0.0)
            work.reactions[number] += self._counted(forces, done, dt, SUPPORT, work)
        for number, name in enumerate(self.motions, start=1):
            forces = np.where((self.numbers == number)[:, None], done.leading, 0.0)
            work.motions[name][:] += self._counted(forces, done, dt, MOTION, work)

    def _counted(self, forces: np.ndarray, done: StepDone, dt: float, column: int, work: StepWork) -> np.ndarray:
        """Add the work of forces on the nodes [N], shape (n, d), over a substep dt [s] to `work.works[column]`, and return
        their impulse [N s], shape (3,). done: velocities of the substep.
        """
        worked = dt * float(np.sum(forces * done.velocity))
        work.works[column] += worked
        work.works[INTERNAL] -= worked
        return np.asarray(dt * in_space(forces, self._axes).sum(axis=0) * (self._across, 1.0, 1.0))

    def _constrained(self, number: int) -> np.ndarray:
        """Return a mask of the velocity components that the support with this number prescribes, shape (n, d)."""
        return np.asarray(self._owner[:, self._axes] == number + 1)
