"""Settling before time 0: dynamics with all velocities set to zero whenever the kinetic energy passes a peak.

At a peak of the kinetic energy an oscillating body passes its equilibrium. If it is stopped there, the remaining
oscillation is smaller. Source: P. A. Cundall, Proc. 1st Int. Conf. Numer. Methods Geomech. (1976); M. R. Barnes, Int. J.
Space Struct. 14 (1999) 89.
"""

import signal
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import Interrupted, RunStopped
from pellucid.grid.points import FAULTS, LOST
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.progress import Progress
from pellucid.simulation.clock import Clock
from pellucid.simulation.loop import Observer

if TYPE_CHECKING:
    from pellucid.case.stages import SettleCase
    from pellucid.simulation.simulation import Simulation

# times that pressure waves need to cross a body; peaks must stay small at least so long, so that all parts affect each other
CROSSINGS = 2.0
AT_REST = 1e-12  # kinetic energy over the energy that bodies could release; below it they are at rest in any case
SWINGS = ("_passed", "_since", "_longest_swing", "_quiet", "_kinetic", "peak")  # attributes stored in a checkpoint
NAMED = "[settle]"  # start of messages about settling
SETTLING = "settling"  # key of these attributes among the numbers of the clock


class SettlingClock(Clock):
    """Clock of the settling (motion to rest before time 0): counts steps while the time of the loads is constant. settle:
    the table [settle]; run: clock of the run afterwards; models: models of all bodies."""

    def __init__(self, settle: "SettleCase", run: Clock, models: Sequence[BodyModel]) -> None:
        super().__init__(run.case, run.longest, parts=run.parts)
        self.settle, self.run = settle, run
        self._least = CROSSINGS * max((_crossing(model) for model in models if not model.is_rigid), default=0.0)
        self._passed = self._since = self._longest_swing = self._quiet = 0.0  # [s] of the settling
        self._kinetic = self.peak = 0.0

    def next_step(self, bodies: Sequence[Body]) -> float:
        limit, body = self.stable_step(bodies)
        if self.case.step is not None:
            self._check_fixed(self.case.step, limit)
            return self.case.step
        dt = min(self.case.courant * limit.step, self.case.end)
        self.check_collapse(dt, limit, [body] if body else bodies)
        return dt

    def span(self, dt: float) -> tuple[float, float]:
        """Return 0 for the time of the loads and for its increment in the step [s]: the loads are constant while bodies
        settle."""
        return 0.0, 0.0

    def advance(self, dt: float) -> None:
        self.n_steps += 1
        self.dt = dt
        self._passed += dt

    def passes_peak(self, kinetic: float, moved: float, at_stake: float) -> bool:
        """Return True if the kinetic energy of the bodies [J] has passed a peak, i.e. is lower than after the previous step:
        the bodies are then stopped.

        The bodies are settled after the kinetic energy has stayed small for at least the longest oscillation so far and the
        time that waves need to cross the bodies. Small means below the fraction `share` of `moved`, the largest energy that
        the bodies have exchanged so far [J], or below AT_REST times `at_stake`, the energy that the bodies could release
        [J].
        """
        small = kinetic <= max(self.settle.share * moved, AT_REST * at_stake)
        self._quiet = self._quiet + self.dt if small else 0.0
        passes = kinetic < self._kinetic
        if passes:
            self.peak = self._kinetic
            if not small:
                self._longest_swing = max(self._longest_swing, self._passed - self._since)
            self._since = self._passed
        self._kinetic = 0.0 if passes else kinetic
        return passes

    @property
    def _wanted(self) -> float:
        """Time for which the kinetic energy must stay small until the bodies count as at rest [s]."""
        return max(self._longest_swing, self._least)

    @property
    def is_settled(self) -> bool:
        """True if the bodies are at rest: their kinetic energy has been small for long enough, see `passes_peak`."""
        return self._quiet > self._wanted

    def no_rest(self, kinetic: float, moved: float) -> RunStopped | None:
        """Return an error if settling has taken too many steps, else None; kinetic: kinetic energy [J]; moved: largest energy
        that the bodies have exchanged so far [J]."""
        if self.n_steps < self.settle.most_steps:
            return None
        share = max(self.peak, kinetic) / moved if moved > 0.0 else 0.0
        state = f"the kinetic energy still reaches {share:.3g} of its reference ({moved:.3g} J)"
        if share <= self.settle.share:
            state = f"the kinetic energy has been small for {self._quiet:.3g} s, but {self._wanted:.3g} s are required"
        return RunStopped(
            f"{NAMED}: the bodies are not at rest after settle.most_steps = {self.settle.most_steps} steps: {state}, "
            f"settle.share = {self.settle.share:g}\n    Increase settle.most_steps (or, for bodies in contact, reduce "
            f"time.courant) and resume the run. Or start a new run: constrain bodies that can fall, slide or flow without end, "
            f"use more points per cell or trilinear functions for thin bodies, or increase settle.share."
        )

    def state_numbers(self) -> dict[str, Any]:
        return super().state_numbers() | {SETTLING: {name: vars(self)[name] for name in SWINGS}}

    def restore(self, numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(numbers, arrays)
        vars(self).update(numbers[SETTLING])


def settle(
    simulation: "Simulation", caught: Sequence[int], progress: Progress | None, keeper: Observer | None
) -> dict[str, Any]:
    """Bring the bodies of a simulation to rest under the actions at time 0, or continue an interrupted settling; return the
    entries for the summary.

    caught: signals received so far. A signal ends the settling after the observer `keeper` has written a checkpoint, from
    which the settling can be continued. Raises RunStopped if the bodies do not come to rest, Interrupted after a signal.
    """
    if simulation.case.settle is None:
        return {}
    if isinstance(simulation.clock, SettlingClock):
        settling = simulation.clock
    else:
        _stop_what_moves(simulation, simulation.case.settle.share)
        simulation.clock = settling = SettlingClock(simulation.case.settle, simulation.clock, simulation.case.body)
    if progress:
        progress.begin("settling")
    try:
        _come_to_rest(simulation, settling, caught, progress, keeper)
    except RunStopped as error:
        place = error.place | {"settling_step": settling.n_steps}
        raise RunStopped(_while_settling(str(error)), **place) from error
    finally:
        simulation.clock = settling.run
    simulation.begin_balance()
    return {"settled": {"steps": settling.n_steps, "kinetic_energy": settling.peak}}


def _while_settling(text: str) -> str:
    """Return the reason of a stop, `text`, marked as a stop during settling (the search for rest before time 0), with a
    remedy if a body has moved out of the grid."""
    text = text if text.startswith(NAMED) else f"{NAMED}: {text}"
    remedy = "\n    Constrain bodies that can fall, slide or flow without end."
    return f"{text}{remedy}" if FAULTS[LOST].meaning in text else text


def _stop_what_moves(simulation: "Simulation", share: float) -> None:
    """Set the velocities of the bodies to zero before settling, and warn, if their kinetic energy is larger than a fraction
    (`share`) of the energy that they could release.

    Velocities in a case with [settle] are errors, but bodies may have velocities from an earlier run. They settle at their
    positions of that run, and their initial kinetic energy must not affect the criterion for rest.
    """
    kinetic = simulation.kinetic_energy()
    if kinetic > share * simulation.budget.at_stake:
        text = f"{NAMED} sets all velocities to zero, but the bodies start with a kinetic energy of {kinetic:.3g} J"
        warnings.warn(f"{text}. Remove [settle] to keep these velocities.", stacklevel=2)
        _stop(simulation)
        simulation.begin_balance()


def _come_to_rest(
    simulation: "Simulation", settling: SettlingClock, caught: Sequence[int], progress: Progress | None, keeper: Observer | None
) -> None:
    while not settling.is_settled:
        budget = simulation.budget
        stopped = settling.no_rest(simulation.kinetic_energy(), budget.moved)
        if stopped:
            if keeper:
                keeper.checkpoint(simulation)  # from which it can go on with more steps
            raise stopped
        simulation.advance_bodies()
        if settling.passes_peak(simulation.kinetic_energy(), budget.moved, budget.at_stake):
            _stop(simulation)
        if keeper:
            keeper.while_settling(simulation)
        if caught:
            if keeper:
                keeper.checkpoint(simulation)
            raise Interrupted(by_keyboard=caught[0] == signal.SIGINT)
        simulation.show(progress)
    _stop(simulation)


def _stop(simulation: "Simulation") -> None:
    for body in simulation.bodies:
        body.come_to_rest()


def _crossing(model: BodyModel) -> float:
    """Return the time that pressure waves need to cross the body of a model from end to end [s]."""
    lower, upper = model.bounds()
    return float((upper - lower).max()) / model.waves_at_start()[0]
