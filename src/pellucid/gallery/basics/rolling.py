"""Metrics and figures of balls, discs and cylinders that roll or slide down a slope, in a trough and over a disc, compared with
rigid bodies."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from pellucid.gallery.exact_curves import beside, column, compared, energy_metric, vanishing
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

BALL_METRICS = ("way", "speed", "aside", "energy")

SHARE = 5.0 / 7.0
"""Acceleration of a rolling ball, divided by the gravity component along the slope; its moment of inertia is 2/5 m R²."""


def ball_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distance and speed along the slope at the end, largest lateral deviation of the ball, error
    of the energy balance."""
    end, pull = float(run.history["time"][-1]), SHARE * float(run.case.gravity[0])
    way, aside = float(column(run, "ball_x")[-1]), float(np.max(np.abs(column(run, "ball_y"))))
    # four cells to the radius: as far as a disc of eight may err, twice over
    return {
        "way": compared(way, 0.5 * pull * end**2, 0.04, "m", "distance along the slope at the end"),
        "speed": compared(float(column(run, "ball_vx")[-1]), pull * end, 0.04, "m/s", "speed along the slope at the end"),
        "aside": Metric(
            aside, 0.0, aside / way, 0.002, "m", "largest lateral deviation; error relative to the distance travelled"
        ),
        "energy": energy_metric(run, 0.005),
    }


BALLS_SHARES = {"solid_rolls": 5.0 / 7.0, "hollow_rolls": 3.0 / 5.0, "solid_glides": 1.0, "hollow_glides": 1.0}
"""Acceleration of each ball, divided by the gravity component along the slope. The moments of inertia of the solid and
the hollow ball are 2/5 and 2/3 m R²; sliding balls do not rotate."""
ROLLS, GLIDES, ASIDE, ENERGY = 0.02, 0.005, 0.002, 0.005
LAST = 0.1  # s at the end, over which the speed is taken: a ball of flat faces rolls on unevenly

BALLS_METRICS = (*(f"{name}_{what}" for name in BALLS_SHARES for what in ("way", "speed")), "aside", "energy")


def balls_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distance along the slope and speed of each ball at the end, largest lateral deviation of any
    ball, error of the energy balance."""
    time = column(run, "time")
    end, result, aside = float(time[-1]), {}, 0.0
    for name, share in BALLS_SHARES.items():
        way, tolerance = column(run, f"{name}_way"), ROLLS if "rolls" in name else GLIDES
        exact = share * exact_way(run, time)
        result[f"{name}_way"] = compared(
            float(way[-1]), float(exact[-1]), tolerance, "m", "distance along the slope at the end"
        )
        found, reference = ((way[-1] - np.interp(end - LAST, time, way)) / LAST for way in (way, exact))
        text = f"mean speed along the slope over the last {LAST:g} s"
        result[f"{name}_speed"] = compared(float(found), float(reference), tolerance, "m/s", text)
        aside = max(aside, float(np.abs(column(run, f"{name}_aside")).max() / way[-1]))
    text = "largest lateral deviation, relative to the distance travelled: the meshes are not exactly symmetric"
    return {**result, "aside": Metric(aside, 0.0, aside, ASIDE, "", text), "energy": energy_metric(run, ENERGY)}


def exact_way(run: Run, time: np.ndarray) -> np.ndarray:
    """Return the distance that a frictionless body slides down the slope [m] at times [s]; as in the case, gravity first
    increases linearly."""
    case: Any = run.case
    grown, pull = float(case.gravity_amplitude.times[1]), float(case.gravity[0])
    late = np.maximum(time - grown, 0.0)
    early = np.minimum(time, grown)
    return np.asarray(pull * (early**3 / (6.0 * grown) + 0.5 * grown * late + 0.5 * late**2))


DISCS_METRICS = ("rigid", "elastic", "gliding", "gliding_speed", "energy")

DISCS_SHARES = {"rigid": 2.0 / 3.0, "elastic": 2.0 / 3.0, "gliding": 1.0}
"""Acceleration of each disc, divided by the gravity component along the slope; a rolling disc also rotates, with a
moment of inertia of m R²/2."""
DISCS_RADIUS = 0.4


def discs_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: distances of the discs along the slope at the end, speed of the frictionless disc at the end,
    error of the energy balance."""
    end, along = float(run.history["time"][-1]), float(run.case.gravity[0])
    # A surface of points is round to a share of (cell/R)², but a layer of half a cell gives way where it touches: the radius
    # it rolls with, and the place where it is borne, are known to a small share of cell/R. 2 % at R/8, twice for elastic ones.
    cells = run.case.grid.cell / DISCS_RADIUS
    tolerances = {"rigid": 0.16 * cells, "elastic": 0.32 * cells, "gliding": 0.08 * cells}
    result = {
        name: compared(
            float(column(run, f"{name}_x")[-1]), 0.5 * share * along * end**2, tolerances[name], "m", "distance along the slope"
        )
        for name, share in DISCS_SHARES.items()
    }
    speed = float(column(run, "gliding_vx")[-1])
    result["gliding_speed"] = compared(
        speed, along * end, tolerances["gliding"], "m/s", "speed of the frictionless disc at the end"
    )
    return result | {"energy": energy_metric(run, 0.005)}


