"""Steps and times that are foretold of gallery cases against those of their runs: python compare.py [CASE...]."""

import sys
import tempfile
import warnings
from pathlib import Path

import pellucid
from pellucid.results.forecast.pace import Paces
from pellucid.results.forecast.steps import of_case

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


def foretold(runs, cases, name):
    """The time of the steps of a case [s], by what some runs taught; not a number where that is nothing."""
    with tempfile.TemporaryDirectory() as folder:
        paces = Paces(Path(folder))
        for known, (in_all, _, seconds) in runs.items():
            paces.learn(cases[known], in_all, seconds)
        each = paces.seconds_of_a_step(cases[name])
    return float("nan") if each is None else each * of_case(cases[name]).number


def main(names):
    warnings.simplefilter("ignore")
    cases = {name: pellucid.load(name).quick_variant() for name in names}
    earlier, later = {}, {}
    for name, case in cases.items():
        run(case)  # its kernels are compiled
        earlier[name], later[name] = run(case), run(case)
    print(
        "| case | steps foretold | taken | ratio | time taken | foretold by an earlier run | ratio | by other cases | ratio |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, case in cases.items():
        number, (in_all, steps, seconds) = of_case(case).number, later[name]
        settling = in_all / steps  # these steps are not foretold, but take time
        known = foretold(earlier, cases, name) * settling
        others = foretold({other: it for other, it in earlier.items() if other != name}, cases, name) * settling
        print(
            f"| `{name}` | {number:.0f} | {steps} | {number / steps:.2f} | {seconds:.2f} s "
            f"| {known:.2f} s | {known / seconds:.2f} | {others:.2f} s | {others / seconds:.2f} |"
        )


if __name__ == "__main__":
    main(sys.argv[1:] or CASES)
