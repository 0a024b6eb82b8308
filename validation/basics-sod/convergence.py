"""Errors of Sod's tube over the cell, with B-splines and with linear functions at three Courant numbers.

python convergence.py        writes convergence.csv beside this file
"""

import csv
from pathlib import Path

import pellucid
from pellucid.case import load

NAMES = ("density_l1", "pressure_l1", "velocity_l1", "internal_energy_l1")
VARIANTS = (("quadratic-bspline", 0.4), ("trilinear", 0.4), ("trilinear", 0.1), ("trilinear", 0.05))

if __name__ == "__main__":
    with (Path(__file__).parent / "convergence.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["functions", "courant", "cell [m]", *NAMES, "energy error"])
        for functions, courant in VARIANTS:
            for cell in (0.01, 0.005, 0.0025, 0.00125):
                settings = {"grid.functions": functions, "time.courant": courant, "grid.cell": cell}
                run = pellucid.run(load("basics/sod").with_settings(settings), report=False)
                errors = [f"{run.metrics[name].error:.3e}" for name in NAMES]
                writer.writerow([functions, courant, cell, *errors, f"{run.summary['conservation']['energy']:.1e}"])
