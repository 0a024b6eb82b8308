"""The same tissue on nodes of its own and as material points: a block bounces on a floor. Writes bounce.csv.

python bounce.py [bar] [cube] [plate]: a bar without lateral strain, whose bounce is exact, and a cube with ν = 0.3, a quarter
of it, on a wall of the grid; the same cube on a rigid plate, by contact.
"""

import csv
import sys
import time
from pathlib import Path

import numpy as np

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

DENSITY, MODULUS, SPEED = 1000.0, 1e5, 0.1
LENGTH, EDGE = 0.2, 0.1
COLUMNS = (
    *("block", "floor", "kind", "along", "courant"),
    *("rebound", "turn_ms", "contact_ms", "energy_error", "steps", "wall_seconds"),
)


def material(poisson_ratio):
    return {"kind": "neo-hookean", "density": DENSITY, "young_modulus": MODULUS, "poisson_ratio": poisson_ratio}


def bar(kind, along, bottom):
    """A bar as thick as one cube or cell; material points move along it alone."""
    h = LENGTH / along
    body = {"name": "block", "material": material(0.0), "velocity": (0, 0, -SPEED)}
    if kind == "meshless":
        mesh = {"box": {"lower": (h, h, bottom), "upper": (2 * h, 2 * h, LENGTH + bottom), "cells": (1, 1, along)}}
        return body | {"kind": "meshless-solid", "mesh": mesh}, (3, 3), []
    shape = {"box": {"lower": (0, 0, bottom), "upper": (h, h, LENGTH + bottom)}}
    return body | {"shape": shape, "points_per_cell": (1, 1, 2)}, (1, 1), []


def cube(kind, along, bottom):
    """A quarter of a cube, between planes of symmetry."""
    body = {"name": "block", "material": material(0.3), "velocity": (0, 0, -SPEED)}
    sides = [{"where": f"{axis}-lower", "fix": "normal"} for axis in "xy"]
    beside = (along // 2 + along // 4 + 1,) * 2
    if kind == "meshless":
        mesh = {"lower": (0, 0, bottom), "upper": (EDGE / 2, EDGE / 2, EDGE + bottom), "cells": (along // 2, along // 2, along)}
        return body | {"kind": "meshless-solid", "mesh": {"box": mesh}}, beside, sides
    shape = {"box": {"lower": (0, 0, bottom), "upper": (EDGE / 2, EDGE / 2, EDGE + bottom)}}
    return body | {"shape": shape}, beside, sides


def wall(kind, h):
    """A wall of the grid below the block; material points feel it as soon as they reach its nodes."""
    return 0.0, h if kind == "points" else 0.02 * h, {"support": [{"name": "floor", "where": "z-lower", "fix": "normal"}]}


def plate(kind, h):
    """A plate of elements half as long as the cells, held, two cells above the bottom of the grid: what the block touches."""
    along = round(EDGE / h)
    n, thickness = 2 * (along // 2 + along // 4) + 1, 1e-3 * h
    edge, height = 0.5 * n * h, 2.0 * h
    rectangle = {"corner": (0, 0, height - 0.5 * thickness), "first_edge": (edge, 0, 0), "second_edge": (0, edge, 0)}
    floor = {
        "name": "floor",
        "field": "floor",
        "kind": "membrane-elements",
        "surface": {"rectangle": rectangle | {"points": (n + 1, n + 1)}},
        "thickness": thickness,
        "material": {"kind": "linear-membrane", "density": DENSITY, "young_modulus": 1e3, "poisson_ratio": 0.0},
    }
    motion = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    return height, 0.02 * h, {"body": [floor], "motion": [motion], "contact": [{"between": ["block", "floor"]}]}


def bounce(make, size, kind, along, courant, lasting, floor=wall):
    """One row of the table: velocity of the centre of mass after the bounce over that before, times from the first touch."""
    h = size / along
    height, fall, more = floor(kind, h)
    body, beside, sides = make(kind, along, height + fall)
    end = lasting + fall / SPEED
    case = Case.model_validate(
        {
            "schema": 1,
            "title": "a block bounces",
            "grid": {"lower": (0, 0, 0), "upper": (beside[0] * h, beside[1] * h, (2 * along) * h), "cell": h},
            "time": {"end": end, "courant": courant},
            "energy": {"warn": 1e3, "stop": 1e4},
        }
        | more
        | {"body": [body | {"field": "block"}, *more.get("body", [])], "support": [*sides, *more.get("support", [])]}
    )
    began, simulation = time.perf_counter(), Simulation(case)
    times, speeds = [0.0], [-SPEED]
    while simulation.time < end * (1.0 - 1e-12):
        simulation.step()
        times.append(simulation.time)
        speeds.append(float(simulation.bodies[0].totals.momentum[2] / simulation.bodies[0].mass))
    t, v = np.array(times), np.array(speeds)

    def crossing(level):
        k = int(np.argmax(v > level))
        return t[k - 1] + (t[k] - t[k - 1]) * (level - v[k - 1]) / (v[k] - v[k - 1])

    touch, turn, leave = crossing(-0.95 * SPEED), crossing(0.0), crossing(0.95 * v[-1])
    energy = simulation.budget.conservation()["energy"]
    numbers = v[-1] / SPEED, 1e3 * (turn - touch), 1e3 * (leave - touch), energy
    wall = round(time.perf_counter() - began, 1)
    row = [make.__name__, floor.__name__, kind, along, courant, *(f"{number:.4g}" for number in numbers), len(t) - 1, wall]
    print(*row, flush=True)
    return row


def main(chosen):
    rows = []
    if "bar" in chosen:  # 2 L/c = 40 ms
        rows += [bounce(bar, LENGTH, "meshless", n, 0.5, 0.06) for n in (12, 24, 48, 96)]
        rows += [bounce(bar, LENGTH, "points", n, 0.5, 0.06) for n in (12, 24, 48, 96, 192)]
        rows += [bounce(bar, LENGTH, "points", 48, 0.1, 0.06)]
    if "cube" in chosen:
        rows += [bounce(cube, EDGE, "meshless", n, 0.5, 0.03) for n in (8, 16)]
        rows += [bounce(cube, EDGE, "points", n, 0.5, 0.03) for n in (8, 16, 32)]
    if "plate" in chosen:
        rows += [bounce(cube, EDGE, "meshless", n, 0.5, 0.03, plate) for n in (8, 16)]
        rows += [bounce(cube, EDGE, "points", n, 0.5, 0.03, plate) for n in (8, 16, 32)]
        rows += [bounce(cube, EDGE, "points", n, 0.2, 0.03, plate) for n in (8, 16)]
    return rows


if __name__ == "__main__":
    found = main(sys.argv[1:] or ["bar", "cube", "plate"])
    with open(Path(__file__).with_name("bounce.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *found])
