"""Fluid films: bodies with their own nodes whose velocities follow from a balance of forces without inertia (Benet 2015).

A film takes steps of its own within that of the clock, as long as what changes between the two estimates of the velocity of a
step is small beside the distance of its nodes.
"""

from collections.abc import Mapping, Sequence
from math import ceil, inf
from typing import Protocol

import numpy as np

from pellucid.bodies.fluid_film.balance import Driving, FilmBalance, StepDone, in_space
from pellucid.bodies.fluid_film.forms import FilmPhysics, bending_energies
from pellucid.bodies.fluid_film.geometry import FilmGeometry
from pellucid.bodies.fluid_film.goals import Goals
from pellucid.bodies.fluid_film.operators import Operators
from pellucid.bodies.fluid_film.solver import FilmSolver, IncompatibleLoad
from pellucid.energy import DAMPING, FIRST_LOAD, GRAVITY, INTERNAL, SUPPORT, VISCOUS, StepWork, Totals, no_work
from pellucid.errors import RunStopped
from pellucid.geometry.cells import Cells
from pellucid.linear_algebra import on_one_thread
from pellucid.materials.film import FilmMaterial
from pellucid.parts.body import NodalSupport, Placement
from pellucid.parts.families import NodalBody
from pellucid.parts.surface_load import Traction

THINNEST = 0.05  # of the density of rest
GROWTH, SHRINKAGE, SAFETY = 2.0, 0.2, 0.9  # of the length of its steps
SHORTEST = 1e-9  # of the step of the clock
FIRST_SHARE = 1e-3  # of the first step of the clock, with which its own begin
FIELDS = ("id", "position", "velocity", "mass", "areal_density", "tension", "curvature", "distance")


class FilmCase(Protocol):
    """What a film is built from, as its model describes it."""

    @property
    def name(self) -> str: ...
    @property
    def material(self) -> FilmMaterial: ...
    @property
    def initial_density(self) -> float: ...
    @property
    def nodes(self) -> str: ...
    @property
    def accuracy(self) -> float: ...
    @property
    def time_weight(self) -> float: ...
    @property
    def is_around(self) -> bool: ...
    def physics(self) -> FilmPhysics: ...
    def geometry(self) -> tuple[FilmGeometry, np.ndarray]: ...
    def solver(self, geometry: FilmGeometry, x: np.ndarray) -> FilmSolver: ...
    def goals(self, o: Operators) -> Goals: ...


