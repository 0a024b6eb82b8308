"""Errors of contact with exact answers, by all functions, two cells and two transfers, and what the functions cost.

    python table.py            writes table.csv beside this file (half an hour)
    python table.py report     prints the tables of README.md from it

Each case runs as its quick variant, on its cells, with what `CASES` sets. Wall times are those of the steps, over that of
trilinear functions with FLIP on the same cells.
"""

import csv
import sys
from pathlib import Path

import numpy as np

import pellucid
from pellucid.case import load
from pellucid.errors import RunStopped

FILE = Path(__file__).parent / "table.csv"
FUNCTIONS = ("trilinear", "gimp", "quadratic-bspline", "cubic-bspline")
TRANSFERS = ("flip", "apic")
BOTH = (0.05, 0.025)
AT_ONCE = {"load.1.amplitude.shares": [1.0, 1.0]}  # the weight of the block that sticks
CASES = {
    "gliding-discs": ((0.05,), {"time.end": 0.7}, ("energy_flat", "energy_round")),
    "rolling-ball": ((0.05,), {"time.end": 0.3}, ("way",)),
    "colliding-bars": ((0.025, 0.0125), {}, ("struck",)),
    "blocks-on-slope": (BOTH, {"time.end": 0.8}, ("slides", "wall_slides", "sticks", "wall_sticks")),
    "turned-blocks": (BOTH, {}, ("east", "west", "east_sticks", "west_sticks")),
    "rolling-discs": (BOTH, {"time.end": 0.4}, ("rigid", "elastic", "gliding")),
    "blocks-on-oblique-planes": ((0.05,), {}, ("on_plate", "on_wall")),
    "cylinders-in-trough": ((0.05,), {}, ("glides", "rolls")),
}
"""Cells [m], what differs from the quick variants, and the errors that stand in the table."""
FIELDS = ("case", "cell", "functions", "transfer", "metric", "error", "cost")


def measure(name, cell, functions, transfer, reference):
    """Rows of one run, and its wall time [s]; of one that stopped itself no numbers. reference: wall time that costs one."""
    _, settings, metrics = CASES[name]
    choice = {"grid.cell": cell, "grid.functions": functions, "time.transfer": transfer}
    key = {"case": name, "cell": cell, "functions": functions, "transfer": transfer}
    case = load(f"basics/{name}").quick_variant().with_settings(settings | choice)
    try:
        run = pellucid.run(case, report=False, threads=1)
    except RunStopped:
        return [key | {"metric": metric, "error": "stopped", "cost": ""} for metric in metrics], None
    seconds = run.summary["wall_seconds"]
    cost = f"{seconds / (reference or seconds):.2f}"
    errors = run.metrics
    return [key | {"metric": metric, "error": f"{errors[metric].error:.2e}", "cost": cost} for metric in metrics], seconds


def slip(cell, functions, transfer):
    """Row of the block of the case as it stands whose weight is switched on at once: its slip after 0.8 s over the column's."""
    choice = {"grid.cell": cell, "grid.functions": functions, "time.transfer": transfer}
    key = {"case": "blocks-on-slope", "cell": cell, "functions": functions, "transfer": transfer, "metric": "slip", "cost": ""}
    column = np.genfromtxt(FILE.parent / "column.csv", delimiter=",", skip_header=2)[-1, -1]
    try:
        run = pellucid.run(load("basics/blocks-on-slope").with_settings(AT_ONCE | choice), report=False, threads=1)
    except RunStopped:
        return key | {"error": "stopped"}
    return key | {"error": f"{float(run.history['sticks_x'][-1]) / column:.2f}"}


def write():
    """All runs."""
    with FILE.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        for name, (cells, *_) in CASES.items():
            for cell in cells:
                reference = None
                for transfer in TRANSFERS:
                    for functions in FUNCTIONS:
                        rows, seconds = measure(name, cell, functions, transfer, reference)
                        reference = reference or seconds
                        writer.writerows(rows)
                        file.flush()
        for transfer in TRANSFERS:
            for functions in FUNCTIONS:
                writer.writerow(slip(0.05, functions, transfer))
                file.flush()


def report():
    """Print a table for each transfer: a row for each error and cell with the functions beside each other; then the costs."""
    with FILE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    for transfer in TRANSFERS:
        found = {(r["case"], r["cell"], r["metric"], r["functions"]): r for r in rows if r["transfer"] == transfer}
        print(f"\n| {transfer} | cell [m] | " + " | ".join(FUNCTIONS) + " |\n" + "|---" * (2 + len(FUNCTIONS)) + "|")
        lines = list(dict.fromkeys(key[:3] for key in found))
        for case, cell, metric in lines:
            errors = [_shown(metric, found[case, cell, metric, functions]["error"]) for functions in FUNCTIONS]
            print(f"| {case}: {metric} | {cell} | " + " | ".join(errors) + " |")
        for case, cell, metric in lines:
            costs = [found[case, cell, metric, functions]["cost"] for functions in FUNCTIONS]
            if metric == CASES[case][2][0]:
                print(f"| {case}: time | {cell} | " + " | ".join(costs) + " |")


def _shown(metric, error):
    """As it stands in a table: relative errors in percent, ways of what sticks in mm, slips over that of the column."""
    if error in ("", "stopped") or metric == "slip":
        return error
    return f"{1e3 * float(error):.3f} mm" if metric.endswith("sticks") else f"{1e2 * float(error):.2f}"


if __name__ == "__main__":
    report() if sys.argv[1:] == ["report"] else write()
