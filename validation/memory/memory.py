"""Memory that the set-up of gallery cases and their first steps take, beside the estimate by which a case is refused.

    python memory.py [full] [CASE...]

Every case runs in a process of its own: first once untraced, so that modules and kernels are loaded, then again under
tracemalloc, which sees the arrays of numpy. Rows go to memory.csv beside this file.
"""

import csv
import subprocess
import sys
from pathlib import Path

TABLE = Path(__file__).with_name("memory.csv")
STEPS = 3
PROGRAM = """
import sys, tracemalloc, warnings
import pellucid
from pellucid.case.memory import memory_estimate
from pellucid.simulation.simulation import Simulation
warnings.simplefilter("ignore")
quick = pellucid.load(sys.argv[1]).quick_variant()
case = quick if sys.argv[2] == "quick" else pellucid.load(sys.argv[1])
def begin(case):
    simulation = Simulation(case, threads=1)
    for _ in range(int(sys.argv[3])):
        simulation.step()
    return simulation
begin(quick)
tracemalloc.start()
simulation = begin(case)
print(sum(body.n_points for body in simulation.bodies), memory_estimate(case), tracemalloc.get_traced_memory()[1])
"""


def main(variant: str, cases: list[str]) -> None:
    from pellucid import catalogue

    new = not TABLE.exists()
    for case in cases or catalogue.ids():
        done = subprocess.run([sys.executable, "-c", PROGRAM, case, variant, str(STEPS)], capture_output=True, text=True)
        if done.returncode:
            print(case, done.stderr.splitlines()[-1])
            continue
        points, estimate, peak = map(float, done.stdout.split())
        with TABLE.open("a", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            if new:
                writer.writerow(("case", "variant", "points", "estimate_bytes", "peak_bytes", "ratio"))
            writer.writerow((case, variant, f"{points:.0f}", f"{estimate:.0f}", f"{peak:.0f}", f"{peak / estimate:.3g}"))
        new = False
        print(case, f"{peak / 2**20:.1f} MiB, {peak / estimate:.2f} of the estimate", flush=True)


if __name__ == "__main__":
    words = sys.argv[1:]
    full = words[:1] == ["full"]
    main("full" if full else "quick", words[full:])
