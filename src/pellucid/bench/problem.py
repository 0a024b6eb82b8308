"""The problem that is measured: a closed box full of points, eight a cell, through which a sine wave runs."""

import math
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
SPEED = {"ideal-gas": 3.0, "hypoelastic": 0.5, "neo-hookean": 0.5}  # m/s, amplitude of the wave


def bench_case(body: str, points: int, **time: Any) -> Case:
    """A cube of about `points` points of the material called `body`; `time` holds further fields of `[time]`."""
    cells = max(2, round((points / POINTS_PER_CELL) ** (1 / 3)))
    edge = cells * CELL
    corner = [edge, edge, edge]
    return Case.model_validate(
        {
            "schema": 1,
            "title": f"Benchmark: {body}",
            "grid": {"lower": [0.0, 0.0, 0.0], "upper": corner, "cell": CELL},
            "time": {"end": 1.0, **time},
            "energy": {
                "warn": 1e9,
                "stop": 1e9,
            },  # speed is measured here; of small waves in a hot gas little energy moves, and its relative error is large
            "body": [
                {
                    "kind": "material-points",
                    "name": "block",
                    "shape": {"box": {"lower": [0.0, 0.0, 0.0], "upper": corner}},
                    "points_per_cell": POINTS_PER_CELL,
                    "material": MATERIALS[body],
                    "velocity_wave": {
                        "amplitude": [SPEED[body], 0.0, 0.0],
                        "wave_vector": [math.tau / edge, 0.0, 0.0],
                    },
                }
            ],
            "support": [{"where": f"{axis}-{end}", "fix": "normal"} for axis in "xyz" for end in ("lower", "upper")],
        }
    )
