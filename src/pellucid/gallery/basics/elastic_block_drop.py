"""Metrics of a block without lateral strain that bounces on a floor, compared with the exact impact of a bar on a rigid
wall."""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.model import MeshlessSolidCase
from pellucid.gallery.exact_curves import compared, energy_metric
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

METRICS = ("force", "turn", "rebound", "energy")


class Impact(NamedTuple):
    """Impact of an elastic bar on a rigid wall: during the time 2 L/c the force is ρ c v A, and the bar rebounds with its
    initial speed.

    L: length, c: wave speed, ρ: density, v: speed, A: cross-section. Source: Timoshenko & Goodier, Theory of Elasticity,
    section 167.
    """

    length: float  # length of the bar [m]
    area: float  # cross-section [m²]
    wave_speed: float  # speed of longitudinal waves [m/s]
    density: float  # density of the bar [kg/m³]
    speed: float  # speed of the bar before the impact [m/s]
    touch: float  # time of first contact [s]
    spacing: float  # spacing of the nodes along the bar [m]

    @classmethod
    def of(cls, run: Run) -> "Impact":
        """Build the impact from the case of a run. Raises TypeError unless the body is a meshless box."""
        body = run.case.body[0]
        if not isinstance(body, MeshlessSolidCase) or body.mesh.box is None:
            raise TypeError("the exact impact requires a box of a meshless solid")
        low, high = (np.array(corner) for corner in body.bounds())
        size, speed = high - low, -body.velocity[2]
        fall = float(low[2]) - run.case.grid.lower[2]
        along = body.mesh.box.cells[2]
        wave = body.wave_speeds()[0]
        length = float(size[2])
        return cls(length, float(size[0] * size[1]), wave, body.density, speed, fall / speed, length / along)

    @property
    def duration(self) -> float:
        """Duration of the impact, 2 L/c [s]."""
        return 2.0 * self.length / self.wave_speed

    @property
    def force(self) -> float:
        """Force of the bar on the floor during the impact, ρ c v A [N]."""
        return self.density * self.wave_speed * self.speed * self.area

    @property
    def front(self) -> float:
        """Return the rise time of the wave front at the end of the impact, as a fraction of the duration.

        Lumped masses at a distance h slow waves of wave number k by (kh)²/24, which widens a front to (c t h²/8)^(1/3) (as
        an Airy function, Whitham, Linear and Nonlinear Waves, section 11.5).
        """
        return float((0.125 * (self.spacing / (2.0 * self.length)) ** 2) ** (1.0 / 3.0))


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: mean force on the floor during contact, time from contact until the velocity is zero, rebound
    velocity, error of the energy balance."""
    exact, history = Impact.of(run), run.history
    time, velocity, push = (np.asarray(history[name], dtype=float) for name in ("time", "velocity_z", "force"))
    step = np.diff(time, prepend=0.0)  # a row has the mean force since the row before
    since = (time - exact.touch) / exact.duration
    middle = (since > 0.2) & (since <= 0.8)
    force = float(push[middle] @ step[middle] / step[middle].sum())
    k = int(np.argmax(velocity > 0.0))
    turn = float(np.interp(0.0, velocity[k - 1 : k + 1], time[k - 1 : k + 1])) - exact.touch
    rebound = float(velocity[-1])
    # the reference is linear in the strain v/c; the nodes on the floor, half a spacing of the mass, stop at once
    strain, stopped = exact.speed / exact.wave_speed, 0.5 * exact.spacing / exact.length
    half = 0.5 * exact.duration
    text = "rebound velocity at the end; reference: impact speed, of which a part remains as vibration"
    return {
        "force": compared(force, exact.force, strain + stopped, "N", "mean force from 20 % to 80 % of the exact contact time"),
        "turn": compared(turn, half, strain + stopped, "s", "time from first contact until the velocity is zero"),
        "rebound": compared(rebound, exact.speed, 2.0 * exact.front, "m/s", text),
        "energy": energy_metric(run, 0.02),
    }
