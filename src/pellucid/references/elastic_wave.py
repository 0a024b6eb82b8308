"""Standing wave in an elastic bar between two walls or in a periodic bar: v = V sin(kx+φ) cos(ωt)."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.materials.elastic import ElasticMaterial
from pellucid.references.annotations import Array, Case


@dataclass(frozen=True)
class StandingWave:
    """A standing wave v = V sin(kx+φ) cos(ωt) in an elastic bar, the reference of a case: amplitude V [m/s], wave number k
    [rad/m], phase φ [rad] and wave speed [m/s]."""

    amplitude: float  # V, largest velocity [m/s]
    wave_number: float  # k [rad/m]
    phase: float  # φ [rad]
    speed: float  # wave speed c [m/s]

    @classmethod
    def of(cls, case: Case) -> "StandingWave":
        """Build the standing wave from the initial velocity of the first body of a case. In a laterally constrained bar
        the modulus is λ + 2μ."""
        body = case.body[0]
        wave = body.velocity_wave if isinstance(body, MaterialPointsCase) else None
        material: object = body.material
        if wave is None or not isinstance(material, ElasticMaterial):
            raise ValueError(f"body {body.name!r} must be an elastic solid with a velocity_wave")
        nu = material.poisson_ratio
        modulus = material.young_modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        return cls(wave.amplitude[0], wave.wave_vector[0], wave.phase, sqrt(modulus / material.density))

    @property
    def frequency(self) -> float:
        """Angular frequency ω = kc [rad/s]."""
        return abs(self.wave_number) * self.speed

    @property
    def period(self) -> float:
        """Period 2π/ω of the standing wave [s]."""
        return 2.0 * np.pi / self.frequency

    def velocity(self, x: Array, time: float) -> Array:
        """Return the velocity along the bar [m/s] at initial positions x [m] and a time [s]."""
        return self.amplitude * np.sin(self.wave_number * x + self.phase) * np.cos(self.frequency * time)

    def displacement(self, x: Array, time: float) -> Array:
        """Return the displacement along the bar [m] at initial positions x [m] and a time [s]."""
        swing = np.sin(self.frequency * time) / self.frequency
        return self.amplitude * np.sin(self.wave_number * x + self.phase) * swing


def period_of(times: Array, signal: Array) -> float:
    """Return the period [s] of an oscillation about zero, from its linearly interpolated zero crossings; NaN for fewer than
    two crossings.

    times: times of the samples [s], shape (n,); signal: samples, shape (n,).
    """
    before = np.flatnonzero(signal[:-1] * signal[1:] < 0.0)
    if len(before) < 2:
        return float("nan")
    share = signal[before] / (signal[before] - signal[before + 1])
    crossings = times[before] + share * (times[before + 1] - times[before])
    return float(2.0 * (crossings[-1] - crossings[0]) / (len(crossings) - 1))
