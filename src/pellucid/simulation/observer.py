"""Interface for objects that read a simulation during a run: the recorder, and tests."""

from typing import Any, Protocol

from pellucid.errors import RunStopped


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
