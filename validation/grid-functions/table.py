"""The cases of the gallery with each of the shape functions of the grid: their errors and what they cost.

    python table.py [SECONDS]   writes table.csv beside this file, of the cases that take no longer than that as they stand
    python table.py report      prints the tables of README.md from it

Each case with a grid runs as its quick variant on one thread, first with trilinear functions. Errors are those of the metrics,
over the tolerances that the cases have; the wall time is that of the steps.
"""

import csv
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

import pellucid
from pellucid import catalogue
from pellucid.case import load
from pellucid.errors import PellucidError

FILE = Path(__file__).parent / "table.csv"
FUNCTIONS = ("trilinear", "gimp", "quadratic-bspline")
FIELDS = ("case", "functions", "metric", "error", "seconds")
LEAST = 0.01  # of a tolerance: errors below count as this much


def rows_of(name, functions):
    """One run, a row for each metric; of one that stopped a single row."""
    case = load(name).quick_variant().with_settings({"grid.functions": functions})
    key = {"case": name, "functions": functions}
    try:
        run = pellucid.run(case, report=False, threads=1)
    except PellucidError as error:
        return [key | {"metric": "", "error": "stopped", "seconds": str(error).splitlines()[0][:60]}]
    seconds = f"{run.summary['wall_seconds']:.2f}"
    found = run.metrics
    return [key | {"metric": m, "error": f"{found[m].error / found[m].tolerance:.3e}", "seconds": seconds} for m in found]


def write(most):
    """All runs."""
    with FILE.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        for name in catalogue.ids():
            case = load(name)
            if case.grid_or_none is None or case.times.quick > most:
                continue
            for functions in FUNCTIONS:
                writer.writerows(rows_of(name, functions))
                file.flush()


def report():
    """A row for each case: mean errors and times over those of trilinear functions, and both at equal cost."""
    with FILE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    errors, seconds = defaultdict(dict), {}
    for row in rows:
        key = row["case"], row["functions"]
        if row["error"] == "stopped":
            seconds[key] = None
        else:
            errors[key][row["metric"]] = max(float(row["error"]), LEAST)
            seconds[key] = float(row["seconds"])
    print("| case | " + " | ".join(f"{f}: error | time | at equal cost" for f in FUNCTIONS[1:]) + " |")
    print("|---|" + "---|" * 3 * (len(FUNCTIONS) - 1))
    whole = defaultdict(list)
    for name in dict.fromkeys(case for case, _ in seconds):
        base, taken = errors[name, "trilinear"], seconds[name, "trilinear"]
        cells = []
        for functions in FUNCTIONS[1:]:
            its = seconds[name, functions]
            if its is None or taken is None:
                cells += ["stopped" if its is None else "alone runs", "", ""]
                continue
            ratio = float(np.exp(np.mean([np.log(errors[name, functions][m] / base[m]) for m in base])))
            time = its / taken
            # errors of first order, and three axes of which the third is time: the same cost buys cells larger by the root
            equal = ratio * time ** (1.0 / 3.0)
            whole[functions].append((ratio, time, equal))
            cells += [f"{ratio:.2f}", f"{time:.2f}", f"{equal:.2f}"]
        print(f"| {name} | " + " | ".join(cells) + " |")
    means = [np.exp(np.mean(np.log(whole[f]), axis=0)) for f in FUNCTIONS[1:]]
    print("| geometric mean | " + " | ".join(f"{value:.2f}" for mean in means for value in mean) + " |")


if __name__ == "__main__":
    if sys.argv[1:] == ["report"]:
        report()
    else:
        write(float(sys.argv[1]) if sys.argv[1:] else 1e9)
