"""A rigid ball or cylinder pressed into a bonded block by contact between surfaces, compared with finite elements.

    python by_surfaces.py      by_surfaces.csv

The tool has a radius of 1 m, the block a height of 1 m and a half width of 2 m (E = 1 kPa, ν = 0.3, neo-Hookean), the tool is
0.1 m deep. A quarter is computed under the ball, and under the cylinder a half of a slice between two planes of symmetry. The
forces are compared with those of `blocks.csv`, which has the same law, finite strains and the same width; there the block under
the ball is round, which changes the force by 0.1 % at most.

Solids are meshless in a steady state, meshless or of material points in time. Meshes are finest under the tool, material points
have a uniform grid. In time the load grows smoothly over 20 s, and a drag and 10 s of rest leave no inertia.
"""

import csv
import sys
import time
import warnings
from pathlib import Path

import numpy as np

from pellucid.case import Case
from pellucid.results.storage.probes import ProbeReader
from pellucid.simulation.simulation import Simulation

HERE = Path(__file__).parent
E, NU, HEIGHT, WIDTH, DEPTH = 1000.0, 0.3, 1.0, 2.0, 0.1
SOFT = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": E, "poisson_ratio": NU}
HARD = SOFT | {"kind": "linear-elastic", "young_modulus": 1e6}
OUT, DOWN = 4.0, 3.0  # coarsest over finest elements along the surface and across the block
LOADING, RESTING, DRAG = 20.0, 10.0, 1.0  # s, s, 1/s


