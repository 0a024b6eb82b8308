"""The same bits on any number of threads, also across re-sorting, and whether kernels were compiled before or not."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# a gas square in motion: eight slabs and more, several chunks of nodes, points that stray from slab to slab
PROGRAM = """
import hashlib, json, sys
import numpy as np
from small_cases import GAS, SLIP, SOLID, advance, box, case
from pellucid.simulation.simulation import Simulation

wave = {"amplitude": (0.3, 0.4, 0), "wave_vector": (0.3, 0.2, 0)}
gas = box((1, 1, 0), (71, 71, 1), GAS, (2, 2, 1), velocity=(0.8, 0.5, 0), velocity_wave=wave)
# shear of a solid: where multiplications and additions are fused tells in every component of its stress
shear = {"amplitude": (0.1, 0.3, 0), "wave_vector": (0.2, 0.5, 0)}
block = box((74, 20, 0), (90, 50, 1), SOLID, (2, 2, 1), name="solid", velocity_wave=shear)
tables = case(gas, block, counts=(96, 72, 1), support=SLIP, end=100.0, functions="quadratic-bspline")

def fingerprint(sim):
    digest = hashlib.sha256()
    for name, array in sorted(sim.state_arrays().items()):
        digest.update(name.encode() + array.tobytes())
    for array in sim.grid.nodes:
        digest.update(array.tobytes())
    numbers = json.dumps([sim.state_numbers(), sim.budget.energies(), sim.budget.conservation()])
    return digest.hexdigest() + hashlib.sha256(numbers.encode()).hexdigest()

results = []
for threads in map(int, sys.argv[1:]):
    sim = Simulation(tables, threads=threads)
    assert sim.threads == threads, sim.threads
    body, sortings, prints = sim.bodies[0], 0, []
    for _ in range(4):
        for _ in range(6):
            since = body.storage.short_runs  # the last sorting
            advance(sim, 1)
            sortings += body.storage.short_runs is not since
        prints.append(fingerprint(sim))
    results.append({"prints": prints, "sortings": sortings, "slabs": body.n_slabs, "points": body.n_points})
print(json.dumps(results))
"""


def run(cache, *threads):
    """The results of the program above for each number of threads, in a process of its own, kernels kept in a folder."""
    environment = os.environ | {
        "NUMBA_CACHE_DIR": str(cache),
        "NUMBA_NUM_THREADS": "4",
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path]),
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *map(str, threads)], env=environment, capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("kernels")


@pytest.fixture(scope="module")
def one_two_four(cache):
    return run(cache, 1, 2, 4)


def test_the_case_is_worth_it(one_two_four):
    assert one_two_four[0]["points"] > 19_000
    assert one_two_four[0]["slabs"] >= 8
    assert one_two_four[0]["sortings"] >= 1


def test_threads_do_not_change_a_bit(one_two_four):
    one, two, four = one_two_four
    assert one == two
    assert one == four


def test_another_process_that_finds_the_kernels_compiled_gets_the_same_bits(one_two_four, cache):
    assert run(cache, 3) == [one_two_four[0]]
