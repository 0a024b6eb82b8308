"""A synthetic curve of an oocyte between plates, and the modulus that the membrane's equations find from it.

    python noisy.py > curve.csv

There is no measurement behind it: the force of the membrane with E = 17.9 kPa (`exact.py`), a quarter of it as for an eighth of
an oocyte, at twelve displacements, with normal noise of 3 % of the largest force (seed 1). The force is proportional to E if
the inflation is given, so that least squares are a mean with weights; the estimate and its standard deviation go to stderr.
"""

import csv
import sys
from pathlib import Path

import numpy as np

TABLE = Path(__file__).parents[2] / "src" / "pellucid" / "references" / "pressed_membrane.csv"
MODULUS, THICKNESS, RADIUS, GAP = 17.9e3, 8e-6, 50e-6, 0.2e-6
SHARE, SEED = 0.03, 1


def main() -> None:
    with TABLE.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    known, forces = ([float(row[name]) for row in rows] for name in ("displacement", "force"))
    displacements = np.linspace(2e-6, 16e-6, 12)
    of_unit = np.interp(displacements / RADIUS, known, forces) * THICKNESS * RADIUS / 4
    exact = of_unit * MODULUS
    deviation = SHARE * exact.max()
    noisy = exact + np.random.default_rng(SEED).normal(0.0, deviation, len(exact))
    print("plate [um],force [nN],deviation [nN]")
    for way, force in zip(displacements[::-1], noisy[::-1], strict=True):
        print(f"{-(way + GAP) * 1e6:.4f},{force * 1e9:.3f},{deviation * 1e9:.3f}")
    estimate = float(of_unit @ noisy / (of_unit @ of_unit))
    print(f"E = {estimate:.0f} Pa, standard deviation {deviation / np.sqrt(of_unit @ of_unit):.0f} Pa", file=sys.stderr)


if __name__ == "__main__":
    main()
