"""Bodies as the user describes them; a new kind of body is one class here in the union and one file beside this."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator

from pellucid.geometry.shapes import Shape
from pellucid.materials import Material
from pellucid.model import Model, Vector, parameter

ZERO = (0.0, 0.0, 0.0)


class SineWave(Model):
    """An initial velocity a sin(k·x + φ)."""

    amplitude: Vector = parameter("m/s", "amplitude a")
    wave_vector: Vector = parameter("rad/m", "wave vector k")
    phase: float = parameter("rad", "phase φ", 0.0)

    def at(self, position: np.ndarray) -> np.ndarray:
        """Velocity [m/s], shape (n, 3), at positions [m], shape (n, 3)."""
        return np.sin(position @ np.array(self.wave_vector) + self.phase)[:, None] * np.array(self.amplitude)


class MaterialPointsCase(Model):
    """A fluid or solid body of material points."""

    kind: Literal["material-points"] = "material-points"
    name: str = parameter("", "name of the body, used for its files and in probes", pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    shape: Shape = parameter("", "where the body is at the start")
    points_per_cell: int | tuple[int, int, int] | None = parameter(
        "", "points in a cell: along each axis, or their number; without it two along each axis that is not thin", None
    )
    material: Material = parameter("", "what the body is made of")
    velocity: Vector = parameter("m/s", "initial velocity", ZERO)
    angular_velocity: Vector = parameter("rad/s", "initial angular velocity about the shape's centre", ZERO)
    velocity_wave: SineWave | None = parameter("", "initial sinusoidal velocity, added to the others", None)

    @field_validator("points_per_cell")
    @classmethod
    def _positive(cls, value: int | tuple[int, int, int] | None) -> int | tuple[int, int, int] | None:
        if value is not None and min(value if isinstance(value, tuple) else (value,)) < 1:
            raise ValueError("points_per_cell must be at least 1 along every axis")
        return value


Body = Annotated[MaterialPointsCase, Field(description="a body")]
