"""The shock tube itself, killed at random moments and resumed on other numbers of threads."""

import json
import random
import subprocess
import sys
import time

PELLUCID = [sys.executable, "-m", "pellucid"]
SETTINGS = ["--quick", "--set", "time.end=0.02", "--set", "output.checkpoint=0.02", "--set", "output.frames=0.001"]
RUN = [*PELLUCID, "run", "gan2011/shock-tube", "--no-report", *SETTINGS]
KILLS = 3


def rows(out):
    history = out / "history.csv"
    return history.read_bytes().count(b"\n") if history.exists() else 0


def kill_on_the_way(command, out):
    """Start a command, wait until it has written some rows, and kill it a moment later."""
    seen, wanted = rows(out), random.randint(3, 30)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and abs(rows(out) - seen) < wanted:
        time.sleep(0.005)
    time.sleep(0.03 * random.random())
    process.kill()
    process.wait()


def results(out):
    summary = json.loads((out / "summary.json").read_text())
    for name in ("wall_seconds", "point_steps_per_second", "threads"):
        del summary[name]
    fields = {path.name: path.read_bytes() for path in (out / "fields").glob("[!.]*.vtkhdf")}
    return {"history": (out / "history.csv").read_bytes(), "summary": summary, "fields": fields}


def test_killed_and_resumed_ends_in_the_same_bits(tmp_path):
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    subprocess.run([*RUN, "--out", whole, "--threads", "2"], check=True, capture_output=True)
    kill_on_the_way([*RUN, "--out", broken, "--threads", "1"], broken)
    for number in range(KILLS):
        kill_on_the_way([*PELLUCID, "resume", broken, "--no-report", "--threads", str(1 + number % 2)], broken)
    subprocess.run([*PELLUCID, "resume", broken, "--no-report", "--threads", "2"], check=True, capture_output=True)
    assert results(broken) == results(whole)
    assert len(results(whole)["fields"]) == 2
