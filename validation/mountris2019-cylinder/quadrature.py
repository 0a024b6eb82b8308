"""The indented cylinder with 1 to 32 points a cell, and as linear tetrahedra: strain energies and forces at the end.

    python quadrature.py ACROSS ALONG [KIND...]

Adds rows to quadrature.csv beside this file, of all kinds or those named.
"""

import csv
import sys
from pathlib import Path

from pellucid.case import load
from pellucid.errors import RunStopped
from pellucid.simulation.simulation import Simulation

TABLE = Path(__file__).with_name("quadrature.csv")
POINTS = (1, 4, 8, 16, 32)
KINDS = {
    "meshless": {},
    "meshless, plain": {"body.cylinder.volume_averaging": False},
    "meshless, uncorrected": {"body.cylinder.volume_averaging": False, "body.cylinder.consistent": False},
    "tetrahedra": {"body.cylinder.approximant": {"kind": "linear-simplex"}, "body.cylinder.volume_averaging": False},
    "tetrahedra, averaged": {"body.cylinder.approximant": {"kind": "linear-simplex"}},
}


def run(settings: dict[str, object]) -> dict[str, object]:
    """Energy, force and steps, or where the run stopped itself."""
    case = load("mountris2019/cylinder-indentation").with_settings(settings)
    simulation = Simulation(case)
    try:
        while not simulation.clock.finished(None):
            simulation.step()
    except RunStopped as error:
        return {"nodes": simulation.bodies[0].n_points, "steps": simulation.n_steps, "stopped": str(error)[:80]}
    done = {"nodes": simulation.bodies[0].n_points, "steps": simulation.n_steps}
    energy, force = simulation.budget.energies()["strain"], simulation.budget.reactions()["indenter"][2]
    return done | {"strain_energy": f"{energy:.6g}", "force": f"{force:.5g}"}


if __name__ == "__main__":
    across, along = int(sys.argv[1]), int(sys.argv[2])
    mesh = {"body.cylinder.mesh.cylinder.across": across, "body.cylinder.mesh.cylinder.along": along}
    columns = ("kind", "points", "nodes", "steps", "strain_energy", "force", "stopped")
    new = not TABLE.exists()
    with TABLE.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        if new:
            writer.writeheader()
        for kind in sys.argv[3:] or KINDS:
            changes = KINDS[kind]
            for points in POINTS if kind.startswith("meshless") else POINTS[:1]:
                steady = {"steady.load_steps": 1, "steady.tolerance": 1e-4, "body.cylinder.points_per_cell": points}
                row = run(mesh | steady | changes)
                writer.writerow({"kind": kind, "points": points, **row})
                file.flush()
                print(kind, points, row)
