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
    """Steps of a run and how long they took [s], those of the settling included."""
    summary = pellucid.run(case, report=False).summary
    return summary["steps"] + summary.get("settled", {}).get("steps", 0), summary["steps"], summary["wall_seconds"]


def main(names):
    warnings.simplefilter("ignore")
    cases = {name: pellucid.load(name).quick_variant() for name in names}
    for case in cases.values():
        run(case)  # its kernels are compiled
    first = {name: run(case) for name, case in cases.items()}
    print(
        "| case | steps foretold | taken | over | time taken | foretold by an earlier run | over | by the other cases | over |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, case in cases.items():
        with tempfile.TemporaryDirectory() as folder:
            known, others = Paces(Path(folder) / "known"), Paces(Path(folder) / "others")
            for other, (in_all, _, seconds) in first.items():
                known.learn(cases[other], in_all, seconds)
                if other != name:
                    others.learn(cases[other], in_all, seconds)
            ahead = of_case(case)
            each, guess = known.seconds_of_a_step(case), others.seconds_of_a_step(case)
        in_all, steps, seconds = run(case)
        number = ahead.number * in_all / steps  # settling is not foretold, but takes time
        of_known = each * number if each is not None else float("nan")
        of_others = guess * number if guess is not None else float("nan")
        print(
            f"| `{name}` | {ahead.number:.0f} | {steps} | {ahead.number / steps:.2f} | {seconds:.2f} s "
            f"| {of_known:.2f} s | {of_known / seconds:.2f} | {of_others:.2f} s | {of_others / seconds:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:] or CASES)
