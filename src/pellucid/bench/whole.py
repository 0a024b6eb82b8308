"""The whole benchmark: the machine, each body at each size, and other programs."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import pellucid
from pellucid.bench.problem import MATERIALS, MEMBRANES
from pellucid.errors import RunStopped, UsageError
from pellucid.simulation.threads import numbers_up_to

POINTS = (10_000, 100_000, 1_000_000, 4_000_000)
MOST_POINTS = 1_000_000_000
CONTACT_POINTS, CONTACT_STEPS = 200_000, 50
SOLID_POINTS, SOLID_STEPS = 200_000, 50
FILM_NODES, FILM_STEPS = (642, 2_562, 10_242, 40_962), 30
PEER_POINTS = 1_000_000
VARIANT_POINTS = 100_000
VARIANTS = [
    *({"body": "ideal-gas", "functions": functions} for functions in ("gimp", "quadratic-bspline", "cubic-bspline")),
    *({"body": "ideal-gas", "functions": functions, "transfer": "apic"} for functions in ("trilinear", "quadratic-bspline")),
    *({"body": body} for body in MEMBRANES),
]
"""Variants of bodies, functions and transfers that the benchmark measures in addition to the bodies with trilinear
functions and FLIP."""
PASSES = [
    *({"body": body, "functions": functions} for body in MATERIALS for functions in ("trilinear", "quadratic-bspline")),
    {"body": "ideal-gas", "transfer": "apic"},
    {"body": "membrane-points"},
]
"""Problems whose passes over points are measured one by one."""
THREADS_POINTS = 20_000, 100_000, 1_000_000
"""Numbers of points of the gas that is measured with one, two, four and all threads."""


def bench(
    points: list[int] | None = None, steps: int | None = None, threads: int | None = None, peers: bool = False
) -> dict[str, Any]:
    """Measure the point-steps per second of each kind of body, including all parts of a step.

    points: approximate sizes (the body is a cube of whole cells). steps: steps per block, of which the fastest of three
    counts; default: chosen by size. threads: default all cores. peers: also run `benchmarks/peers`. The result `cores` is
    the number of cores effectively used, which is less than the threads if other processes run on the machine. Raises
    RunStopped if a measurement fails, e.g. for lack of memory.

    Returns {"machine": {...}, "bodies": [{body, functions, transfer, points, threads, steps, seconds_per_step,
    point_steps_per_second, cores, bytes_per_point, peak_bytes, parts: {part: share of the time}}, ...], "variants": [the
    same for VARIANTS], "passes": [{body, functions, transfer, points, threads, passes: {name: {seconds_per_point,
    bytes_per_point, bytes_per_second}}}, ...], "threads": [the same for a gas with 1 to `threads` threads], "contact":
    {elements, points, steps, seconds_per_step: {sheet, block, together}, ratio}, "solid": {points, nodes, nodes_per_point,
    threads, build_seconds, build_processor_seconds, build_bytes, bytes_per_point, forms: {averaged and pointwise:
    {seconds_per_update, point_updates_per_second, processor_seconds_per_update, moved_bytes_per_second}}}, "films":
    [{points, steps, build_seconds, seconds_per_step, processor_seconds_per_step, factors_per_step, bytes_per_point, parts},
    ...], "peers": [...]}; SI units.
    """
    import numba

    from pellucid.bench.machine import triad_bandwidth

    unfit = [n for n in points or () if not 8 <= n <= MOST_POINTS]
    if unfit:
        raise UsageError(f"--points {unfit[0]:g}: must be between 8 and {MOST_POINTS:g}")
    threads = threads or numba.config.NUMBA_NUM_THREADS
    machine = {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "threads": threads,
        "triad_bytes_per_second": triad_bandwidth(threads),
        "python": platform.python_version(),
        "numba": numba.__version__,
        "pellucid": pellucid.__version__,
    }
    largest = max(points or POINTS)
    bodies = [_measured({"body": body}, n, steps or _steps(n), threads) for body in MATERIALS for n in points or POINTS]
    size = min(largest, VARIANT_POINTS)
    variants = [_measured(variant, size, steps or _steps(size), threads) for variant in VARIANTS]
    pressed = {"points": min(largest, CONTACT_POINTS), "steps": steps or CONTACT_STEPS, "threads": threads}
    contact = _in_a_process("contact", pressed)
    strained = {"points": min(largest, SOLID_POINTS), "steps": steps or SOLID_STEPS, "threads": threads}
    solid = _in_a_process("meshless", strained)
    films = [
        _in_a_process("film", {"points": n, "steps": steps or FILM_STEPS, "threads": threads})
        for n in FILM_NODES
        if n <= largest or n == FILM_NODES[0]
    ]
    passes = [_in_a_process("passes", {**what, "points": size, "threads": threads}) for what in PASSES]
    sizes = [n for n in THREADS_POINTS if n <= largest]
    gas = {"body": "ideal-gas"}
    by_threads = [_measured(gas, n, steps or _steps(n), number) for n in sizes for number in numbers_up_to(threads)]
    result: dict[str, Any] = {"machine": machine, "bodies": bodies, "variants": variants, "passes": passes}
    result |= {"threads": by_threads, "contact": contact, "solid": solid, "films": films, "peers": []}
    if peers:
        size = PEER_POINTS if points is None else max(points)
        result["peers"] = [_with_ratio(peer, bodies) for peer in run_peers(size, steps or _steps(size), threads)]
    return result


def _steps(points: int) -> int:
    """Return the number of steps per measured block for a number of points, a compromise between timing noise and duration."""
    return max(20, min(500, 20_000_000 // points))


def _measured(what: dict[str, str], points: int, steps: int, threads: int) -> dict[str, Any]:
    return _in_a_process("measure", {**what, "points": points, "steps": steps, "threads": threads})


def _in_a_process(module: str, request: dict[str, Any]) -> dict[str, Any]:
    command = [sys.executable, "-m", "pellucid.bench.alone", module, json.dumps(request)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1:] or ["it may require more memory than this machine has"]
        what = request.get("body", module)
        raise RunStopped(
            f"the benchmark of {request['points']} points ({what}) ended with status {done.returncode}: {reason[0]}"
        )
    result: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return result


def _with_ratio(peer: dict[str, Any], bodies: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the result of another program with "ratio" added: point-steps per second of pellucid divided by those of the
    other program, for the same material law and number of points; without "ratio" if there is no such result of pellucid.
    peer: the result. bodies: results of pellucid."""
    if "missing" in peer:
        return peer
    same = [b for b in bodies if b["body"] == peer["law"] and b["points"] == peer["points"]]
    return {**peer, "ratio": same[0]["point_steps_per_second"] / peer["point_steps_per_second"]} if same else peer


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


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
