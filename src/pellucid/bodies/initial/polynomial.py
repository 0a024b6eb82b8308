"""Initial field: a concentration that is a polynomial of one coordinate, given by its zeros."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.bodies.initial.contract import InitialField
from pellucid.model import parameter


class Polynomial(InitialField):
    """A concentration a (x - x₁)(x - x₂)... of the position x along an axis, with zeros x₁, x₂, ... [m]."""

    quantity: ClassVar[str] = "concentration"

    kind: Literal["polynomial"] = "polynomial"
    factor: float = parameter("", "factor a of the polynomial", 1.0)
    zeros: tuple[float, ...] = parameter("m", "zeros x₁, x₂, ... of the polynomial", ())
    axis: Literal["x", "y", "z"] = parameter("", "axis along which the added field varies", "x")

    def at(self, position: np.ndarray) -> np.ndarray:
        x = position[:, "xyz".index(self.axis)]
        return self.factor * np.prod(x[:, None] - np.array(self.zeros), axis=1)
