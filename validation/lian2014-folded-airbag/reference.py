"""Radius, volume and pressure of a slice of a bag blown up by gas that keeps its temperature, on unit of length.

    python reference.py --circumference 0.6 --stiffness 1e5 --poisson 0.3 --gas 500
    python reference.py table > ../../src/pellucid/gallery/lian2014/folded-airbag.csv

A section of the circumference C becomes a circle, R0 = C/2 pi. Its hoop strain is e = p R (1 - nu^2)/(E t) with R = R0 (1 + e)
between planes that keep its length (small strains). The gas has p pi R^2 = G, with G = m R_gas T on unit of length [N].
"""

import argparse
import sys
from math import pi

CIRCUMFERENCE, LENGTH, STIFFNESS, POISSON_RATIO = 0.59901, 0.02, 1e7 * 0.002, 0.3  # [m, m, N/m]; of lian2014/folded-airbag
GAS = (1.5333e-3 * 0.015 + 2.001e-8) * 287.05 * 300.0  # m R T of what flows in and of what the folded bag contains [J]


def blown_up(circumference: float, stiffness: float, poisson_ratio: float, gas: float) -> tuple[float, float, float]:
    """Radius [m], volume [m^2] on unit of length, and pressure [Pa]; `stiffness` is E t [N/m], `gas` m R T on length [N]."""
    start = radius = circumference / (2 * pi)
    for _ in range(100):
        pressure = gas / (pi * radius**2)
        radius = start * (1 + pressure * radius * (1 - poisson_ratio**2) / stiffness)
    return radius, pi * radius**2, gas / (pi * radius**2)


def table() -> str:
    """Return the bag of lian2014/folded-airbag at rest as a table for its plot."""
    radius, volume, pressure = blown_up(CIRCUMFERENCE, STIFFNESS, POISSON_RATIO, GAS / LENGTH)
    row = f"{2 * radius:.6g},{volume * LENGTH:.6g},{pressure:.6g}"
    head = "# validation/lian2014-folded-airbag/reference.py table\ntime [s],diameter [m],volume [m^3],pressure [Pa]"
    return f"{head}\n0.02,{row}\n0.1,{row}"


def main() -> None:
    if sys.argv[1:] == ["table"]:
        print(table())
        return
    parser = argparse.ArgumentParser()
    for name in ("circumference", "stiffness", "poisson", "gas"):
        parser.add_argument(f"--{name}", type=float, required=True)
    chosen = parser.parse_args()
    radius, volume, pressure = blown_up(chosen.circumference, chosen.stiffness, chosen.poisson, chosen.gas)
    print(f"{radius:.6g} m, {volume:.6g} m^3/m, {pressure:.6g} Pa")


if __name__ == "__main__":
    main()
