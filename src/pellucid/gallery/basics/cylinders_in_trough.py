"""Metrics and figures of cylinders that oscillate in a trough, sliding or rolling: angles and energies compared with
pendulums."""

import numpy as np
from scipy.integrate import solve_ivp

from pellucid.gallery.exact_curves import beside, column, energy_metric, vanishing
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"cylinders_in_trough": "Angles of the cylinders, errors of the angles, and changes of energy."}

METRICS = ("glides", "rolls", "glides_energy", "rolls_energy", "slip", "spin", "aside", "energy")

LENGTH, RADIUS, GRAVITY = 0.5, 0.2, 9.81  # difference of the radii [m], of the cylinders [m], [m/s²]
START = np.arctan2(4.0, 3.0)
INERTIA = {"glides": 1.0, "rolls": 1.5}
"""Effective inertia divided by mass of a gliding and a rolling cylinder; a rolling cylinder also rotates, with a moment
of inertia of m R²/2."""


def exact(run: Run, name: str) -> Array:
    """Return the exact angle of the axis of the cylinder `name` about the axis of the trough, from the lowest point, at
    each row of the history [rad]: the angle of an equivalent pendulum."""
    time, pull = column(run, "time"), GRAVITY / LENGTH / INERTIA[name]
    found = solve_ivp(
        lambda _, s: [s[1], -pull * np.sin(s[0])], (0.0, time[-1]), [START, 0.0], t_eval=time, rtol=1e-9, atol=1e-9
    )
    return np.asarray(found.y[0])


def angle(run: Run, name: str) -> Array:
    """Return the computed angle of a cylinder's axis about the axis of the trough, from the lowest point, at each row of the
    history [rad]."""
    return np.arctan2(column(run, f"{name}_x"), -column(run, f"{name}_y"))


def energy_change(run: Run, name: str) -> Array:
    """Return the change of kinetic plus potential energy of the cylinder `name` since the start, divided by the potential
    energy released on the way down, at each row of the history. The kinetic energy of a rolling cylinder includes its
    rotation."""
    squared = column(run, f"{name}_vx") ** 2 + column(run, f"{name}_vy") ** 2
    energy = 0.5 * INERTIA[name] * squared + GRAVITY * column(run, f"{name}_y")
    return np.asarray((energy - energy[0]) / (GRAVITY * LENGTH * (1.0 - np.cos(START))))


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each cylinder the largest error of its angle in the trough and the largest change of its
    energy; largest difference between the rotation of the rolling cylinder and rolling without slip; largest rotation of the
    sliding cylinder; displacement of the cylinders along the trough; error of the energy balance."""
    # A cylinder sinks in by 0.01 to 0.025 cells, most where it presses most, and the start leaves it free by the sagittas of
    # facets: the pendulum is longer by some cell/50, and what that frees is damped. What rolls winds up springs of friction
    # across the width of the contact, and leaves them behind: twice as much.
    cells = run.case.grid.cell / RADIUS
    result = {}
    for name in INERTIA:
        off = float(np.max(np.abs(angle(run, name) - exact(run, name))))
        meaning = "largest difference from the angle of the pendulum; error relative to the initial angle"
        result[name] = Metric(off, 0.0, off / START, 0.04 * cells, "rad", meaning)
        change = float(np.max(np.abs(energy_change(run, name))))
        meaning = "largest change of energy, relative to the potential energy released on the way down"
        result[f"{name}_energy"] = vanishing(change, (0.06 if name == "glides" else 0.12) * cells, meaning)
    turned, way = column(run, "rolls_angle"), LENGTH / RADIUS * (START - angle(run, "rolls"))
    slip, spin = float(np.max(np.abs(turned - way))), float(np.max(np.abs(column(run, "glides_angle"))))
    meaning = "rolling cylinder: largest difference between its rotation and that of rolling without slip"
    result["slip"] = Metric(slip, 0.0, slip / float(way[-1]), 0.04 * cells, "rad", meaning)
    result["spin"] = Metric(
        spin,
        0.0,
        spin / float(way[-1]),
        0.02 * cells,
        "rad",
        "sliding cylinder: largest rotation; error relative to that of the rolling cylinder",
    )
    aside = max(float(np.ptp(column(run, f"{name}_z"))) for name in INERTIA)
    result["aside"] = Metric(
        aside,
        0.0,
        aside / RADIUS,
        1e-6,
        "m",
        "displacement along the trough, which must vanish by symmetry; error relative to the radius",
    )
    return result | {"energy": energy_metric(run, 0.005)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the angles of the cylinders in the trough, their differences from the equivalent
    pendulums, and the changes of their energies against time."""
    time = column(run, "time")
    figure, (swing, off, energy) = new_panels(1, 3, height=3.4)
    for colour, name in zip(COLOURS, INERTIA, strict=False):
        found, wanted = np.degrees(angle(run, name)), np.degrees(exact(run, name))
        beside(swing, time, found, wanted, name, colour)
        off.plot(time, found - wanted, color=colour, label=name)
        energy.plot(time, 100.0 * energy_change(run, name), color=colour, label=name)
    for axes in (off, energy):
        axes.axhline(0.0, color="#bbb", linewidth=1.0)
    label(swing, "time", "angle", "s", "°", legend=True)
    label(off, "time", "computed minus exact angle", "s", "°")
    label(energy, "time", "change of energy", "s", "%")
    return {"cylinders_in_trough": figure}
