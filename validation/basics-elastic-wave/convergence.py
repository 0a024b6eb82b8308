"""Errors of the standing wave over the cell.

python convergence.py        writes convergence.csv beside this file
"""

import csv
from math import log2
from pathlib import Path

import pellucid
from pellucid.case import load

NAMES = ("displacement_l2", "velocity_l2", "period")

if __name__ == "__main__":
    rows, before = [], None
    for cell in (0.05, 0.025, 0.0125, 0.00625):
        run = pellucid.run(load("basics/elastic-wave").with_settings({"grid.cell": cell}), report=False)
        errors = [run.metrics[name].error for name in NAMES]
        orders = [f"{log2(b / e):.2f}" for b, e in zip(before, errors, strict=True)] if before else [""] * len(NAMES)
        rows.append([cell, *(f"{e:.3e}" for e in errors), *orders])
        before = errors
    with (Path(__file__).parent / "convergence.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["cell [m]", *NAMES, *(f"order of {name}" for name in NAMES)])
        writer.writerows(rows)
