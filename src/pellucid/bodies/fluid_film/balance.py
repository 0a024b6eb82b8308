"""Balance of forces on a film: computes its nodal velocities, and its motion over a time step, from loads, resistance and
constraints.

A step is the midpoint rule or, with another weight α, the generalised trapezoidal rule of Benet 2015, eq. 6.52: a first
velocity v, computed at the start, gives the positions x + α dt v at which the velocity of the step is computed. Stiff modes
must be able to relax faster than a step. Therefore changes of pressure, tension and curvature over a time c dt resist the first
velocity, and then the difference between the second velocity and the first; this does not change the order of the method. The
factor c satisfies 1 - 2/c + α/c² = 0, so that a mode that relaxes instantly has decayed after one step (as in the Rosenbrock
method of Verwer et al. 1999, SIAM J. Sci. Comput. 20, 1456); of its two roots the smaller one has the smaller error.
"""

from collections.abc import Callable, Mapping, Sequence
from math import ceil, inf, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.assembly import ElementRows, SharedRows
from pellucid.bodies.fluid_film.film_geometry import FilmGeometry, Operators
from pellucid.bodies.fluid_film.forces import FilmForces, FilmPhysics, Forms, dissipation, in_space, turning
from pellucid.bodies.fluid_film.solvers import Border, FilmSolver, IncompatibleLoad, Solution, System
from pellucid.energy import GRAVITY
from pellucid.linear.elimination import on_one_thread
from pellucid.materials.lipid_film import THINNEST, LipidFilm
from pellucid.parts.capabilities import ActingTraction
from pellucid.smooth_step import risen

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase


class Led(NamedTuple):
    """Nodes of a film whose velocity along the normal is prescribed, with these velocities."""

    nodes: np.ndarray  # (n,) True for these nodes
    rate: np.ndarray  # (n,) prescribed velocity along the outward normal [m/s]
    before: np.ndarray  # (n, d) nodal velocities in the previous step [m/s]


