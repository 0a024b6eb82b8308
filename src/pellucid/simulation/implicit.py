"""Motion in time by implicit steps, for bodies with their own nodes and a factored stiffness.

A step Δt follows the midpoint rule: velocities and positions change by the forces in the middle of the step,

    M (v₁ - v₀)/Δt = f(x_m) - c M (v₀ + v₁)/2,  x_m = (x₀ + x₁)/2 = x₀ + Δt (v₀ + v₁)/4 .

It is of second order, conserves momentum and angular momentum, and dissipates nothing (Hairer, Lubich & Wanner 2006, Geometric
Numerical Integration, sections IV.2 and VI.4). With the potential energy W, f = -∂W/∂x, the middle is the minimum of

    W(x) + (2/Δt²) (x - x̂)ᵀM (x - x̂) + (c/Δt) (x - x₀)ᵀM (x - x₀),  x̂ = x₀ + Δt v₀/2,

which `Minimiser` finds with the factors of K + (4/Δt² + 2c/Δt) M. The factors serve for many steps.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.case.sections import parts_of
from pellucid.errors import Interrupted, RunStopped
from pellucid.parts.body import Body
from pellucid.parts.condition import Condition
from pellucid.parts.elastic_system import HasElasticSystem, MovingSystem, Trial
from pellucid.simulation.clock import Clock
from pellucid.simulation.minimum import Minimiser, NoEquilibrium
from pellucid.step.part import StepParts

if TYPE_CHECKING:
    from pellucid.case import Case, TimeCase

TOLERANCE = 1e-8  # estimated error of the positions in the middle of a step, over the largest displacement to it
SMALLEST = 1.0 / 64.0  # of `time.step`: smallest step that is tried
FEW = 10  # iterations up to which the factors serve for the next step, too


class Midpoint:
    """An `ElasticSystem` whose minimum is the middle of a time step; system: energy, forces and stiffness of the body."""

    has_potential: bool

    def __init__(self, system: MovingSystem) -> None:
        self._system = system
        self.rest = self.position = system.position
        self._velocity = system.velocity.copy()
        self._half, self._weights = 0.0, (0.0, 0.0)
        self._tried = system.position
        self.factored_at: np.ndarray | None = None
        """Positions at which the stiffness was factored [m], shape (n, 3); None if there are no factors."""
        self.weight = 0.0
        """Factor of the masses in the present matrix [1/s²]."""

    def begin(self, dt: float) -> None:
        """Store the present state as the start of a step dt [s]."""
        self._system.begin(dt)
        self._velocity[:] = self._system.velocity
        self._half = 0.5 * dt
        self._weights = 4.0 / dt**2, 2.0 * self._system.drag / dt
        self.weight = sum(self._weights)

    def take_loads(self, renew: Callable[[], None] | None) -> None:
        """Take the present external forces as those in the middle of the step; renew: as for `ElasticSystem`."""
        self._system.take_loads(renew)
        self.has_potential = False
        self._free, self._mass = self._system.free, self._system.inertia[:, None]
        self._system.added = self.weight * self._system.inertia

    def predicted(self) -> np.ndarray:
        """Return the positions in the middle of the step without forces [m], shape (n, 3)."""
        moved = np.where(self._free, self._half * self._velocity, 0.5 * self._system.increment)
        return np.asarray(self.position + moved)

    @property
    def rounding(self) -> float:
        return self._system.rounding

    def attempt(self, position: np.ndarray) -> Trial:
        here, moved = self._system.attempt_step(position), position - self.position
        self._tried = position
        of_inertia, of_drag = self._weights
        push = self._mass * (of_inertia * (moved - self._half * self._velocity) + of_drag * moved)
        return here._replace(residual=here.residual - np.where(self._free, push, 0.0))

    def factor(self) -> None:
        self._system.factor_at(self.position)
        self.factored_at = self._tried.copy()

    def solve(self, force: np.ndarray) -> np.ndarray:
        return self._system.solve(force)

    def arrive(self, middle: np.ndarray, dt: float) -> None:
        """Move the body to the end of the step dt [s]; middle: positions in its middle [m], shape (n, 3)."""
        self._system.arrive(middle, dt)

    def reject(self) -> None:
        """Restore the start of the step."""
        self._system.reject()


class ImplicitClock(Clock):
    """Clock of a run in implicit steps of the length `time.step`. Each of them is one step of the run, or several shorter ones
    if no minimum was found.

    time: table of the case; bodies, parts: all bodies, and the parts of the step; systems: energy, forces and stiffness of the
    bodies; follows: True if loads depend on the deformation.
    """

    def __init__(
        self, time: "TimeCase", bodies: Sequence[Body], parts: StepParts, systems: Sequence[MovingSystem], follows: bool
    ) -> None:
        super().__init__(time, parts=parts)
        self._bodies, self._step_parts, self._follows = bodies, parts, follows
        self._midpoints = [Midpoint(system) for system in systems]
        self._minimisers = [Minimiser(midpoint, TOLERANCE) for midpoint in self._midpoints]
        self._from = 0.0  # time at which steps got their present length [s]
        self._whole, self._part, self._share = 0, 0.0, 1.0  # steps since, part of the present one, part to try
        self._weights = [0.0 for _ in systems]  # of the masses in the factors [1/s²]
        self._free = [system.free for system in systems]
        self._kept: list[tuple[np.ndarray, float] | None] = [None for _ in systems]  # factors at the start of the next step
        self.iterations, self.halved, self.factorisations = 0, 0, 0
        self._told = 0, 1.0  # iteration of the present search, and estimated error

    def _length(self) -> float:
        """Return the length of the present step, which may be done in parts [s]."""
        step = self.case.step or self.case.end
        left = self.case.end - (self._from + self._whole * step)
        return step if left > step * (1.0 - 1e-9) else left

    def next_step(self, bodies: Sequence[Body]) -> float:
        return min(self._share, 1.0 - self._part) * self._length()

    def carry_out(self, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> float:
        while True:
            begin(dt)
            for midpoint in self._midpoints:
                midpoint.begin(dt)
            renew = partial(self._renew_loads, self.time + 0.5 * dt, dt)
            renew()
            for midpoint in self._midpoints:
                midpoint.take_loads(renew if self._follows else None)
            try:
                found = []
                for midpoint, minimiser in zip(self._midpoints, self._minimisers, strict=True):
                    found.append(minimiser.descend(midpoint.predicted(), self._tell, FEW))
            except NoEquilibrium as reason:
                dt = self._retry(dt, str(reason))
                continue
            except Interrupted:
                self._reject()
                raise
            for midpoint, middle in zip(self._midpoints, found, strict=True):
                midpoint.arrive(middle.position, dt)
            self.iterations += sum(one.iterations for one in found)
            return dt

    def _renew_loads(self, time: float, dt: float) -> None:
        """Compute the loads at a time [s] for the present positions of the bodies, in a step dt [s]."""
        for body in self._bodies:
            body.begin(dt)
        self._step_parts.run("begin", time, 0.0)

    def _tell(self, iteration: int, error: float) -> None:
        self._told = iteration, error
        self.on_the_way()

    def _retry(self, dt: float, reason: str) -> float:
        self._reject()
        self.halved += 1
        self._share = 0.5 * dt / self._length()
        if self._share < SMALLEST:
            raise RunStopped(f"step {self.n_steps}, time {self.time:.6g} s: no solution of {dt:.3g} s ({reason})")
        return 0.5 * dt

    def _reject(self) -> None:
        for midpoint, minimiser in zip(self._midpoints, self._minimisers, strict=True):
            midpoint.reject()
            minimiser.forget()

    def advance(self, dt: float) -> None:
        self.n_steps += 1
        self.dt = dt
        length = self._length()
        self._part += dt / length
        self._share = min(2.0 * dt / length, 1.0)
        if self._part >= 1.0 - 1e-9:
            self._whole, self._part = self._whole + 1, 0.0
        step = self.case.step or self.case.end
        self.time = self._from + self._whole * step + self._part * length
        if self.case.end - self.time < 1e-9 * dt:
            self.time = self.case.end

    def facts(self) -> dict[str, Any]:
        return {"implicit": {"iterations": self.iterations, "halved": self.halved}}


def implicit_clock(case: "Case", bodies: Sequence[Body], parts: StepParts) -> ImplicitClock:
    """Return the clock of a case with implicit steps."""
    systems = [body.elastic_system() for body in bodies if isinstance(body, HasElasticSystem)]
    follows = any(condition.load_kind == "follower" for condition in parts_of(case).of(Condition))
    return ImplicitClock(case.time, bodies, parts, systems, follows)
