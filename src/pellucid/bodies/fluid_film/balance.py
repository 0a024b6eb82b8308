"""Balance of forces on a film: computes its nodal velocities, and its motion over a time step, from loads, resistance and
constraints.

A step is the midpoint rule or, with another weight α, the generalised trapezoidal rule of Benet 2015, eq. 6.52: a first
velocity v, computed at the start, gives the positions x + α dt v at which the velocity of the step is computed. Stiff modes
must be able to relax faster than a step. Therefore changes of pressure, tension and curvature over a time c dt resist the first
velocity, and then the difference between the second velocity and the first; this does not change the order of the method. The
factor c satisfies 1 - 2/c + α/c² = 0, so that a mode that relaxes instantly has decayed after one step (as in the Rosenbrock
method of Verwer et al. 1999, SIAM J. Sci. Comput. 20, 1456); of its two roots the smaller one has the smaller error.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.conditions.nodal_frames import Frames, Led
from pellucid.bodies.fluid_film.conditions.unbalanced_loads import why_unbalanced
from pellucid.bodies.fluid_film.forms.film_forces import FilmForces
from pellucid.bodies.fluid_film.forms.virtual_power import FilmPhysics, Forms, dissipation, turning
from pellucid.bodies.fluid_film.solvers.contract import Border, FilmSolver, IncompatibleLoad, Solution, System
from pellucid.bodies.fluid_film.surfaces.contract import FilmGeometry
from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.energy import GRAVITY
from pellucid.materials.lipid_film import LipidFilm
from pellucid.parts.surface_load import ActingTraction

ACCURACY, FIRST_ACCURACY = 1e-7, 1e-4  # relative errors of iterative solutions for the second and the first velocity


class Unbalanced(Exception):
    """Raised if loads on the film do work on motions that neither viscosity nor drag resists. The message describes the loads
    and continues a sentence that starts with the name of the film.
    """


class Driving(NamedTuple):
    """Loads (tractions, nodal forces) and constraints (prescribed velocities, volume and area) of a film with n nodes in d
    dimensions over a step.
    """

    tractions: Sequence[ActingTraction]  # loads per unit area
    forces: Sequence[tuple[int, np.ndarray]]  # nodal forces [N], shape (n, d), each with its index in `StepWork.works`
    known: np.ndarray  # (n, d) mask of the prescribed velocity components
    velocity: np.ndarray  # (n, d) values of the prescribed components [m/s]
    led: Led  # nodes with a prescribed velocity along the normal
    volume: float | None  # prescribed enclosed volume at the end of the step [m³]; None if free
    area: float | None  # prescribed area at the end of the step [m²]; None if free
    after: float = 0.0  # start of the film's substep, relative to the start of the step of the run [s]


class Found(NamedTuple):
    """The velocities of a film with n nodes in d dimensions at an instant, and the forces that determine them."""

    velocity: np.ndarray  # (n, d) nodal velocities [m/s]
    parts: Forms  # resistance, stiffness and forces of the elements
    tractions: list[tuple[int, np.ndarray]]  # nodal forces [N], shape (n, d), each with its index in `StepWork.works`
    borders: list[tuple[Border, float]]  # constraints of volume and area, with their forces: pressure [Pa], tension [N/m]
    normal: np.ndarray | None  # (n, d) normals at the nodes; None if no velocity along them is prescribed


class StepDone(NamedTuple):
    """The result of one step of a film with n nodes in d dimensions: motion, forces of constraints, and powers."""

    x: np.ndarray  # (n, d) nodal positions at the end of the step [m]
    velocity: np.ndarray  # (n, d) nodal velocities over the step [m/s]
    change: float  # largest change of a velocity component from the first estimate to the last [m/s]
    loads: Sequence[tuple[int, float]]  # index in `StepWork.works` and power [W] of each load
    viscous: float  # power dissipated by viscosity [W]
    drag: float  # power dissipated by drag [W]
    prescribed: np.ndarray  # (n, d) forces that enforce the prescribed components [N]
    leading: np.ndarray  # (n, d) forces that enforce the prescribed velocities along the normal [N]
    bordered: float  # power of the constraints of volume and area [W]

    @property
    def power_received(self) -> float:
        """Return the power that loads, prescribed motions, and the constraints of volume and area supply to the film [W]."""
        leading = float(np.sum((self.prescribed + self.leading) * self.velocity))
        return sum((power for _, power in self.loads), self.bordered + leading)

    @property
    def at_rest(self) -> "StepDone":
        """Return a copy of this step with the same forces, but zero velocity and zero power, for a film that is in
        equilibrium.
        """
        still = [(column, 0.0) for column, _ in self.loads]
        return self._replace(velocity=np.zeros_like(self.velocity), loads=still, viscous=0.0, drag=0.0, bordered=0.0)


class FilmBalance(FilmForces):
    """Computes the velocities of a film from its loads, resistance and constraints, and moves it over time steps.

    geometry: interpolation between the nodes; material: equation of state of the film; physics: viscosities, bending rigidity
    and drag; initial_density: surface density at the start [kg/m²]; solver: solver for the nodal velocities.
    """

    def __init__(
        self, geometry: FilmGeometry, material: LipidFilm, physics: FilmPhysics, initial_density: float, solver: FilmSolver
    ) -> None:
        super().__init__(geometry, material, physics, initial_density)
        self.solver = solver
        self._resists_all = min(physics.drag) > 0.0

    def step(self, x: np.ndarray, start: Operators, mass: np.ndarray, dt: float, weight: float, driving: Driving) -> StepDone:
        """Compute the motion of a film with nodes at x [m], shape (n, d), over a time step dt [s].

        start: geometry and strain operators of the film at x; mass: masses of the film's parts (pieces that belong to a node
        or an element) [kg]; weight: α of the time integration, 0 < α ≤ 1; driving: loads and constraints.
        """
        ahead = (1.0 - sqrt(1.0 - weight)) * dt
        zero = np.zeros_like(x)
        rates = self._rates(start, driving, dt)
        first = self._velocity(start, mass, x, ahead, zero, driving, driving.after, rates, FIRST_ACCURACY).velocity
        there = x + weight * dt * first
        o = self.geometry.operators(there)
        found = self._velocity(o, mass, there, ahead, first, driving, driving.after + weight * dt, rates, ACCURACY)
        velocity, tractions = found.velocity, found.tractions
        lost = dissipation(o, self.physics, velocity[self.geometry.nodes])
        loads = [(column, float(np.sum(force * velocity))) for column, force in (*tractions, *driving.forces)]
        held = sum((force * border.row for border, force in found.borders), zero)
        left = zero
        if driving.known.any() or driving.led.nodes.any():
            left = self._left(found.parts, velocity, first) - held
            left = left - sum((force for _, force in (*tractions, *driving.forces)), zero)
        along = zero if found.normal is None else driving.led.nodes[:, None] * found.normal
        return StepDone(
            x + dt * velocity,
            velocity,
            float(np.abs(velocity - first).max()),
            loads,
            lost.viscous,
            lost.drag,
            np.where(driving.known, left, 0.0),
            along * np.einsum("ni,ni->n", along, left)[:, None],
            float(np.sum(held * velocity)),
        )

    def _left(self, parts: Forms, velocity: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return the forces that loads and constraints must exert on the nodes to balance the film's own forces [N], shape (n,
        d).

        parts: resistance, stiffness and forces of the elements; velocity: nodal velocities [m/s]; first: the first velocity
        estimate of the step, relative to which the stiffness acts [m/s]; shape (n, d) each.
        """
        felt = self._felt(parts.resistance, velocity) + self._felt(parts.stiffness, velocity - first)
        return self._sums.gathered(felt) - self._sums.gathered(parts.force)

    def _velocity(
        self,
        o: Operators,
        mass: np.ndarray,
        x: np.ndarray,
        ahead: float,
        guess: np.ndarray,
        driving: Driving,
        after: float,
        rates: Sequence[float],
        accuracy: float,
    ) -> Found:
        parts = self.forms(o, mass, ahead)
        tractions = [(acting.column, self.traction_force(o, mass, acting.traction, after)) for acting in driving.tractions]
        load = sum((f for _, f in (*tractions, *driving.forces)), np.zeros_like(guess))
        force = self._sums.gathered(parts.force) + load
        borders = [Border(self._sums.summed(row), rate) for row, rate in zip(_rows(o, driving), rates, strict=True)]
        free = None if self._resists_all else turning(o)
        area = self._sums.summed(np.einsum("eq,eqmi->emi", o.area, o.value))[:, 0]
        known, velocity = driving.known, driving.velocity
        system = System(x, area, parts.resistance, parts.stiffness, force, load, guess, known, velocity, free, accuracy)
        normal = self.geometry.normals(x) if driving.led.nodes.any() else None
        try:
            if normal is None:
                solution = self.solver.solve(system, borders)
            else:
                solution = self._led(system, borders, driving.led, normal)
        except IncompatibleLoad as error:
            loads = _by_label(driving, [force for _, force in tractions])
            raise Unbalanced(why_unbalanced(error.driven, x, self.geometry.axes, loads)) from error
        forces = solution.border_forces.tolist()
        return Found(solution.velocity, parts, tractions, list(zip(borders, forces, strict=True)), normal)

    def _led(self, system: System, borders: Sequence[Border], led: Led, normal: np.ndarray) -> Solution:
        """Solve the balance of forces if the velocity along the normal is prescribed at some nodes. Returns the nodal
        velocities and the forces of the constraints.

        system: the balance without these velocities; borders: linear constraints of volume and area; led: the nodes and their
        velocities along the normal; normal: normals at the nodes, shape (n, d). If the film does not pass through its nodes,
        the velocity of the film is prescribed, not the velocity of the node. The difference between the two is computed from
        the best estimate of the nodal velocities so far.
        """
        frames, nodes = Frames(normal, led.nodes), self.geometry.nodes
        near = system.guess if system.guess.any() else led.before
        apart = np.einsum("ni,ni->n", normal, near - self.geometry.places(near))
        known, velocity = frames.known(led, led.rate + apart, system.known, system.velocity)
        turned = system._replace(
            resistance=frames.rows(system.resistance, nodes),
            stiffness=frames.rows(system.stiffness, nodes),
            turning=None if system.turning is None else frames.rows(system.turning, nodes),
            force=frames.of(system.force),
            load=frames.of(system.load),
            guess=frames.of(system.guess),
            known=known,
            velocity=velocity,
            directions=frames.directions,
        )
        solution = self.solver.solve(turned, [border._replace(row=frames.of(border.row)) for border in borders])
        return solution._replace(velocity=frames.of(solution.velocity))

    @staticmethod
    def _rates(o: Operators, driving: Driving, dt: float) -> list[float]:
        """Return the rates of change of volume [m³/s] and area [m²/s] with which volume and area have the values prescribed
        by `driving` at the end of a step dt [s]. The list has no entry for a volume or area that is free. o: geometry of
        the film at the start of the step."""
        now = (o.volume(), float(o.area.sum()))
        goals = (driving.volume, driving.area)
        return [(goal - value) / dt for goal, value in zip(goals, now, strict=True) if goal is not None]


def _by_label(driving: Driving, tractions: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the total nodal forces of each load on the film [N], shape (n, d), by the name of the load.

    driving: loads on the film (tractions and nodal forces); tractions: nodal forces of each of its tractions [N], shape (n, d)
    each.
    """
    loads = {acting.label: force for acting, force in zip(driving.tractions, tractions, strict=True)}
    for column, force in driving.forces:
        label = "gravity" if column == GRAVITY else "the forces on its nodes"
        loads[label] = loads.get(label, 0.0) + force
    return loads


def _rows(o: Operators, driving: Driving) -> list[np.ndarray]:
    """Return the derivatives of the enclosed volume [m²] and of the area [m] of a film with respect to the positions of the
    m nodes of each of its e elements, shape (e, m, d) each.

    o: geometry and strain operators of the film; driving: constraints of the film. The list contains only the quantities
    (volume, area) that `driving` prescribes.
    """
    rows = []
    if driving.volume is not None:
        rows.append(o.volume_rate().sum(axis=1))
    if driving.area is not None:
        rows.append(np.einsum("eq,eqmd->emd", o.area, o.dilatation()))
    return rows
