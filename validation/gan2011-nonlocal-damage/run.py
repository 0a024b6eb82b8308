"""A strip of the zona with a round hole, pulled apart: the failed area against the cell, with local and with nonlocal damage.

Needs `pip install 'pellucid[mesh]'`, for the surface with a hole. Writes failed-area.csv and two figures beside this script.
"""

import csv
import tempfile
import time
from itertools import product
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import Delaunay

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

HERE = Path(__file__).parent
LENGTH, WIDTH, HOLE, FREE = 100e-6, 60e-6, 12e-6, 80e-6  # of the strip, the hole's radius, the length between the grips [m]
THICKNESS, DENSITY = 8e-6, 1100.0
SPACING = 1e-6  # of the points of the surface [m]
PULL, DURATION = 4.6e-6, 0.7e-3  # by which the ends move apart [m], and within what time [s]
CELLS = (10e-6, 5e-6, 10e-6 / 3.0, 2.5e-6)
FUNCTIONS = ("trilinear", "quadratic-bspline")
RADIUS = 15e-6
TORN = 3.9e-6  # pull at which the strip has torn with either damage and any cell [m]
ROWS = 46


def write_strip(path: Path, spacing: float) -> None:
    """The strip with its hole as an OBJ file, in micrometres: a lattice of points, a ring about the hole, triangles."""
    # half a spacing within the strip's edges, which are faces of cells: points on a face would be alone in the cells beyond
    x, y = (spacing * (np.arange(round(extent / spacing)) + 0.5) - 0.5 * extent for extent in (LENGTH, WIDTH))
    lattice = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    lattice = lattice[np.hypot(*lattice.T) > HOLE + 0.5 * spacing]
    angle = np.linspace(0.0, 2.0 * np.pi, round(2.0 * np.pi * HOLE / spacing), endpoint=False)
    points = np.concatenate([lattice, HOLE * np.stack([np.cos(angle), np.sin(angle)], axis=1)])
    triangles = Delaunay(points / LENGTH).simplices
    a, b, c = (points[corner] for corner in triangles.T)
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    in_hole = np.all(triangles >= len(lattice), axis=1)
    keep = ~in_hole & (np.abs(twice) > 1e-3 * spacing**2)
    triangles = np.where((twice < 0.0)[:, None], triangles[:, ::-1], triangles)[keep]
    lines = [f"v {px * 1e6:.9g} {py * 1e6:.9g} 0" for px, py in points]
    lines += ["f " + " ".join(str(corner + 1) for corner in triangle) for triangle in triangles]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def strip(path: Path, cell: float, radius: float | None, functions: str) -> Case:
    """The case; both ends are gripped and drawn apart along x on a smooth ramp."""
    damage = {"elastic_limit": 0.05937, "stiffness_loss": 10, "rate": 10, "failure_strain": 0.06}
    elastic = {"kind": "linear-membrane", "density": DENSITY, "young_modulus": 17.9e3, "poisson_ratio": 0.49}
    ends = {"left": (-1.0, -0.5 * FREE, -0.5), "right": (0.5 * FREE, 1.0, 0.5)}
    return Case.model_validate(
        {
            "schema": 1,
            "title": "A strip with a hole, pulled apart",
            "grid": {"lower": [-60e-6, -100e-6, 0.0], "upper": [60e-6, 100e-6, 0.0], "cell": cell, "functions": functions},
            "time": {"end": DURATION, "courant": 0.2},
            "energy": {"warn": 0.2, "stop": 0.4},  # a point fails within a step or two; see the README
            "body": [
                {
                    "name": "strip",
                    "kind": "membrane-points",
                    "surface": {"file": {"path": str(path), "scale": 1e-6}},
                    "thickness": THICKNESS,
                    "material": elastic | {"damage": damage | ({"radius": radius} if radius else {})},
                }
            ],
            "motion": [
                {
                    "name": name,
                    "body": "strip",
                    "part": {"box": {"lower": [low, -1.0, -1.0], "upper": [high, 1.0, 1.0]}},
                    "hold": ["y"],
                    "displacement": {"x": {"kind": "ramp", "distance": share * PULL, "duration": DURATION}},
                }
                for name, (low, high, share) in ends.items()
            ],
        }
    )


