"""Metrics and figures of discs that slide without friction on a plate and over a disc: speed and energy are conserved; the
second disc moves like a bead on a circle."""

import numpy as np
from scipy.integrate import solve_ivp

from pellucid.gallery.exact_curves import beside, column, compared
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"energy": "Energy of both discs; grey: exact."}

METRICS = ("speed", "contact_work", "energy_flat", "energy_round", "way")

HILL = np.array([3.6, 0.6])
CENTRES, GRAVITY = 0.8, 9.81  # distance of the centres [m], [m/s²]


def metrics(run: Run) -> dict[str, Metric]:
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
    return np.asarray(0.5 * squared + GRAVITY * (column(run, f"{name}_y") - level))


def bead(run: Run, time: Array) -> Array:
    """Return the exact positions of the centre of the disc that slides over the hill [m], shape (n, 2), at times [s]: on a
    circle until it loses contact, then in free flight."""
    first = np.array([column(run, "round_x")[0], column(run, "round_y")[0]]) - HILL
    speed = float(np.hypot(column(run, "round_vx")[0], column(run, "round_vy")[0]))
    start = [np.arctan2(first[0], first[1]), speed / CENTRES]

    def leaves(_: float, state: Array) -> float:
        return float(GRAVITY * np.cos(state[0]) - CENTRES * state[1] ** 2)

    leaves.terminal = True  # type: ignore[attr-defined]
    end = float(time[-1]) + 1e-9
    found = solve_ivp(
        lambda _, s: [s[1], GRAVITY / CENTRES * np.sin(s[0])], (0, end), start, events=leaves, rtol=1e-9, dense_output=True
    )
    off = float(found.t[-1])
    if found.sol is None:
        raise ValueError("no dense output")
    angle, rate = found.sol(np.minimum(time, off))
    flown = np.maximum(time - off, 0.0)
    outward, along = np.stack([np.sin(angle), np.cos(angle)]), np.stack([np.cos(angle), -np.sin(angle)])
    way = HILL[:, None] + CENTRES * outward + CENTRES * rate * flown * along
    way[1] -= 0.5 * GRAVITY * flown**2
    return np.asarray(way.T)


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the relative changes of kinetic plus potential energy of both discs against time."""
    time = column(run, "time")
    figure, axes = new_panels(height=3.0)
    for name, level, what, colour in (("flat", 0.6, "on the plate", 0), ("round", HILL[1], "over the hill", 1)):
        share = energy_of(run, name, level)
        beside(axes, time, 100.0 * (share / share[0] - 1.0), np.zeros(len(time)), what, COLOURS[colour])
    axes.set_ylim(-1.0, 1.0)
    label(axes, "time", "change of energy", "s", "%", legend=True)
    return {"energy": figure}
