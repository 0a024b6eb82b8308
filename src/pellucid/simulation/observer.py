"""The interface of what reads a simulation during a run: the recorder, and tests."""

from typing import Any, Protocol

from pellucid.errors import RunStopped


class Observer(Protocol):
    """Reads the simulation during a run, and never changes it."""

    def begin(self, simulation: Any) -> None:
        """Called before the first step."""

    def after_step(self, simulation: Any) -> None:
        """Called after each step."""

    def while_settling(self, simulation: Any) -> None:
        """Called after each step of settling, before `begin`."""

    def checkpoint(self, simulation: Any) -> None:
        """Keep all that is needed to go on."""

    def end(self, simulation: Any) -> None:
        """Called after the last step."""

    def keep_last(self, simulation: Any) -> None:
        """Keep the state as it is, from which the run does not go on."""

    def failed(self, simulation: Any, error: RunStopped) -> None:
        """Called when the run stopped itself."""
