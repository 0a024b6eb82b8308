"""Steps and times that are foretold of gallery cases against those of their runs: python compare.py [CASE...]."""

import sys
import tempfile
import warnings
from pathlib import Path

import pellucid
from pellucid.running.forecast import Paces, of_simulation

CASES = [
    "basics/elastic-wave",
    "basics/sod",
    "basics/colliding-bars",
    "basics/colliding-discs",
    "basics/dam-break",
    "basics/hydrostatic-column",
    "basics/spinning-disc",
    "basics/tank-at-rest",
    "basics/elastic-block-drop",
    "basics/blast",
    "basics/rolling-ball",
    "gan2011/shock-tube",
    "gan2011/membrane-expansion",
    "gan2011/net-impact",
    "lian2014/airbag",
    "lian2014/sphere-on-membrane",
    "benet2015/ring",
]


def run(case):
    """Steps of a run, those of the settling included and not, and how long they took [s]."""
    summary = pellucid.run(case, report=False).summary
    return summary["steps"] + summary.get("settled", {}).get("steps", 0), summary["steps"], summary["wall_seconds"]


def main(names):
    warnings.simplefilter("ignore")
    print("| case | steps foretold | taken | ratio | time foretold | taken | ratio |")
    print("|---|---|---|---|---|---|---|")
    for name in names:
        case = pellucid.load(name).quick_variant()
        run(case)  # its kernels are compiled
        with tempfile.TemporaryDirectory() as folder:
            paces = Paces(Path(folder))
            in_all, _, seconds = run(case)
            paces.learn(case, in_all, seconds)
            each, number = paces.seconds_of_a_step(case), of_simulation(pellucid.Simulation(case)).number
        in_all, steps, seconds = run(case)
        known = each.most * number * in_all / steps  # steps to settle are not foretold, but take time
        print(f"| `{name}` | {number:.0f} | {steps} | {number / steps:.2f}", end=" ")
        print(f"| {known:.2f} s | {seconds:.2f} s | {known / seconds:.2f} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or CASES)
