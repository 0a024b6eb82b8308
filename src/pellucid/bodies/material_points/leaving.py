"""Material points that leave and enter through open faces of the grid.

Points that left keep their rows in the arrays, after the rows of the points present, so that all frames of the results have
the same number of points. They do not belong to any slab (layer of grid cells), so kernels do not process them. Their mass,
volume and velocity are zero, and they stay at the face that they crossed until an entering point uses the row.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from pellucid.energy import Passed, kinetic_energies
from pellucid.grid.folding import cells_beyond
from pellucid.grid.lattice import Lattice
from pellucid.grid.points import FIELD_ENERGY
from pellucid.state import FIELDS


class OpenFaces:
    """The faces of the grid through which points may leave."""

    def __init__(self) -> None:
        self._open = np.zeros((3, 2), dtype=bool)

    def add(self, faces: Iterable[tuple[int, int]]) -> None:
        """Mark faces as open, each given by an axis and an end: 0 lower, 1 upper."""
        for axis, end in faces:
            self._open[axis, end] = True

    def crossed(self, position: np.ndarray, lattice: Lattice) -> tuple[np.ndarray, np.ndarray]:
        """Return two masks, shape (n,), for points at positions [m], shape (n, 3): the points beyond an open face of the grid,
        and the points beyond closed faces only.
        """
        cells = (position - np.array(lattice.lower)) * lattice.inverse_cell  # as kernels judge it
        beyond = np.stack([cells < 0.0, cells > np.array(lattice.counts)], axis=-1)
        beyond[:, [cells_beyond(lattice.folding, axis) > 0 for axis in range(3)]] = False  # there it goes on
        left = np.asarray((beyond & self._open).any(axis=(1, 2)))
        return left, beyond.any(axis=(1, 2)) & ~left


def taken_along(
    arrays: Mapping[str, np.ndarray], stored: np.ndarray, which: np.ndarray | slice, half_power: float
) -> tuple[Passed, float]:
    """Return number, mass, momentum and energies of leaving points (`Passed`), and the energy of their affine velocity
    fields (APIC) [J].

    arrays: arrays of the points present by name; stored: internal or strain energies of the points present [J], shape (n,);
    which: selection of the leaving points, shape (n,); half_power: half the power of the internal forces of the leaving
    points [W].
    """
    mass, velocity = arrays["mass"][which], arrays["velocity"][which]
    affine = float(np.sum(mass * arrays["affine"][which, FIELD_ENERGY])) if "affine" in arrays else 0.0
    kinetic = float(np.sum(kinetic_energies(mass, velocity))) + affine
    momentum = np.sum(mass[:, None] * velocity, axis=0)
    left = Passed(len(mass), float(np.sum(mass)), momentum, kinetic, float(np.sum(stored[which])), half_power)
    return left, affine


def empty(arrays: Mapping[str, np.ndarray], which: np.ndarray, lattice: Lattice) -> None:
    """Set mass, volume, velocity and stress of the selected points to zero, in place, and move them to the face of the grid
    that they crossed. arrays: arrays of the points; which: selection of points that left; lattice: cells of the grid.
    """
    for name, array in arrays.items():
        if name in FIELDS and FIELDS[name].leaves:
            array[which] = 0.0
    lower = np.array(lattice.lower)
    upper = lower + np.array(lattice.counts) * lattice.cell
    folds = [cells_beyond(lattice.folding, axis) > 0 for axis in range(3)]
    lower[folds], upper[folds] = -np.inf, np.inf
    arrays["position"][which] = np.clip(arrays["position"][which], lower, upper)


def brought_in(arrays: Mapping[str, np.ndarray], stored: np.ndarray) -> tuple[Passed, float]:
    """Return number, mass, momentum and energies of entering points (`Passed`), and the sum Σ m|v| over these points [kg
    m/s]. arrays: arrays of the entering points by name; stored: internal or strain energies of the points [J], shape (n,)."""
    entered, _ = taken_along(arrays, stored, slice(None), 0.0)
    return entered, float(np.sum(arrays["mass"] * np.linalg.norm(arrays["velocity"], axis=1)))