TROUGH_CAPTIONS = {"cylinders_in_trough": "Angles of the cylinders, errors of the angles, and changes of energy."}

TROUGH_METRICS = ("glides", "rolls", "glides_energy", "rolls_energy", "slip", "spin", "aside", "energy")

LENGTH, TROUGH_RADIUS, TROUGH_GRAVITY = 0.5, 0.2, 9.81  # difference of the radii [m], of the cylinders [m], [m/s²]
START = np.arctan2(4.0, 3.0)
INERTIA = {"glides": 1.0, "rolls": 1.5}
"""Effective inertia divided by mass of a gliding and a rolling cylinder; a rolling cylinder also rotates, with a moment
of inertia of m R²/2."""


def exact_angle(run: Run, name: str) -> Array:
    """Return the exact angle of the axis of the cylinder `name` about the axis of the trough, from the lowest point, at
    each row of the history [rad]: the angle of an equivalent pendulum."""
    time, pull = column(run, "time"), TROUGH_GRAVITY / LENGTH / INERTIA[name]
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
    energy = 0.5 * INERTIA[name] * squared + TROUGH_GRAVITY * column(run, f"{name}_y")
    return np.asarray((energy - energy[0]) / (TROUGH_GRAVITY * LENGTH * (1.0 - np.cos(START))))


def trough_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: for each cylinder the largest error of its angle in the trough and the largest change of its
    energy; largest difference between the rotation of the rolling cylinder and rolling without slip; largest rotation of the
    sliding cylinder; displacement of the cylinders along the trough; error of the energy balance."""
    # A cylinder sinks in by 0.01 to 0.025 cells, most where it presses most, and the start leaves it free by the sagittas of
    # facets: the pendulum is longer by some cell/50, and what that frees is damped. What rolls winds up springs of friction
    # across the width of the contact, and leaves them behind: twice as much.
    cells = run.case.grid.cell / TROUGH_RADIUS
    result = {}
    for name in INERTIA:
        off = float(np.max(np.abs(angle(run, name) - exact_angle(run, name))))
        meaning = "largest difference from the angle of the pendulum; error relative to the initial angle"
        result[name] = Metric(off, 0.0, off / START, 0.04 * cells, "rad", meaning)
        change = float(np.max(np.abs(energy_change(run, name))))
        meaning = "largest change of energy, relative to the potential energy released on the way down"
        result[f"{name}_energy"] = vanishing(change, (0.06 if name == "glides" else 0.12) * cells, meaning)
    turned, way = column(run, "rolls_angle"), LENGTH / TROUGH_RADIUS * (START - angle(run, "rolls"))
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
        aside / TROUGH_RADIUS,
        1e-6,
        "m",
        "displacement along the trough, which must vanish by symmetry; error relative to the radius",
    )
    return result | {"energy": energy_metric(run, 0.005)}


def trough_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the angles of the cylinders in the trough, their differences from the equivalent
    pendulums, and the changes of their energies against time."""
    time = column(run, "time")
    figure, (swing, off, energy) = new_panels(1, 3, height=3.4)
    for colour, name in zip(COLOURS, INERTIA, strict=False):
        found, wanted = np.degrees(angle(run, name)), np.degrees(exact_angle(run, name))
        beside(swing, time, found, wanted, name, colour)
        off.plot(time, found - wanted, color=colour, label=name)
        energy.plot(time, 100.0 * energy_change(run, name), color=colour, label=name)
    for axes in (off, energy):
        axes.axhline(0.0, color="#bbb", linewidth=1.0)
    label(swing, "time", "angle", "s", "°", legend=True)
    label(off, "time", "computed minus exact angle", "s", "°")
    label(energy, "time", "change of energy", "s", "%")
    return {"cylinders_in_trough": figure}


GLIDING_CAPTIONS = {"energy": "Energy of both discs; grey: exact."}

GLIDING_METRICS = ("speed", "contact_work", "energy_flat", "energy_round", "way")

HILL = np.array([3.6, 0.6])
CENTRES, GLIDING_GRAVITY = 0.8, 9.81  # distance of the centres [m], [m/s²]


