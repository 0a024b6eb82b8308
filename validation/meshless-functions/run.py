"""Problems with known answers under the functions of meshless solids: errors, steps and time of each; writes a table.

Run by hand: python validation/meshless-functions/run.py [FUNCTIONS...]
"""

import csv
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

import pellucid

HERE = Path(__file__).parent
FUNCTIONS = ("cell-based-least-squares", "cell-based-maximum-entropy", "modified-moving-least-squares", "linear-simplex")
KUHN = [(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)]
BEAM, COOK = -0.4974, {1 / 3: 7.785, 0.4999: 6.955}  # reference.csv, to the difference of its finest meshes


def written(path: Path, nodes: np.ndarray, cells: np.ndarray) -> str:
    """A Gmsh file of tetrahedra."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += [f"{k + 1} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(nodes.tolist())]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{k + 1} 4 2 1 1 {a} {b} {c} {d}" for k, (a, b, c, d) in enumerate((cells + 1).tolist())]
    path.write_text("\n".join([*lines, "$EndElements", ""]))
    return str(path)


def mapped(cells: tuple[int, int, int], place: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and Kuhn's tetrahedra of a cube of cells, mapped from [0, 1]³ by a function of (n, 3) to (n, 3)."""
    counts = np.array(cells) + 1
    number = np.arange(counts.prod()).reshape(counts)
    unit = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    nx, ny, nz = cells
    corner = [number[i : i + nx, j : j + ny, k : k + nz].ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    found = np.concatenate([np.stack([corner[c] for c in corners], axis=1) for corners in KUHN])
    nodes = place(unit)
    turned = np.linalg.det(nodes[found[:, 1:]] - nodes[found[:, :1]]) < 0
    found[turned] = found[turned][:, [0, 1, 3, 2]]
    return nodes, found


def solid(mesh: dict, kind: str, young: float, nu: float) -> dict:
    """A neo-Hookean body."""
    material = {"kind": "neo-hookean", "density": 1000, "young_modulus": young, "poisson_ratio": nu}
    return {"name": "body", "kind": "meshless-solid", "mesh": mesh, "approximant": {"kind": kind}, "material": material}


def case(body: dict, supports: list[dict], loads: list[dict], probe: dict, steady: dict) -> dict[str, Any]:
    """An equilibrium of one body."""
    probes = [{"name": "value", "body": "body", "reduce": "point", "change": True, "quantity": "position"} | probe]
    parts = {"body": [body], "support": supports, "load": loads, "probe": probes}
    return {"schema": 1, "title": "trial", "time": {"end": 1.0}, "steady": steady} | parts


def beam(kind: str, across: int, folder: Path) -> dict:
    """A cantilever under a dead load at its tip, P L²/(E I) = 2."""
    mesh = {"box": {"lower": [0, 0, 0], "upper": [1, 0.1, 0.1], "cells": [10 * across, across, across]}}
    load = {"kind": "traction", "body": "body", "where": {"normal": [1, 0, 0]}, "traction": [0, 0, -2000], "rise": 1.0}
    supports = [{"body": "body", "where": {"normal": [-1, 0, 0]}}]
    return case(solid(mesh, kind, 1.2e6, 0.0), supports, [load], {"component": "z", "at": [1, 0.05, 0.05]}, {"load_steps": 2})


def cook(kind: str, n: int, nu: float, folder: Path) -> dict:
    """Cook's membrane in plane strain."""

    def place(unit: np.ndarray) -> np.ndarray:
        s, t, w = unit.T
        return np.stack([48 * s, 44 * s + t * (44 - 28 * s), 48 / n * w], axis=1)

    path = written(folder / "cook.msh", *mapped((n, n, 1), place))
    load = {
        "kind": "traction",
        "body": "body",
        "where": {"normal": [1, 0, 0], "within": 5},
        "traction": [0, 6.25, 0],
        "rise": 1.0,
    }
    foot = {"body": "body", "where": {"normal": [-1, 0, 0], "within": 5}, "fix": ["x", "y"]}
    flat = {"body": "body", "where": {"box": {"lower": [-1, -1, -1], "upper": [49, 61, 49]}}, "fix": ["z"]}
    probe = {"component": "y", "at": [48, 52, 24 / n]}
    return case(solid({"file": {"path": path}}, kind, 240.565, nu), [foot, flat], [load], probe, {"load_steps": 1})


def lame(kind: str, n: int, folder: Path) -> dict:
    """An eighth of a thick sphere, of radii 1 and 2, under a small pressure within."""
    nodes, cells = [], []
    for turn in range(3):

        def place(unit: np.ndarray, turn: int = turn) -> np.ndarray:
            u, v = unit[:, 1:2], unit[:, 2:]
            middle, one, other = np.ones(3), np.array([1.0, 1.0, 0.0]), np.array([1.0, 0.0, 1.0])
            at = [
                (1 - u) * (1 - v) * [1.0, 0, 0],
                u * (1 - v) * one / 2**0.5,
                (1 - u) * v * other / 2**0.5,
                u * v * middle / 3**0.5,
            ]
            d = sum(at)
            return np.roll((1 + unit[:, :1]) * d / np.linalg.norm(d, axis=1)[:, None], turn, axis=1)

        patch = mapped((n, n, n), place)
        cells.append(patch[1] + sum(map(len, nodes)))
        nodes.append(patch[0])
    _, first, which = np.unique(np.round(np.concatenate(nodes), 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    path = written(folder / "lame.msh", np.concatenate(nodes)[first], which.reshape(-1)[np.concatenate(cells)])
    planes = [np.where(np.eye(3)[k] > 0, 1e-6, 3.0).tolist() for k in range(3)]
    supports = [
        {"body": "body", "where": {"box": {"lower": [-1e-6] * 3, "upper": upper}}, "fix": ["xyz"[k]]}
        for k, upper in enumerate(planes)
    ]
    pressure = {"body": "body", "where": {"sphere": {"centre": [0, 0, 0], "radius": 1.01}}, "value": 0.1, "rise": 1.0}
    probe = {"component": "x", "at": [1, 0, 0]}
    body = solid({"file": {"path": path}}, kind, 1000.0, 0.3)
    return case(body, supports, [], probe, {"load_steps": 1, "tolerance": 1e-5}) | {"pressure": [pressure]}


def lame_displacement(young: float = 1000.0, nu: float = 0.3, pressure: float = 0.1, a: float = 1.0, b: float = 2.0) -> float:
    """Lamé: u(a) = p a³ / (E (b³ - a³)) ((1 - 2ν) a + (1 + ν) b³ / (2 a²))."""
    return pressure * a**3 / (young * (b**3 - a**3)) * ((1 - 2 * nu) * a + (1 + nu) * b**3 / (2 * a**2))


def problems(kind: str, folder: Path) -> Iterator[tuple[str, dict, float]]:
    """Name, case and what is right, of each."""
    yield "beam, 2 across", beam(kind, 2, folder), BEAM
    yield "beam, 4 across", beam(kind, 4, folder), BEAM
    for nu, right in COOK.items():
        for n in (6, 12, 24):
            yield f"Cook, nu {nu:.4g}, {n} cells", cook(kind, n, nu, folder), right
    for n in (3, 6):
        yield f"thick sphere, {n} cells", lame(kind, n, folder), lame_displacement()


def main(functions: tuple[str, ...]) -> None:
    """Run all, and write the table."""
    rows = []
    for kind in functions:
        with TemporaryDirectory() as name:
            for problem, made, right in problems(kind, Path(name)):
                start = perf_counter()
                try:
                    run = pellucid.run(pellucid.Case(**made), out=Path(name, "run"), threads=1, report=False)
                except Exception as error:
                    print(problem, kind, "failed:", str(error)[:300], flush=True)
                    continue
                found = float(run.history["value"][-1])
                row = problem, kind, found, right, found / right - 1, int(run.summary["steps"]), perf_counter() - start
                rows.append(row)
                print(*row, flush=True)
    with (HERE / "table.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("problem", "functions", "found", "right", "error", "steps", "seconds"), *rows])


if __name__ == "__main__":
    main(tuple(sys.argv[1:]) or FUNCTIONS)
