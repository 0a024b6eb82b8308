"""An elastic disc that flies through cells and swings a little: its energy with each of the functions, into fly.csv.

Nothing acts on it, so that kinetic and strain energy together stay as they are.
"""

import csv
from pathlib import Path

import pellucid
from pellucid.case import Case

FUNCTIONS = ("trilinear", "gimp", "quadratic-bspline", "cubic-bspline")
SOLID = {"kind": "neo-hookean", "density": 1000, "young_modulus": 4e6, "poisson_ratio": 0.3}


def energies(functions, cell):
    """Strain energy and kinetic energy [J] after 0.2 s and 1 s."""
    disc = {
        "name": "disc",
        "shape": {"cylinder": {"centre": [0.6, 0.7, 0], "radius": 0.4}},
        "points_per_cell": [3, 3, 1],
        "material": SOLID,
        "velocity": [2, 0, 0],
        "velocity_wave": {"amplitude": [0.1, 0.1, 0], "wave_vector": [6, 3, 0]},
    }
    grid = {"lower": [0, 0, 0], "upper": [4, 1.4, 0], "cell": cell, "functions": functions}
    case = Case.model_validate(
        {"schema": 1, "title": "A disc in flight", "grid": grid, "time": {"end": 1.0}, "body": [disc], "energy": {"stop": 10}}
    )
    history = pellucid.run(case, report=False, threads=1).history
    early = int(abs(history["time"] - 0.2).argmin())
    return [float(history[name][row]) for row in (early, -1) for name in ("strain_energy", "kinetic_energy")]


if __name__ == "__main__":
    with (Path(__file__).parent / "fly.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["cell [m]", "functions", "strain 0.2 s [J]", "kinetic 0.2 s [J]", "strain 1 s [J]", "kinetic 1 s [J]"])
        for cell in (0.05,):
            for functions in FUNCTIONS:
                writer.writerow([cell, functions, *(f"{value:.4g}" for value in energies(functions, cell))])
