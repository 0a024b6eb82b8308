"""Speed of whole steps and of loops over points (passes) of this working tree relative to another one. The trees are
measured in turns, so that the load of the machine affects both.

    git worktree add /tmp/before COMMIT
    python benchmarks/pairs.py /tmp/before [--points 1e6] [--threads 1] [--pairs 5] [--only ideal-gas]

A ratio above one means that this tree is faster. If the ratio of a pass is below 0.9, its code probably breaks one of the
rules for fast loops in `pellucid.grid.passes.each_point`.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]
WHAT = [
    {"body": body, "functions": functions, "transfer": transfer}
    for body in ("ideal-gas", "hypoelastic", "neo-hookean")
    for functions in ("trilinear", "quadratic-bspline")
    for transfer in ("flip", "apic")
] + [{"body": "membrane-points"}]


def main() -> None:
    """Print for each problem the median and range of the ratios of whole steps, and of each pass if both trees measure
    passes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("--points", type=float, default=1e6)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    for what in WHAT:
        if given.only in what["body"]:
            request = {**what, "points": int(given.points), "threads": given.threads}
            print(" ".join(what.values()), flush=True)
            for name, ratios in _ratios(given.before, request, given.steps, given.pairs).items():
                print(f"    {name:24} {statistics.median(ratios):.3f}  ({min(ratios):.3f} to {max(ratios):.3f})", flush=True)


def _ratios(before: Path, request: dict[str, Any], steps: int, pairs: int) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for _ in range(pairs):
        old, new = (_times(tree, request, steps) for tree in (before, HERE))
        for name in old.keys() & new.keys():
            found.setdefault(name, []).append(old[name] / new[name])
    return dict(sorted(found.items()))


def _times(tree: Path, request: dict[str, Any], steps: int) -> dict[str, float]:
    times = {"whole step": _run(tree, "measure", {**request, "steps": steps})["seconds_per_step"]}
    if (tree / "src/pellucid/bench/passes.py").exists():
        times |= {name: one["seconds_per_point"] for name, one in _run(tree, "passes", request)["passes"].items()}
    return times


def _run(tree: Path, module: str, request: dict[str, Any]) -> dict[str, Any]:
    alone = (tree / "src/pellucid/bench/alone.py").exists()  # in older trees each module ran by itself
    what = ["pellucid.bench.alone", module] if alone else [f"pellucid.bench.{module}"]
    command = [sys.executable, "-m", *what, json.dumps(request)]
    environment = {**os.environ, "PYTHONPATH": str(tree / "src")}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    answer: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return answer


if __name__ == "__main__":
    main()
