"""Interface of the solvers that compute the nodal velocities of a film from the linear forms (`ElementRows`) of its
elements.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, SharedRows


class IncompatibleLoad(Exception):
    """The loads do work on motions without resistance, so that no velocity balances them.

    driven: forces of the loads on these motions [N], shape (n, d).
    """

    def __init__(self, driven: np.ndarray) -> None:
        super().__init__("a load drives motions without resistance")
        self.driven = driven


class Border(NamedTuple):
    """A linear constraint row · v = rate of the nodal velocities v."""

    row: np.ndarray  # (n, d) coefficients
    rate: float  # prescribed value of row · v


class Solution(NamedTuple):
    """Solution of the linear system of a film: nodal velocities, and the k factors of the linear constraints. The
    constraint forces on the nodes are the sum of each factor times the coefficients of its constraint (`Border.row`)."""

    velocity: np.ndarray  # (n, d) nodal velocities [m/s]
    border_forces: np.ndarray  # (k,) e.g. pressure [Pa] for a constraint of the volume


class System(NamedTuple):
    """The linear system (R + S) v = f + S g for the nodal velocities v of a film with nodes at x.

    R, the resistance, and S, the stiffness, are sums of squares of linear forms (`ElementRows`); f are the forces and g is a
    first velocity estimate.
    """

    x: np.ndarray  # (n, d) nodal positions [m]
    area: np.ndarray  # (n,) area of the film at each node [m²]
    resistance: Sequence[ElementRows | SharedRows]  # R [N s/m]
    stiffness: Sequence[ElementRows]  # S [N s/m]
    force: np.ndarray  # (n, d) f [N]
    load: np.ndarray  # (n, d) external part of f [N]; the internal part does no work on rigid motions
    guess: np.ndarray  # (n, d) g, first velocity [m/s]
    known: np.ndarray  # (n, d) mask of the prescribed velocity components
    velocity: np.ndarray  # (n, d) values of the prescribed components [m/s]
    turning: Sequence[ElementRows] | None
    """Measure of rotation, used if some motions have no resistance: among the motions with the same strain rates, the
    solver chooses the one that rotates least. On surfaces this is the motion without mean velocity and rotation."""
    accuracy: float  # allowed relative error of the velocity
    directions: np.ndarray | None = None
    """Directions of the components of vectors and rows at each node, shape (n, d, d); None for the axes of space."""


def refuse_driven(system: System, driven: np.ndarray, most: float) -> None:
    """Raise IncompatibleLoad if loads do work on motions without resistance.

    system: the balance of forces, with the loads; driven: forces of the loads on these motions along the directions of the
    system [N], shape (n, d); most: largest allowed ratio of these forces to the loads, both as sums of magnitudes over the
    nodes.
    """
    if np.linalg.norm(driven, axis=1).sum() > most * np.linalg.norm(system.load, axis=1).sum():
        in_space = driven if system.directions is None else np.einsum("ncd,nc->nd", system.directions, driven)
        raise IncompatibleLoad(in_space)


class FilmSolver(Protocol):
    """Interface of a solver that computes the nodal velocities of a film under linear constraints."""

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        """Return the nodal velocities that satisfy the balance of forces and the linear constraints `borders`, and the
        constraint forces. Raises IncompatibleLoad if the loads do work on motions without resistance.
        """

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return, for a checkpoint, the arrays on which the next solution depends in addition to the system of equations, such
        as the matrix whose factors are the preconditioner.
        """

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays that `state_arrays` returned, from a checkpoint."""
