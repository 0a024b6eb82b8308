"""How well water stays at rest over ten seconds, by FLIP and APIC, on three grids.

python rest.py        writes rest.csv beside this file (a quarter of an hour)
"""

import csv
from pathlib import Path

import pellucid
from pellucid.case import load

NAMES = {"fastest": "fastest point [m/s]", "pressure": "error of the pressure", "column": "beside a compressible column"}

if __name__ == "__main__":
    rows = []
    for transfer in ("flip", "apic"):
        for cell in (0.05, 0.025, 0.0125):
            case = load("basics/tank-at-rest").with_settings({"grid.cell": cell, "time.transfer": transfer})
            run = pellucid.run(case, report=False)
            errors = [f"{run.metrics[name].error:.2e}" for name in (*NAMES, "energy")]
            rows.append([transfer, cell, run.summary["steps"], *errors])
    with (Path(__file__).parent / "rest.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["transfer", "cell [m]", "steps", *NAMES.values(), "energy error"])
        writer.writerows(rows)
