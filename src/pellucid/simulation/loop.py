"""The time loop of a run whose results are stored: settling, steps, threads, checkpoints, signals and progress; and the
interface of objects that read a simulation during a run."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from pellucid.errors import Interrupted, RunStopped
from pellucid.progress import Progress
from pellucid.ranks.domain import domain
from pellucid.simulation.ranks import interrupted
from pellucid.system.interrupts import signals_caught

if TYPE_CHECKING:
    from pellucid.simulation.simulation import Simulation


class Observer(Protocol):
    """Interface of an object that reads a simulation during a run, for example to store results, and never changes the
    simulation."""

    def begin(self, simulation: Any) -> None:
        """Record the initial state. Called before the first step."""

    def after_step(self, simulation: Any) -> None:
        """Read the simulation after a step. Called after each step."""

    def while_settling(self, simulation: Any) -> None:
        """Read the simulation after a step of settling (the search for rest before time 0), before `begin`."""

    def checkpoint(self, simulation: Any) -> None:
        """Write a checkpoint, from which the run can continue."""

    def end(self, simulation: Any) -> None:
        """Complete the stored results. Called after the last step."""

    def keep_last(self, simulation: Any) -> None:
        """Store the present state as a last row of the history and a last frame, for a run that ends before its goal."""

    def failed(self, simulation: Any, error: RunStopped) -> None:
        """Record the state in which the run was stopped by an error."""


def recorded_steps(
    simulation: "Simulation", recorder: Observer, until: float | None = None, progress: Progress | None = None
) -> Iterator["Simulation"]:
    """Compute steps until the end of the case or `until` [s] of simulated time, and yield the simulation after each step. If
    the loop over this generator ends early, the stored results end at the last step of the loop.

    recorder: object that stores the results; progress: display of the progress. SIGTERM and Ctrl-C write a checkpoint and
    raise Interrupted. Raises RunStopped if the state becomes invalid.
    """
    with signals_caught() as caught:
        try:
            if not simulation.begun:
                _settle_and_begin(simulation, recorder, caught, progress)
            else:
                recorder.begin(simulation)
            simulation.clock.on_the_way = partial(_on_the_way, simulation, caught, progress)
            if progress:
                progress.begin("running", simulation.case.time.end if until is None else until)
            while not simulation.clock.finished(until):
                if simulation.clock.is_last_try:
                    recorder.checkpoint(simulation)
                simulation.thread_choice.before_step()
                try:
                    simulation.step()
                except Interrupted:
                    recorder.checkpoint(simulation)
                    raise
                simulation.thread_choice.after_step()
                recorder.after_step(simulation)
                if simulation.clock.missed is not None:
                    recorder.keep_last(simulation)
                    raise RunStopped(simulation.clock.missed, step=simulation.n_steps, time=simulation.time)
                if signals := domain.caught(caught):
                    recorder.checkpoint(simulation)
                    raise interrupted(signals)
                simulation.show(progress)
                yield simulation
            recorder.end(simulation)
            if signals := domain.caught(caught):
                raise interrupted(signals)
        except GeneratorExit:
            recorder.end(simulation)
            raise
        except RunStopped as error:
            domain.group.agree_on(error)  # the next calls communicate with all processes
            recorder.failed(simulation, error)
            raise


def _on_the_way(simulation: "Simulation", caught: Sequence[int], progress: Progress | None) -> None:
    """Show the progress within a long step, and raise Interrupted, which ends the step, after a signal.

    caught: signals received so far; progress: display of the progress.
    """
    simulation.show(progress)
    if signals := domain.caught(caught):
        raise interrupted(signals)


def _settle_and_begin(simulation: "Simulation", recorder: Observer, caught: Sequence[int], progress: Progress | None) -> None:
    """Let the bodies settle if the case has [settle], and start recording. If settling fails, the state at the failure is
    recorded; an error of this recording does not replace the error that stopped the settling.

    recorder: object that stores the results; caught: signals received so far.
    """
    try:
        simulation.settle(caught, progress, recorder)
    except RunStopped as error:
        simulation.begin_balance()  # the balance of settling omits the energy that stopping the bodies removed
        try:
            recorder.begin(simulation)
        except Exception as trouble:
            error.add_note(f"The state at the stop could not be recorded: {trouble}")
        raise
    recorder.begin(simulation)
