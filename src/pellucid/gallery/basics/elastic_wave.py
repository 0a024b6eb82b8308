"""Metrics and figures of the standing wave of an elastic bar, compared with the exact solution."""

import numpy as np
from numpy.typing import NDArray

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.references.solids import StandingWave, period_of
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"wave": "Velocity and displacement along the bar at the end, and the velocity of the antinode against time."}

METRICS = ("velocity_l2", "displacement_l2", "period")


def metrics(run: Run) -> dict[str, Metric]:
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


def figures(run: Run) -> dict[str, Figure]:
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
