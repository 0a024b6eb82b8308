"""Material points that leave and enter through open faces of the grid.

Points that left keep their rows in the arrays, after the rows of the points present, so that all frames of the results have
the same number of points. They do not belong to any slab (layer of grid cells), so kernels do not process them. Their mass,
volume and velocity are zero, and they stay at the face that they crossed until an entering point uses the row.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from pellucid.bodies.material_points.initial_arrays import arrays_at, point_energies, with_room
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.energy import Passed, kinetic_energies
from pellucid.errors import RunStopped
from pellucid.grid.folding import cells_beyond
from pellucid.grid.lattice import Lattice
from pellucid.grid.points import FIELD_ENERGY, LOST, OK, POWER
from pellucid.materials.contract import PointMaterial
from pellucid.materials.law import Law
from pellucid.materials.point_state import in_arrays
from pellucid.model import Vector
from pellucid.parts.capabilities import GainsPoints, LosesPoints
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.state import FIELDS

NOBODY = np.zeros(0, dtype=bool)
NOWHERE, NOTHING = np.zeros((0, 3)), np.zeros(0)


class OpenPoints(PointsOnGrid, LosesPoints, GainsPoints):
    """Base class of bodies whose points may leave and enter through open faces of the grid."""

    law: Law
    material: PointMaterial
    _model: SeededBody
    _gravity: Vector
    _open_faces: "OpenFaces | None" = None
    _leaving, _takes_in = NOBODY, False
    _just_left = NOWHERE, NOTHING

    @property
    def may_leave(self) -> bool:  # type: ignore[override]
        """True if points may leave through open faces of the grid: no motion prescribes the body, and its pressure is not
        averaged over cells (`cell_pressure`).
        """
        return self.constraint is None and not self._model.cell_pressure

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        self.storage.keep_whole()
        self._open_faces = self._open_faces or OpenFaces()
        self._open_faces.add(faces)
        self.constant_fields = ("id",)

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped` if a point has a fault, such as a position outside the grid. Points that left through open faces
        are no faults; they are removed when the step is recorded.
        """
        self._just_left = NOWHERE, NOTHING
        fault = self.storage.slabs.fault if self._open_faces is None else domain.complete(self.storage.slabs.fault)
        if (
            self._open_faces is not None
            and np.count_nonzero(fault[:, 0])
            and np.all((fault[:, 0] == OK) | (fault[:, 0] == LOST))
        ):
            self._leaving, lost = self._open_faces.crossed(self.storage.present("position"), self.grid.lattice)
            if lost.any():
                self.stop(LOST, int(np.flatnonzero(lost)[0]), n_steps, time)
            if self._leaving.any():
                return
        super().check(n_steps, time)

    def let_leave(self) -> Passed | None:
        gone, self._leaving = self._leaving, NOBODY
        if not gone.any():
            return None
        there = {name: self.storage.present(name) for name in self.arrays}
        stored, dissipated = self.stored_field("stored_energy"), "dissipated_energy" in there
        if dissipated:
            lost = there["mass"] * there["dissipated_energy"]
            self.totals.parts["dissipated"] -= float(np.sum(lost[gone]))
            stored = stored + lost
        self.storage.complete_all()
        of_lost = domain.complete(self.storage.slabs.of_lost)
        power = 0.0 if self.material.keeps_heat else -0.5 * float(ordered_sum(of_lost)[POWER])
        left, affine = taken_along(there, stored, gone, power)
        self._just_left = there["position"][gone], there["volume"][gone]
        speed = np.linalg.norm(there["velocity"][gone], axis=1)
        self.totals.momentum_size -= float(np.sum(there["mass"][gone] * speed))
        self.totals.give(left, affine)
        empty(there, gone, self.grid.lattice)
        self.storage.put_behind(gone)
        return left

    def just_left(self) -> tuple[np.ndarray, np.ndarray]:
        return self._just_left

    @property
    def n_told(self) -> int:
        """Number of points in messages and summaries: the points present if points can enter, otherwise all, including points
        that left.
        """
        return self.storage.n_present if self._takes_in else self.n_points

    def make_room(self, rows: int, place: np.ndarray) -> None:
        self.storage.keep_whole()
        self._takes_in = True
        before, n = self.n_points, self.n_points + rows
        self.arrays |= {name: with_room(array, n) for name, array in self.arrays.items()}
        self.arrays["id"][before:], self.arrays["position"][before:] = np.arange(before, n), place
        self._heat = np.zeros(n if self.keeps_heat else 0)
        self.constant_fields = ("id",)
        self._bind()
        self._make_bundles()

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        if self._takes_in:
            self.storage.shared.first[-1] = self.n_points  # loading moves rows of points without mass behind the others
        super().load_state(state)

    def state_at(self, position: np.ndarray, volume: np.ndarray) -> dict[str, np.ndarray]:
        return arrays_at(self._model, position, volume, self._gravity)

    def stresses_of(self, sets: Callable[[np.ndarray], Sequence[np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
        self.storage.complete("position", "stress", "volume")
        chosen = sets(self.arrays["position"][: self.storage.n_present])
        return [(self.arrays["stress"][numbers], self.arrays["volume"][numbers]) for numbers in chosen]

    def pressed(self, arrays: Mapping[str, np.ndarray], more: float) -> Mapping[str, np.ndarray]:
        return self.material.pressed(arrays, more)

    def let_in(self, arrays: Mapping[str, np.ndarray], n_steps: int, time: float) -> Passed:
        """Add points with these arrays (position, velocity, mass, volume, material state) to the body, e.g. at an inflow,
        after a step; the points must lie in the grid. They are stored in the rows of points that left or have not entered
        yet.

        n_steps, time: steps and time [s] of the run, for the message. Returns mass, momentum and energies of the added
        points. Raises RunStopped if no rows are left.
        """
        there, mass = self.storage.n_present, arrays["mass"]
        end = there + len(mass)
        if end > self.n_points:
            text = (
                f"step {n_steps}, time {time:.6g} s: the grid is full: no points can be added to the {there} points "
                f"of body `{self.name}`"
            )
            remedy = (
                "add an [[outflow]], or enlarge the grid; a gas enters at its initial pressure: set it to the pressure at the "
                "face"
            )
            raise RunStopped(f"{text}; {remedy}", step=n_steps, time=time, body=self.name)
        self.storage.complete_all()
        for name, array in self.arrays.items():
            if name != "id":
                array[there:end] = arrays.get(name, 0.0)
        entered, size = brought_in(arrays, self._stored_in(arrays))
        self.totals.take(entered, size)
        self.storage.shared.first[-1] = end
        self.storage.sort()
        return entered

    def _stored_in(self, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the internal or strain energies of points [J], shape (n,), from their arrays (mass, volume, material
        state).
        """
        kind = self.material.energy_field
        if kind in arrays:
            return np.asarray(arrays["mass"] * arrays[kind])
        state = in_arrays(self.material.initial_state(), arrays)
        return np.asarray(arrays["mass"] * point_energies(self.law, state, arrays["mass"] / arrays["volume"]))


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
        if FIELDS[name].leaves:
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
