"""Interface of an initial field: an addition to the uniform initial state of a body."""

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from pellucid.model import Model


class InitialField(Model):
    """Field added to a quantity of a body at the start. A new kind is a subclass with its own `kind`."""

    quantity: ClassVar[str] = "velocity"
    """The array of the points to which the field is added: the velocity, or a state of the material such as the stress."""

    kind: str

    @abstractmethod
    def at(self, position: np.ndarray) -> np.ndarray:
        """Return the values that the field adds at positions [m], shape (n, 3): one row per position, for velocities [m/s]
        shape (n, 3)."""
