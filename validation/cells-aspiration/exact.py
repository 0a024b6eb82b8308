"""Reference curves of cells/aspiration.

    python validation/cells-aspiration/exact.py > src/pellucid/gallery/cells/aspiration.csv
    python validation/cells-aspiration/exact.py formula > src/pellucid/gallery/cells/aspiration-formula.csv
    python validation/cells-aspiration/exact.py table

A disc of Evans' and Skalak's law is drawn into a smooth tube of radius 1 with a sharp mouth in a smooth plane, G = 1. Its cap
is shot from the pole: along the initial radius s

    r' = λ₁ cos θ,  z' = λ₁ sin θ,  θ' = λ₁ (p - T₂ sin θ/r)/T₁,  (r T₁)' = T₂ λ₁ cos θ,  λ₂ = r/s

until it touches the wall, θ = 90° at r = 1, for a stretch of the pole; this gives p. On the wall T₁ stays as it is and λ₂ =
1/s; on the plane (r T₁)' = T₂ r', and the rim is free, T₁ = 0, which gives the length of the wall. Times are those of the
case, in which the suction p grows with the square of the time. The formula 2 l - 1 + ln 2 l takes the cap for a hemisphere
and the area for constant. Needs scipy.
"""

import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

END, LARGEST = 80.0, 7.2  # s and Pa of the case
EXACT = {"rtol": 1e-9, "atol": 1e-11}


def tensions(first, second, K):
    shear = (first**2 - second**2) / (2 * (first * second) ** 2)
    return K * (first * second - 1) + shear, K * (first * second - 1) - shear


def stretch_of(T, second, K):
    """λ₁ for a tension T₁, by Newton's method."""
    first = 1 / second
    for _ in range(60):
        first -= (tensions(first, second, K)[0] - T) / (K * second + first**-3)
    return first


def shoot(pole, p, K):
    """Initial radius, r, λ₁ and height where the cap is upright."""

    def slopes(s, y):
        r, theta, first, _ = y
        second, cos, sin = r / s, np.cos(theta), np.sin(theta)
        T1, T2 = tensions(first, second, K)
        second_grows = (first * cos - second) / s
        first_grows = ((T2 - T1) * first * cos / r - (K * first - second**-3) * second_grows) / (K * second + first**-3)
        return first * cos, first * (p - T2 * sin / r) / T1, first_grows, first * sin

    def upright(s, y):
        return y[1] - np.pi / 2

    upright.terminal = True
    start = 1e-4
    begin = (pole * start, p * pole * start / (2 * tensions(pole, pole, K)[0]), pole, 0.0)
    found = solve_ivp(slopes, (start, 5.0), begin, events=upright, method="DOP853", **EXACT)
    return found.t[-1], *found.y[[0, 2, 3], -1]


def state(strain, K, rim):
    """Suction, length and height of the cap, for a share by which the pole's area has grown; rim: initial radius."""
    pole = np.sqrt(1 + strain)
    guesses = np.geomspace(0.3, 6.0, 25) * tensions(pole, pole, K)[0]
    off = [shoot(pole, p, K)[1] - 1 for p in guesses]
    ends = next((a, b) for a, b, u, v in zip(guesses, guesses[1:], off, off[1:], strict=False) if u * v < 0 and abs(u - v) < 3)
    p = brentq(lambda p: shoot(pole, p, K)[1] - 1, *ends)
    s, _, first, height = shoot(pole, p, K)
    T = tensions(first, 1 / s, K)[0]

    def at_the_rim(wall):
        def along(z, y):
            return [1 / stretch_of(T, 1 / y[0], K)]

        mouth = solve_ivp(along, (0, wall), [s], **EXACT).y[0, -1] if wall > 0 else s

        def plane(s, y):
            first = stretch_of(y[1], y[0] / s, K)
            return first, (tensions(first, y[0] / s, K)[1] - y[1]) * first / y[0]

        return solve_ivp(plane, (mouth, rim), [1.0, T], **EXACT).y[1, -1]

    wall = brentq(at_the_rim, 0.0, 8.0) if at_the_rim(0.0) * at_the_rim(8.0) < 0 else np.nan
    return p, height + wall, height


def formula(length):
    return 2 * length - 1 + np.log(2 * length)


def time_of(p):
    return END * np.sqrt(p / LARGEST)


def main(what):
    if what == "formula":
        print("time [s],length [m],suction [Pa]")
        for length in np.linspace(1.0, 3.1, 22):
            print(f"{time_of(formula(length)):.6g},{length:.2f},{formula(length):.6g}")
        return
    K, rim = 100.0, 10.0
    curve = np.array([state(strain, K, rim) for strain in np.arange(0.7, 4.0, 0.1) / K])
    curve = curve[np.isfinite(curve[:, 1])]
    if what == "table":
        for K, rim in ((100.0, 10.0), (100.0, 8.0), (1000.0, 100.0)):
            curve = np.array([state(strain, K, rim) for strain in np.arange(0.7, 4.0, 0.1) / K])
            curve = curve[np.isfinite(curve[:, 1])]
            for length in (1.0, 2.0, 3.0):
                p, height = (np.interp(length, curve[:, 1], curve[:, column]) for column in (0, 2))
                row = (K, rim, length, round(p, 4), round(height, 4), round(p / formula(length) - 1, 4), round(time_of(p), 3))
                print(*row)
        return
    print("time [s],length [m],suction [Pa],height of the cap [m]")
    for p, length, height in curve:
        print(f"{time_of(p):.6g},{length:.6g},{p:.6g},{height:.6g}")


if __name__ == "__main__":
    main((sys.argv[1:] or ["curve"])[0])
