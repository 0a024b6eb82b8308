"""Interface of a signal: a prescribed displacement as a function of time."""

from abc import abstractmethod
from collections.abc import Callable

from pellucid.model import Model

Displacement = Callable[[float], float]


class SignalModel(Model):
    """A displacement as a function of time. A new kind of signal is a subclass with its own `kind`."""

    kind: str

    @abstractmethod
    def function(self) -> Displacement:
        """Return the displacement [m] as a function of time [s]."""

    @abstractmethod
    def top_speed(self) -> float:
        """Return the largest absolute velocity [m/s], or an upper bound."""