def exact(tool, depth=DEPTH, column="force"):
    """Return the force [N], of a cylinder [N/m], or another column of `blocks.csv`."""
    with (HERE / "blocks.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            same = tool, HEIGHT, WIDTH, NU, "finite", depth
            if same == (
                row["tool"],
                *(float(row[k]) for k in ("thickness", "width", "poisson_ratio")),
                row["strains"],
                float(row["depth"]),
            ):
                return float(row[column]) * (E if column == "force" else 1.0)
    raise ValueError(f"blocks.csv has no {tool} {depth:g} m deep")


def layers(length, finest, ratio):
    """Return the number of elements over a length, whose widths grow steadily from the finest to `ratio` times that."""
    for n in range(2, 1000):
        if finest * np.sum(ratio ** (np.arange(n) / (n - 1))) >= length * 0.999:
            return n
    raise ValueError("elements are too small")


def case(tool, kind, finest, depth=DEPTH, **steady):
    """Return the data of a case.

    kind: "steady", "meshless" or "points". finest: edge of the finest elements, or of the cells [m]. steady: more keys of
    `[steady]`.
    """
    ball, plane = tool == "sphere", tool == "cylinder" and kind == "points"
    n = layers(WIDTH, finest, OUT)
    slice_width = finest if plane else 2.0 * finest
    across = WIDTH if ball else slice_width
    block_ends = (WIDTH, across, HEIGHT)
    block = {"name": "block", "field": "block", "material": SOFT}
    if kind == "points":
        block |= {"kind": "material-points", "shape": {"box": {"lower": (0.0, 0.0, 0.0), "upper": block_ends}}}
        block["points_per_cell"] = 8 if ball else 4
    else:
        cells, grading = (n, n if ball else 2, layers(HEIGHT, finest, DOWN)), (OUT, OUT if ball else 1.0, 1.0 / DOWN)
        mesh = {"lower": (0.0, 0.0, 0.0), "upper": block_ends, "cells": cells, "grading": grading}
        block |= {"kind": "meshless-solid", "mesh": {"box": mesh}}
    start = 0.0 if kind != "steady" else 0.2 * finest  # steady tools begin just above the block
    shape = {
        "cylinder": {"centre": (0.0, 0.5 * across, HEIGHT + 1.0 + start), "radius": 1.0, "height": 3.0 * across, "axis": "y"}
    }
    if ball:
        shape = {"sphere": {"centre": (0.0, 0.0, HEIGHT + 1.0 + start), "radius": 1.0}}
    planes = ["x-lower"] + ["y-lower"] * (not plane) + ["y-upper"] * (not plane and not ball)
    body = {"name": "tool", "field": "tool", "kind": "material-points", "rigid": True, "shape": shape, "material": HARD}
    body |= {"points_per_cell": 1, "cut_at": planes}
    hold = (["x"], ["y"]) if plane else (["x", "y"], ["x", "y", "z"])
    motion = {"name": "press", "body": "tool", "hold": hold[0], "hold_rotation": hold[1]}
    data = {"schema": 1, "title": f"{tool} on a block"}
    if kind == "steady":
        data |= {"time": {"end": 1.0}, "steady": {"tolerance": 1e-3} | steady}
        motion["displacement"] = {"z": {"kind": "steady", "velocity": -depth - start}}
    else:
        data["time"] = {"end": LOADING + RESTING, "courant": 0.5}
        motion["displacement"] = {"z": {"kind": "ramp", "distance": -depth, "duration": LOADING}}
        block["damping"] = DRAG
    foot = {"body": "block", "where": {"box": {"lower": (-1.0, -1.0, -1.0), "upper": (9.0, 9.0, 0.1 * finest)}}}
    if kind == "points":
        foot = {"where": ["z-lower"]}
    ends = [finest * np.ceil((length + 2.0 * finest) / finest - 1e-9) for length in (WIDTH, WIDTH, HEIGHT + 2.0)]
    ends[1] = ends[1] if ball else slice_width
    grid = {"lower": (0.0, 0.0, 0.0), "upper": tuple(ends), "cell": finest} | ({"thickness": slice_width} if plane else {})
    data |= {"grid": grid, "body": [block, body], "motion": [motion], "support": [{"where": planes, "fix": "normal"}, foot]}
    return data | {"probe": [{"name": "force", "quantity": "reaction", "condition": "press", "component": "z"}]}


def press(tool, kind, finest, depth=DEPTH, **steady):
    """Return the force over that of the finite elements, and the simulation at its end."""
    data = case(tool, kind, finest, depth, **steady)
    parsed = Case.model_validate(data)
    simulation, reader = Simulation(parsed, threads=1), ProbeReader(parsed.probe)
    while not simulation.clock.finished(None):
        before = simulation.time
        simulation.step()
        if simulation.time > before:  # the reader has the mean force since it read before
            (force,) = reader.read(simulation.bodies, simulation.budget.reactions(), simulation.time)
    whole = 4.0 if tool == "sphere" else 2.0 / (finest if kind == "points" else 2.0 * finest)
    return abs(force) * whole / exact(tool, depth), simulation


RUNS = {
    ("cylinder", "steady"): (0.1, 0.0625, 0.04),
    ("cylinder", "meshless"): (0.1, 0.0625),
    ("cylinder", "points"): (0.1, 0.0625, 0.04),
    ("sphere", "steady"): (0.1, 0.0625),
    ("sphere", "points"): (0.2, 0.125),
}


def main():
    rows = []
    for (tool, kind), sizes in RUNS.items():
        if sys.argv[1:] and [tool, kind] != sys.argv[1:]:
            continue
        for finest in sizes:
            begun = time.perf_counter()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                ratio, simulation = press(tool, kind, finest)
            contact = exact(tool, column="contact")
            row = (tool, kind, finest, f"{contact / finest:.1f}", simulation.bodies[0].n_points, f"{ratio:.4f}")
            print(*row, simulation.n_steps, f"{time.perf_counter() - begun:.0f} s", flush=True)
            rows.append(row)
    if sys.argv[1:]:
        return
    with (HERE / "by_surfaces.csv").open("w", newline="", encoding="utf-8") as file:
        columns = ["tool", "solid", "finest", "elements_in_contact", "points", "over_finite_elements"]
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])


if __name__ == "__main__":
    main()