def pull(case: Case) -> tuple[list[tuple[float, float]], dict[str, np.ndarray], float]:
    """Rows of the ends' distance [m] and the failed area [m²]; the initial places and failed points; the energy error."""
    simulation = Simulation(case, threads=1)
    body = simulation.bodies[0]
    move = case.motion[1].functions()[0]
    rows = []
    for row in range(1, ROWS + 1):
        while simulation.time < DURATION * row / ROWS:
            simulation.step()
        failed = body.field("failed") @ body.field("mass") / (DENSITY * THICKNESS)
        rows.append((2.0 * move(simulation.time), float(failed)))
    frame = {name: body.field(name)[np.argsort(body.field("id"))] for name in ("start", "failed")}
    return rows, frame, simulation.budget.energy_error()


def torn_area(rows: list[tuple[float, float]]) -> float:
    """The failed area [m²] just after the strip has torn."""
    return float(np.interp(TORN, *np.array(rows).T))


def draw(histories: dict[tuple[str, str, float], list[tuple[float, float]]], frames: dict[tuple[str, float], dict]) -> None:
    """Failed area against the pull and against the cell; where the failed points are."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    for (functions, kind, cell), rows in histories.items():
        if functions == FUNCTIONS[0]:
            u, area = 1e6 * np.array(rows)[:, 0], 1e12 * np.array(rows)[:, 1]
            style = {"color": f"C{CELLS.index(cell)}", "linestyle": "--" if kind == "local" else "-"}
            left.plot(u, area, label=f"{kind}, {1e6 * cell:.2g} µm", **style)
    left.axvline(1e6 * TORN, color="0.8", zorder=0)
    left.set(xlabel="distance that the ends moved apart [µm]", ylabel="failed area [µm²]", xlim=(1.0, None))
    left.set_title(f"{FUNCTIONS[0]} functions")
    left.legend(fontsize=8, title="damage, cell")
    for functions, marker in zip(FUNCTIONS, ("s", "o"), strict=True):
        for kind, line in (("local", "--"), ("nonlocal", "-")):
            areas = [1e12 * torn_area(histories[functions, kind, cell]) for cell in CELLS]
            right.plot(1e6 * np.array(CELLS), areas, marker + line, label=f"{kind}, {functions}")
    right.set(xlabel="cell [µm]", ylabel=f"failed area at {1e6 * TORN:.2g} µm [µm²]", xlim=(0, None), ylim=(0, 1200))
    right.legend(fontsize=8)
    figure.savefig(HERE / "failed-area.png", dpi=110)
    figure, axes = plt.subplots(2, len(CELLS), figsize=(13, 5), layout="constrained", sharex=True, sharey=True)
    for (kind, cell), frame in frames.items():
        axis = axes[("local", "nonlocal").index(kind)][CELLS.index(cell)]
        x, y = 1e6 * frame["start"][:, :2].T
        failed = frame["failed"] > 0
        axis.scatter(x[~failed], y[~failed], s=0.5, color="0.7")
        axis.scatter(x[failed], y[failed], s=1.5, color="crimson")
        axis.set(title=f"{kind}, {1e6 * cell:.2g} µm", aspect="equal")
    figure.savefig(HERE / "failed-points.png", dpi=110)


def main() -> None:
    """Every cell with both kinds of damage and both kinds of shape functions."""
    histories, frames, table = {}, {}, []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "strip.obj"
        write_strip(path, SPACING)
        for functions, (kind, radius), cell in product(FUNCTIONS, (("local", None), ("nonlocal", RADIUS)), CELLS):
            started = time.monotonic()
            rows, frame, error = pull(strip(path, cell, radius, functions))
            histories[functions, kind, cell] = rows
            if functions == FUNCTIONS[0]:
                frames[kind, cell] = frame
            table += [(functions, kind, cell, *row) for row in rows]
            torn, last, seconds = 1e12 * torn_area(rows), 1e12 * rows[-1][1], time.monotonic() - started
            print(f"{functions}, {kind}, cell {cell:.3g} m: {torn:.0f} um^2, {last:.0f} at the end, ", end="")
            print(f"energy error {error:.2g}, {seconds:.0f} s", flush=True)
    with (HERE / "failed-area.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("functions", "damage", "cell [m]", "pull [m]", "failed area [m^2]"))
        writer.writerows((f, kind, f"{cell:.6g}", f"{u:.6g}", f"{area:.6g}") for f, kind, cell, u, area in table)
    draw(histories, frames)


if __name__ == "__main__":
    main()
