"""Benchmark problems: a closed box filled with eight points per cell and a sine wave; a free sheet."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from pellucid.case import Case

POINTS_PER_CELL = 8
CELL = 0.01  # m
DENSITY = 1000.0  # kg/m^3
PRESSURE = 1.0e5  # Pa
YOUNG_MODULUS = 1.0e6  # Pa

SOLID = {"density": DENSITY, "young_modulus": YOUNG_MODULUS, "poisson_ratio": 0.3}
MATERIALS: dict[str, dict[str, Any]] = {
    "ideal-gas": {
        "kind": "fluid",
        "density": DENSITY,
        "pressure": PRESSURE,
        "eos": {"kind": "ideal-gas", "gamma": 1.4},
        "artificial_viscosity": {"quadratic": 2.0, "linear": 1.0},
        "energy_update": "closed",
    },
    "hypoelastic": {"kind": "linear-elastic", **SOLID},
    "neo-hookean": {"kind": "neo-hookean", **SOLID},
}
MEMBRANES = "membrane-points", "membrane-elements"
SPEED = {"ideal-gas": 3.0, "hypoelastic": 0.5, "neo-hookean": 0.5}  # m/s, amplitude of the wave


def case_of(points: int, body: str, functions: str = "trilinear", transfer: str = "flip") -> Case:
    """Build the benchmark case of a body: a name in `MATERIALS` (a cube of material points with this material) or in
    `MEMBRANES` (a square sheet).

    points: approximate number of points. functions, transfer: shape functions of the grid and velocity transfer, as in a case;
    for sheets, the defaults are used.
    """
    return sheet_case(body, points) if body in MEMBRANES else bench_case(body, points, functions, transfer=transfer)


def problem(name: str, bodies: list[dict[str, Any]], time: Mapping[str, Any] = MappingProxyType({}), **more: Any) -> Case:
    """Build a benchmark case. name: text for the title of the case. bodies: tables `[[body]]`. time: further fields of
    `[time]`. more: further tables of the case, by key.

    Energy limits are disabled because small waves in a hot gas exchange little energy, so that the relative error is large.
    """
    limits = {"time": {"end": 1.0, **time}, "energy": {"warn": 1e9, "stop": 1e9}}
    return Case.model_validate({"schema": 1, "title": f"Benchmark: {name}", **limits, "body": bodies, **more})


def grid(lower: list[float], upper: list[float], functions: str = "trilinear") -> dict[str, Any]:
    """Return the `[grid]` table of a case for a grid between two corners [m]. functions: kind of its shape functions."""
    return {"lower": lower, "upper": upper, "cell": CELL, "functions": functions}


def sheet(kind: str, corner: list[float], edge: float, along: int) -> dict[str, Any]:
    """Return the `[[body]]` table of a square sheet. kind: kind of membrane. corner: lower corner of the sheet [m]. edge:
    edge length [m]. along: number of points along an edge."""
    edges = {"first_edge": [edge, 0.0, 0.0], "second_edge": [0.0, edge, 0.0]}
    surface = {"rectangle": {"corner": corner, **edges, "points": [along, along]}}
    law = {"kind": "linear-membrane", **SOLID}
    return {"kind": kind, "name": "sheet", "surface": surface, "thickness": 0.1 * CELL, "material": law}


def bench_case(body: str, points: int, functions: str = "trilinear", **time: Any) -> Case:
    """Build the case of a cube of about `points` material points in a closed box, with the material named `body`. functions:
    kind of shape functions of the grid; `time`: further fields of `[time]`."""
    cells = max(2, round((points / POINTS_PER_CELL) ** (1 / 3)))
    edge = cells * CELL
    lower, upper = [0.0, 0.0, 0.0], [edge, edge, edge]
    block = {
        "kind": "material-points",
        "name": "block",
        "shape": {"box": {"lower": lower, "upper": upper}},
        "points_per_cell": POINTS_PER_CELL,
        "material": MATERIALS[body],
        "velocity_wave": {"amplitude": [SPEED[body], 0.0, 0.0], "wave_vector": [math.tau / edge, 0.0, 0.0]},
    }
    walls = [{"where": f"{axis}-{end}", "fix": "normal"} for axis in "xyz" for end in ("lower", "upper")]
    return problem(body, [block], time, grid=grid(lower, upper, functions), support=walls)


def sheet_case(kind: str, points: int) -> Case:
    """Build the case of a freely moving square sheet of about `points` membrane points or element nodes (`kind`), half a cell
    apart."""
    along = max(3, round(points**0.5))
    corner, high = [2.0 * CELL, 2.0 * CELL, 0.0], (math.ceil((along - 1) / 2) + 4) * CELL
    moving = {**sheet(kind, corner, 0.5 * (along - 1) * CELL, along), "velocity": [0.0, 0.0, 0.1]}
    return problem(kind, [moving], grid=grid([0.0, 0.0, -4.0 * CELL], [high, high, 4.0 * CELL]))
