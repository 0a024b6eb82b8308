"""Metrics of two colliding discs: symmetry, energy, contact and rebound."""

import numpy as np

from pellucid.gallery.exact_curves import energy_metric, vanishing, worst_balance
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

# Finite elements of our own, 48 rings (validation/basics-colliding-discs/disc_on_wall.csv), for the case as it stands
CONTACT_BEGINS, CONTACT_DURATION = 1.609, 0.975  # s
RESTITUTION = 0.905
REFERENCE_MATERIAL = {"young_modulus": 1000.0, "poisson_ratio": 0.3, "density": 1000.0}

METRICS = ("momentum", "mirror", "diagonal", "energy", "energy_swing", "contact_begins", "contact_duration", "rebound")


def metrics(run: Run) -> dict[str, Metric]:
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