class FluidFilm(NodalBody):
    """A film, its nodes in the order of its geometry.

    Its state: `x`, the nodes in the coordinates of its geometry, and `part_mass`, which its parts have.
    """

    energy_kind = "strain"
    is_surface = True

    def __init__(self, case: FilmCase, placement: Placement) -> None:
        self.name, self._case = case.name, case
        self.geometry, x = case.geometry()
        self._physics = case.physics()
        solver = case.solver(self.geometry, x)
        self.balance = FilmBalance(self.geometry, case.material, self._physics, case.initial_density, solver)
        o = self.geometry.operators(x)
        part_mass = case.initial_density * self.balance.part_areas(o)
        n = len(x)
        self.arrays = {
            "id": np.arange(n),
            "position": np.zeros((n, 3)),
            "velocity": np.zeros((n, 3)),
            "mass": np.zeros(n),
            "x": x,
            "v": np.zeros_like(x),
            "part_mass": part_mass,
            "own_step": np.zeros(1),
        }
        self.areal_density = case.initial_density
        self._gravity = np.array(placement.gravity)[list(self.geometry.axes)]
        self._columns = FIRST_LOAD + placement.n_loads
        self._goals = case.goals(o)
        self._supports: Sequence[NodalSupport] = ()
        self._tractions: list[tuple[int, Traction]] = []
        self._forces: list[tuple[int, np.ndarray]] = []
        self._work = no_work(self._columns, 0)
        self.totals = Totals()
        self._elapsed = 0.0
        self._fault: str | None = None
        self._show(o)

    # conditions

    def add_external_force(self, force: np.ndarray, column: int) -> None:
        """Add external forces on the nodes [N], shape (n, 3), over this step."""
        self._forces.append((column, np.asarray(force)[:, list(self.geometry.axes)]))

    def add_pressure(self, pressure: float, column: int) -> None:
        """Add a pressure [Pa] that follows the normal over this step."""
        self.add_traction(lambda points: pressure * points.normal, column)

    def add_traction(self, traction: Traction, column: int) -> None:
        """Add forces on the film's surface over this step."""
        self._tractions.append((column, traction))

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """A support constrains its nodes."""
        self._supports = supports

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """Its model refuses them."""

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """There are none."""

    # the step

    def begin(self, dt: float) -> None:
        """Forget the loads of the last step."""
        self._tractions.clear()
        self._forces.clear()

    def predict(self, dt: float) -> None:
        """Nothing: the film moves when all loads are known."""

    def correct(self, remap: bool) -> None:
        """Nothing."""

    def update(self, dt: float) -> None:
        """Move the film over a step, in as many of its own as its accuracy needs."""
        works, reactions = np.zeros(self._columns), np.zeros((len(self._supports) + 1, 3))
        driving, left = self._driving(), dt
        arrays, own = self.arrays, float(self.arrays["own_step"][0]) or FIRST_SHARE * dt
        o = self.geometry.operators(arrays["x"])
        with on_one_thread():
            while left > 0.0 and self._fault is None:
                span = left / ceil(left / own * (1.0 - 1e-12))
                volume, area = self._goals.at(self._elapsed + dt - left + span)
                done = self._try(o, span, driving._replace(volume=volume, area=area))
                if done is None:
                    break
                error = span * done.change / float(self.geometry.spacing(self.geometry.places(arrays["x"])).min())
                factor = SAFETY * (self._case.accuracy / error) ** 0.5 if error > 0.0 else inf
                own = span * min(max(factor, SHRINKAGE), GROWTH)
                if not error <= self._case.accuracy:  # nor is it a number
                    own = own if np.isfinite(error) else SHRINKAGE * span
                    if own < SHORTEST * dt:
                        self._fault = "moves or stretches without bound: its own step collapsed"
                    continue
                self._take(done)
                self._count(done, span, works, reactions)
                left -= span
                o = self.geometry.operators(arrays["x"])
                self._fault = self._too_thin(o)
        arrays["own_step"][0] = own
        self._work = StepWork(works, 0.0, reactions, np.zeros(3), {})
        self._elapsed += dt
        self._show(o)

    def _try(self, o: Operators, dt: float, driving: Driving) -> StepDone | None:
        arrays = self.arrays
        try:
            return self.balance.step(arrays["x"], o, arrays["part_mass"], dt, self._case.time_weight, driving)
        except IncompatibleLoad:
            self._fault = (
                "is driven along motions that nothing resists: without drag the loads on a curve must hold each other and its "
                "tension; give it a `drag`"
            )
        except (np.linalg.LinAlgError, RuntimeError):  # of dense and of sparse systems
            self._fault = "has no balance of forces: its system of equations is singular"
        return None

    def _take(self, done: StepDone) -> None:
        """The state after one of its own steps, with its nodes spread evenly."""
        arrays = self.arrays
        x = done.x
        if self._case.nodes == "even":
            x, arrays["part_mass"][:] = self.geometry.redistributed(x, arrays["part_mass"], x - arrays["x"])
        arrays["x"][:], arrays["v"][:] = x, done.velocity

    def _count(self, done: StepDone, dt: float, works: np.ndarray, reactions: np.ndarray) -> None:
        gained = 0.0
        for column, power in done.loads:
            works[column] += dt * power
            gained += power
        works[VISCOUS] += dt * done.viscous
        works[DAMPING] += dt * done.drag
        works[SUPPORT] += dt * done.bordered
        works[INTERNAL] -= dt * (gained + done.bordered - done.viscous - done.drag)
        for number, support in enumerate(self._supports):
            chosen = self._constrained(support)
            forces_at = np.where(chosen, done.prescribed, 0.0)
            forces = in_space(forces_at, self.geometry.axes)
            worked = dt * float(np.sum(forces_at * done.velocity))
            works[SUPPORT] += worked
            works[INTERNAL] -= worked
            reactions[number] += dt * forces.sum(axis=0)

    def _driving(self) -> Driving:
        x = self.arrays["x"]
        axes = list(self.geometry.axes)
        known, velocity = np.zeros(x.shape, bool), np.zeros_like(x)
        for support in self._supports:
            chosen = self._constrained(support)
            known |= chosen
            velocity = np.where(chosen, np.array(support.velocity)[axes], velocity)
        forces = list(self._forces)
        if self._gravity.any():
            forces.append((GRAVITY, self.arrays["mass"][:, None] * self._gravity))
        return Driving(list(self._tractions), forces, known, velocity, None, None)

    def _constrained(self, support: NodalSupport) -> np.ndarray:
        """Which components a support prescribes, shape (n, d)."""
        return np.asarray(support.nodes[:, None] & np.array(support.axes)[list(self.geometry.axes)])

    def renew_totals(self) -> None:
        """Stored energy; it has no momentum, and its own steps do not bound that of the clock."""
        self._show(self.geometry.operators(self.arrays["x"]))

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped` where it found no motion, is not finite, or too thin to be a film."""
        if self._fault is not None:
            text = f"step {n_steps}, time {time:.6g} s: film {self.name} {self._fault}"
            raise RunStopped(text, step=n_steps, time=time, body=self.name)

    def _too_thin(self, o: Operators) -> str | None:
        """That it is stretched so far that it is no film any more, and where."""
        geometry, x, rest = self.geometry, self.arrays["x"], self._case.material.density
        density = self.balance.densities(o, self.arrays["part_mass"])
        if density.min() >= THINNEST * rest:
            return None
        node = min(int(density.argmin()), self.n_points - 1)
        place = ", ".join(f"{value:.6g}" for value in in_space(geometry.places(x), geometry.axes)[node])
        return (
            f"is stretched to {density.min() / rest:.2g} of its density of rest near ({place}) m: no tension holds the loads; "
            "lower them, or raise `stiffness`"
        )

    def work(self) -> StepWork:
        """Work and impulses of this step."""
        return self._work

    # checkpoint

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Its nodes and masses, the length of its own steps."""
        kept = {f"{part}.{name}": array for part, of in self._stateful().items() for name, array in of.state_arrays().items()}
        return {**self.arrays, "elapsed": np.array([self._elapsed]), **kept}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from such arrays."""
        for name, array in self.arrays.items():
            array[...] = arrays[name]
        self._elapsed = float(arrays["elapsed"][0])
        for part, of in self._stateful().items():
            of.restore({name.removeprefix(f"{part}."): array for name, array in arrays.items() if name.startswith(f"{part}.")})

    def _stateful(self) -> "dict[str, FilmGeometry | FilmSolver]":
        """What depends on more than the nodes."""
        return {"geometry": self.geometry, "solver": self.balance.solver}

    # results

    def cells(self) -> Cells:
        """Lines or triangles between its nodes."""
        return self.geometry.cells()

    @property
    def field_names(self) -> list[str]:
        """The fields that results show."""
        return list(FIELDS)

    def field(self, name: str) -> np.ndarray:
        """A field at the nodes: what varies between them as means by area of the elements about each."""
        if name == "kinetic_energy":
            return np.zeros(self.n_points)
        if name in self.arrays:
            return self.arrays[name]
        if name == "distance":
            return self._distances()
        o = self.geometry.operators(self.arrays["x"])
        if name == "curvature":
            return self._at_nodes(o.area, o.curvature)
        if name == "bending_energy":
            return self._shared(bending_energies(o, self._physics))
        density = self.balance.densities(o, self.arrays["part_mass"])
        if name == "areal_density":
            return self._at_nodes(o.area, self.balance.at_points(density))
        if name == "tension":
            return self._at_nodes(o.area, self.balance.at_points(-self._case.material.pressure(density)))
        raise KeyError(name)

    def volumes(self) -> np.ndarray:
        """A film has none."""
        return np.zeros(self.n_points)

    def kinetic_energies(self) -> np.ndarray:
        """Its inertia is left out."""
        return np.zeros(self.n_points)

    def _show(self, o: Operators) -> None:
        """Positions, velocities and masses of the nodes, as others see them, and the stored energy; o: where they are now."""
        arrays, geometry = self.arrays, self.geometry
        arrays["position"][:] = in_space(geometry.places(arrays["x"]), geometry.axes)
        arrays["velocity"][:] = in_space(geometry.places(arrays["v"]), geometry.axes)
        density = self.balance.at_points(self.balance.densities(o, arrays["part_mass"]))
        arrays["mass"][:] = self._shared(o.area * density)
        self.totals.stored = self.balance.stored_energy(o, arrays["part_mass"])

    def _distances(self) -> np.ndarray:
        """Of the nodes from the centre of mass [m]; that of a surface of revolution lies on its axis."""
        places = self.geometry.places(self.arrays["x"])
        centre = self.arrays["mass"] @ places / self.mass
        if self._case.is_around:
            centre[0] = 0.0
        return np.asarray(np.linalg.norm(places - centre, axis=1))

    def _corners(self) -> np.ndarray:
        cells = self.cells()
        return cells.lines if len(cells.lines) else cells.triangles

    def _shared(self, of_points: np.ndarray) -> np.ndarray:
        """What the quadrature points of each element have, shape (e, q), shared equally by its corners, shape (n,)."""
        corners = self._corners()
        share = np.repeat(of_points.sum(axis=1) / corners.shape[1], corners.shape[1])
        return np.bincount(corners.ravel(), share, self.n_points)

    def _at_nodes(self, area: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Means by area of values at the quadrature points, shape (e, q), at the nodes."""
        return np.asarray(self._shared(area * values) / self._shared(area))
