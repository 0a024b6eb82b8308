"""Metrics and figures of elastic vibrations, compared with exact solutions: the standing wave of a bar and a spinning disc."""

from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from pellucid.gallery.exact_curves import compared, energy_metric, vanishing
from pellucid.references import Array
from pellucid.references.solids import SpinningDisc, StandingWave, period_of
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

WAVE_CAPTIONS = {"wave": "Velocity and displacement along the bar at the end, and the velocity of the antinode against time."}

WAVE_METRICS = ("velocity_l2", "displacement_l2", "period")


def wave_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: relative L2 errors of velocity and displacement along the bar at the end, error of the
    period."""
    wave = StandingWave.of(run.case)
    x, displacement, velocity, time = _state(run)
    # Second order in kh: a lumped mass slows the wave by (kh)²/24, and the grid's smoothing of the points' velocities by
    # (kh)²/12 to (kh)²/8 with linear functions, by about (kh)²/4 with quadratic B-splines. The phase error grows with
    # time; each field has its own (kh)² too. Velocities and places are half a step apart: first order, but small here.
    cell_phase = abs(wave.wave_number) * run.case.grid.cell
    slower = 0.3 * cell_phase**2
    allowed = wave.frequency * time * slower + 0.25 * cell_phase**2 + 0.5 * run.case.time.courant * cell_phase
    result = {}
    for name, found, exact in (
        ("velocity_l2", velocity, wave.velocity(x, time)),
        ("displacement_l2", displacement, wave.displacement(x, time)),
    ):
        scale = abs(wave.amplitude) * (1.0 if name == "velocity_l2" else 1.0 / wave.frequency)
        error = float(np.sqrt(np.mean((found - exact) ** 2)) / (scale * np.sqrt(0.5)))
        result[name] = vanishing(error, allowed, f"L2 error of the {name.split('_')[0]}, relative to the norm of its amplitude")
    period = period_of(run.history["time"], run.history["antinode"])
    result["period"] = compared(period, wave.period, slower, "s", "period at the antinode")
    return result


def wave_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show velocity and displacement along the bar at the end, and the velocity of the antinode
    against time."""
    wave = StandingWave.of(run.case)
    x, displacement, velocity, time = _state(run)
    order = np.argsort(x)
    figure, (along, across, swing) = new_panels(1, 3, width=10.0, height=3.4, title=f"{run.case.title}, t = {time:.4g} s")
    for axes, name, unit, found, exact in (
        (along, "velocity", "m/s", velocity, wave.velocity(x, time)),
        (across, "displacement", "m", displacement, wave.displacement(x, time)),
    ):
        axes.plot(x[order], exact[order], color="black", linewidth=1, label="exact")
        axes.plot(x[order], found[order], ".", color=COLOURS[1], markersize=3, label="points")
        label(axes, "x", name, "m", unit)
    times = run.history["time"]
    swing.plot(times, wave.velocity(np.array(0.25), 0.0) * np.cos(wave.frequency * times), color="black", linewidth=1)
    swing.plot(times, run.history["antinode"], "--", color=COLOURS[1])
    label(swing, "time", "velocity at x = 0.25 m", "s", "m/s")
    along.legend()
    return {"wave": figure}


def _state(run: Run) -> "tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]":
    """Return initial position [m], displacement [m] and velocity [m/s] along x, each (n,), and the time [s] at the end."""
    name = run.case.body[0].name
    times = run.times(name)
    start, end = run.fields(name, float(times[0])), run.fields(name, float(times[-1]))
    x = np.asarray(start["position"])[:, 0]
    return x, np.asarray(end["position"])[:, 0] - x, np.asarray(end["velocity"])[:, 0], float(times[-1])


DISC_CAPTIONS = {"spinning_disc": "Mean stress against time, and stresses against the radius, averaged over the frames."}

DISC_METRICS = ("mean_stress", "breathing_period", "angle", "angular_momentum", "energy")


def disc_metrics(run: Run) -> dict[str, Metric]:
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


def disc_figures(run: Run) -> dict[str, Figure]:
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


CASES = {
    "elastic-wave": SimpleNamespace(METRICS=WAVE_METRICS, CAPTIONS=WAVE_CAPTIONS, metrics=wave_metrics, figures=wave_figures),
    "spinning-disc": SimpleNamespace(METRICS=DISC_METRICS, CAPTIONS=DISC_CAPTIONS, metrics=disc_metrics, figures=disc_figures),
}
"""Metrics, captions and figures of each case, by its name without the group."""
