"""Memory of the process that sets gallery cases up and takes their first steps, beside the estimate by which one is refused.

    python memory.py quick|full CASE... [KEY=VALUE...]

Without cases all of the gallery. Every case runs in a process of its own, twice, so that kernels are compiled before. Rows go
to memory.csv beside this file.
"""

import csv
import subprocess
import sys
from pathlib import Path

TABLE = Path(__file__).with_name("memory.csv")
PROGRAM = """
import resource, sys, warnings
import pellucid
from pellucid.case import parse_setting
from pellucid.case.memory import memory_estimate
from pellucid.simulation.simulation import Simulation
warnings.simplefilter("ignore")
case = pellucid.load(sys.argv[1])
case = case.quick_variant() if sys.argv[2] == "quick" else case
case = case.with_settings(dict(map(parse_setting, sys.argv[3:])))
simulation = Simulation(case, threads=1)
for _ in range(3):
    simulation.step()
peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(sum(body.n_points for body in simulation.bodies), memory_estimate(case), peak)
"""


def main(variant: str, cases: list[str], settings: list[str]) -> None:
    """Add a row for each case."""
    from pellucid import catalogue

    new = not TABLE.exists()
    for case in cases or catalogue.ids():
        command = [sys.executable, "-c", PROGRAM, case, variant, *settings]
        subprocess.run(command, capture_output=True)
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            print(case, done.stderr.splitlines()[-1])
            continue
        points, estimate, peak = map(float, done.stdout.split())
        with TABLE.open("a", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            if new:
                writer.writerow(("case", "variant", "settings", "points", "estimate_mib", "peak_mib", "ratio"))
            numbers = f"{points:.0f}", f"{estimate / 2**20:.1f}", f"{peak / 2**20:.1f}", f"{peak / estimate:.3g}"
            writer.writerow((case, variant, " ".join(settings), *numbers))
        new = False
        print(case, f"{peak / 2**20:.1f} MiB, {peak / estimate:.2f} of the estimate", flush=True)


if __name__ == "__main__":
    words = sys.argv[2:]
    main(sys.argv[1], [word for word in words if "=" not in word], [word for word in words if "=" in word])
