"""Implicit viscosity: nodal velocities in equilibrium with the viscous stresses that they cause.

With the lumped masses m_I, the velocities v*_I that result from all other forces and the conditions, and the viscous
operator (K v)_I = Σ_p V_p σ(D_p)·∇N_I, σ = 2μD + λ tr(D) I, of points with the volumes V_p and strain rates D_p,

    m_I (v_I - v*_I) + Δt (K v)_I = 0

is solved by conjugate gradients, preconditioned by the diagonal of the matrix, starting from the velocities at the start of
the step. K is never stored: each iteration passes over the points. The velocity of a node is prescribed if supports or
driven points constrain it completely. If driven points or an absorbing face constrain it partly, its mass is increased.

The points receive the viscous stress of the solution. Its forces are added to the other nodal forces before the momentum
update. Therefore momentum is conserved to rounding at any tolerance, and works, reactions and heat are computed as for all
forces. The nodal velocities then differ from the solution by r_I/m_I, where r is the residual. The iteration ends when the
energy Σ r_I²/2m_I of this difference is at most TOLERANCE² times the energy of Δv = v - v*, the change by viscosity in the
step: TOLERANCE is the relative error of the viscous forces. A node with less mass than a point counts with the mass of a
point. The iteration also ends at the rounding error of the operator on v (column ROUNDING).

Implicit Euler removes more energy from the motion than the dissipation Δt Σ_p V_p σ_p:D_p of the solution: the difference
is Σ Δt f_I·(v_I - v̄_I), with the viscous forces f and the mean velocities v̄ of the step. Both become heat of the points;
the energy balance lists them separately. (Conjugate gradients: Hestenes & Stiefel 1952, J. Res. Natl. Bur. Stand. 49, 409.)
"""

from collections.abc import Iterable, Mapping, Sequence
from math import inf, sqrt
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from pellucid.energy import FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT, INTERNAL, StepWork, WorkLayout, no_work
from pellucid.errors import RunStopped
from pellucid.grid.nodal_fields import allocate
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.gifts import FIRST, scatter
from pellucid.grid.point_storage import PointStorage
from pellucid.grid.points import POWER
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.viscous_nodes import (
    CHANGE,
    COLUMNS,
    DESCENT,
    RESIDUAL,
    ROUNDING,
    ViscousNodes,
    add_forces,
    add_stress,
    begin,
    diagonal_by_viscosity,
    find_curvature,
    move,
    start,
    straining_by_viscosity,
    sum_lag,
    turn,
)
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.jit.bundle import Bundle
from pellucid.state import Field
from pellucid.step.part import StepPart

VISCOUS_STRESS = "viscous_stress"
"""Name of the point array that holds the viscous stress."""
TOLERANCE = 1e-3
RELATIVE_ROUNDING = 1e-14
MOST_ROUNDS = 1000


