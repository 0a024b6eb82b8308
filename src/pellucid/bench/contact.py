"""Cost of contact: a block of points pressed on a sheet of membrane elements, compared with each of the two alone."""

import time
from typing import Any

import numpy as np

from pellucid.bench.problem import CELL, POINTS_PER_CELL, SOLID, grid, problem, sheet
from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

DEEP = 5  # cells of the block above the sheet
CLEAR = 10  # cells below the sheet, and above the block
WARM_UP_STEPS = 3
QUARTER = 25.0  # percentile of the steps: other work on the machine slows some of them
WHICH = {"sheet": ("sheet",), "block": ("block",), "together": ("sheet", "block")}


def contact_case(points: int, which: tuple[str, ...]) -> Case:
    """Build a benchmark case of a sheet with elements half a cell long and a block of about `points` material points that
    covers it. which: names of the bodies to include, "sheet" and "block"."""
    cells = max(2, round((points / (POINTS_PER_CELL * DEEP)) ** 0.5))
    edge, low = cells * CELL, 0.5 * CELL
    along = 2 * cells + 1
    bodies: dict[str, dict[str, Any]] = {
        "sheet": sheet("membrane-elements", [low, low, 0.0], edge, along),
        "block": {
            "kind": "material-points",
            "name": "block",
            "shape": {"box": {"lower": [low, low, 0.0], "upper": [low + edge, low + edge, DEEP * CELL]}},
            "points_per_cell": POINTS_PER_CELL,
            "material": {"kind": "neo-hookean", **SOLID},
            "velocity": [0.0, 0.0, -0.1],
        },
    }
    wall = edge + CELL
    room = grid([0.0, 0.0, -CLEAR * CELL], [wall, wall, (DEEP + CLEAR) * CELL])
    return problem("contact", [{"field": name, **bodies[name]} for name in which], grid=room)


def measure(points: int, steps: int, threads: int | None) -> dict[str, Any]:
    """Measure the wall-clock time of steps of the block alone, of the sheet alone, and of both in contact, in alternation.

    points: approximate number of points of the block. steps: number of measured steps of each simulation. Returns numbers
    of elements and points, the lower quartiles of the times (`seconds_per_step` [s]), and `ratio`: the time of both in
    contact divided by the sum of the times of block and sheet alone.
    """
    simulations = {what: Simulation(contact_case(points, which), threads=threads) for what, which in WHICH.items()}
    taken: dict[str, list[float]] = {what: [] for what in WHICH}
    for number in range(WARM_UP_STEPS + steps):
        for what, simulation in simulations.items():
            start = time.perf_counter()
            simulation.step()
            if number >= WARM_UP_STEPS:
                taken[what].append(time.perf_counter() - start)
    seconds = {what: float(np.percentile(steps_taken, QUARTER)) for what, steps_taken in taken.items()}
    elements, block = simulations["together"].bodies
    return {
        "elements": len(elements.cells().quadrilaterals),
        "points": block.n_points,
        "steps": steps,
        "seconds_per_step": seconds,
        "ratio": seconds["together"] / (seconds["sheet"] + seconds["block"]),
    }
