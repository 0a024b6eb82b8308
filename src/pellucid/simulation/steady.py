"""Steady states by adaptive dynamic relaxation.

The loads increase smoothly. Then the displacements u follow damped steps, u⁺ = u + κ² (u - u⁻) + ((1 + κ) h/2)² M⁻¹ f,
until nothing moves, with the previous and next values u⁻ and u⁺, the damping factor κ, the step h, the masses M and the
forces f. The optimal κ = (K - 1)/(K + 1), K = 2/(ω h), depends on the lowest frequency ω that is still excited, estimated
by ω² = |Δu·Δf| / Δu·M Δu from the changes Δu and Δf since a stored state.

Sources: Joldes, Wittek & Miller 2009, Comput. Methods Appl. Mech. Eng. 198, 2645, and 2011, 200, 1779.
"""

from collections.abc import Mapping, Sequence
from math import ceil, inf, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import SLOWER_LOADS, Relaxable
from pellucid.simulation.clock import Clock
from pellucid.smooth_step import smooth_step
from pellucid.step.part import StepParts

if TYPE_CHECKING:
    from pellucid.case import TimeCase
    from pellucid.case.steady import SteadyCase

LOADING = 0.999  # κ while the loads grow
ESTIMATED, KEPT_ANEW = 20, 200  # steps between estimates of ω, and between the stored states with which they compare
AGREE = 0.1  # largest relative difference of two successive estimates of 1 - κ that are used
WITH_SHEETS = 0.5
"""Largest fraction of the stable step if membranes touch other bodies: it leaves room for the contact dampers, which stop a
node within a step."""
CROSSINGS = 16.0  # times that shear waves cross a body while all loads grow
ALL_LOADS, FEWEST = 800, 100  # smallest numbers of steps in which all loads, and the loads of one load step, grow
PER_CELL = 8.0  # steps for each cell that a rigid body crosses: at most a quarter of a cell in a step
BEGINNING = 1e-3  # fraction for the first step of a load step, in which supports release nodes; later steps include these nodes
BEGIN_AT, NEARER = 0.1, 0.1  # errors at which overlaps are removed: first their product, then NEARER times the last removal
LEFT = 0.02  # change of leads, relative to the largest, below which overlaps are not corrected any more
MOST_CORRECTIONS = 25  # largest number of corrections of overlaps in a load step
QUIET = 100  # steps for which the estimated error must stay below the tolerance


