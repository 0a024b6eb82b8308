"""Several bodies in contact, and rigid bodies under forces, as one system in the search for an equilibrium."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pellucid.parts.elastic_system import BodySystem, Trial
from pellucid.simulation.free_tools import FreeTool

SOFTEST = 1e-3
"""Least stiffness of a rigid body in the factors, relative to a deforming body as a whole. Without it a body that nothing holds
yet along an axis, such as a ball on a flat side, would move without bound; it has no effect on the equilibrium."""


class JointSystem:
    """The `ElasticSystem` of several bodies in contact, whose nodes follow each other, and of rigid bodies whose places follow
    from forces. Its factored stiffness is that of the bodies and of the springs of contact at their points, without the
    stiffness between two bodies that deform. The unknowns of the rigid bodies are eliminated last, so that their stiffness is
    that of contact and bodies in series.

    Arrays of n nodes have one more row for each rigid body: its displacement since the start, or the force on it.

    systems: systems of the bodies; exert: function that adds the contact forces at the present positions of the nodes to the
    loads of all bodies; tools: rigid bodies that are free along an axis; stiffness_of: function that returns the stiffness of
    contact against displacements of a rigid body along the axes, shape (3, 3) [N/m]; coupling: function of the index of a body,
    a rigid body and an axis, that returns the forces on the nodes of the body for a unit displacement of the rigid body [N/m].
    """

    has_potential, has_contact, is_approximate = False, True, False

    def __init__(
        self,
        systems: Sequence[BodySystem],
        exert: Callable[[], None],
        tools: Sequence[FreeTool] = (),
        stiffness_of: Callable[[FreeTool], np.ndarray] = lambda tool: np.zeros((3, 3)),
        coupling: Callable[[int, FreeTool, int], np.ndarray] = lambda body, tool, axis: np.zeros((0, 3)),
    ) -> None:
        self._systems, self._exert, self._tools = systems, exert, tools
        self._stiffness_of, self._coupling = stiffness_of, coupling
        self._ends = np.cumsum([len(system.rest) for system in systems])
        self._free = [(row, axis) for row, tool in enumerate(tools) for axis in range(3) if tool.free[axis]]
        self._pulls, self._moves, self._schur = list[np.ndarray](), list[np.ndarray](), np.zeros((0, 0))
        # rigid bodies have no part in the size of the system: their rows are within the bodies until the first trial
        self.rest = self._joined([system.rest for system in systems], [systems[0].rest[0]] * len(tools))
        self.rounding = sum(system.rounding for system in systems)
        self._renew: Callable[[float], None] = lambda share: None

    def _joined(self, parts: Sequence[np.ndarray], of_tools: Sequence[np.ndarray] | None = None) -> np.ndarray:
        rows = [np.zeros(3)] * len(self._tools) if of_tools is None else of_tools
        return np.concatenate([*parts, np.array(rows).reshape(-1, 3)])

    def _each(self, values: np.ndarray) -> Iterator[tuple[BodySystem, np.ndarray]]:
        """Yield each system with its rows of values, shape (n, 3)."""
        return zip(self._systems, np.split(values, self._ends)[:-1], strict=True)

    def _of_tools(self, values: np.ndarray) -> np.ndarray:
        """Return the rows of values that belong to the rigid bodies."""
        return values[self._ends[-1] :]

    @property
    def position(self) -> np.ndarray:
        return self._joined([system.position for system in self._systems], [tool.position for tool in self._tools])

    @property
    def increment(self) -> np.ndarray:
        return self._joined([system.increment for system in self._systems])

    @property
    def tried(self) -> np.ndarray:
        return self._joined([system.tried for system in self._systems], [tool.tried for tool in self._tools])

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
        for tool, moved in zip(self._tools, self._of_tools(position), strict=True):
            tool.place(moved)
        self._of_tools(self.rest)[...] = self._of_tools(position)  # errors are relative to the displacements of the bodies
        self._renew(1.0)
        self._exert()
        trials = [system.judge() for system in self._systems]
        residual = self._joined([trial.residual for trial in trials], [tool.residual for tool in self._tools])
        size = sum(trial.size for trial in trials) + sum(tool.size for tool in self._tools)
        return Trial(sum(trial.energy for trial in trials), residual, size, all(trial.is_valid for trial in trials))

    def factor(self) -> None:
        for system in self._systems:
            system.factor()
        if self._tools:
            self._factor_tools()

    def _factor_tools(self) -> None:
        """Compute, for each unknown of the rigid bodies, the forces on the nodes and the displacements of the nodes for a unit
        of it, and the stiffness of these unknowns when the nodes follow them."""
        own = [self._stiffness_of(tool) + np.diag(tool.stiffness) for tool in self._tools]
        forces = [[self._coupling(k, self._tools[row], axis) for k in range(len(self._systems))] for row, axis in self._free]
        self._pulls = [self._joined(each) for each in forces]
        self._moves = [
            self._joined([system.solve(force) for system, force in zip(self._systems, each, strict=True)]) for each in forces
        ]
        matrix = np.array(
            [
                [
                    (own[row][axis, other_axis] if row == other else 0.0) - float(np.sum(pull * moved))
                    for (other, other_axis), moved in zip(self._free, self._moves, strict=True)
                ]
                for (row, axis), pull in zip(self._free, self._pulls, strict=True)
            ]
        ).reshape(len(self._free), len(self._free))
        least = SOFTEST * min(system.resistance / float(np.ptp(system.rest, axis=0).max()) ** 2 for system in self._systems)
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        self._schur = np.einsum("ik,k,jk->ij", vectors, 1.0 / np.maximum(values, least), vectors)

    def _with_tools(self, moved: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return the displacements of nodes and rigid bodies under forces [N], shape (n, 3), from the displacements of the
        nodes [m] that keep the rigid bodies in place."""
        if not self._free:
            return moved
        on_tools = self._of_tools(force)
        left = [on_tools[at] + float(np.sum(pull * moved)) for at, pull in zip(self._free, self._pulls, strict=True)]
        for at, row, own in zip(self._free, self._schur, self._moves, strict=True):
            way = sum(float(a) * b for a, b in zip(row, left, strict=True))
            moved = moved + way * own
            self._of_tools(moved)[at] += way
        return moved

    def solve(self, force: np.ndarray) -> np.ndarray:
        return self._with_tools(self._joined([system.solve(part) for system, part in self._each(force)]), force)

    def follow(self, force: np.ndarray) -> np.ndarray:
        return self._with_tools(self._joined([system.follow(part) for system, part in self._each(force)]), force)

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
