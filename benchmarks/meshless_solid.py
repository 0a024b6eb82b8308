"""Benchmark of a meshless solid on the finest mesh of Mountris et al. 2019, with about 50 000 nodes and 300 000 tetrahedra
of four points each: time to build the tables of shape functions, memory, and point updates per second on two threads and on
one.

Run it with `python benchmarks/meshless_solid.py [points]`; it takes minutes. Numbers: docs/reference/speed.md.
"""

import json
import sys
import time

from pellucid.bench.machine import peak_bytes
from pellucid.bench.meshless import built, cube, forms
from pellucid.jit import set_threads

FINEST = 1_170_000  # quadrature points
UPDATES = 60

if __name__ == "__main__":
    mesh = cube(int(float(sys.argv[1])) if len(sys.argv) > 1 else FINEST)
    set_threads(2)
    built(cube(200), True)  # compiles the kernels or loads them
    start, processor_start = time.perf_counter(), time.process_time()
    tables = built(mesh, True)
    result = {
        "nodes": len(mesh.nodes),
        "tetrahedra": len(mesh.cells),
        "build_seconds": time.perf_counter() - start,
        "build_processor_seconds": time.process_time() - processor_start,
        "peak_bytes": peak_bytes(),
    }
    for threads in (2, 1):
        set_threads(threads)
        result[f"{threads} threads"] = forms(tables.solid, mesh, UPDATES)
    print(json.dumps(result, indent=1))
