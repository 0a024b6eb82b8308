"""Gallery cases, settings and the files of cases, damaged at random and validated in a process that is watched.

python watched.py 10000        writes mutated_inputs.csv beside this file

Trial k is made from the number k alone: `python watched.py --worker 17 18` repeats trial 17.
"""

import csv
import json
import select
import subprocess
import sys
import tempfile
import warnings
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

LATEST = 60.0  # s of wall time after which a trial is taken to hang, whatever else the machine does
SHARE = 5000
"""Trials of one process."""
MOST_MEMORY = 1024.0  # MB above that of the process before: what the largest mesh that is made may need
COLUMNS = ("kind", "inputs", "accepted", "refused", "slowest [s]", "most memory [MB]", "tracebacks", "hangs", "other")


def work(first: int, end: int) -> None:
    """Make trials, and print each outcome as a line of JSON."""
    from mutated_inputs import trial

    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, end):
            Path("/proc/self/clear_refs").write_text("5")  # the highest memory counts from here on
            before = memory("VmHWM")
            outcome = trial(number, Path(folder))
            found = outcome._asdict() | {"number": number, "memory": memory("VmHWM") - before}
            print(json.dumps(found), flush=True)


def memory(name: str) -> float:
    """Memory of this process [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024.0


def outcomes(first: int, end: int) -> list[dict]:
    """Outcomes of trials; where a process hangs or dies, the trial counts as such and the next one begins anew."""
    found: list[dict] = []
    while first + len(found) < end:
        number = first + len(found)
        command = [sys.executable, __file__, "--worker", str(number), str(end)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        while first + len(found) < end:
            ready, _, _ = select.select([process.stdout], [], [], LATEST)
            line = process.stdout.readline() if ready else ""
            if not line:
                process.kill()
                wrong = f"ended with status {process.wait()}" if ready else "hang"
                died = {"kind": "?", "accepted": False, "seconds": 0.0, "memory": 0.0, "wrong": wrong, "message": ""}
                found.append(judged(died | {"number": first + len(found)}))
                break
            found.append(judged(json.loads(line)))
    return found


def judged(found: dict) -> dict:
    """An outcome; too much memory is wrong too."""
    if not found["wrong"] and found["memory"] > MOST_MEMORY:
        found["wrong"] = f"{found['memory']:.0f} MB"
    if found["wrong"]:
        print(found["number"], found["kind"], found["wrong"], found["message"][-600:], flush=True)
    return found


def main(n: int) -> None:
    """All trials, and a table of what became of them."""
    kinds = defaultdict(list)
    starts = range(0, n, SHARE)
    with ThreadPoolExecutor() as pool:
        parts = list(pool.map(outcomes, starts, [min(first + SHARE, n) for first in starts]))
    for found in (one for part in parts for one in part):
        kinds[found["kind"]].append(found)
    with (Path(__file__).parent / "mutated_inputs.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for kind, several in sorted(kinds.items()):
            accepted = sum(one["accepted"] for one in several)
            slowest, most = (max(one[key] for one in several) for key in ("seconds", "memory"))
            wrongs = [one["wrong"] for one in several if one["wrong"]]
            counts = [wrongs.count("traceback"), sum("hang" in one or one.endswith(" s") for one in wrongs)]
            row = [kind, len(several), accepted, len(several) - accepted, f"{slowest:.2f}", f"{most:.0f}", *counts]
            writer.writerow([*row, len(wrongs) - sum(counts)])


if __name__ == "__main__":
    if sys.argv[1] == "--worker":
        work(int(sys.argv[2]), int(sys.argv[3]))
    else:
        main(int(sys.argv[1]))
