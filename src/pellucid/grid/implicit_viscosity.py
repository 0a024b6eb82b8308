"""Implicit viscosity and pressure: nodal velocities in equilibrium with the stresses that they cause in liquids.

With the lumped masses m_I, the velocities v*_I that result from all other forces and the conditions, and the operator
(K v)_I = Σ_p V_p σ(D_p)·∇N_I, σ = 2μD + λ tr(D) I, of points with the volumes V_p and strain rates D_p,

    m_I (v_I - v*_I) + Δt (K v)_I = 0

is solved by conjugate gradients. They start from velocities that are extrapolated from the solutions of the last two steps; at
nodes without these, from the velocities at the start of the step. K is never stored: each iteration passes over the points. The
viscosity of a point with a rheology is that of its shear rate in the step before, so that the equation remains linear. The
velocity of a node is prescribed if supports or driven points constrain it completely. If driven points or an absorbing face
constrain it partly, its mass is increased. The equations are preconditioned by the diagonal of the matrix, or by
`fast_diagonalisation` if liquids with an implicit pressure fill most of the grid.

The points receive the stress of the solution. Its forces are added to the other nodal forces before the momentum update.
Therefore momentum is conserved to rounding at any tolerance, and works, reactions and heat are computed as for all forces. The
nodal velocities then differ from the solution by r_I/m_I, where r is the residual. The end of the iteration depends on the
preconditioner:

- With fast diagonalisation. The preconditioner is nearly the inverse of the matrix A of the equations. The error e = A⁻¹r of
  the velocities then has the energy e·Ae = r·A⁻¹r, kinetic and dissipated, which each iteration computes. The iteration ends
  when it is at most ACCURACY² times that of the velocities, v·Av. Beside free surfaces, where the preconditioner is less
  exact, the error may be several times as large. In a liquid at rest, whose velocities are errors themselves,
  it ends by the next rule, with the tolerance TOLERANCE_AT_REST.
- With the diagonal, which underestimates the energy of smooth errors, the forces are compared. The iteration ends when the
  energy Σ r_I²/2m_I is at most TOLERANCE² times the energy of Δv = v - v*, the change by the implicit stress in the step:
  TOLERANCE is the relative error of its forces. A node with less mass than a point counts with the mass of a point. This is
  much stricter where viscosity dominates: a force that changes its sign from node to node hardly moves a viscous liquid.

The iteration always ends at the rounding error of the operator on v (column ROUNDING).

Implicit pressure. The pressure of a liquid at the end of the step is p - ρc²Δt tr(D), with the pressure p of its density: ρc²Δt
is added to λ. Sound then does not limit the step (Harlow & Amsden 1971, J. Comput. Phys. 8, 197). More is needed in long steps:

- The solution, without r_I/m_I, strains and moves the points. Otherwise the residual, times ρc²Δt²/ρh², is a pressure of the
  next step that grows.
- In a velocity field of liquids alone the equations are solved for the velocities at the time θΔt of the step,
  u = v⁻ + θ (v - v⁻), between those before and after it, v⁻ and v: m_I (u_I - v⁻_I) is θΔt times all forces, with the stresses
  of u. The velocities u strain the points. The points receive v and move with v. In this way second order is reached with
  θ = 1/2. If the equations are solved for v (θ = 1), the points carry velocities without divergence from step to step, and
  their motion turns these, so that they point outwards in a vortex. The solve then removes the divergence, and with it energy:
  a rotation ω decays by (ωΔt)²/2 in each step, in addition to its viscous decay. With θ = 1/2 the divergence changes its
  sign instead (advection-reflection: Zehnder, Narain & Thomaszewski 2018, ACM Trans. Graph. 37, 85): as in the leapfrog method,
  the velocities of the points belong to the middle of a step and the pressures to its ends. Points that move with their
  own velocity keep their angular momentum. θ is slightly larger than 1/2, so that errors that change their sign fade.
- Where bodies with explicit forces share the field, these would gain energy if they were strained by u. There the equations
  are solved for v, which strains all points, and liquids move by v + Δt/2 L v, see `pellucid.grid.straining`: in a rotation
  straight paths of v would spread points by (ωΔt)² in each step, which volumes that grow by 1 + Δt tr(L) do not follow.
  Viscous forces are θ times those of v plus 1 - θ times those of v⁻. θ is 1/2 + Δt/Δt_max with the limit Δt_max of these
  bodies, at most 1, so that their motion is damped, and 1 if a viscosity depends on the shear rate.

The pressure p(V) of a gas or liquid in a membrane (`PressedContents`) is linearised in the same way: with the derivatives g_I
of its volume V with respect to the positions of the nodes, it changes by dp/dV Δt Σ g_I·v_I, and exerts forces p g_I. This adds
a matrix of rank one to the equations, so that the stiffness of the contents does not limit the step either.

Implicit Euler removes more energy from the motion than the dissipation Δt Σ_p V_p σ_p:D_p of the solution: the difference
is Σ Δt f_I·(v_I - v̄_I), with the viscous forces f and the mean velocities v̄ of the step. Both become heat of the points;
the energy balance lists them separately. The second includes the work of the change of an implicit pressure. (Conjugate
gradients: Hestenes & Stiefel 1952, J. Res. Natl. Bur. Stand. 49, 409.)
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, sqrt
from types import MappingProxyType
from typing import Any

import numpy as np

from pellucid.energy import FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT, INTERNAL, StepWork, WorkLayout, no_work
from pellucid.errors import RunStopped
from pellucid.grid.fast_diagonalisation import FastDiagonalisation
from pellucid.grid.full_cells import CellPressure
from pellucid.grid.nodal_fields import ROW, VECTOR, allocate
from pellucid.grid.passes.each_point import each_point
from pellucid.grid.passes.gifts import FIRST, scatter
from pellucid.grid.points import HEATING, POWER
from pellucid.grid.velocity_field import PressedContents, VelocityField
from pellucid.grid.viscous_bodies import VISCOUS_STRESS, PointViscosity, Viscous
from pellucid.grid.viscous_nodes import (
    CHANGE,
    COLUMNS,
    DESCENT,
    RESIDUAL,
    ROUNDING,
    SIZE,
    WORK,
    StressByViscosity,
    ViscousNodes,
    add_forces,
    add_stress,
    begin,
    diagonal_by_viscosity,
    extrapolate_velocities,
    find_curvature,
    keep_forces,
    keep_viscous,
    move,
    precondition,
    start,
    store_solution,
    strain_by_solution,
    straining_by_viscosity,
    sum_descent,
    sum_lag,
    turn,
)
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.jit.bundle import Bundle
from pellucid.materials.contract import ImplicitStress
from pellucid.materials.rheology import UniformViscosity
from pellucid.ranks.domain import domain
from pellucid.state import Field
from pellucid.step.part import StepPart

ACCURACY = 5e-5
"""Relative error of the velocities, in the norm of their kinetic energy and dissipation, at which the iteration ends."""
TOLERANCE = 1e-3
"""Relative error of the forces at which the iteration ends if the equations are preconditioned by their diagonal."""
RELATIVE_ROUNDING = 1e-14
TOLERANCE_AT_REST = 1e-4
"""Relative error of the forces at which the iteration ends in liquids at rest, with fast diagonalisation. In moving liquids
ACCURACY is mostly reached before."""
STEADY_TOLERANCE = 1e-5
"""With implicit pressure and the diagonal, relative error of the velocities at which the iteration ends although the change in
the step, as in a steady flow, is so small that the error of its forces is larger than TOLERANCE."""
MOST_ROUNDS = 1000
DAMPED_STEPS = 4
"""Number of first steps in which viscous forces are fully implicit, so that a sudden start does not swing."""
LEAST_DAMPING = 0.05
"""Smallest difference between the implicit share of viscous forces and one half: it damps the shortest waves by a fifth in a
step."""
GROWTH = 1.25
"""Largest ratio of a step to the step before."""
MOSTLY = 0.5
"""Smallest share of the volume of the grid that liquids fill, at which the equations are preconditioned as on a full grid."""


class ImplicitViscosity(StepPart):
    """Solver (conjugate gradients) for the stresses of all fluids with implicit viscosity or pressure in a velocity field, see
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

    def __init__(
        self,
        field: VelocityField,
        bodies: Sequence[Viscous],
        explicit: Sequence[Any],
        layout: WorkLayout,
        cells: Sequence[CellPressure],
    ) -> None:
        """field: the velocity field; bodies: its fluids with an implicit stress; explicit: its other bodies; layout: order of
        the works; cells: mean pressures of its full cells (cells that a fluid fills)."""
        self.field, self._bodies, self._explicit = field, bodies, explicit
        stiffness, density = max((body.implicit_stress.stiffness, body.material.density) for body in bodies)
        self._presses = stiffness > 0.0
        self._centred = self._presses and not explicit
        if self._presses and explicit:
            for body in bodies:
                body.curve_paths()
        self._columns = [layout.column(heat) for heat in (FLUID_VISCOUS_HEAT, IMPLICIT_VISCOUS_HEAT)]
        self._rows = allocate(ViscousRows, field.grid.n_nodes)
        if not field.walls:
            self._rows = self._rows._replace(normal=np.zeros(0))
        masses = (body.stored_array("mass") for body in bodies)
        self._lightest = min(float(np.min(mass, where=mass > 0.0, initial=inf)) for mass in masses)
        self.rounds = [0, 0, 0]
        """Total number of iterations, number of steps, and the largest number of iterations in a step."""
        self._wrong: tuple[str, float, float] | None = None
        self._sums = np.zeros((field.momentum.n_chunks, COLUMNS))
        self._nodes = Bundle(ViscousNodes(field.momentum.advanced, self._rows, self._sums))
        self._factors = [np.zeros(2) for _ in bodies]
        self._diagonals = [
            diagonal_by_viscosity(body.mapped.content, body.mapped.content.points.volume, factors, self._rows.inverse)
            for body, factors in zip(bodies, self._factors, strict=True)
        ]
        self._point_viscosities = [self._viscosity_of_points(body) for body in bodies]
        self._of_direction, self._of_solution = (
            (velocity, [self._pass(body, velocity) for body in bodies])
            for velocity in (self._rows.direction, self._rows.solution)
        )
        self._cells = cells if self._presses else ()
        self._cell_power = 0.0
        self._contents: list[tuple[PressedContents, float, np.ndarray, np.ndarray]] = []
        self._longest = field.grid.lattice.cell / sqrt(stiffness / density) if self._presses else inf
        self._full = self._density() if self._presses else 0.0
        self._fast: FastDiagonalisation | None = None
        self._mean = self._mean_stress() if self._full > 0.0 else ImplicitStress(0.0, 0.0, 0.0, 0.0)
        self._theta = 1.0
        self._earlier_dt = 0.0

    @property
    def _time(self) -> float:
        """Time of the solution, as a share of the step: θ, or 1 at its end."""
        return self._theta if self._centred else 1.0

    @property
    def _share(self) -> float:
        """Share of the forces of the solution in those of the step: 1, or θ if forces before the step have the rest."""
        return 1.0 if self._centred else self._theta

    @property
    def delay(self) -> float:
        """Time from the forces at the start of a step to the viscous forces in it, as a share of the step: they are θ times
        those after the step and 1 - θ times those before it, half a step away from these forces each."""
        return self._theta - 0.5

    def _density(self) -> float:
        """Return the mean density of the liquids in a grid that they mostly fill [kg/m³]; 0 in other grids."""
        volume, mass = (sum(float(body.stored_array(name).sum()) for body in self._bodies) for name in ("volume", "mass"))
        return mass / volume if volume >= MOSTLY * self.field.grid.volume else 0.0

    def _mean_stress(self) -> ImplicitStress:
        """Return the mean parameters of the implicit stress over the volumes of the liquids."""
        volumes = np.array([float(body.stored_array("volume").sum()) for body in self._bodies])
        stresses = []
        for body in self._bodies:
            mu, lam, stiffness, least, second = body.implicit_stress
            if second is not None:
                mu = float(np.average(body.stored_array("viscosity"), weights=body.stored_array("volume")))
                lam = second.ratio * mu + second.constant
            stresses.append((mu, lam, stiffness, least))
        mean = (volumes / float(volumes.sum())) @ np.array(stresses)
        return ImplicitStress(*mean.tolist())

    def _viscosity_of_points(self, body: Viscous) -> PointViscosity | None:
        viscosity, second = body.arrays.get("viscosity"), body.implicit_stress.second
        return None if viscosity is None or second is None else PointViscosity(body, viscosity, second, self._rows.inverse)

    def _pass(self, body: Viscous, velocity: np.ndarray) -> Bundle:
        mu, lam, stiffness, _, second = body.implicit_stress
        rule = StressByViscosity(UniformViscosity(mu, lam) if second is None else second, stiffness, body.full_cells)
        how = body.arrays.get("viscosity"), body.arrays[VISCOUS_STRESS], velocity, self._rows.viscous_force
        return straining_by_viscosity(body.mapped.content, rule, *how)

    def exert_forces(self, dt: float) -> None:
        """Set θ for a step dt [s], see `pellucid.grid.implicit_viscosity`."""
        if self._centred or (self._presses and not any(self._point_viscosities)):
            explicit = max((body.totals.rate for body in self._explicit), default=0.0)
            self._theta = min(0.5 + max(LEAST_DAMPING, dt * explicit), 1.0) if self.rounds[1] >= DAMPED_STEPS else 1.0

    def before_momentum(self, dt: float) -> None:
        """Solve for the stress of the points over a step dt [s] by conjugate gradients, and add its forces to the nodal
        forces."""
        theta, share = self._theta, self._share
        self._n, self._dt = self.field.momentum.near(), dt
        self._begin(dt)
        self._earlier_power = self._add_earlier_forces(dt) if share < 1.0 else 0.0
        if self._full > 0.0:
            if self._fast is None:  # not before: walls free nodes that supports constrain at the start
                self._fast = FastDiagonalisation(self.field.grid, self._bodies[0].functions, self._full)
            if any(self._point_viscosities):
                self._mean = self._mean_stress()
        self._contents = [(one, *one.linearise()) for one in self.field.contents] if self._presses else []
        rounds = self._solve(theta * dt, dt / share)
        self._hand_over_contents(dt / share, share)
        self._power, self._compression = (
            share * sum(float(body.storage.sums()[of]) for body in self._bodies) for of in (POWER, HEATING)
        )
        self._compression += share * self._cell_power
        add_forces(self._n, self._nodes, self._bodies[0].nodal_forces, share)
        for body, own_viscosity in zip(self._bodies, self._point_viscosities, strict=True):
            viscous = body.arrays[VISCOUS_STRESS]
            add_stress(body.n_slabs, body.mapped, viscous, share)
            mu, lam, stiffness, *_ = body.implicit_stress
            if stiffness > 0.0 and dt > 0.0:
                own = np.full(len(viscous), 3.0 * lam + 2.0 * mu) if own_viscosity is None else own_viscosity.bulk()
                own = np.maximum(own, 0.0)
                keep_viscous(body.n_slabs, body.mapped, viscous, own / (own + 3.0 * stiffness * dt / share))
        self._rows.before[:] = self._rows.latest
        store_solution(self._n, self._nodes)
        domain.spread(self._rows.latest.reshape(-1, ROW))  # before the next step, rows may pass to another process
        self._earlier_dt = dt
        self.rounds = [self.rounds[0] + rounds, self.rounds[1] + 1, max(self.rounds[2], rounds)]

    def _begin(self, dt: float) -> None:
        """Find the masses and velocities of the equations for a step dt [s]."""
        begin(self._n, self._nodes, dt)
        for wall in self.field.walls:
            wall.constrain(self._rows)

    def _add_earlier_forces(self, dt: float) -> float:
        """Add the explicit share of the viscous forces, of the nodal velocities before the step, to the nodal forces and
        stresses; return their power [W]."""
        share = 1.0 - self._theta
        self._map(self._of_solution, 0.0)
        power = share * sum(float(body.storage.sums()[POWER]) for body in self._bodies)
        add_forces(self._n, self._nodes, self._bodies[0].nodal_forces, share)
        for body in self._bodies:
            add_stress(body.n_slabs, body.mapped, body.arrays[VISCOUS_STRESS], share)
        keep_forces(self._n, self._nodes, share)
        self._begin(dt)
        return power

    def _hand_over_contents(self, dt: float, share: float) -> None:
        """Move `share` times the forces of the contents of membranes, which the solution contains, from the viscous forces to
        those of the contents; dt: time by which their stiffness is multiplied [s]."""
        for contents, node, force in self._pressed(self._rows.solution, dt):
            self._rows.viscous_force.reshape(-1, ROW)[node, VECTOR] -= force
            contents.add_force(node, share * force)

    def _pressed(self, velocity: np.ndarray, dt: float) -> Iterator[tuple[PressedContents, np.ndarray, np.ndarray]]:
        """Yield the contents of membranes, each with indices of nodes and the forces on them [N], shape (n, 3), of the change
        of its pressure in dt [s] at nodal velocities in rows of four numbers, shape (4 nodes,) [m/s]."""
        at_nodes = velocity.reshape(-1, ROW)
        for contents, stiffness, node, slope in self._contents:
            growth = float(np.sum(domain.of_nodes(slope * at_nodes[node, VECTOR], node)))
            yield contents, node, -stiffness * dt * growth * slope

    def _solve(self, dt: float, pressing: float) -> int:
        """Solve for the nodal velocities, and compute the stresses and nodal forces of the solution; return the number of
        iterations.

        dt: time over which viscous forces act [s]; pressing: time by which the stiffness of the pressure is multiplied [s].
        """
        for body, factors, diagonal, own_viscosity in zip(
            self._bodies, self._factors, self._diagonals, self._point_viscosities, strict=True
        ):
            mu, lam, stiffness, *_ = body.implicit_stress
            if own_viscosity is not None:
                own_viscosity.add_diagonal()
                mu, lam = 0.0, own_viscosity.second.constant
            factors[:] = mu, 2.0 * mu + lam + stiffness * pressing
            scatter(diagonal)
        extrapolate_velocities(self._n, self._nodes, self._time, self._dt / self._earlier_dt if self._earlier_dt > 0.0 else 0.0)
        self._map(self._of_solution, pressing)
        start(self._n, self._nodes, dt, self._lightest)
        sums = self._summed()
        floor, energy, tolerance = RELATIVE_ROUNDING**2 * float(sums[ROUNDING]), 0.0, TOLERANCE
        if self._fast is not None:
            self._fast.begin(dt, pressing, self._mean, self._rows.inverse)
            energy, tolerance = float(sums[SIZE]) + dt * (self._power_of_stress() + self._cell_power), TOLERANCE_AT_REST
        elif self._presses:
            floor = max(floor, STEADY_TOLERANCE**2 * float(sums[SIZE]))
        rounds, last, work = 0, inf, float(sums[WORK])
        while sums[RESIDUAL] > max(tolerance**2 * float(sums[CHANGE]), floor):
            if rounds == MOST_ROUNDS:
                of_forces = "forces", sqrt(float(sums[RESIDUAL] / sums[CHANGE])), TOLERANCE
                self._wrong = of_forces if self._fast is None else ("velocities", sqrt(last / energy), ACCURACY)
                break
            descent = self._precondition()
            if not descent > ACCURACY**2 * energy:
                break
            turn(self._n, self._nodes, descent / last)
            self._map(self._of_direction, pressing)
            find_curvature(self._n, self._nodes, dt)
            length = descent / float(self._summed()[DESCENT])
            move(self._n, self._nodes, dt, length)
            sums, last = self._summed(), descent
            if self._fast is not None:
                # with the change d of the velocities d·Ad = length * descent, and d·Av is the decrease of v·r
                energy += length * descent + 2.0 * (work - float(sums[WORK]))
                work = float(sums[WORK])
            rounds += 1
        if rounds:
            self._map(self._of_solution, pressing)
        return rounds

    def _precondition(self) -> float:
        """Compute the preconditioned residual, and return its product with the residual [J]."""
        if self._fast is None:
            precondition(self._n, self._nodes)
        else:
            self._fast.apply(self._rows.residual, self._rows.preconditioned)
        sum_descent(self._n, self._nodes)
        return float(self._summed()[DESCENT])

    def after_momentum(self) -> None:
        """Let the solution strain the points, and find the longest next step: it is at most GROWTH times as long as this one,
        and the largest acceleration of a node, over a step of this length, moves it by at most half a cell."""
        if not self._presses or self._dt == 0.0:
            return
        strain_by_solution(self._n, self._nodes, self._time)
        edges, nodes = self.field.momentum.advanced.edges, self.field.grid.nodes
        here = slice(int(edges[0]), int(edges[self._n]))
        gained = np.max(nodes.increment_energy[here], where=nodes.mass[here] >= self._lightest, initial=0.0)
        change = domain.largest(sqrt(2.0 * float(gained)))
        crossing = sqrt(self.field.grid.lattice.cell * self._dt / change) if change > 0.0 else inf
        self._longest = min(GROWTH * self._dt, crossing)

    def longest_step(self) -> float:
        return self._longest

    def _map(self, of: tuple[np.ndarray, Sequence[Bundle]], dt: float) -> None:
        """Compute the viscous stresses of the points in a nodal velocity field, and add their forces to the nodal array of
        viscous forces, after those of the implicit pressure in full cells (cells that a fluid fills).

        of: the velocities, and for each body the loop over its points (see `straining_by_viscosity`).
        """
        velocity, passes = of
        if dt > 0.0:  # before the points, since sums of nodes go on from process to process
            self._cell_power = sum(cells.press(velocity, dt, self._rows.viscous_force) for cells in self._cells)
        for one in passes:
            each_point(one, dt, FIRST)
        if dt > 0.0:
            for _, node, force in self._pressed(velocity, dt):
                self._rows.viscous_force.reshape(-1, ROW)[node, VECTOR] += force

    def _power_of_stress(self) -> float:
        """Return the power of the stresses of the points in the velocities of the last `_map` [W]."""
        return sum(float(np.sum(body.storage.sums()[[POWER, HEATING]])) for body in self._bodies)

    def _summed(self) -> np.ndarray:
        return self.field.momentum.sum_of_near(self._sums)

    def check(self, n_steps: int, time: float) -> None:
        """Raise RunStopped if the conjugate gradient iterations for the implicit stresses did not converge in step
        `n_steps`, which ended at `time` [s]."""
        if self._wrong is None:
            return
        of, error, limit = self._wrong
        text = (
            f"step {n_steps}, time {time:.6g} s: implicit {'pressure' if self._presses else 'viscosity'} in the velocity field "
            f"`{self.field.name}` did not "
            f"converge: after {MOST_ROUNDS} iterations the relative error of its {of} is {error:.2g}, above {limit:g}"
        )
        softer = ", or a smaller eos.sound_speed" if self._presses else ""
        raise RunStopped(f"{text}; use a smaller time.step or time.courant{softer}", step=n_steps, time=time)

    def work(self) -> StepWork:
        """Return the works of the viscous stress in the last step along the mean nodal velocities [J]: the dissipation, and the
        energy lost by implicit Euler."""
        sum_lag(self._n, self._nodes, self._share)
        dissipated = self._dt * (self._power + self._earlier_power)
        lag = self._dt * (float(self._summed()[DESCENT]) + self._compression - self._earlier_power)
        done = no_work(max(self._columns) + 1, 0)
        done.works[self._columns] = dissipated, lag
        done.works[INTERNAL] = -dissipated - lag
        return done

    def facts(self) -> dict[str, Any]:
        """Return the mean and the largest number of conjugate gradient iterations in a step, and the relative error at which
        they end, of the velocities with fast diagonalisation and else of the viscous forces, by velocity field."""
        rounds, steps, most = self.rounds
        mean = rounds / steps if steps else 0.0
        found = {"rounds_mean": mean, "rounds_largest": most, "tolerance": TOLERANCE if self._fast is None else ACCURACY}
        return {"implicit_viscosity": {self.field.name: found}}

    def state_numbers(self) -> dict[str, Any]:
        return {"rounds": self.rounds, "longest": self._longest, "earlier_step": self._earlier_dt}

    def state_arrays(self) -> dict[str, np.ndarray]:
        return self._solutions()

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self.rounds, self._longest = list(numbers["rounds"]), numbers["longest"]
        self._earlier_dt = numbers["earlier_step"]

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, solution in self._solutions().items():
            solution[:] = arrays[name]

    def _solutions(self) -> dict[str, np.ndarray]:
        """Return the solutions of the last two steps by name, in rows of four numbers, shape (nodes, 4)."""
        return {name: getattr(self._rows, name).reshape(-1, ROW) for name in ("latest", "before")}


def implicit_viscosity(
    field: VelocityField, bodies: Iterable[Any], layout: WorkLayout, cells: Sequence[CellPressure]
) -> list[ImplicitViscosity]:
    """Return the solver of implicit viscosity of a velocity field in a list, or no solver if no fluid has implicit viscosity.

    bodies: all bodies of the field on the grid; layout: order of the works; cells: mean pressures of its full cells (cells that
    a fluid fills).
    """
    fluids = [body for body in bodies if getattr(body, "solves_viscosity", False)]
    return [ImplicitViscosity(field, fluids, [body for body in bodies if body not in fluids], layout, cells)] if fluids else []