class Frames:
    """Orthonormal directions at n nodes, along which vectors are resolved into components: the axes of space, except at nodes
    with a prescribed velocity along the normal n, the mask `led`.

    At these nodes the axes are reflected so that the last one lies along n: by I - 2 w wᵀ/w², with w = e + sgn(n·e) n and the
    last axis e. On an axis of symmetry the first component remains perpendicular to it. normal: normals at the nodes, shape
    (n, d).
    """

    def __init__(self, normal: np.ndarray, led: np.ndarray) -> None:
        d = normal.shape[1]
        self._way = np.where(normal[:, -1] < 0.0, 1.0, -1.0)  # sign of the last direction relative to the normal
        w = np.eye(d)[-1] - self._way[:, None] * normal
        mirrored = np.eye(d) - 2.0 * w[:, :, None] * w[:, None] / np.einsum("ni,ni->n", w, w)[:, None, None]
        self.directions = np.where(led[:, None, None], mirrored, np.eye(d))

    def of(self, vectors: np.ndarray) -> np.ndarray:
        """Return the components of nodal vectors along the orthonormal directions stored for each node, from their components
        along the axes of space, shape (n, d) both. The transformation is its own inverse.
        """
        return np.asarray(np.einsum("ncd,nd->nc", self.directions, vectors))

    def rows(self, forms: Sequence[ElementRows | SharedRows], nodes: np.ndarray) -> list[ElementRows]:
        """Convert linear forms of nodal vectors to the components of these vectors along the orthonormal directions stored for
        each node, instead of the axes of space.

        forms: coefficients of the linear forms of each element; nodes: nodes of the elements, shape (e, m).
        """
        e, m = nodes.shape
        d, directions = self.directions.shape[2], self.directions[nodes]
        whole = [form.of_components(d) for form in forms]
        found = [np.einsum("ermd,emcd->ermc", form.rows.reshape(e, -1, m, d), directions) for form in whole]
        return [
            ElementRows(np.ascontiguousarray(rows.reshape(form.rows.shape)), form.factor)
            for rows, form in zip(found, whole, strict=True)
        ]

    def known(self, led: Led, rate: np.ndarray, known: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a mask of the prescribed velocity components along the orthonormal directions stored for each node, and their
        values [m/s], shape (n, d) each.

        led: nodes with a prescribed normal velocity; rate: these velocities [m/s], shape (n,); known, velocity: mask and values
        [m/s] of the components along the axes that supports prescribe, shape (n, d).
        """
        last = np.zeros(known.shape, bool)
        last[:, -1] = led.nodes
        return known | last, np.where(last, (self._way * rate)[:, None], velocity)


ROUNDING = 1e-9  # smallest resultant that is reported, relative to the driving forces


def why_unbalanced(driven: np.ndarray, x: np.ndarray, axes: Sequence[int], loads: Mapping[str, np.ndarray]) -> str:
    """Return a text that describes the loads on motions without resistance; it continues a sentence that starts with the name
    of the film.

    driven: forces of the loads on these motions [N], shape (n, d); x: nodal positions [m], shape (n, d); axes: the d axes of
    space of the components; loads: nodal forces of each load by name, shape (n, d) each [N].
    """
    size, whole = _size(driven), _size(sum(loads.values(), np.zeros_like(driven)))
    shares = {label: abs(float(np.sum(force * driven))) for label, force in loads.items()}
    most = max(shares, key=lambda label: shares[label])
    forces, places = in_space(driven, axes), in_space(x - x.mean(axis=0), axes)
    resultant, torque = np.linalg.norm(forces.sum(axis=0)), np.linalg.norm(np.cross(places, forces).sum(axis=0))
    reach = float(np.linalg.norm(places, axis=1).max())
    parts = [f"a resultant of {resultant:.3g} N"] if resultant > ROUNDING * size else []
    parts += [f"a torque of {torque:.3g} N m"] if torque > ROUNDING * size * reach else []
    has = f", with {' and '.join(parts)}" if parts else ""
    plane = tuple(axes) == (0, 1)
    balance = "its tension must balance the loads on a curve" if plane else "resultant forces and torques cannot be balanced"
    return (
        f"is driven along motions without resistance, mainly by {most}: forces of {size:.3g} N, {100.0 * size / whole:.2g} % "
        f"of the loads{has}; without drag {balance}; add `drag`, or change the loads"
    )


def _size(forces: np.ndarray) -> float:
    """Return the sum of the magnitudes of nodal forces [N], which approximates ∫|b| dA for a load b per unit area."""
    return float(np.linalg.norm(forces, axis=1).sum())


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


GROWTH, SHRINKAGE, SAFETY = 2.0, 0.2, 0.9  # largest and smallest factor between substeps, and safety factor
SHORTEST = 1e-9  # length of a substep, relative to the step of the run, at which the film fails
GENTLER = "apply loads and volume changes more slowly (`rise`, `volume.over`), or use more nodes where it is thin or sharp"
STILL = 1e-14  # displacement in a substep, relative to the largest coordinate, below which the film is at rest
FIRST_SHARE = 1e-3  # length of the first substep, relative to the first step of the run


class Goals(NamedTuple):
    """Prescribed volume and area of a film over time.

    Attributes: start, volume: initial and final enclosed volume [m³]; over: duration of the change [s]; area: constant area
    [m²]. None if volume or area are free.
    """

    start: float
    volume: float | None
    over: float
    area: float | None

    def at(self, time: float) -> tuple[float | None, float | None]:
        """Return the prescribed volume [m³] and area [m²] at a time [s]; None if free."""
        volume = None if self.volume is None else self.start + (self.volume - self.start) * risen(time, self.over)
        return volume, self.area


def is_still(done: StepDone, span: float) -> bool:
    """Return True if a substep of length span [s] moves the nodes by no more than the round-off of their positions. done:
    result of the substep.
    """
    return bool(span * np.abs(done.velocity).max() <= STILL * np.abs(done.x).max())


class OwnSteps:
    """Moves a film by substeps.

    Updates the arrays `x` (nodal positions), `v` (nodal velocities), `part_mass`, `own_step` (length of a substep) and
    `unspread` (displacement of the nodes with the film since they were last redistributed [m]). balance: computes the
    velocities; goals: prescribed volume and area over time; how: settings of the film.
    """

    def __init__(self, balance: FilmBalance, goals: Goals, how: "FluidFilmCase", arrays: dict[str, np.ndarray]) -> None:
        self._balance, self._goals, self._how, self._arrays = balance, goals, how, arrays
        self.fault: str | None = None
        """Reason why the film cannot be moved further; None if it can."""

    def over(self, dt: float, elapsed: float, driving: Driving, count: Callable[[StepDone, float], None]) -> Operators:
        """Move the film over a step of the run from time `elapsed` to `elapsed` + dt [s]; return the geometry and strain
        operators at the end.

        driving: loads and constraints; count: function called with the result of each substep and its length [s].
        """
        arrays, geometry, accuracy, left = self._arrays, self._balance.geometry, self._how.accuracy, dt
        own = float(arrays["own_step"][0]) or FIRST_SHARE * dt
        o = geometry.operators(arrays["x"])
        with on_one_thread():
            while left > 0.0 and self.fault is None:
                span = left / ceil(left / own * (1.0 - 1e-12))
                volume, area = self._goals.at(elapsed + dt - left + span)
                done = self._try(o, span, driving._replace(volume=volume, area=area, after=dt - left))
                if done is None:
                    break
                error = span * done.change / float(geometry.spacing(geometry.places(arrays["x"])).min())
                factor = SAFETY * (accuracy / error) ** 0.5 if error > 0.0 else inf
                own = span * min(max(factor, SHRINKAGE), GROWTH)
                if not error <= accuracy:  # nor is it a number
                    own = own if np.isfinite(error) else SHRINKAGE * span
                    if own < SHORTEST * dt:
                        self.fault = f"moves or stretches without bound: its substep became too small; {GENTLER}"
                    continue
                left -= span
                if is_still(done, span):
                    arrays["v"][:] = 0.0
                    count(done.at_rest, span)
                    continue
                o = self._take(o, done, span)
                count(done, span)
                self.fault = too_thin(self._balance, arrays, o)
        arrays["own_step"][0] = own
        return o

    def velocities_now(self, dt: float, elapsed: float, driving: Driving) -> np.ndarray:
        """Return the nodal velocities at the start of a step dt [s] of the run [m/s], shape (n, d), from its first substep;
        zero if the loads cannot be balanced (the step itself reports this). elapsed: time at the start of the step [s];
        driving: loads and constraints.
        """
        x, span = self._arrays["x"], FIRST_SHARE * dt
        volume, area = self._goals.at(elapsed + span)
        with on_one_thread():
            done = self._try(self._balance.geometry.operators(x), span, driving._replace(volume=volume, area=area, after=0.0))
        self.fault = None
        return np.zeros_like(x) if done is None or is_still(done, span) else done.velocity

    def _try(self, o: Operators, dt: float, driving: Driving) -> StepDone | None:
        arrays = self._arrays
        try:
            return self._balance.step(arrays["x"], o, arrays["part_mass"], dt, self._how.time_weight, driving)
        except Unbalanced as found:
            self.fault = str(found)
        except np.linalg.LinAlgError:
            self.fault = "has no equilibrium of forces: its system of equations is singular"
        return None

    def _take(self, o: Operators, done: StepDone, span: float) -> Operators:
        """Accept the result `done` of a substep of length span [s], redistribute the nodes evenly, and return the geometry and
        strain operators at the end. o: operators at the start.

        The surface through the redistributed nodes differs from the surface before by the interpolation error, and may store
        more energy. Redistribution that can wait is done only if the stored energy grows by at most the work done on the film.
        """
        arrays, balance, geometry = self._arrays, self._balance, self._balance.geometry
        mass, moved = arrays["part_mass"], arrays["unspread"] + (done.x - arrays["x"])
        arrays["v"][:], arrays["x"][:], arrays["unspread"][:] = done.velocity, done.x, moved
        if self._how.nodes == "even":
            waits, functions = geometry.can_wait(done.x), geometry.state_arrays()
            allowed = balance.stored_energy(o, mass) + span * done.power_received if waits else inf
            spread = geometry.redistributed(done.x, mass, moved)
            there = geometry.operators(spread.x)
            if not waits or balance.stored_energy(there, spread.mass) <= allowed:
                arrays["x"][:], mass[:], arrays["unspread"][:] = *spread, 0.0
                return there
            geometry.restore(functions)
        return geometry.operators(arrays["x"])


def too_thin(balance: FilmBalance, arrays: dict[str, np.ndarray], o: Operators) -> str | None:
    """Return a message about the place where the film is stretched so much that its density is too low for the model; None
    if there is no such place.

    balance: forces and densities of the film; arrays: state of the film; o: geometry of the film in this state.
    """
    geometry, rest = balance.geometry, balance.material.density
    density = balance.densities(o, arrays["part_mass"])
    if density.min() >= THINNEST * rest:
        return None
    places = geometry.places(arrays["x"])
    node = min(int(density.argmin()), len(places) - 1)
    place = ", ".join(f"{value:.6g}" for value in in_space(places, geometry.axes)[node])
    return (
        f"is stretched to {density.min() / rest:.2g} of its rest density near ({place}) m: its tension cannot carry the loads; "
        "reduce the loads, or increase `stiffness`"
    )
