"""Initial field: a sinusoidal velocity."""

from typing import Literal

import numpy as np

from pellucid.bodies.initial.contract import InitialField
from pellucid.model import Vector, parameter


class SineWave(InitialField):
    """An initial velocity a sin(k·x + φ) at positions x, with an amplitude vector a, a wave vector k and a phase φ."""

    kind: Literal["sine-wave"] = "sine-wave"
    amplitude: Vector = parameter("m/s", "amplitude a")
    wave_vector: Vector = parameter("rad/m", "wave vector k")
    phase: float = parameter("rad", "phase φ", 0.0)

    def at(self, position: np.ndarray) -> np.ndarray:
        return np.sin(position @ np.array(self.wave_vector) + self.phase)[:, None] * np.array(self.amplitude)
