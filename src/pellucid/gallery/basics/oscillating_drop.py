"""Metrics and figures of an oscillating drop, compared with Rayleigh's frequency and Laplace's pressure."""

import numpy as np

from pellucid.gallery.exact_curves import compared
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"oscillating_drop": "Stretch of the drop against time, compared with an oscillation of Rayleigh's frequency."}

METRICS = ("period", "pressure", "surface", "balance")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: period of the oscillation, mean pressure in the drop, surface energy at the start, largest
    error of the energy balance."""
    rate, fading, radius, tension = _exact(run)
    time, stretch = _stretch(run)
    share = run.case.grid.cell / radius
    still = np.flatnonzero(stretch[:-1] * stretch[1:] < 0.0)
    instants = time[still] - stretch[still] * (time[still + 1] - time[still]) / (stretch[still + 1] - stretch[still])
    # a whole swing from the start: where it swings about is not known to the last
    period = float(instants[1]) if len(instants) > 1 else float("nan")
    name = run.case.body[0].name
    pressures = [_mean_pressure(run.fields(name, float(at))) for at in run.times(name)]
    missed = float(np.abs(run.history["time_integration_error"]).max() / np.asarray(run.history["kinetic_energy"])[0])
    octant = 0.5 * np.pi * radius**2 * tension
    surface = float(np.asarray(run.history[f"{name}_surface_energy"])[0])
    exact = float(2.0 * np.pi / np.sqrt(rate**2 - fading**2))
    return {
        "period": compared(period, exact, 0.5 * share, "s", "period; reference: Rayleigh's period with Lamb's damping"),
        "pressure": compared(
            float(np.mean(pressures)), 2.0 * tension / radius, 0.03, "Pa", "mean pressure over the run; reference: 2 σ/R"
        ),
        "surface": compared(surface, octant, 0.5 * share, "J", "surface energy at the start; reference: σ times the area"),
        "balance": Metric(
            missed,
            0.0,
            missed,
            0.02,
            "",
            "largest error of the energy balance during the run, relative to the initial kinetic energy",
        ),
    }


def _exact(run: Run) -> tuple[float, float, float, float]:
    """Return Rayleigh's angular frequency and Lamb's decay rate [1/s], the radius [m] and the surface tension [N/m]."""
    body, tension = run.case.body[0], run.case.surface_tension[0].tension
    lower, upper = body.bounds()
    radius, law = float(upper[2] - lower[2]) / 2.0, body.material
    rate, viscosity = float(np.sqrt(8.0 * tension / (law.density * radius**3))), law.model_dump()["viscosity"]
    return rate, 5.0 * viscosity / (law.density * radius**2), radius, tension


def _stretch(run: Run) -> tuple[Array, Array]:
    """Return the times of the stored frames [s], and the change of the drop's elongation along z since the start, divided by
    its radius, shape (frames,) each."""
    name = run.case.body[0].name
    times, radius = np.asarray(run.times(name), float), _exact(run)[2]
    found = []
    for time in times:
        points = run.fields(name, float(time))
        x, y, z = (np.asarray(points["position"]) ** 2).T
        mass = np.asarray(points["mass"])
        found.append(float(np.sum(mass * (z - 0.5 * (x + y))) / np.sum(mass)))
    stretch = np.array(found) * 5.0 / (3.0 * radius**2)  # z = (1 + a) Z and x = (1 - a/2) X: 3 a R²/5 for small a
    return times, stretch - stretch[0]


def _mean_pressure(points: dict[str, Array]) -> float:
    """Return the volume average of the pressure [Pa] within half the radius of the drop. points: fields of its points."""
    place = np.linalg.norm(np.asarray(points["position"]), axis=1)
    within = place < 0.5 * place.max()
    volume = np.asarray(points["mass"])[within] / np.asarray(points["density"])[within]
    return float(np.sum(volume * np.asarray(points["pressure"])[within]) / volume.sum())


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the elongation of the drop along z, divided by its radius, against time."""
    rate, fading, _, _ = _exact(run)
    time, stretch = _stretch(run)
    swing = float(np.sqrt(rate**2 - fading**2))
    speed = float(run.case.body[0].initial_velocity(np.array([[0.0, 0.0, 1.0]]))[0, 2])  # of the stretch at the start
    figure, axes = new_panels(1, 1, width=6.0, height=3.5)
    shown = np.linspace(0.0, time[-1], 400)
    exact = speed / swing * np.exp(-fading * shown) * np.sin(swing * shown)
    axes.plot(1e3 * shown, exact, color="black", linewidth=1, label="exact")
    axes.plot(1e3 * time, stretch, "o", color=COLOURS[0], markersize=3, label="points")
    label(axes, "time", "stretch", "ms", "1", legend=True)
    return {"oscillating_drop": figure}
