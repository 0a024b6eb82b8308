"""Linear algebra of films on one thread."""

import os
import subprocess
import sys

LIBRARIES = """
from threadpoolctl import threadpool_info
import pellucid.bodies.fluid_film.body
from pellucid.linear.elimination import on_one_thread
import numpy, scipy.linalg
with on_one_thread():
    print([library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"])
"""


def test_the_libraries_of_numpy_and_scipy_take_one_thread() -> None:
    """In a process of its own, in which nothing has loaded them before."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2"}
    found = subprocess.run(
        [sys.executable, "-c", LIBRARIES], env=environment, capture_output=True, text=True, check=True
    ).stdout
    threads = [int(number) for number in found.strip("[]\n").split(",")]
    assert len(threads) >= 1
    assert set(threads) == {1}
