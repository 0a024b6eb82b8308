"""A small run killed at random instants and resumed: the results have the bits of a run that nothing disturbed.

python killed_runs.py 100        writes killed_runs.csv beside this file
"""

import csv
import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CASE = Path(__file__).parent / "two-blocks.toml"  # with a checkpoint at every step
BEGIN = "import pellucid, sys; pellucid.run(pellucid.load(sys.argv[1]), sys.argv[2], threads=1, report={})"
GO_ON = "import sys; from pellucid.results import resume_case; resume_case(sys.argv[1], threads=1, report={})"
REPORTS = 4
"""One run in so many draws its figures and its report, which take longer than the steps."""
OF_THE_MACHINE = ("wall_seconds", "point_steps_per_second")
COLUMNS = (
    *("trial", "report", "seconds", "phase", "rows", "frames written", "checkpoints", "draft"),
    *("second kill [s]", "phase then", "same bits", "missing or left"),
)


def begin(out: Path, report: bool) -> list[str | Path]:
    return [sys.executable, "-c", BEGIN.format(report), CASE, out]


def go_on(out: Path, report: bool) -> list[str | Path]:
    return [sys.executable, "-c", GO_ON.format(report), out]


def started(command: list[str | Path]) -> subprocess.Popen:
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def killed_after(command: list[str | Path], seconds: float) -> None:
    """Start a command and kill it, if it has not ended by then."""
    process = started(command)
    try:
        process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def names(out: Path) -> set[str]:
    """The files of a run; those of checkpoints by their ending, as their names have their numbers and digests."""
    found = {path.relative_to(out) for path in out.rglob("*") if path.is_file()}
    return {f"checkpoint/*{name.suffix}" if name.parts[0] == "checkpoint" else str(name) for name in found}


def results(out: Path) -> dict[str, object]:
    """Everything that must not depend on how often a run was broken off."""
    summary = json.loads((out / "summary.json").read_text())
    for name in OF_THE_MACHINE:
        del summary[name]
    files = [out / "case.toml", out / "history.csv", *sorted((out / "fields").glob("*.vtkhdf"))]
    return {"summary": summary} | {path.name: path.read_bytes() for path in files}


def state(out: Path) -> tuple[str, int, bool, int, bool]:
    """How far a run has come: phase, rows of its history, whether frames are there, checkpoints, a draft left behind."""
    history, checkpoints = out / "history.csv", list((out / "checkpoint").glob("*.npz"))
    rows = max(0, history.read_bytes().count(b"\n") - 2) if history.exists() else 0
    phases = {
        "report": (out / "figures").exists(),
        "metrics": (out / "summary.json").exists(),
        "running": bool(rows),
        "begun": (out / "run.lock").exists(),
        "set-up": True,
    }
    draft = any(".writing" in path.name for path in out.rglob("*"))
    return next(name for name, there in phases.items() if there), rows, (out / "fields").exists(), len(checkpoints), draft


def trial(number: int, folder: Path, duration: float, whole: Path) -> dict[str, object]:
    """One run, killed once or twice, and resumed; begun again where it had not yet begun."""
    rng, out = random.Random(number), folder / f"run-{number}"
    report = number % REPORTS == 0
    seconds = rng.uniform(0.2, 1.0) * duration
    killed_after(begin(out, report), seconds)
    row: dict[str, object] = dict(zip(COLUMNS, (number, report, f"{seconds:.3f}", *state(out)), strict=False))
    row |= {"second kill [s]": "", "phase then": ""}
    begun = (out / "case.toml").exists()
    if begun and rng.random() < 0.5:
        seconds = rng.uniform(0.2, 1.0) * duration
        killed_after(go_on(out, report), seconds)
        row |= {"second kill [s]": f"{seconds:.3f}", "phase then": state(out)[0]}
    ended = subprocess.run((go_on if begun else begin)(out, report), capture_output=True, text=True)
    if ended.returncode:
        print(number, ended.stderr, flush=True)
        return row | {"same bits": False, "missing or left": f"exit status {ended.returncode}"}
    wrong = sorted(names(whole) ^ names(out))
    return row | {"same bits": results(out) == results(whole), "missing or left": " ".join(wrong)}


def trials(numbers: range, folder: Path) -> list[dict[str, object]]:
    """The unbroken runs, with a report and without, then the trials."""
    durations, whole = {}, {report: folder / f"whole-{report}" for report in (True, False)}
    for report, out in whole.items():
        for _ in range(2):  # the first may compile
            begun = time.monotonic()
            subprocess.run(begin(out, report), check=True, capture_output=True)
            durations[report] = time.monotonic() - begun
    rows = []
    for number in numbers:
        report = number % REPORTS == 0
        rows.append(trial(number, folder, durations[report], whole[report]))
        print(rows[-1], flush=True)
    return rows


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        rows = trials(range(int(sys.argv[1])), Path(folder))
    with (Path(__file__).parent / "killed_runs.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} kills, {sum(bool(row['same bits']) for row in rows)} with the same bits, ", end="")
    print(f"{sum(bool(row['missing or left']) for row in rows)} with files missing or left behind")
