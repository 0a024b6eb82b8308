"""Steady states by factored methods: equilibria as minima of the potential energy, one load step after the other, and dynamic
relaxation for load steps in which none is found."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import ceil, dist, inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.case.sections import parts_of
from pellucid.conditions.enclosed.steady import VolumeLoad
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.energy import StepWork
from pellucid.errors import CaseError, Interrupted, Problem, RunStopped
from pellucid.findings import listed
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.elastic_system import BodySystem, ElasticSystem, HasElasticSystem
from pellucid.simulation.arc_length import ArcLengthClock
from pellucid.simulation.clock import Clock, renew_loads
from pellucid.simulation.contact_search import ContactSearch, contact_search, deforms, must_touch
from pellucid.simulation.minimum import Equilibrium, Minimiser, NoEquilibrium
from pellucid.simulation.steady import BEGIN_AT, MOST_CORRECTIONS, NEARER, SteadyClock
from pellucid.smooth_step import smooth_step
from pellucid.step.part import StepParts

if TYPE_CHECKING:
    from pellucid.case import Case, TimeCase
    from pellucid.case.steady import SteadyCase

SMALLEST = 1.0 / 64.0  # of a load step: smallest part that is tried before the relaxation
UNSETTLED, MOST_UNSETTLED = 1e-2, 0.3
"""Limits of the residual forces over all forces after a new detection of contact at an equilibrium: from the first on a
warning, from the second on the load step is divided."""
TOO_FAR = "surfaces move so far in one step that they could pass through each other"
QUICK = 60  # iterations up to which the next part of a load step is twice as large


class FactoredClock(SteadyClock):
    """Clock of a steady analysis that finds equilibria with a factored stiffness. Each step of the run ends at an equilibrium:
    at the end of a load step, or in between if a whole load step failed.

    steady, time, bodies, models, parts: as for `SteadyClock`; systems: energy, forces and stiffness of the bodies that relax;
    follows: True if loads depend on the deformation; contact: contact of the bodies, None without contact; farthest: longest
    way in the grid [m].
    """

    def __init__(
        self,
        steady: "SteadyCase",
        time: "TimeCase",
        bodies: Sequence[Body],
        models: Sequence[BodyModel],
        parts: StepParts,
        systems: Sequence[BodySystem],
        follows: bool,
        contact: ContactSearch | None,
        farthest: float = inf,
    ) -> None:
        super().__init__(steady, time, bodies, models, parts)
        self.touching = contact
        """Contact of the bodies; None without contact."""
        self._parts, self._systems, self._follows = parts, systems, follows
        self._free_tools = [] if contact is None else contact.free_tools
        self._farthest = farthest
        self._searched: Sequence[ElasticSystem] = systems
        if contact is not None and (len(systems) > 1 or contact.free_tools):
            self._searched = [contact.joint(systems)]
        self._minimisers = [Minimiser(system, steady.tolerance) for system in self._searched]
        self._share = 1.0  # of a load step that is tried next
        self._relaxing, self._prepared = False, False
        self._was_search = False  # True if the last step was one of the search, not of the relaxation
        self._iterations = 0  # of this load step
        self._residual: float | None = None  # residual forces over all forces if the last step was not one of the relaxation
        self.relaxed: list[int] = []
        """Numbers of the load steps that ended with a relaxation, counted from 1."""
        self.unstable: list[int] = []
        """Numbers of the load steps in which an unstable equilibrium was found and left."""
        self.kept_unstable: list[int] = []
        """Numbers of the load steps that end at an unstable equilibrium."""
        self.frequencies: list[float | None] = []
        """Lowest natural frequency of each equilibrium [Hz]; None if it is not known."""
        self._frequency: float | None = None  # of the last equilibrium
        self._told = 0, 1.0  # iteration of the present search, and estimated error

    def next_step(self, bodies: Sequence[Body]) -> float:
        if self._relaxing:
            return super().next_step(bodies)
        level = self._levels[self._equilibria + 1]
        whole = min(self._share, level - self._begun_at) * self._each
        if self.touching is None or whole <= (longest := self.touching.largest_step()):
            return whole
        return whole / ceil(whole / longest)

    def span(self, dt: float) -> tuple[float, float]:
        if self._relaxing:
            return super().span(dt)
        return self._begun_at * self._each, dt

    def pace(self, dt: float) -> None:
        if self._relaxing:
            super().pace(dt)
        else:
            self._share_gravity(self._begun_at * self._each)
            for tool in self._led:
                tool.load_rate = 1.0

    def _share_gravity(self, time: float) -> None:
        """Let the fraction of gravity act that acts at a time of the loads [s]."""
        share = smooth_step(time / self.case.end)
        for body in self._relaxed:
            body.relax(1.0, 1.0, 1.0, share)
        for tool in self._free_tools:
            tool.share_gravity(share)

    def carry_out(self, dt: float, begin: Callable[[float], None], act: Callable[[float], None]) -> float:
        while not self._relaxing:
            if self.touching is not None:
                self.touching.begin(self._begun_at * self._each, dt, begin, act)
            else:
                begin(dt)
            for system in self._searched:
                system.begin(dt)
            renew = partial(self._renew_loads, self._begun_at * self._each, dt)
            renew(1.0)
            for system in self._searched:
                system.take_loads(renew, self._follows)
            try:
                self._approach(partial(renew, 1.0))
                rough = 0.0 if self.touching is None else NEARER * BEGIN_AT
                found = [minimiser.find(self._tell, rough) for minimiser in self._minimisers]
                if self._free_tools and self.touching is not None and self.touching.moved_too_far():
                    raise NoEquilibrium(TOO_FAR)
                if self.touching is not None:
                    found = self._without_overlap(self.touching, found, not self._reaches(dt), begin, act)
            except NoEquilibrium as reason:
                dt = self._retry(dt, str(reason))
                continue
            except Interrupted:
                self._reject()
                raise
            self._accept(found, dt)
            self._was_search = True
            return dt
        self._was_search = False
        return super().carry_out(super().next_step(self._bodies), begin, act)

    def _approach(self, renew: Callable[[], None]) -> None:
        """Let rigid bodies that nothing holds touch another body; renew: function that computes the loads."""
        if self.touching is None:
            return
        lost = self.touching.approach(renew, self._farthest)
        self._check_left_out(self.touching)
        if lost is not None:
            self._reject()
            raise RunStopped(
                f"load step {self._equilibria + 1}: the load on the rigid body {lost} moves it beyond the grid without contact "
                "with a body that deforms, so it has no equilibrium. Turn the load towards such a body, or hold the body by a "
                'spring (a [[load]] of kind "rigid-spring")',
                body=lost,
            )

    def _without_overlap(
        self,
        touching: ContactSearch,
        found: Sequence[Equilibrium],
        on_the_way: bool,
        begin: Callable[[float], None],
        act: Callable[[float], None],
    ) -> list[Equilibrium]:
        """Remove the overlaps in contact from equilibria that were found, and compute reactions and works of the tools. Returns
        the equilibria. Raises NoEquilibrium. on_the_way: True before the end of a load step; begin, act: as for `carry_out`.
        """
        iterations, overlaps = [equilibrium.iterations for equilibrium in found], list[float]()
        for number in range(1, MOST_CORRECTIONS + 1):
            touching.correct()
            for system in self._searched:
                system.attempt(system.tried.copy())
            scale = max(minimiser.largest[0] for minimiser in self._minimisers)
            overlaps.append(touching.overlap(scale))
            is_exact = touching.is_exact(overlaps, on_the_way) or number == MOST_CORRECTIONS
            enough = 0.0 if is_exact else NEARER * min(overlaps[-1], BEGIN_AT)
            found = [minimiser.again(self._tell, enough) for minimiser in self._minimisers]
            iterations = [before + equilibrium.iterations for before, equilibrium in zip(iterations, found, strict=True)]
            if is_exact:
                break
        if touching.moved_too_far():
            raise NoEquilibrium(TOO_FAR)
        (minimiser,) = self._minimisers
        left = touching.jump(minimiser.unbalanced)
        if left > MOST_UNSETTLED and not on_the_way:  # at the first touch all forces are small, and on the way nothing is lost
            raise NoEquilibrium(f"the forces of contact jump with its geometry, by {left:.2g} of all forces")
        if left > UNSETTLED and not on_the_way:
            self._warn_of_jump(left)
        self._check_left_out(touching)
        touching.end(begin, act)
        minimiser.unbalanced()
        touching.accept()
        return [equilibrium._replace(iterations=n, unbalanced=left) for equilibrium, n in zip(found, iterations, strict=True)]

    def _check_left_out(self, touching: ContactSearch) -> None:
        """Raise RunStopped if bodies overlap whose contact is not computed."""
        if (between := touching.left_out()) is None:
            return
        self._reject()
        raise RunStopped(
            f"load step {self._equilibria + 1}: {between} overlap, but [steady] computes contact of a rigid body under forces "
            "only with bodies that deform. Model it as a meshless solid of a stiff material"
        )

    def _warn_of_jump(self, left: float) -> None:
        warnings.warn(
            f"load step {self._equilibria + 1}: at the equilibrium the forces of contact jump by {left:.2g} of all forces with "
            "the smallest motion of a surface, because its points pass an edge or a corner of the other one. The contact "
            "force has an error of this size. Use a finer mesh where the edge presses, or a tool with a round edge",
            stacklevel=2,
        )

    def _renew_loads(self, start: float, dt: float, share: float) -> None:
        """Compute the loads for the present positions of the bodies at a share of a step dt [s] that begins at the time `start`
        of the loads [s]."""
        time = start + share * dt
        self._share_gravity(time)
        if self.touching is not None:
            self.touching.discard_loads()
        renew_loads(self._bodies, self._parts, time, dt)
        if self.touching is not None:
            self.touching.take_loads()

    def _tell(self, iteration: int, error: float) -> None:
        self._told = iteration, error
        self.on_the_way()

    def search(self) -> str:
        if self._relaxing:
            return super().search()
        iteration, error = self._told
        return f"{self._load_step()}: iteration {iteration}, estimated error {error:.1e}"

    def _retry(self, dt: float, reason: str) -> float:
        """Restore the last equilibrium after a failed search over a step dt [s]; return the next, shorter step [s]. If it would
        be too short, the load step goes on with the relaxation."""
        self._reject()
        self._share = 0.5 * dt / self._each
        number = self._equilibria + 1
        smallest = SMALLEST**2 if self._free_tools else SMALLEST
        if self._share >= smallest * (self._levels[number] - self._levels[number - 1]):
            return 0.5 * dt
        if self._free_tools:
            names = listed([tool.body.name for tool in self._free_tools])
            raise RunStopped(
                f"load step {number}: no equilibrium was found with a factored stiffness ({reason}) after the last one, at "
                f"{self._begun_at * self._each:.4g} s. The relaxation does not move the rigid body {names}. Hold it along axes "
                "on which contact does not hold it, or set more `steady.load_steps` or smaller loads"
            )
        if self._parts.of(VolumeLoad):
            raise RunStopped(
                f"load step {number}: no equilibrium was found with a factored stiffness ({reason}) after the last one, at "
                f"{self._begun_at * self._each:.4g} s. Set more `steady.load_steps`, or smaller loads; the "
                "relaxation includes neither enclosed contents nor given volumes"
            )
        warnings.warn(
            f"load step {number}: no equilibrium was found with a factored stiffness ({reason}); the relaxation goes on from "
            f"the last equilibrium, at {self._begun_at * self._each:.4g} s",
            stacklevel=2,
        )
        self._relaxing = True
        self.relaxed.append(number)
        self._prepare()
        return dt

    def _reject(self) -> None:
        """Restore the last equilibrium."""
        if self.touching is not None:
            self.touching.go_back()
        for system, minimiser in zip(self._searched, self._minimisers, strict=True):
            system.reject()
            minimiser.give_up()

    def _prepare(self) -> None:
        """Prepare the bodies for a relaxation; a second time nothing is left to do."""
        if self.touching is not None:
            self.touching.leave()
        if not self._prepared:
            self._prepared = True
            for body in self._relaxed:
                body.begin_relaxing(self.steady.mass_scaling)

    def _accept(self, found: Sequence[Equilibrium], dt: float) -> None:
        for system, equilibrium in zip(self._searched, found, strict=True):
            system.accept(equilibrium.position, dt, equilibrium.left_unstable)
        iterations = sum(equilibrium.iterations for equilibrium in found)
        self._iterations += iterations
        self.error = max(equilibrium.error for equilibrium in found)
        self._residual = max(equilibrium.unbalanced for equilibrium in found)
        every = [equilibrium.frequency for equilibrium in found if equilibrium.frequency is not None]
        self._frequency = min(every) if len(every) == len(found) else None
        number = self._equilibria + 1
        if any(equilibrium.left_unstable for equilibrium in found) and number not in self.unstable:
            self.unstable.append(number)
        if any(equilibrium.is_unstable for equilibrium in found) and number not in self.kept_unstable:
            self.kept_unstable.append(number)
            warnings.warn(
                f"load step {number}: the equilibrium is unstable: a small disturbance would grow. The search found no way "
                "from it to a stable one. A small load across the body, or an imperfect shape, shows where it goes",
                stacklevel=2,
            )
        if iterations <= QUICK:
            self._share = 2.0 * dt / self._each

    def advance(self, dt: float) -> None:
        if self._relaxing:
            self._residual = None
            super().advance(dt)
            return
        self.n_steps += 1
        self.dt, self.weight = dt, 0.0
        reached = self._reaches(dt)
        self._begun_at += dt / self._each
        if reached:
            self._step = self._iterations
            self._reach()

    def _reach(self) -> None:
        super()._reach()
        self.frequencies.append(None if self._relaxing else self._frequency)
        self._relaxing, self._iterations, self._share = False, 0, max(self._share, 1.0)
        if self.relaxed and self.relaxed[-1] == self._equilibria:
            for minimiser in self._minimisers:
                minimiser.forget()

    def counts(self, body: Body) -> bool:
        return self._was_search and self.touching is not None and self.touching.counts(body)

    def works_of_step(self, on_grid: StepWork) -> StepWork:
        return self.touching.done if self._was_search and self.touching is not None else on_grid

    adds_works_of_load_steps = True

    def _reaches(self, dt: float) -> bool:
        """Return True if a step dt [s] of the loads ends the load step."""
        return self._begun_at + dt / self._each >= self._levels[self._equilibria + 1] * (1.0 - 1e-12)

    @property
    def is_last_try(self) -> bool:
        return self._relaxing and super().is_last_try

    def _unbalanced(self) -> float:
        return super()._unbalanced() if self._residual is None else self._residual

    def facts(self) -> dict[str, Any]:
        own = {"method": "factored", "relaxed_load_steps": self.relaxed, "unstable_load_steps": self.unstable}
        own["kept_unstable_load_steps"] = self.kept_unstable
        return {"steady": {**own, "lowest_frequencies": self.frequencies, **super().facts()["steady"]}}

    def state_numbers(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in FACTORED}
        largest = [minimiser.largest for minimiser in self._minimisers]
        lists = {"relaxed": list(self.relaxed), "unstable": list(self.unstable), "largest_so_far": largest}
        lists["frequencies"], lists["kept_unstable"] = list(self.frequencies), list(self.kept_unstable)
        lists["in_single"] = [system.in_single for system in self._systems]
        return {**super().state_numbers(), **own, **lists}

    def ready(self, numbers: Mapping[str, Any]) -> None:
        if numbers["_prepared"]:
            self._prepare()

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(numbers, arrays)
        for name in (*FACTORED, "relaxed", "unstable", "kept_unstable", "frequencies"):
            setattr(self, name, numbers[name])
        for minimiser, largest in zip(self._minimisers, numbers["largest_so_far"], strict=True):
            minimiser.largest = tuple(largest)
        for system, in_single in zip(self._systems, numbers["in_single"], strict=True):
            system.in_single = in_single


def steady_clock(
    case: "Case", steady: "SteadyCase", bodies: Sequence[Body], parts: StepParts, works_on_grid: Callable[[], StepWork]
) -> Clock:
    """Return the clock of a steady analysis for its method. steady: its settings; works_on_grid: function that returns the
    works of the bodies on the grid in the last step."""
    given = steady, case.time, bodies, case.body, parts
    of_case = parts_of(case)
    if not steady.is_factored(of_case):
        return SteadyClock(*given)
    contact = next((contact for contact in parts.of(SurfacePairs) if contact), None)
    searched = [body for body in bodies if contact is None or deforms(body)]
    own = {body.name: body.elastic_system() for body in searched if isinstance(body, HasElasticSystem)}
    for pressure in parts.of(VolumeLoad):
        pressure.prepare(case.time.end, own[pressure.body].resistance)
        try:
            own[pressure.body].enclose(pressure)
        except ValueError as error:
            text = f"body {pressure.body}: {error}, which is not computed with a factored stiffness"
            raise CaseError(Problem(text, remedy="Hold the rim along the normal of its lid with a [[support]].")) from None
    systems = list(own.values())
    follows = any(condition.kind_of_load() == "follower" for condition in of_case.of(Condition))
    if steady.control == "arc-length":
        (system,) = systems
        return ArcLengthClock(steady, case.time, bodies, parts, system, follows)
    if (alone := must_touch(bodies, contact)) is not None:
        text = f"the rigid body {alone.name} is free to move, but no body that deforms can touch it"
        raise CaseError(Problem(text, remedy=f"Give {alone.name} a `field` of its own, or prescribe its motion."))
    touching = None if contact is None else contact_search(contact, bodies, systems, works_on_grid)
    grid = case.grid_or_none
    farthest = inf if grid is None else dist(grid.lower, grid.upper)
    return FactoredClock(*given, systems, follows or touching is not None, touching, farthest)


FACTORED = "_share", "_relaxing", "_prepared", "_iterations", "_residual"
