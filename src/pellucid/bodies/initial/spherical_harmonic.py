"""Initial field: a concentration that is a spherical harmonic around a centre."""

from math import factorial, pi, sqrt
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.polynomial.legendre import Legendre
from pydantic import model_validator

from pellucid.bodies.initial.contract import InitialField
from pellucid.model import Vector, parameter


class SphericalHarmonic(InitialField):
    """A concentration a Y_lm that depends on the direction from a centre. Y_lm is the real spherical harmonic whose square
    has the integral 1 over the unit sphere."""

    quantity: ClassVar[str] = "concentration"

    kind: Literal["spherical-harmonic"] = "spherical-harmonic"
    amplitude: float = parameter("", "factor a of the harmonic", 1.0)
    degree: int = parameter("", "degree l of the harmonic", ge=0, le=20)
    order: int = parameter("", "order m: cos(mφ) for positive m, sin(|m|φ) for negative m; φ is the angle about z from x", 0)
    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _has_an_order(self) -> Self:
        if abs(self.order) > self.degree:
            raise ValueError(f"`order` = {self.order} must be between -`degree` and `degree`, here {self.degree}")
        return self

    def at(self, position: np.ndarray) -> np.ndarray:
        """Return the concentration, shape (n,), at positions [m], shape (n, 3). No position may be the centre."""
        offset = position - np.array(self.centre)
        x, y, z = (offset / np.linalg.norm(offset, axis=1)[:, None]).T
        m = abs(self.order)
        around = (x + 1j * y) ** m
        norm = sqrt((2 * self.degree + 1) / (4.0 * pi) * factorial(self.degree - m) / factorial(self.degree + m))
        wave = around.imag if self.order < 0 else around.real
        return self.amplitude * norm * (sqrt(2.0) if m else 1.0) * Legendre.basis(self.degree).deriv(m)(z) * wave
