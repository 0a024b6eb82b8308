"""The clamped cube with each approximant on denser and denser meshes: critical step, steps, seconds, energy, reaction.

    python steps.py WAY CELLS APPROXIMANT...

WAY: extension or compression; CELLS: cubes along an edge; APPROXIMANT: cme-S-ALPHA, mmls, tetrahedra, averaged. Adds rows to
steps.csv beside this file.
"""

import csv
import sys
import time
from pathlib import Path

from pellucid.case import load
from pellucid.simulation.simulation import Simulation

TABLE = Path(__file__).with_name("steps.csv")
COLUMNS = ("way", "approximant", "nodes", "points", "critical_step", "steps", "build_seconds", "seconds", "threads")
RESULTS = ("strain_energy", "reaction", "ebc_residual_nodes", "ebc_residual_between")


def settings(approximant: str) -> dict[str, object]:
    """What a name of an approximant stands for."""
    if approximant == "tetrahedra":
        return {"body.cube.approximant": {"kind": "linear-simplex"}, "body.cube.volume_averaging": False, **ONE_POINT}
    if approximant == "averaged":
        return {"body.cube.approximant": {"kind": "linear-simplex"}, **ONE_POINT}
    if approximant == "mmls":
        return {"body.cube.approximant": {"kind": "modified-moving-least-squares", "dilatation": 1.6}}
    _, smoothness, shape = approximant.split("-")
    return {"body.cube.approximant.smoothness": float(smoothness), "body.cube.approximant.shape": float(shape)}


ONE_POINT = {"body.cube.points_per_cell": 1}


def run(way: str, cells: int, approximant: str) -> dict[str, object]:
    """One row of the table; a run that stops itself has no results."""
    case = load(f"mountris2019/cube-{way}").with_settings(
        {"body.cube.mesh.box.cells": [cells] * 3, "steady.load_steps": 1, **settings(approximant)}
    )
    begun = time.perf_counter()
    simulation = Simulation(case)
    body = simulation.bodies[0]
    built = time.perf_counter()
    row: dict[str, object] = {
        "way": way,
        "approximant": approximant,
        "nodes": body.n_points,
        "points": len(case.body[0].mesh.mesh().cells) * case.body[0].points_per_cell,
        "critical_step": 1.0 / body.totals.rate,
        "threads": simulation.threads,
    }
    try:
        while not simulation.clock.finished(None):
            simulation.step()
    except Exception as error:
        print(error)
        return row | {"steps": simulation.n_steps, "build_seconds": built - begun}
    done = time.perf_counter()
    return (
        row
        | {"steps": simulation.n_steps, "build_seconds": built - begun, "seconds": done - built}
        | {
            "strain_energy": simulation.budget.energies()["strain"],
            "reaction": simulation.budget.reactions()["top"][2],
            **body.facts(),
        }
    )


if __name__ == "__main__":
    way, cells = sys.argv[1], int(sys.argv[2])
    new = not TABLE.exists()
    for approximant in sys.argv[3:]:
        row = run(way, cells, approximant)
        with TABLE.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, (*COLUMNS, *RESULTS), lineterminator="\n")
            if new:
                writer.writeheader()
            writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in row.items()})
        new = False
        print(row)
