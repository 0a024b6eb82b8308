"""Gas in a closed plane box, at rest and stirred, with the pressure summed over points and integrated over cells.

python gas.py        writes gas.csv beside this file (two minutes)

Nothing of it has a scale but the speed of sound: rest is exact, and a vortex without viscosity can only lose motion to heat.
"""

import csv
from pathlib import Path

import numpy as np

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

AT_REST, DEEP, STIRRED = "at rest", "at rest under gravity", "vortex of 20 m/s"
RUNS = [
    (AT_REST, False, 0.1),
    (AT_REST, False, 0.2),
    (AT_REST, True, 2.0),
    (DEEP, True, 2.0),
    (STIRRED, False, 0.1),
    (STIRRED, True, 0.4),
]


def box(kind: str, cell_pressure: bool, end: float) -> Case:
    """The case; its energy may go where it will."""
    width, height = (0.4, 0.4) if kind == STIRRED else (0.2, 0.6)
    gas = {"kind": "fluid", "density": 1.2, "pressure": 1e5, "eos": {"kind": "ideal-gas", "gamma": 1.4}}
    body = {"name": "gas", "shape": {"box": {"lower": [0, 0, 0], "upper": [width, height, 0]}}, "points_per_cell": [3, 3, 1]}
    body |= {"material": gas, "cell_pressure": cell_pressure} | ({"hydrostatic": {"level": 0.3}} if kind == DEEP else {})
    return Case.model_validate(
        {
            "schema": 1,
            "title": kind,
            "gravity": [0, -9.81 if kind == DEEP else 0, 0],
            "grid": {"lower": [0, 0, 0], "upper": [width, height, 0], "cell": 0.05, "functions": "quadratic-bspline"},
            "time": {"end": end},
            "energy": {"warn": 0.5, "stop": 0.9},
            "body": [body],
            "support": [{"where": f"{axis}-{side}", "fix": "normal"} for axis in "xy" for side in ("lower", "upper")],
        }
    )


if __name__ == "__main__":
    rows = []
    for kind, cell_pressure, end in RUNS:
        simulation = Simulation(box(kind, cell_pressure, end))
        body = simulation.bodies[0]
        if kind == STIRRED:
            x, y = np.pi / 0.4 * body.arrays["position"][:, :2].T
            body.arrays["velocity"][:, :2] = 20.0 * np.stack((np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)), axis=1)
            body.renew_totals()
            simulation.begin_balance()
        begun, volume = simulation.kinetic_energy(), body.arrays["volume"].sum()
        while not simulation.clock.finished(None):
            simulation.step()
        fastest = np.sqrt((body.arrays["velocity"] ** 2).sum(axis=1)).max()
        grown = body.arrays["volume"].sum() / volume - 1.0
        found = begun, simulation.kinetic_energy(), fastest, grown, simulation.budget.energy_error()
        rows.append([kind, cell_pressure, end, simulation.n_steps, *(f"{value:.2e}" for value in found)])
    with (Path(__file__).parent / "gas.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        names = "kinetic energy at first [J]", "at the end [J]", "fastest point [m/s]", "growth of the volume", "energy error"
        writer.writerow(["case", "cell_pressure", "time [s]", "steps", *names])
        writer.writerows(rows)
