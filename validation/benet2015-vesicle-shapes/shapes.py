"""Bending energies of vesicles of revolution by solving the shape equations of Seifert, Berndl & Lipowsky 1991.

Prolate and oblate ones, symmetric about their equator: half a meridian from pole to equator, by collocation. Writes
energies.csv beside this script, in half a minute.
"""

import csv
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid, solve_bvp
from scipy.optimize import brentq

HERE = Path(__file__).parent
CASES = [("prolate", v) for v in (0.95, 0.90, 0.80, 0.70, 0.65)] + [("oblate", v) for v in (0.80, 0.65, 0.60)]
STEPS = {"prolate": np.linspace(0.97, 0.65, 65), "oblate": np.linspace(0.97, 0.60, 75)}
POLE = 1e-4  # arc length at which the equations begin, of the whole
TOLERANCE = 1e-7


def slopes(t, y, p):
    """Of angle ψ, its rate U, multiplier γ, radius r, area, volume and energy (over κ) along t = s/S; p: length S, pressure P,
    tension Σ."""
    psi, U, gamma, r = y[:4]
    length, pressure, tension = p
    sine, cosine = np.sin(psi), np.cos(psi)
    return length * np.array(
        [
            U,
            -U * cosine / r + cosine * sine / r**2 + gamma * sine / r + 0.5 * pressure * r * cosine,
            0.5 * U**2 - 0.5 * sine**2 / r**2 + pressure * r * sine + tension,
            cosine,
            2.0 * np.pi * r,
            np.pi * r**2 * sine,
            np.pi * r * (U + sine / r) ** 2,
        ]
    )


def ends(start, end, p, v):
    """At the pole a cap of curvature U; at the equator ψ = π/2 and γ = 0; area 4π and volume 4π v/3 in all."""
    first = POLE * p[0]
    return np.array(
        [
            start[0] - start[1] * first,
            start[2] - p[2] * first,
            start[3] - first,
            start[4] - np.pi * first**2,
            start[5],
            start[6] - 4.0 * np.pi * start[1] ** 2 * 0.5 * first**2,
            end[0] - 0.5 * np.pi,
            end[2],
            end[4] - 2.0 * np.pi,
            end[5] - 2.0 * np.pi / 3.0 * v,
        ]
    )


def spheroid(branch, v):
    """A first guess: t, the seven along it, and parameters as of a sphere that is about to buckle (P = 12, Σ = -6)."""

    def meridian(ratio):
        angle = np.linspace(0.0, 0.5 * np.pi, 4001)
        r, z = np.sin(angle), -ratio * np.cos(angle)
        ds = np.hypot(np.gradient(r, angle), np.gradient(z, angle))
        s = cumulative_trapezoid(ds, angle, initial=0.0)
        psi = np.unwrap(np.arctan2(np.gradient(z, angle), np.gradient(r, angle)))
        psi[0], psi[-1] = 0.0, 0.5 * np.pi
        area = cumulative_trapezoid(2.0 * np.pi * r, s, initial=0.0)
        volume = cumulative_trapezoid(np.pi * r**2 * np.sin(psi), s, initial=0.0)
        return s, psi, r, area, volume

    def missing(ratio):
        area, volume = (2.0 * of[-1] for of in meridian(ratio)[3:])
        return 6.0 * np.sqrt(np.pi) * volume / area**1.5 - v

    ratio = brentq(missing, *((1.01, 8.0) if branch == "prolate" else (0.05, 0.99)))
    s, psi, r, area, volume = meridian(ratio)
    size = np.sqrt(2.0 * np.pi / area[-1])
    s, r, area, volume = size * s, size * r, size**2 * area, size**3 * volume
    U = np.gradient(psi, s)
    bend = np.where(r > 0.0, U + np.sin(psi) / np.maximum(r, 1e-12), 2.0 * U)
    energy = cumulative_trapezoid(np.pi * r * bend**2, s, initial=0.0)
    t = np.linspace(POLE, 1.0, 400)
    along = (psi, U, -6.0 * np.sin(psi) * np.cos(psi), r, area, volume, energy)
    return t, np.array([np.interp(t, s / s[-1], of) for of in along]), np.array([s[-1], 12.0, -6.0])


def energies(branch):
    """Energy over 8πκ at each of the reduced volumes of a branch, from a spheroid on."""
    found, guess = {}, None
    for v in STEPS[branch]:
        if guess is None:
            guess = spheroid(branch, v)
        solution = solve_bvp(
            slopes, lambda a, b, p, v=v: ends(a, b, p, v), guess[0], guess[1], guess[2], tol=TOLERANCE, max_nodes=200000
        )
        if not solution.success:
            raise RuntimeError(f"{branch}, v = {v:g}: {solution.message}")
        guess = solution.x, solution.y, solution.p
        found[round(float(v), 3)] = 2.0 * solution.y[6, -1] / (8.0 * np.pi)
    return found


def main():
    """The table."""
    of = {branch: energies(branch) for branch in STEPS}
    with (HERE / "energies.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["branch", "reduced_volume", "energy"])
        for branch, v in CASES:
            rows.writerow([branch, f"{v:g}", f"{of[branch][v]:.6f}"])
            print(branch, v, of[branch][v])


if __name__ == "__main__":
    main()
