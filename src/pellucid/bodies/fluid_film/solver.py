"""The interface of what finds the velocities of a film from the forms of its elements."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np


class IncompatibleLoad(Exception):
    """The load does work on motions that nothing resists: there is no velocity at which it is balanced."""


class Border(NamedTuple):
    """A linear constraint: row · v = rate."""

    row: np.ndarray  # (n, d)
    rate: float


class Solution(NamedTuple):
    """Velocities of the nodes [m/s], shape (n, d), and the forces of the borders, one for each: they act along their rows."""

    velocity: np.ndarray
    border_forces: np.ndarray


class FilmSolver(Protocol):
    """Solves (R + S) v = f + S g under linear constraints, with matrices R, S of the elements, shape (e, md, md)."""

    def solve(
        self,
        resistance: np.ndarray,
        stiffness: np.ndarray,
        force: np.ndarray,
        guess: np.ndarray,
        borders: Sequence[Border],
        known: np.ndarray,
        velocity: np.ndarray,
        turning: np.ndarray | None,
    ) -> Solution:
        """Velocities for forces f on the nodes [N], shape (n, d), and velocities g about which the stiffness is zero.

        known: (n, d) components that are prescribed, with their values in `velocity`. turning: of the elements, shape
        (e, md, md), what the film turns by, where some motions meet no resistance: of those with the same strain rates the
        one is taken that turns least, and IncompatibleLoad is raised where the load drives motions without resistance.
        """