class SteadyClock(Clock):
    """Clock of a steady analysis by dynamic relaxation: counts steps; its time is the time of the loads at the last
    equilibrium.

    steady, time: tables of the case; bodies, models: all bodies of the case and their models; parts: parts of the step, among
    them contact by surfaces. Bodies that do not relax are rigid, with positions prescribed by motions.
    """

    def __init__(
        self,
        steady: "SteadyCase",
        time: "TimeCase",
        bodies: Sequence[Body],
        models: Sequence[BodyModel],
        parts: StepParts,
    ) -> None:
        self._contact = next((contact for contact in parts.of(SurfacePairs) if contact), None)
        sheets = self._contact is not None and any(surface.is_sheet for surface in self._contact.surfaces)
        courant = min(steady.courant, WITH_SHEETS) if sheets else steady.courant
        super().__init__(time.model_copy(update={"courant": courant}), parts=parts)
        self._bodies, self._relaxed = bodies, [body for body in bodies if isinstance(body, Relaxable)]
        self._led = [body for body in bodies if not isinstance(body, Relaxable)]
        self._crossing = max(_crossing(m) for m, b in zip(models, bodies, strict=True) if isinstance(b, Relaxable))
        self._passed = max((_cells_passed(body, time.end) for body in self._led), default=0.0)
        self.steady = steady
        levels = steady.levels(time.end)
        self._levels = [*levels, levels[-1] + 1.0]  # of the loads, in load steps; one beyond the end
        for tool in self._led:
            tool.relaxes = True
        if self._contact is not None:
            self._contact.begin_steady()
        self._start = [_places(body).copy() for body in bodies]
        self._step = 0  # of this load step
        self.loading = 1
        """Number of steps over which the loads of the present load step increase."""
        self._equilibria, self._begun_at = 0, 0.0  # equilibria so far; loads at the last one, in load steps
        self._kappa, self._estimate, self._believed = LOADING, 0.0, False
        self._quiet, self._scale, self.error = 0, 0.0, 1.0
        self._change, self._decay = 0.0, 1.0  # the largest in a step, and what is left of it a step later
        self._near = 0  # steps in which the error was small enough for another correction
        self._left = 1.0  # the last correction of overlaps, of the largest displacement
        self._kept: list[tuple[np.ndarray, ...]] = []
        self._corrections, self._renewed = 0, False  # of overlaps in this load step; whether the last step made one
        self._exact = self._contact is None  # whether what is left of overlaps does not count
        self.steps_taken: list[int] = []
        """Number of steps of each load step so far."""

    # a step

    def next_step(self, bodies: Sequence[Body]) -> float:
        limit, body = self.stable_step(bodies)
        dt = self.case.courant * limit.step
        self.check_collapse(dt, limit, [body] if body else bodies)
        if self._step == 0:
            whole = max(ALL_LOADS, CROSSINGS * self._crossing / dt, PER_CELL * self._passed)
            before, level = self._begun_at, self._levels[self._equilibria + 1]
            self.loading = self.steady.loading or max(FEWEST, ceil(whole / self.steady.load_steps * (level - before)))
            dt *= BEGINNING
        return dt

    def span(self, dt: float) -> tuple[float, float]:
        """Return the time of the loads at the start of the coming step [s] and its increment in the step [s]."""
        start, end = self._loads_at(self._step), self._loads_at(self._step + 1)
        return start, end - start

    def pace(self, dt: float) -> None:
        """Set the damping and the load rate (increment of the time of the loads over the length of the step) of the bodies for
        the coming step dt [s]."""
        kappa, (start, grown) = self._kappa, self.span(dt)
        for body in self._relaxed:
            body.relax(kappa * kappa, 0.25 * (1.0 + kappa) ** 2, grown / dt, smooth_step((start + grown) / self.case.end))
        for tool in self._led:
            tool.load_rate = grown / dt

    def advance(self, dt: float) -> None:
        """Count a step of the length dt [s] and check whether a steady state is reached."""
        self.n_steps += 1
        self._step += 1
        self.dt, self.weight = dt, 0.0
        if self._step <= self.loading:
            return
        self._estimate_error(dt)
        self._correct_overlaps()
        since = (self._step - self.loading - 1) % KEPT_ANEW
        if since % ESTIMATED == 0:
            self._estimate_damping(dt, since)
        if self._quiet >= QUIET:
            self._reach()
        elif self._step >= self.steady.most_steps and not self._quiet:
            self.missed = (
                f"step {self.n_steps}, load step {self._equilibria + 1} of {len(self._levels) - 2}: no steady state after "
                f"{self._step} steps (steady.most_steps = {self.steady.most_steps}): the estimated error is {self.error:.3g} "
                f"of the largest displacement (steady.tolerance = {self.steady.tolerance:g}), and the residual force is "
                f"{self._unbalanced():.2g} of all forces\n    To continue from the last state, run `pellucid resume` "
                "with a larger "
                "`--set steady.most_steps=...` or `--set steady.tolerance=...`. If a body can still move freely, add a support."
            )
            self._reach()

    @property
    def is_adjusting(self) -> bool:  # type: ignore[override]
        """True from the first correction of overlaps in contact until the equilibrium, since each correction changes the
        contact forces at once."""
        return self._corrections > 0

    @property
    def is_last_try(self) -> bool:
        return self._step == max(self.steady.most_steps - 1, self.loading) and not self._quiet

    def _loads_at(self, step: int) -> float:
        """Return the time of the loads [s] after `step` steps of the present load step (the increase of the loads to the next
        equilibrium)."""
        before, level = self._begun_at, self._levels[self._equilibria + 1]
        if step >= self.loading:
            return level * self._each
        return (before + smooth_step(step / self.loading) * (level - before)) * self._each

    @property
    def _each(self) -> float:
        """Length of a load step in the time of the loads [s]."""
        return self.case.end / self.steady.load_steps

    def _estimate_error(self, dt: float) -> None:
        """Estimate the error of the displacements relative to the largest displacement, after a step dt [s].

        The estimate is the remaining change if the largest change per step decays by the damping factor κ, or more slowly
        if a slower decay is observed. A mode whose frequency is far below the frequency for which κ is optimal is hidden by
        the changes of all other modes.
        """
        change = dt * max(float(abs(body.arrays["velocity"]).max()) for body in self._bodies)
        if (self._step - self.loading) % ESTIMATED == 1:
            moved = zip(self._bodies, self._start, strict=True)
            self._scale = max(float(abs(_places(body) - start).max()) for body, start in moved)
            self._decay = min((change / self._change) ** (1.0 / ESTIMATED), 1.0) if self._change > 0.0 else 1.0
            self._change = change
        seen = self._decay / (1.0 - self._decay) if self._decay < 1.0 else inf
        still = max(self._kappa / (1.0 - self._kappa), min(seen, float(self._step))) * change
        self.error = still / self._scale if self._scale > 0.0 else 0.0
        steady = self._believed and self.error < self.steady.tolerance and not self._renewed
        done = self._exact or self._corrections >= MOST_CORRECTIONS
        self._quiet = self._quiet + 1 if steady and done else 0

    def _correct_overlaps(self) -> None:
        """Near an equilibrium, remove the overlaps of bodies in contact that the compliance of the contact springs causes; see
        `pellucid.contact.leads`."""
        if self._contact is None:
            return
        if self._renewed:
            self._renewed = False
            change, largest = self._contact.lead_change()
            self._left = change / self._scale if self._scale > 0.0 else 0.0
            self._exact = change <= max(LEFT * largest, self.steady.tolerance * self._scale)
            self._quiet = 0
        near = max(self.steady.tolerance, NEARER * min(self._left, BEGIN_AT))
        self._near = self._near + 1 if self._believed and self.error < near else 0
        if self._near >= ESTIMATED and not self._exact and self._corrections < MOST_CORRECTIONS:
            self._contact.renew_leads()
            self._renewed, self._corrections, self._kept, self._near = True, self._corrections + 1, [], 0

    def _estimate_damping(self, dt: float, since: int) -> None:
        springs = [body.springs() for body in self._relaxed]
        if since == 0 or not self._kept:
            self._kept = [tuple(array.copy() for array in spring.of_forces()) for spring in springs]
            return
        work = inertia = 0.0
        for spring, (position, force, *of_contact) in zip(springs, self._kept, strict=True):
            moved = (spring.position - position) * spring.free
            work += float(np.sum(moved * (spring.force - force)))
            if spring.contact is not None and of_contact:
                began, pushed = of_contact
                work += float(np.sum((spring.contact[0] - began) * spring.free * (spring.contact[1] - pushed)))
            inertia += float(np.sum(spring.inertia[:, None] * moved * moved))
        if inertia == 0.0:  # nothing moves
            self._believed = True
            return
        ratio = 2.0 / max(sqrt(abs(work) / inertia) * dt, 1e-9)
        estimate = 2.0 / (1.0 + ratio)  # 1 - κ
        if abs(estimate - self._estimate) <= AGREE * max(estimate, self._estimate):
            # what moves first after a correction of overlaps is stiff, and the rest of the body as slow as before
            least = self._kappa if self._corrections > 0 else 0.0
            self._kappa, self._believed = max(1.0 - estimate, least), True
        self._estimate = estimate

    def _reach(self) -> None:
        """End the load step (the increase of the loads to an equilibrium), and start the next one."""
        self.steps_taken.append(self._step)
        self._equilibria += 1
        self._begun_at = self._levels[self._equilibria]
        before, self.time = self.time, self._begun_at / self.steady.load_steps * self.case.end
        self.weight = (self.time - before) / self.dt
        self._step, self._quiet, self._kept = 0, 0, []
        if self._contact is not None:
            self._contact.reach_equilibrium()
        self._corrections, self._renewed, self._exact, self._left = 0, False, self._contact is None, 1.0
        self._near = 0
        self._kappa, self._estimate, self._believed = LOADING, 0.0, False
        self._change, self._decay = 0.0, 1.0

    # results and checkpoint

    against_energy_error = f"The loads increase too fast: {SLOWER_LOADS}"

    def facts(self) -> dict[str, Any]:
        """Return, for the summary, the number of steps of each load step, the estimated relative error of the displacements,
        and the residual force relative to all forces."""
        return {"steady": {"steps": self.steps_taken, "estimated_error": self.error, "unbalanced_force": self._unbalanced()}}

    def _unbalanced(self) -> float:
        """Return the norm of the residual forces on the nodes relative to the norm of all nodal forces."""
        left, every = np.sqrt(np.square([body.unbalanced() for body in self._relaxed]).sum(axis=0))
        return float(left / every) if every > 0.0 else 0.0

    def search(self) -> str:
        return f"{self._load_step()}: step {self._step} of the relaxation, estimated error {self.error:.1e}"

    def _load_step(self) -> str:
        """Return number and total number of load steps as text."""
        total = len(self._levels) - 2
        return f"load step {min(self._equilibria + 1, total)} of {total}"

    def progress(self) -> float:
        return self._loads_at(self._step)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {f"{what}-{n}": array for n, kept in enumerate(self._kept) for what, array in zip(KEPT, kept, strict=False)}

    def state_numbers(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in OWN}
        return {**super().state_numbers(), **own, "steps_taken": list(self.steps_taken)}

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(numbers, arrays)
        for name in (*OWN, "steps_taken"):
            setattr(self, name, numbers[name])
        count = sum(name.startswith(KEPT[0]) for name in arrays)
        names = [[f"{what}-{n}" for what in KEPT] for n in range(count)]
        self._kept = [tuple(arrays[name] for name in of_body if name in arrays) for of_body in names]


def _places(body: Body) -> np.ndarray:
    """Return the positions of the points of a body [m], shape (n, 3), in an order that stays the same during a run."""
    return body.arrays["position"] if isinstance(body, Relaxable) else body.arrays["position"][body.order()]


def _cells_passed(body: Body, end: float) -> float:
    """Return the largest number of cells that the prescribed motions of a body can cross until the end of the loads,
    `end` [s]."""
    grid, speed = getattr(body, "grid", None), getattr(body.constraint, "top_speed", 0.0)
    return 0.0 if grid is None else speed * end * float(grid.lattice.inverse_cell)


def _crossing(model: BodyModel) -> float:
    """Return the time that shear waves need to cross a body from end to end [s]. For a body without shear waves, as some
    membranes, 0.2 times the speed of pressure waves is used."""
    lower, upper = model.bounds()
    pressure, shear = model.waves_at_start()
    return float((upper - lower).max()) / (shear or 0.2 * pressure)


KEPT = "position", "force", "start", "contact"
OWN = (
    *("_step", "loading", "_equilibria", "_begun_at"),
    *("_kappa", "_estimate", "_believed", "_quiet", "_scale", "_change", "_decay", "error"),
    *("_corrections", "_renewed", "_exact", "_left", "_near"),
)
