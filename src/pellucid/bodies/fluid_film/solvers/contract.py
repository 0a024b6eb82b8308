"""The interface of what finds the velocities of a film from the forms of its elements."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, SharedRows


class IncompatibleLoad(Exception):
    """The load does work on motions that nothing resists: there is no velocity at which it is balanced.

    driven: the forces that drive them [N], shape (n, d).
    """

    def __init__(self, driven: np.ndarray) -> None:
        super().__init__("a load drives motions without resistance")
        self.driven = driven


class Border(NamedTuple):
    """A linear constraint: row · v = rate."""

    row: np.ndarray  # (n, d)
    rate: float


class Solution(NamedTuple):
    """Velocities of the nodes [m/s], shape (n, d), and the forces of the borders, one for each: they act along their rows."""

    velocity: np.ndarray
    border_forces: np.ndarray


class System(NamedTuple):
    """(R + S) v = f + S g, with matrices R, S that are sums of squares of rows, for nodes at x."""

    x: np.ndarray  # (n, d) [m]
    area: np.ndarray  # (n,) of the nodes [m²]
    resistance: Sequence[ElementRows | SharedRows]  # R [N s/m]
    stiffness: Sequence[ElementRows]  # S [N s/m]
    force: np.ndarray  # (n, d) f [N]
    load: np.ndarray  # (n, d) what of it acts from outside [N]; the film's own forces do no work on rigid motions
    guess: np.ndarray  # (n, d) g [m/s], velocities about which the stiffness is zero
    known: np.ndarray  # (n, d) components that are prescribed
    velocity: np.ndarray  # (n, d) their values [m/s]
    turning: Sequence[ElementRows] | None
    """What the film turns by, where some motions meet no resistance: of those with the same strain rates the one is taken that
    turns least; on surfaces, that has no mean velocity and rotation."""
    accuracy: float  # error of the velocity that does not matter, of the velocity
    directions: np.ndarray | None = None
    """Of the components of vectors and rows at each node, shape (n, d, d), where they are not those of space."""


def refuse_driven(system: System, driven: np.ndarray, most: float) -> None:
    """Raise IncompatibleLoad where these forces on motions without resistance, in the directions of the system [N], shape
    (n, d), are more than this share of the loads, both summed over the nodes."""
    if np.linalg.norm(driven, axis=1).sum() > most * np.linalg.norm(system.load, axis=1).sum():
        in_space = driven if system.directions is None else np.einsum("ncd,nc->nd", system.directions, driven)
        raise IncompatibleLoad(in_space)


class FilmSolver(Protocol):
    """Finds the velocities of a film under linear constraints."""

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        """Raises IncompatibleLoad where the forces drive motions that meet no resistance."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays that the next solution depends on besides its system, for checkpoints."""

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of a checkpoint."""
