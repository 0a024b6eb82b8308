"""Reference curves of cells/sphere-inflation and cells/disc-inflation, from the energies of the laws alone.

    python validation/cells-inflation/exact.py sphere > src/pellucid/gallery/cells/sphere-inflation.csv
    python validation/cells-inflation/exact.py disc > src/pellucid/gallery/cells/disc-inflation.csv
    python validation/cells-inflation/exact.py table

W(λ₁, λ₂) of unit initial area over G is differentiated symbolically: T₁ = (1/λ₂) ∂W/∂λ₁ on unit of present length; no formula
for a tension is used. Lengths are over R₀, pressures over G/R₀.

A sphere has p = 2T/λ. A clamped disc is shot from its pole (Yang & Feng 1970, J. Appl. Mech. 37, 1002): along the initial
radius R

    r' = λ₁ cos θ,  z' = -λ₁ sin θ,  θ' = λ₁ (p - T₂ sin θ/r)/T₁,  (r T₁)' = T₂ λ₁ cos θ,  λ₂ = r/R

with λ₁ = λ₂ = the pole's stretch at R = 0, and p such that r(1) = 1. `table` has, with each state, the error of the balance of
forces along the axis at the rim, p π r² = 2π r T₁ sin θ, which the shooting does not use. Needs scipy and sympy.
"""

import sys

import numpy as np
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

a, b = sympy.symbols("a b", positive=True)
I, II = a**2 + b**2 + 1 / (a * b) ** 2, 1 / a**2 + 1 / b**2 + (a * b) ** 2
I1, I2 = a**2 + b**2 - 2, (a * b) ** 2 - 1


def mooney_rivlin(c):
    return (I - 3 + c * (II - 3)) / (2 * (1 + c))


SPHERES = {"neo-hookean": mooney_rivlin(0), "mooney-rivlin": mooney_rivlin(sympy.Rational(1, 5))}
DISCS = {
    "neo-hookean": mooney_rivlin(0),
    "mooney-rivlin": mooney_rivlin(sympy.Rational(1, 10)),
    "skalak": (I1**2 + 2 * I1 - 2 * I2 + I2**2) / 4,
}
LARGEST = {"neo-hookean": 3.1, "mooney-rivlin": 3.1, "skalak": 1.32}
"""The pole's stretches where curves end."""
TABLE = {"neo-hookean": (1.1, 1.5, 2.0, 2.25, 3.0), "mooney-rivlin": (2.0, 3.0), "skalak": (1.1, 1.3)}
START = 1e-5  # radius where the shooting begins


class Law:
    """Tensions and their slopes as functions of the stretches."""

    def __init__(self, W):
        T = sympy.diff(W, a) / b
        self.T, self.T_1, self.T_2 = (sympy.lambdify((a, b), each) for each in (T, sympy.diff(T, a), sympy.diff(T, b)))


def shoot(law, pole, p):
    """r, θ, λ₁, the height of the pole and the volume at the rim."""

    def slopes(R, y):
        r, theta, first, _, _ = y
        second, cos, sin = r / R, np.cos(theta), np.sin(theta)
        T1, T2 = law.T(first, second), law.T(second, first)
        second_grows = (first * cos - second) / R
        first_grows = ((T2 - T1) * first * cos / r - law.T_2(first, second) * second_grows) / law.T_1(first, second)
        return first * cos, first * (p - T2 * sin / r) / T1, first_grows, first * sin, np.pi * r * r * first * sin

    r = pole * START
    begin = (r, p * r / (2 * law.T(pole, pole)), pole, 0.0, 0.0)
    return solve_ivp(slopes, (START, 1.0), begin, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]


def disc(law, pole):
    """Pressure, height, volume, and the error of the balance of forces at the rim."""

    def rim(p):
        return shoot(law, pole, p)[0] - 1.0

    low = high = law.T(pole, pole) * 1e-3
    while rim(high) > 0.0:
        low, high = high, 1.3 * high
    p = brentq(rim, low, high, xtol=1e-13)
    r, theta, first, height, volume = shoot(law, pole, p)
    return p, height, volume, p * r / (2 * law.T(first, r) * np.sin(theta)) - 1.0


def main(what):
    if what == "sphere":
        laws = {name: Law(W) for name, W in SPHERES.items()}
        print("stretch [m]," + ",".join(f"{name} [Pa]" for name in laws))
        for stretch in np.linspace(1.0, 2.15, 116):
            print(f"{stretch:.2f}," + ",".join(f"{2 * law.T(stretch, stretch) / stretch:.8g}" for law in laws.values()))
    elif what == "disc":
        print(",".join(f"{name} pole [1],{name} pressure [Pa],{name} height [m],{name} volume [m^3]" for name in DISCS))
        curves = []
        for name, W in DISCS.items():
            law, poles = Law(W), np.linspace(1.0, LARGEST[name], 89)[1:]
            curves += np.transpose([(pole, *disc(law, pole)[:3]) for pole in poles]).tolist()
        for row in zip(*curves, strict=True):
            print(",".join(f"{value:.7g}" for value in row))
    else:
        for name, poles in TABLE.items():
            for pole in poles:
                print(name, pole, *(f"{value:.6g}" for value in disc(Law(DISCS[name]), pole)))


if __name__ == "__main__":
    main(sys.argv[1])
