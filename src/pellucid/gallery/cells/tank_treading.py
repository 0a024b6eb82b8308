"""Metrics and figures of a tank-treading capsule: rate and inclination compared with the ellipsoid of Keller and Skalak.

The surface moves as (L cos φ, B sin φ) along its half axes L and B, with the same rate of the phase φ everywhere (Keller &
Skalak 1982, J. Fluid Mech. 120, 27). With equal viscosities inside and outside and the shear rate γ̇, the inclination θ
follows from tan θ = B/L, and φ' = -γ̇ L B/(L² + B²) for any width of the ellipsoid.
"""

import numpy as np

from pellucid.gallery.exact_curves import compared
from pellucid.geometry.meshes.enclosure import ellipsoid_of
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

NAME, SHEAR_RATE = "capsule", 1.0
DRAWN, STEADY = 1.0, 3.0  # from when on it has an inclination, and keeps its shape [s]
SLOWER, SPREAD = 0.025, 0.1
"""Tolerances of the rate. Boundary integrals give a rate 2.2 % below the ellipsoid's. The grid smooths forces and
velocities over a cell, an error of first order: 5 % are allowed with 4 cells per radius, 3.8 % with 8 cells."""
CAPTIONS = {
    "tread": "Mean rotation of the surface (tank-treading) and inclination, compared with an ellipsoid of the same axes."
}
METRICS = ("inclination", "tread_rate")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: inclination of the longest axis of the capsule at the end, and rate at which its membrane
    rotates (tank-treads) while the shape is steady. Empty for a run that ends before its shape is steady."""
    times, phases, axes = _course(run)
    late = times >= STEADY
    if np.count_nonzero(late) < 2:
        return {}
    long, short, inclination = axes[-1]
    expected = float(np.degrees(np.arctan(short / long)))
    turned = float(np.degrees(inclination))
    rate = float(np.polyfit(times[late], phases[late], 1)[0])
    longs, shorts = axes[late, 0], axes[late, 1]
    ideal = -SHEAR_RATE * float(np.mean(longs * shorts / (longs**2 + shorts**2)))
    cell = run.case.grid.cell if run.case.grid is not None else 0.0
    what = "angle of the longest axis to the flow at the end; reference: ellipsoid of the same axes; error in degrees"
    return {
        "inclination": Metric(turned, expected, abs(turned - expected), 2.0, "degree", what),
        "tread_rate": compared(
            rate,
            ideal,
            SLOWER + SPREAD * cell,
            "1/s",
            "mean tank-treading rate from time 3 on; reference: ellipsoid of the same axes",
        ),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the rotation of the membrane about the capsule and the inclination of the longest axis
    against time."""
    times, phases, axes = _course(run)
    figure, (left, right) = new_panels(1, 2, height=3.4)
    ideal = -SHEAR_RATE * axes[:, 0] * axes[:, 1] / (axes[:, 0] ** 2 + axes[:, 1] ** 2)
    steps = np.concatenate([[0.0], 0.5 * (ideal[1:] + ideal[:-1]) * np.diff(times)])
    left.plot(times, -np.degrees(phases), "o-", color=COLOURS[0], markersize=3, label="capsule")
    left.plot(times, -np.degrees(np.cumsum(steps)), "--", color=COLOURS[1], label="Keller & Skalak")
    right.plot(times, np.degrees(axes[:, 2]), "o-", color=COLOURS[0], markersize=3, label="capsule")
    right.plot(times, np.degrees(np.arctan(axes[:, 1] / axes[:, 0])), "--", color=COLOURS[1], label="Keller & Skalak")
    label(left, "time", "rotation of the surface", "s", "degree", legend=True)
    label(right, "time", "inclination", "s", "degree", legend=True)
    return {"tread": figure}


def _course(run: Run) -> tuple[Array, Array, Array]:
    """Return the times of the stored frames [s], shape (n,); the mean change of the phase φ of nodes near the plane of the
    shear [rad], shape (n,); and the two half axes in this plane [m] and the inclination [rad], shape (n, 3)."""
    times, triangles = np.array([time for time in run.times(NAME) if time >= DRAWN]), run.triangles(NAME)
    rows: list[tuple[float, float, float]] = []
    phases: list[Array] = []
    for time in times:
        position = run.fields(NAME, float(time))["position"]
        if not phases:
            middle = np.abs(position[:, 2]) < 0.25 * np.abs(position[:, 2]).max()
        long, short, inclination, phase = _ellipse(position, triangles)
        rows.append((long, short, inclination))
        phases.append(phase[middle])
    return times, np.unwrap(np.array(phases), axis=0).mean(axis=1) - phases[0].mean(), np.array(rows)


def _ellipse(position: Array, triangles: Array) -> tuple[float, float, float, Array]:
    """Fit an ellipsoid to the capsule. Return its two half axes in the plane of the shear [m], the inclination of the longer
    one in [0, π) [rad], and the phase φ of the nodes [rad], shape (n,).

    position: [m], shape (n, 3); triangles: node numbers, shape (m, 3).
    """
    ellipsoid = ellipsoid_of(position, triangles)
    first, second = (k for k in range(3) if abs(ellipsoid.directions[k, 2]) < 0.5)
    long, short = ellipsoid.axes[first], ellipsoid.axes[second]
    along = ellipsoid.directions[first, :2]
    along = along if along[1] >= 0.0 else -along
    x, y = (position[:, :2] - position[:, :2].mean(axis=0)).T
    phase = np.arctan2((y * along[0] - x * along[1]) / short, (x * along[0] + y * along[1]) / long)
    return float(long), float(short), float(np.arctan2(along[1], along[0])), phase
