"""Metrics of collisions of elastic bodies: two bars, two discs, and a block that bounces on a floor."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.model import MeshlessSolidCase
from pellucid.gallery.exact_curves import column, compared, energy_metric, vanishing, worst_balance
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

BARS_METRICS = ("force", "duration", "striker", "struck", "energy")

LENGTH, WAVE_SPEED, IMPEDANCE = 1.0, 100.0, 1e5  # [m], [m/s], ρ c A [N s/m] of a bar of 1 m²
SPEED, GAP = 0.1, 0.001  # [m/s], [m]
TOUCH, DURATION, FORCE = GAP / SPEED, 2.0 * LENGTH / WAVE_SPEED, 0.5 * IMPEDANCE * SPEED


def bars_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: mean contact force, duration of contact, speeds of both bars at the end, error of the energy
    balance."""
    time, force = column(run, "time"), column(run, "force")
    since = (time - TOUCH) / DURATION
    middle = float(np.mean(force[(since > 0.2) & (since < 0.8)]))
    lasted = float(np.sum(np.diff(time) * (force[1:] > 0.5 * FORCE)))
    striker, struck = (float(column(run, f"{name}_vx")[-1]) for name in ("striker", "struck"))
    # A front is a cell wide at first, and on its way widens as (c t h²)^(1/3), as in basics/elastic-block-drop: what comes
    # back late stays as vibration.
    front = (0.125 * (run.case.grid.cell / (2.0 * LENGTH)) ** 2) ** (1.0 / 3.0)
    return {
        "force": compared(middle, FORCE, 0.02, "N", "mean force from 20 % to 80 % of the exact contact time"),
        "duration": compared(
            lasted, DURATION, 2.0 * front, "s", "time for which the contact force exceeds half of the exact force"
        ),
        "striker": Metric(
            striker,
            0.0,
            abs(striker) / SPEED,
            2.0 * front,
            "m/s",
            "speed of the striking bar at the end; error relative to the initial speed",
        ),
        "struck": compared(struck, SPEED, 2.0 * front, "m/s", "speed of the struck bar at the end"),
        "energy": energy_metric(run, 0.01),
    }


# Finite elements of our own, 48 rings (validation/basics-colliding-discs/disc_on_wall.csv), for the case as it stands
CONTACT_BEGINS, CONTACT_DURATION = 1.609, 0.975  # s
RESTITUTION = 0.905
REFERENCE_MATERIAL = {"young_modulus": 1000.0, "poisson_ratio": 0.3, "density": 1000.0}

DISCS_METRICS = ("momentum", "mirror", "diagonal", "energy", "energy_swing", "contact_begins", "contact_duration", "rebound")


def discs_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: conservation of momentum, mirror symmetry of the mean velocities, errors of the energy
    balance at the end and at worst. With the parameters of Sulsky's problem also the time of first contact, the duration of
    contact, and the ratio of speeds after and before."""
    times, lower, upper = _mean_velocities(run)
    speed = float(np.linalg.norm(lower[0]))
    bodies = [run.fields(body.name) for body in run.case.body]
    momentum = sum(np.sum(np.asarray(b["mass"])[:, None] * np.asarray(b["velocity"]), axis=0) for b in bodies)
    scale = sum(np.sum(np.asarray(b["mass"]) * np.linalg.norm(np.asarray(b["velocity"]), axis=1)) for b in bodies)
    drift = float(np.linalg.norm(momentum) / scale)
    asymmetry = float(np.max(np.abs(lower + upper)) / speed)
    off_line = float(np.max(np.abs(lower[:, 0] - lower[:, 1])) / speed)
    result = {
        "momentum": vanishing(drift, 1e-12, "|sum m v| divided by sum m |v| at the end: only round-off is allowed"),
        "mirror": vanishing(asymmetry, 1e-9, "largest sum of the two mean velocities, relative to the initial speed"),
        "diagonal": vanishing(off_line, 1e-6, "largest vx - vy of a disc, relative to the initial speed"),
        "energy": energy_metric(run, 0.02),
        # Contact squeezes a cell or two of each disc at once, which the step follows at first order only: 0.5 % at most.
        "energy_swing": worst_balance(run, 0.03, "largest relative error of the energy balance during the run"),
    }
    if _as_published(run):
        result |= _contact(run, times, lower, speed)
    return result


def _contact(run: Run, times: Array, lower: Array, speed: float) -> dict[str, Metric]:
    """Return the metrics of contact: its start, its duration and the ratio of the speeds after and before.

    Contact lasts from a change of 1 % of the approach velocity to within 1 % of the rebound velocity. times: [s], shape
    (rows,). lower: mean velocity of the lower disc [m/s], shape (rows, 2). speed: initial speed of a disc [m/s].
    """
    along = lower @ lower[0] / speed**2
    begins = _crossing(times, along, 0.99)
    rebound = float(np.mean(along[times > times[-1] - 0.4]))
    ends = _crossing(times, along, 0.99 * rebound + 0.01)
    # Discs feel each other when they share nodes, up to two cells apart along each axis: earlier, and so much longer.
    early = 2.0 * np.sqrt(2.0) * run.case.grid.cell / (2.0 * speed)
    length, slower = ends - begins, abs(-rebound / RESTITUTION - 1.0)
    late, longer = abs(begins / CONTACT_BEGINS - 1.0), abs(length / CONTACT_DURATION - 1.0)
    return {
        "contact_begins": Metric(
            begins, CONTACT_BEGINS, late, early / CONTACT_BEGINS, "s", "time at which the discs start to slow down"
        ),
        "contact_duration": Metric(length, CONTACT_DURATION, longer, early / CONTACT_DURATION, "s", "duration of the contact"),
        "rebound": Metric(
            -rebound, RESTITUTION, slower, 0.1, "", "ratio of the speeds of a disc's centre after and before the contact"
        ),
    }


def _crossing(times: Array, signal: Array, level: float) -> float:
    """Return the time at which a falling signal first crosses a level [s]; nan if it never does."""
    below = np.flatnonzero(signal < level)
    if len(below) == 0 or below[0] == 0:
        return float("nan")
    i = below[0]
    return float(times[i - 1] + (signal[i - 1] - level) / (signal[i - 1] - signal[i]) * (times[i] - times[i - 1]))


def _as_published(run: Run) -> bool:
    case = run.case
    same = all(getattr(body.material, key, None) == value for body in case.body for key, value in REFERENCE_MATERIAL.items())
    return same and np.linalg.norm(case.body[0].velocity) == np.linalg.norm([0.1, 0.1]) and case.time.end > 3.3


def _mean_velocities(run: Run) -> tuple[Array, Array, Array]:
    history = run.history
    lower, upper = (np.column_stack([history[f"{name}_x"], history[f"{name}_y"]]) for name in ("lower", "upper"))
    return np.asarray(history["time"]), lower, upper


DROP_METRICS = ("force", "turn", "rebound", "energy")


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


def drop_metrics(run: Run) -> dict[str, Metric]:
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


CASES = {
    "colliding-bars": SimpleNamespace(METRICS=BARS_METRICS, metrics=bars_metrics),
    "colliding-discs": SimpleNamespace(METRICS=DISCS_METRICS, metrics=discs_metrics),
    "elastic-block-drop": SimpleNamespace(METRICS=DROP_METRICS, metrics=drop_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
