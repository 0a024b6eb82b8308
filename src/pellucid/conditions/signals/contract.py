"""The interface of a signal: a prescribed displacement as a function of time."""

from abc import abstractmethod
from collections.abc import Callable

from pellucid.model import Model

Displacement = Callable[[float], float]


class SignalModel(Model):
    """A displacement as a function of time. A new kind is a subclass with a `kind` of its own."""

    kind: str

    @abstractmethod
    def function(self) -> Displacement:
        """Displacement [m] as a function of time [s]."""

    @abstractmethod
    def top_speed(self) -> float:
        """Largest velocity [m/s]."""
