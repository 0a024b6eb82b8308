"""The clamped cube on meshes that take long: critical step, and seconds a step over the first steps of the extension.

    python finest.py CELLS STEPS

CELLS: cubes along an edge. Adds a row to finest.csv beside this file: steps in which the loads grow, in one load step, and
the median of the seconds of STEPS steps, in wall time and in time of the cores.
"""

import csv
import statistics
import sys
import time
from pathlib import Path

from pellucid.case import load
from pellucid.simulation.simulation import Simulation

TABLE = Path(__file__).with_name("finest.csv")
COLUMNS = ("nodes", "points", "critical_step", "build_seconds", "build_cpu", "loading", "seconds_a_step", "cpu_a_step")

if __name__ == "__main__":
    cells, steps = int(sys.argv[1]), int(sys.argv[2])
    case = load("mountris2019/cube-extension").with_settings({"body.cube.mesh.box.cells": [cells] * 3, "steady.load_steps": 1})
    begun, used = time.perf_counter(), time.process_time()
    simulation = Simulation(case)
    body = simulation.bodies[0]
    row = {
        "nodes": body.n_points,
        "points": len(body.mesh.cells) * case.body[0].points_per_cell,
        "critical_step": 1.0 / body.totals.rate,
        "build_seconds": time.perf_counter() - begun,
        "build_cpu": time.process_time() - used,
    }
    walls, cores = [], []
    for _ in range(steps):
        wall, core = time.perf_counter(), time.process_time()
        simulation.step()
        walls.append(time.perf_counter() - wall)
        cores.append(time.process_time() - core)
    row["loading"] = simulation.clock.loading
    row |= {"seconds_a_step": statistics.median(walls), "cpu_a_step": statistics.median(cores)}
    new = not TABLE.exists()
    with TABLE.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in row.items()})
    print(row)
