"""Cost of the forces of a meshless solid: a strained cube, with pointwise and with averaged volume ratios."""

import time
from typing import Any

import numpy as np

from pellucid.approximants.nodal.maximum_entropy import CellMaximumEntropyModel
from pellucid.bench.machine import peak_bytes
from pellucid.bench.problem import SOLID
from pellucid.bodies.meshless_solid.forces import in_kernels, internal_forces
from pellucid.bodies.meshless_solid.functions import Tables, make_tables
from pellucid.bodies.meshless_solid.solid import Solid
from pellucid.geometry.meshes.points import spatial_order
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.jit import set_threads
from pellucid.materials.neo_hookean import NeoHookeanMaterial

POINTS_PER_CELL = 4
CELLS_IN_A_CUBE = 12  # of the mesh of a box
EDGE, STRAIN = 0.1, 0.01  # m


def cube(points: int) -> SimplexMesh:
    """Build the mesh of a cube with about this number of quadrature points."""
    n = max(2, round((points / (POINTS_PER_CELL * CELLS_IN_A_CUBE)) ** (1.0 / 3.0)))
    mesh = box_mesh(np.zeros(3), np.full(3, EDGE), (n, n, n))
    return SimplexMesh(mesh.nodes, mesh.cells[spatial_order(mesh.nodes[mesh.cells].mean(axis=1))])


def measure(points: int, steps: int, threads: int | None) -> dict[str, Any]:
    """Measure the wall-clock time of the internal forces of a meshless solid with about `points` quadrature points, with
    pointwise and averaged volume ratios; the fastest of `steps` evaluations counts. Keys of the result as in
    `pellucid.bench.whole.bench`."""
    threads = set_threads(threads)
    built(cube(200), True)  # compiles the kernels or loads them
    before, mesh, start, processor_start = peak_bytes(), cube(points), time.perf_counter(), time.process_time()
    tables = built(mesh, True)
    n = len(mesh.cells) * POINTS_PER_CELL
    result: dict[str, Any] = {
        "points": n,
        "nodes": len(mesh.nodes),
        "nodes_per_point": len(tables.solid.gradients.place) / len(tables.solid.weights) * POINTS_PER_CELL,
        "threads": threads,
        "build_seconds": time.perf_counter() - start,
        "build_processor_seconds": time.process_time() - processor_start,
        "build_bytes": peak_bytes() - before,
        "bytes_per_point": _size(tables.solid) / n,
    }
    return result | {"forms": forms(tables.solid, mesh, steps)}


def forms(solid: Solid, mesh: SimplexMesh, steps: int) -> dict[str, dict[str, float]]:
    """Return the shortest measured times of an evaluation of the internal forces, with averaged and with pointwise volume
    ratios: wall-clock time and processor time, which is less affected by other processes. Keys as in
    `pellucid.bench.whole.bench`, entry "forms"."""
    found = {}
    for form, taken in (("averaged", solid), ("pointwise", solid._replace(block_volume=np.zeros(0)))):
        seconds, processor_seconds = _fastest(taken, mesh, steps)
        found[form] = {
            "seconds_per_update": seconds,
            "point_updates_per_second": len(mesh.cells) * POINTS_PER_CELL / seconds,
            "processor_seconds_per_update": processor_seconds,
            "moved_bytes_per_second": _moved(taken) / seconds,
        }
    return found


def built(mesh: SimplexMesh, averaged: bool) -> Tables:
    """Build the tables (shape functions and their gradients at quadrature points) of a meshless solid on a mesh, with
    cell-based maximum-entropy functions and corrected gradients. averaged: whether volume ratios are averaged."""
    law = NeoHookeanMaterial(**SOLID).law()
    return make_tables(mesh, CellMaximumEntropyModel().evaluator(mesh), law, POINTS_PER_CELL, True, averaged)


def _fastest(solid: Solid, mesh: SimplexMesh, steps: int) -> tuple[float, float]:
    """Evaluate the internal forces `steps` times; return the wall-clock time and the processor time of the fastest
    evaluation [s]."""
    solid.displacement[:] = STRAIN * EDGE * np.sin(mesh.nodes / EDGE)
    bundle, force, taken = in_kernels(solid), np.zeros_like(mesh.nodes), []
    for _ in range(steps + 1):
        start, processor_start = time.perf_counter(), time.process_time()
        internal_forces(len(solid.sums), len(solid.node_sums), bundle, 0.0, False, force)
        taken.append((time.perf_counter() - start, time.process_time() - processor_start))
    return min(seconds for seconds, _ in taken), min(seconds for _, seconds in taken)


def _size(value: Any) -> int:
    """Return the memory of all arrays in a nested tuple [bytes]."""
    return sum(_size(part) for part in value) if isinstance(value, tuple) else getattr(value, "nbytes", 0)


def _moved(solid: Solid) -> int:
    """Return the smallest number of bytes that an evaluation of the internal forces reads and writes: all tables of shape
    functions once, or twice for averaged volume ratios."""
    once = _size(solid.gradients) + solid.turns.nbytes + solid.deformation.nbytes
    averages = _size(solid.corners) if len(solid.block_volume) else 0
    return (2 if averages else 1) * (once + averages) + solid.weights.nbytes
