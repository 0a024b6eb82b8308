"""Speed of other programs for the same step: runs the scripts of `benchmarks/peers` whose libraries are installed."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

PEERS = ("taichi", "warp")
LAWS = ("ideal-gas", "hypoelastic")
INTERPRETER_VARIABLE = "PELLUCID_PEER_PYTHON"


def run_peers(points: int, steps: int, threads: int) -> list[dict[str, Any]]:
    """Run the other programs and return one result for each program and material law: the dictionary that its script printed,
    or {"peer", "law", "missing": reason}.

    points: approximate number of points. steps: measured steps.
    """
    folder = _scripts()
    if folder is None:
        why = "the scripts are in benchmarks/peers of the source tree; run the command in the source tree"
        return [{"peer": peer, "law": law, "missing": why} for peer in PEERS for law in LAWS]
    return [_run_one(folder, peer, law, points, steps, threads) for peer in PEERS for law in LAWS]


def _run_one(folder: Path, peer: str, law: str, points: int, steps: int, threads: int) -> dict[str, Any]:
    command = [os.environ.get(INTERPRETER_VARIABLE, sys.executable), str(folder / f"{peer}_step.py"), "--json"]
    command += ["--law", law, "--points", str(points), "--steps", str(steps), "--threads", str(threads)]
    command += ["--scheme", "musl"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = done.stdout.strip().splitlines()
    if done.returncode != 0 or not lines:
        reason = (done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"])[-1]
        return {"peer": peer, "law": law, "missing": reason}
    result: dict[str, Any] = json.loads(lines[-1])
    return result


def _scripts() -> Path | None:
    """Return the folder of the scripts, in the source tree of this module or below the working directory; None if it is not
    found."""
    for root in (Path(__file__).parents[3], Path.cwd()):
        folder = root / "benchmarks" / "peers"
        if (folder / "block.py").is_file():
            return folder
    return None
