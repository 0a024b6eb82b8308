"""Radius, volume and pressure of a slice of a bag blown up by gas that keeps its temperature, on unit of length.

    python reference.py --circumference 0.6 --stiffness 1e5 --poisson 0.3 --gas 500

A section of the circumference C becomes a circle, R0 = C/2 pi. Its hoop strain is e = p R (1 - nu^2)/(E t) with R = R0 (1 + e)
between planes that keep its length (small strains). The gas has p pi R^2 = G, with G = m R_gas T on unit of length [N].
"""

import argparse
from math import pi


def blown_up(circumference: float, stiffness: float, poisson_ratio: float, gas: float) -> tuple[float, float, float]:
    """Radius [m], volume [m^2] on unit of length, and pressure [Pa]; `stiffness` is E t [N/m], `gas` m R T on length [N]."""
    start = radius = circumference / (2 * pi)
    for _ in range(100):
        pressure = gas / (pi * radius**2)
        radius = start * (1 + pressure * radius * (1 - poisson_ratio**2) / stiffness)
    return radius, pi * radius**2, gas / (pi * radius**2)


def main() -> None:
    parser = argparse.ArgumentParser()
    for name in ("circumference", "stiffness", "poisson", "gas"):
        parser.add_argument(f"--{name}", type=float, required=True)
    chosen = parser.parse_args()
    radius, volume, pressure = blown_up(chosen.circumference, chosen.stiffness, chosen.poisson, chosen.gas)
    print(f"{radius:.6g} m, {volume:.6g} m^3/m, {pressure:.6g} Pa")


if __name__ == "__main__":
    main()
