"""Metrics and figures of a spinning elastic disc, compared with the exact radial oscillation of linear elasticity."""

import numpy as np

from pellucid.gallery.exact_curves import compared, energy_metric
from pellucid.references import Array
from pellucid.references.solids import SpinningDisc
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"spinning_disc": "Mean stress against time, and stresses against the radius, averaged over the frames."}

METRICS = ("mean_stress", "breathing_period", "angle", "angular_momentum", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: time mean of σxx + σyy (virial theorem), period of the first radial mode, rotation angle at
    the end, change of the angular momentum, error of the energy balance."""
    disc, name = SpinningDisc.of(run.case), run.case.body[0].name
    times = np.asarray(run.times(name), dtype=float)
    frames = [run.fields(name, float(time)) for time in times]
    cell_share = run.case.grid.cell / disc.radius
    strain = disc.density * (disc.angular_velocity * disc.radius) ** 2 / disc.young_modulus
    # Whole points at the rim leave it known to a fraction of a cell, and the reference is linear in the strain.
    first_order = cell_share + strain
    # Nodes outside the rim take the mean velocity of the points within: a rim of one cell lags by a share of a cell.
    second_order = cell_share**2

    history_time, pull = _mean_pull(run)
    mean = float(np.trapezoid(pull, history_time) / history_time[-1])
    static = disc.static_mean_stress
    breath = float(2.0 * np.pi / disc.breathing[2][0])
    found = _upward_crossings(history_time, pull, static)
    period = float(np.mean(np.diff(found[:6]))) if len(found) > 1 else float("nan")

    angle = _angle(frames[0], frames[-1], disc.angular_velocity * times[-1])
    wanted = disc.angular_velocity * float(times[-1])
    spin = [_angular_momentum(frame) for frame in frames]
    lost = abs(spin[-1] / spin[0] - 1.0)
    return {
        "mean_stress": compared(mean, static, first_order, "Pa", "time mean of sxx + syy; reference: virial theorem"),
        "breathing_period": compared(period, breath, first_order, "s", "period of the first radial mode"),
        "angle": compared(angle, wanted, strain + 3.0 * second_order, "rad", "rotation angle at the end"),
        "angular_momentum": Metric(
            spin[-1],
            spin[0],
            lost,
            second_order,
            "kg m^2/s",
            "angular momentum at the end; reference: at the start",
        ),
        "energy": energy_metric(run, 0.02),
    }


def _mean_pull(run: Run) -> tuple[Array, Array]:
    """Return the times of the history [s], and the mean of σxx + σyy over the points at these times [Pa]."""
    history = run.history
    return np.asarray(history["time"]), np.asarray(history["stress_xx"]) + np.asarray(history["stress_yy"])


def _upward_crossings(times: Array, signal: Array, level: float) -> Array:
    before = np.flatnonzero((signal[:-1] < level) & (signal[1:] >= level))
    share = (level - signal[before]) / (signal[before + 1] - signal[before])
    return np.asarray(times[before] + share * (times[before + 1] - times[before]))


def _angular_momentum(points: dict[str, Array]) -> float:
    x, v, mass = (np.asarray(points[key]) for key in ("position", "velocity", "mass"))
    return float(np.sum(mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])))


def _angle(start: dict[str, Array], end: dict[str, Array], guess: float) -> float:
    """Return the mean rotation angle of the points about the origin [rad]. start, end: fields of the points before and after,
    by name; guess: approximate angle [rad], which determines the number of whole turns."""
    a, b = np.asarray(start["position"]), np.asarray(end["position"])
    turned = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]))
    return float(turned + 2.0 * np.pi * np.round((guess - turned) / (2.0 * np.pi)))


def _polar_stresses(points: dict[str, Array]) -> tuple[Array, Array, Array]:
    """Return radius [m], radial and hoop stress [Pa] of the points, shape (n,) each. points: fields of the points, by name."""
    x, y = np.asarray(points["position"])[:, :2].T
    s = np.asarray(points["stress"])
    angle = np.arctan2(y, x)
    c, n = np.cos(angle), np.sin(angle)
    radial = c * c * s[:, 0] + n * n * s[:, 1] + 2.0 * c * n * s[:, 5]
    return np.hypot(x, y), radial, s[:, 0] + s[:, 1] - radial


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the mean of σxx + σyy against time, and radial and hoop stress against the radius,
    averaged over the stored frames of the run."""
    disc, name = SpinningDisc.of(run.case), run.case.body[0].name
    times, pull = _mean_pull(run)
    shown = times <= min(times[-1], 10.0 * 2.0 * np.pi / disc.breathing[2][0])
    figure, (left, right) = new_panels(1, 2, width=10.0, height=4.0)
    left.plot(times[shown], disc.mean_stress(times[shown]), color="black", linewidth=1, label="exact")
    left.plot(times[shown], pull[shown], "--", color=COLOURS[1], label="points")
    left.axhline(disc.static_mean_stress, color="grey", linewidth=0.8, linestyle=":")
    label(left, "time", "mean of σxx + σyy", "s", "Pa")
    frames = [_polar_stresses(run.fields(name, float(time))) for time in run.times(name)[1:]]
    radius, radial, hoop = (np.concatenate(part) for part in zip(*frames, strict=True))
    edges = np.linspace(0.0, 1.02 * disc.radius, 21)
    count = np.histogram(radius, edges)[0]
    r = np.linspace(1e-6, disc.radius, 200)
    middles = 0.5 * (edges[1:] + edges[:-1])
    for values, exact, colour, name in zip((radial, hoop), disc.stresses(r), COLOURS[:2], ("radial", "hoop"), strict=True):
        right.plot(r, exact, color="black", linewidth=1)
        right.plot(middles, np.histogram(radius, edges, weights=values)[0] / count, "o", color=colour, label=name)
    label(right, "radius", "stress, mean over the frames", "m", "Pa", legend=True)
    left.set_ylim(top=1.25 * float(pull[shown].max()))
    left.legend(loc="upper right", ncols=2)
    return {"spinning_disc": figure}