def gliding_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: speed of the disc on the plate at the end, work of the contact forces over the run, largest
    change of the kinetic plus potential energy of each disc, largest distance of the centre of the disc on the hill from its
    exact position."""
    time, speed, work = column(run, "time"), column(run, "flat_vx"), float(run.history["contact_work"][-1])
    moving = float(run.history["kinetic_energy"][0])
    place, exact = np.column_stack([column(run, "round_x"), column(run, "round_y")]), bead(run, time)
    off = float(np.max(np.linalg.norm(place - exact, axis=1)))
    # Each disc sinks in by 5e-4 m at most until the plate bears it, and what that frees, m g d, is damped: 0.25 % of what
    # moves. The rest is surface points that come and go: together half a percent.
    lost = 0.005
    result = {
        "speed": compared(
            float(speed[-1]), float(speed[0]), lost, "m/s", "speed on the plate at the end; reference: at the start"
        ),
        "contact_work": Metric(
            work, 0.0, abs(work) / moving, lost, "J", "work of contact; error relative to the initial kinetic energy"
        ),
    }
    for name, level in (("flat", 0.6), ("round", HILL[1])):
        energy = energy_of(run, name, level)
        change = float(np.max(np.abs(energy / energy[0] - 1.0)))
        meaning = "largest change of kinetic plus potential energy; heights are measured from the middle of plate or hill"
        result[f"energy_{name}"] = Metric(float(energy[-1]), float(energy[0]), change, lost, "J/kg", meaning)
    # The start leaves the hill free by the sagitta of a facet, and a rigid disc sinks in again: 1e-3 m, which the unstable
    # way over the top doubles.
    result["way"] = Metric(
        off, 0.0, off / CENTRES, 0.01, "m", "largest distance from the exact position; error relative to 0.8 m"
    )
    return result


def energy_of(run: Run, name: str, level: float) -> Array:
    """Return the kinetic plus potential energy of a disc divided by its mass [J/kg] at each row of the history; level: height
    of zero potential energy [m]."""
    squared = column(run, f"{name}_vx") ** 2 + column(run, f"{name}_vy") ** 2
    return np.asarray(0.5 * squared + GLIDING_GRAVITY * (column(run, f"{name}_y") - level))


def bead(run: Run, time: Array) -> Array:
    """Return the exact positions of the centre of the disc that slides over the hill [m], shape (n, 2), at times [s]: on a
    circle until it loses contact, then in free flight."""
    first = np.array([column(run, "round_x")[0], column(run, "round_y")[0]]) - HILL
    speed = float(np.hypot(column(run, "round_vx")[0], column(run, "round_vy")[0]))
    start = [np.arctan2(first[0], first[1]), speed / CENTRES]

    def leaves(_: float, state: Array) -> float:
        return float(GLIDING_GRAVITY * np.cos(state[0]) - CENTRES * state[1] ** 2)

    leaves.terminal = True  # type: ignore[attr-defined]
    end = float(time[-1]) + 1e-9
    found = solve_ivp(
        lambda _, s: [s[1], GLIDING_GRAVITY / CENTRES * np.sin(s[0])],
        (0, end),
        start,
        events=leaves,
        rtol=1e-9,
        dense_output=True,
    )
    off = float(found.t[-1])
    if found.sol is None:
        raise ValueError("no dense output")
    angle, rate = found.sol(np.minimum(time, off))
    flown = np.maximum(time - off, 0.0)
    outward, along = np.stack([np.sin(angle), np.cos(angle)]), np.stack([np.cos(angle), -np.sin(angle)])
    way = HILL[:, None] + CENTRES * outward + CENTRES * rate * flown * along
    way[1] -= 0.5 * GLIDING_GRAVITY * flown**2
    return np.asarray(way.T)


def gliding_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the relative changes of kinetic plus potential energy of both discs against time."""
    time = column(run, "time")
    figure, axes = new_panels(height=3.0)
    for name, level, what, colour in (("flat", 0.6, "on the plate", 0), ("round", HILL[1], "over the hill", 1)):
        share = energy_of(run, name, level)
        beside(axes, time, 100.0 * (share / share[0] - 1.0), np.zeros(len(time)), what, COLOURS[colour])
    axes.set_ylim(-1.0, 1.0)
    label(axes, "time", "change of energy", "s", "%", legend=True)
    return {"energy": figure}


CASES = {
    "rolling-ball": SimpleNamespace(METRICS=BALL_METRICS, metrics=ball_metrics),
    "rolling-balls": SimpleNamespace(METRICS=BALLS_METRICS, metrics=balls_metrics),
    "rolling-discs": SimpleNamespace(METRICS=DISCS_METRICS, metrics=discs_metrics),
    "cylinders-in-trough": SimpleNamespace(
        METRICS=TROUGH_METRICS, CAPTIONS=TROUGH_CAPTIONS, metrics=trough_metrics, figures=trough_figures
    ),
    "gliding-discs": SimpleNamespace(
        METRICS=GLIDING_METRICS, CAPTIONS=GLIDING_CAPTIONS, metrics=gliding_metrics, figures=gliding_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
