"""The motion of a film at an instant and over a step: loads, resistance, constraints.

A step is the midpoint rule, or with another weight α the generalised trapezoidal rule of Benet 2015, eq. 6.52: a first
velocity, at the start, gives the place x + α dt v where the velocity of the step is found. So that what is stiff may relax
faster than a step, changes of pressure, tension and curvature over c dt resist the first velocity, and then what the second
differs from it, which leaves the order as it is. A motion that relaxes at once is over after the step where
1 - 2/c + α/c² = 0 (as in the Rosenbrock method of Verwer et al. 1999, SIAM J. Sci. Comput. 20, 1456); of both roots the
smaller has the smaller error.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.forms import FilmPhysics, Forms, Tension, bending_energies, dissipation, forms, turning
from pellucid.bodies.fluid_film.geometry import FilmGeometry
from pellucid.bodies.fluid_film.nodal_sums import NodalSums, Rows
from pellucid.bodies.fluid_film.operators import Operators
from pellucid.bodies.fluid_film.solver import Border, FilmSolver, System
from pellucid.materials.film import FilmMaterial
from pellucid.parts.surface_load import SurfacePoints, Traction

ACCURACY, FIRST_ACCURACY = 1e-7, 1e-4  # of velocities, as far as solutions are iterative; the first estimate's counts once less


class Driving(NamedTuple):
    """What acts on the film over a step."""

    tractions: Sequence[tuple[int, Traction]]  # each with the column of its work
    forces: Sequence[tuple[int, np.ndarray]]  # on the nodes [N], shape (n, d), each with the column of its work
    known: np.ndarray  # (n, d) components of velocity that are prescribed
    velocity: np.ndarray  # (n, d) their values [m/s]
    volume: float | None  # that the film is to hold at the end of the step [m³]
    area: float | None  # that it is to have then [m²]


class StepDone(NamedTuple):
    """A step of the film."""

    x: np.ndarray  # (n, d) at its end [m]
    velocity: np.ndarray  # (n, d) over it [m/s]
    change: float  # largest change of a velocity component from the first estimate to the last [m/s]
    loads: Sequence[tuple[int, float]]  # power of each load [W], with its column
    viscous: float  # [W]
    drag: float  # [W]
    prescribed: np.ndarray  # (n, d) forces that lead what is prescribed [N]
    bordered: float  # power of the constraints of volume and area [W]


class FilmBalance:
    """Finds the motions of a film."""

    def __init__(
        self,
        geometry: FilmGeometry,
        material: FilmMaterial,
        physics: FilmPhysics,
        initial_density: float,
        solver: FilmSolver,
    ) -> None:
        self._initial_density = initial_density
        self.geometry, self.material, self.physics, self.solver = geometry, material, physics, solver
        self._sums = NodalSums(geometry.nodes, *geometry.held.shape)
        self._resists_all = min(physics.drag) > 0.0

    def part_areas(self, o: Operators) -> np.ndarray:
        """Areas of the parts of the film [m²]."""
        shares = self.geometry.shares
        areas = np.einsum("eq,qc->ec", o.area, shares.share)
        return np.bincount(shares.part.ravel(), areas.ravel())

    def densities(self, o: Operators, mass: np.ndarray) -> np.ndarray:
        """Of the parts [kg/m²]."""
        return np.asarray(mass / self.part_areas(o))

    def at_points(self, parts: np.ndarray) -> np.ndarray:
        """What parts have, at the quadrature points, shape (e, q)."""
        shares = self.geometry.shares
        return np.asarray(parts[shares.part] @ shares.share.T)

    def stored_energy(self, o: Operators, mass: np.ndarray) -> float:
        """Of compression and bending [J]."""
        compressed = float(np.sum(mass * self.material.stored_energy(self.densities(o, mass))))
        return compressed + float(bending_energies(o, self.physics).sum())

    def step(self, x: np.ndarray, start: Operators, mass: np.ndarray, dt: float, weight: float, driving: Driving) -> StepDone:
        """Over dt [s] from nodes at x, with the operators there, and the weight α, above 0 and up to 1."""
        ahead = (1.0 - sqrt(1.0 - weight)) * dt
        zero = np.zeros_like(x)
        rates = self._rates(start, driving, dt)
        first = self._velocity(start, mass, x, ahead, zero, driving, rates, FIRST_ACCURACY)[0]
        there = x + weight * dt * first
        o = self.geometry.operators(there)
        velocity, parts, tractions, borders = self._velocity(o, mass, there, ahead, first, driving, rates, ACCURACY)
        lost = dissipation(o, self.physics, velocity[self.geometry.nodes])
        loads = [(column, float(np.sum(force * velocity))) for column, force in (*tractions, *driving.forces)]
        left = self._left(parts, velocity, first) if driving.known.any() else zero
        left = left - sum((force for _, force in (*tractions, *driving.forces)), zero)
        held = sum((force * border.row for border, force in borders), zero)
        return StepDone(
            x + dt * velocity,
            velocity,
            float(np.abs(velocity - first).max()),
            loads,
            lost.viscous,
            lost.drag,
            np.where(driving.known, left - held, 0.0),
            float(np.sum(held * velocity)),
        )

    def _left(self, parts: Forms, velocity: np.ndarray, first: np.ndarray) -> np.ndarray:
        """What the forces of the film leave unbalanced at the nodes [N], shape (n, d)."""
        found = [(square.of_components(velocity.shape[1]), velocity) for square in parts.resistance]
        found += [(square, velocity - first) for square in parts.stiffness]
        felt = [Rows(square.rows, square.factor * self._sums.rates(square, v)) for square, v in found]
        return self._sums.gathered(felt) - self._sums.gathered(parts.force)

    def _velocity(
        self,
        o: Operators,
        mass: np.ndarray,
        x: np.ndarray,
        ahead: float,
        guess: np.ndarray,
        driving: Driving,
        rates: Sequence[float],
        accuracy: float,
    ) -> tuple[np.ndarray, Forms, list[tuple[int, np.ndarray]], list[tuple[Border, float]]]:
        density = self.densities(o, mass)
        pressure, stiffness = self.material.pressure(density), density * self.material.pressure_slope(density)
        parts = forms(o, self.physics, Tension(self.at_points(pressure), self.at_points(stiffness)), ahead)
        tractions = self._tractions(o, density, driving.tractions)
        load = sum((f for _, f in (*tractions, *driving.forces)), np.zeros_like(guess))
        force = self._sums.gathered(parts.force) + load
        borders = [Border(self._sums.summed(row), rate) for row, rate in zip(_rows(o, driving), rates, strict=True)]
        free = None if self._resists_all else turning(o)
        area = self._sums.summed(np.einsum("eq,eqmi->emi", o.area, o.value))[:, 0]
        known, velocity = driving.known, driving.velocity
        system = System(x, area, parts.resistance, parts.stiffness, force, load, guess, known, velocity, free, accuracy)
        solution = self.solver.solve(system, borders)
        return solution.velocity, parts, tractions, list(zip(borders, solution.border_forces.tolist(), strict=True))

    @staticmethod
    def _rates(o: Operators, driving: Driving, dt: float) -> list[float]:
        """The rates that bring volume and area from where they are to their goals within the step."""
        now = (o.volume(), float(o.area.sum()))
        goals = (driving.volume, driving.area)
        return [(goal - value) / dt for goal, value in zip(goals, now, strict=True) if goal is not None]

    def _tractions(
        self, o: Operators, density: np.ndarray, tractions: Sequence[tuple[int, Traction]]
    ) -> list[tuple[int, np.ndarray]]:
        """Forces of tractions on the nodes [N], shape (n, d), with their columns."""
        axes = list(self.geometry.axes)
        ratio = self.at_points(density) / self._initial_density
        points = SurfacePoints(in_space(o.position, axes), in_space(o.normal, axes), ratio)
        result = []
        for column, traction in tractions:
            on_area = o.area[..., None] * traction(points)[..., axes]
            result.append((column, self._sums.summed(np.einsum("eqd,eqmd->emd", on_area, o.value))))
        return result


def in_space(vectors: np.ndarray, axes: Sequence[int]) -> np.ndarray:
    """Vectors with d components as those of space, shape (..., 3)."""
    result = np.zeros((*vectors.shape[:-1], 3))
    result[..., list(axes)] = vectors
    return result


def _rows(o: Operators, driving: Driving) -> list[np.ndarray]:
    """Rows of the rates of volume and area, of those that are prescribed, shape (e, m, d) each."""
    rows = []
    if driving.volume is not None:
        rows.append(o.volume_rate().sum(axis=1))
    if driving.area is not None:
        rows.append(np.einsum("eq,eqmd->emd", o.area, o.dilatation()))
    return rows