class Viscous(Protocol):
    """Interface of a fluid body whose viscosity is solved implicitly by `ImplicitViscosity`: viscosities, viscous stresses
    and sums over its points."""

    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`
    storage: PointStorage

    @property
    def solves_viscosity(self) -> bool:
        """True if the viscous stress is solved for."""

    @property
    def viscosities(self) -> tuple[float, float]:
        """Viscosities μ and λ [Pa s] of the stress σ = 2μD + λ tr(D) I with the strain rate D."""

    @property
    def viscous_stress(self) -> np.ndarray:
        """Viscous stress of each point at the end of the step [Pa], shape (points, 6)."""

    @property
    def nodal_forces(self) -> np.ndarray: ...
    def stored_array(self, name: str) -> np.ndarray: ...


class ImplicitViscosity(StepPart):
    """Solver (conjugate gradients) for the viscous stresses of all fluids with implicit viscosity in a velocity field, see
    `pellucid.grid.implicit_viscosity`."""

    point_fields = MappingProxyType(
        {
            VISCOUS_STRESS: Field(
                components=6,
                unit="Pa",
                meaning="stress by implicit viscosity in the last step",
                shown=False,
                leaves=True,
                begins=True,
                part_of="stress",
            )
        }
    )

    def __init__(self, field: VelocityField, bodies: Sequence[Viscous], layout: WorkLayout) -> None:
        self.field, self._bodies = field, bodies
        self._columns = [layout.column(heat) for heat in (FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT)]
        self._rows = allocate(ViscousRows, field.grid.n_nodes)
        masses = (body.stored_array("mass") for body in bodies)
        self._lightest = min(float(np.min(mass, where=mass > 0.0, initial=inf)) for mass in masses)
        self.rounds = [0, 0, 0]
        """Total number of iterations, number of steps, and the largest number of iterations in a step."""
        self._wrong: float | None = None
        self._sums = np.zeros((field.momentum.n_chunks, COLUMNS))
        self._nodes = Bundle(ViscousNodes(field.momentum.advanced, self._rows, self._sums))
        self._diagonals = [diagonal_by_viscosity(body.mapped.content, *body.viscosities, self._rows.inverse) for body in bodies]
        self._of_direction = [self._pass(body, self._rows.direction) for body in bodies]
        self._of_solution = [self._pass(body, self._rows.solution) for body in bodies]

    def _pass(self, body: Viscous, velocity: np.ndarray) -> Bundle:
        how = *body.viscosities, body.viscous_stress, velocity, self._rows.viscous_force
        return straining_by_viscosity(body.mapped.content, *how)

    def before_momentum(self, dt: float) -> None:
        """Compute the viscous stress of the points at the end of a step dt [s] by conjugate gradients, and add its forces to
        the nodal forces."""
        self._n = self.field.momentum.near()
        begin(self._n, self._nodes, dt)
        for diagonal in self._diagonals:
            scatter(diagonal)
        self._map(self._of_solution)
        start(self._n, self._nodes, dt, self._lightest)
        sums = self._summed()
        floor = RELATIVE_ROUNDING**2 * float(sums[ROUNDING])
        rounds, share, descent = 0, 0.0, float(sums[DESCENT])
        while sums[RESIDUAL] > max(TOLERANCE**2 * float(sums[CHANGE]), floor) and descent > 0.0:
            if rounds == MOST_ROUNDS:
                self._wrong = sqrt(float(sums[RESIDUAL] / sums[CHANGE]))
                break
            turn(self._n, self._nodes, share)
            self._map(self._of_direction)
            find_curvature(self._n, self._nodes, dt)
            step = descent / float(self._summed()[DESCENT])
            move(self._n, self._nodes, dt, step)
            sums = self._summed()
            last, descent = descent, float(sums[DESCENT])
            share = descent / last
            rounds += 1
        if rounds:
            self._map(self._of_solution)
        self._dt = dt
        self._power = sum(float(body.storage.sums()[POWER]) for body in self._bodies)
        add_forces(self._n, self._nodes, self._bodies[0].nodal_forces)
        for body in self._bodies:
            add_stress(body.n_slabs, body.mapped, body.viscous_stress)
        self.rounds = [self.rounds[0] + rounds, self.rounds[1] + 1, max(self.rounds[2], rounds)]

    def _map(self, passes: Sequence[Bundle]) -> None:
        """Compute the viscous stresses of the points in a nodal velocity field, and add their forces to the nodal array of
        viscous forces.

        passes: for each body, the loop over its points (see `straining_by_viscosity`), which also holds the velocity field.
        """
        for one in passes:
            each_point(one, 0.0, FIRST)

    def _summed(self) -> np.ndarray:
        return self.field.momentum.sum_of_near(self._sums)

    def check(self, n_steps: int, time: float) -> None:
        """Raise RunStopped if the conjugate gradient iterations for the viscous stresses did not converge in step
        `n_steps`, which ended at `time` [s]."""
        if self._wrong is None:
            return
        text = (
            f"step {n_steps}, time {time:.6g} s: implicit viscosity in the velocity field `{self.field.name}` did not "
            f"converge: after {MOST_ROUNDS} iterations the relative error of its forces is {self._wrong:.2g}, "
            f"above {TOLERANCE:g}"
        )
        raise RunStopped(f"{text}; use a smaller time.step or time.courant", step=n_steps, time=time)

    def work(self) -> StepWork:
        """Return the works of the viscous stress in the last step along the mean nodal velocities [J]: the dissipation, and the
        energy lost by implicit Euler."""
        sum_lag(self._n, self._nodes)
        dissipated, lag = self._dt * self._power, self._dt * float(self._summed()[DESCENT])
        done = no_work(max(self._columns) + 1, 0)
        done.works[self._columns] = dissipated, lag
        done.works[INTERNAL] = -dissipated - lag
        return done

    def facts(self) -> dict[str, Any]:
        """Return the mean and the largest number of conjugate gradient iterations in a step, and the relative tolerance of
        the viscous forces, by velocity field."""
        rounds, steps, most = self.rounds
        mean = rounds / steps if steps else 0.0
        found = {"rounds_mean": mean, "rounds_largest": most, "tolerance": TOLERANCE}
        return {"implicit_viscosity": {self.field.name: found}}

    def state_numbers(self) -> dict[str, Any]:
        return {"rounds": self.rounds}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self.rounds = list(numbers["rounds"])


def implicit_viscosity(field: VelocityField, bodies: Iterable[Any], layout: WorkLayout) -> list[ImplicitViscosity]:
    """Return the solver of implicit viscosity of a velocity field in a list, or no solver if no fluid has implicit viscosity.

    bodies: all bodies of the field on the grid; layout: order of the works.
    """
    fluids = [body for body in bodies if getattr(body, "solves_viscosity", False)]
    return [ImplicitViscosity(field, fluids, layout)] if fluids else []
