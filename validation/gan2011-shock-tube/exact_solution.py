"""Two independent checks of the exact Riemann solver that the tubes are compared with.

1. Jump residuals: mass, momentum and energy across the shock, pressure and velocity across the contact, entropy and
   Riemann invariant through the fan.
2. A finite-volume scheme of our own (HLLC fluxes, linear reconstruction with a minmod limiter, two-stage Runge-Kutta)
   that knows nothing of the exact solution must converge to it.

    python exact_solution.py        writes jumps.csv and finite_volume.csv beside this file
"""

import csv
from pathlib import Path

import numpy as np

from pellucid.references.gas_dynamics import GasState, solve

HERE = Path(__file__).parent
TUBES = {  # left and right (density, velocity, pressure), gamma, end
    "gan2011": ((1.0, 0.0, 1.0), (0.125, 0.0, 0.001), 1.4, 0.143),
    "sod": ((1.0, 0.0, 1.0), (0.125, 0.0, 0.1), 1.4, 0.2),
    "strong": ((1.0, 0.0, 10.0), (0.02, 0.0, 0.001), 5.0 / 3.0, 0.04),
}


def jumps(left, right, gamma):
    """Relative residuals of every condition that the solution must satisfy."""
    a, b = GasState(*left, gamma), GasState(*right, gamma)
    s = solve(a, b)
    star = GasState(s.right_wave.density, s.velocity, s.pressure, gamma)
    shock = s.right_wave.head

    def fluxes(g):
        w = g.velocity - shock
        return np.array([g.density * w, g.pressure + g.density * w**2, g.internal_energy + g.pressure / g.density + 0.5 * w**2])

    ahead, behind = fluxes(b), fluxes(star)
    found = dict(zip(("mass", "momentum", "enthalpy"), np.abs(behind / ahead - 1.0), strict=True))
    inside = s.sample(np.linspace(*s.left_wave[:2], 101))
    entropy = inside["pressure"] / inside["density"] ** gamma
    invariant = inside["velocity"] + 2.0 * np.sqrt(gamma * inside["pressure"] / inside["density"]) / (gamma - 1.0)
    found["fan entropy"] = np.ptp(entropy) / entropy[0]
    found["fan invariant"] = np.ptp(invariant) / invariant[0]
    below, above = (s.sample(s.velocity + d) for d in (-1e-9, 1e-9))
    found["contact pressure"] = abs(below["pressure"] / above["pressure"] - 1.0)
    found["contact velocity"] = abs(below["velocity"] / above["velocity"] - 1.0)
    return found


def primitive(u, gamma):
    rho, m, e = u
    v = m / rho
    return np.array([rho, v, (gamma - 1.0) * (e - 0.5 * rho * v**2)])


def conserved(w, gamma):
    rho, v, p = w
    return np.array([rho, rho * v, p / (gamma - 1.0) + 0.5 * rho * v**2])


def hllc(l, r, gamma):
    """Toro's HLLC flux between primitive states, shape (3, faces)."""

    def flux(w):
        u = conserved(w, gamma)
        return np.array([u[1], u[1] * w[1] + w[2], (u[2] + w[2]) * w[1]])

    cl, cr = (np.sqrt(gamma * w[2] / w[0]) for w in (l, r))
    sl, sr = np.minimum(l[1] - cl, r[1] - cr), np.maximum(l[1] + cl, r[1] + cr)
    top = r[2] - l[2] + l[0] * l[1] * (sl - l[1]) - r[0] * r[1] * (sr - r[1])
    sm = top / (l[0] * (sl - l[1]) - r[0] * (sr - r[1]))

    def star(w, s):
        factor = w[0] * (s - w[1]) / (s - sm)
        energy = conserved(w, gamma)[2] / w[0] + (sm - w[1]) * (sm + w[2] / (w[0] * (s - w[1])))
        return factor * np.array([np.ones_like(sm), sm, energy])

    fl, fr = flux(l), flux(r)
    left = fl + sl * (star(l, sl) - conserved(l, gamma))
    right = fr + sr * (star(r, sr) - conserved(r, gamma))
    return np.where(sl >= 0, fl, np.where(sm >= 0, left, np.where(sr > 0, right, fr)))


def finite_volume(left, right, gamma, end, cells):
    """Cell means (3, cells) of density, velocity, pressure at the end, on [0, 1] with the diaphragm in the middle."""
    x = (np.arange(cells) + 0.5) / cells
    u = conserved(np.where(x < 0.5, np.array(left)[:, None], np.array(right)[:, None]), gamma)
    h, t = 1.0 / cells, 0.0

    def rate(u):
        w = primitive(np.pad(u, ((0, 0), (2, 2)), mode="edge"), gamma)
        d = np.diff(w, axis=1)
        slope = 0.5 * (np.sign(d[:, 1:]) + np.sign(d[:, :-1])) * np.minimum(np.abs(d[:, 1:]), np.abs(d[:, :-1]))
        low, high = w[:, 1:-1] - 0.5 * slope, w[:, 1:-1] + 0.5 * slope
        return -np.diff(hllc(high[:, :-1], low[:, 1:], gamma), axis=1) / h

    while t < end:
        w = primitive(u, gamma)
        dt = min(0.4 * h / np.max(np.abs(w[1]) + np.sqrt(gamma * w[2] / w[0])), end - t)
        first = u + dt * rate(u)
        u = 0.5 * (u + first + dt * rate(first))
        t += dt
    return primitive(u, gamma)


def exact_means(left, right, gamma, end, cells, samples=64):
    x = (np.arange(cells)[:, None] + (np.arange(samples) + 0.5) / samples) / cells
    fields = solve(GasState(*left, gamma), GasState(*right, gamma)).sample((x - 0.5) / end)
    return [fields[name].mean(axis=1) for name in ("density", "velocity", "pressure")]


if __name__ == "__main__":
    with (HERE / "jumps.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["tube", "condition", "relative residual"])
        for name, (left, right, gamma, _) in TUBES.items():
            for condition, residual in jumps(left, right, gamma).items():
                writer.writerow([name, condition, f"{residual:.2e}"])
    with (HERE / "finite_volume.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["tube", "cells", "density", "velocity", "pressure", "order of density"])
        for name, (left, right, gamma, end) in TUBES.items():
            before = None
            for cells in (200, 400, 800, 1600, 3200):
                found = finite_volume(left, right, gamma, end, cells)
                exact = exact_means(left, right, gamma, end, cells)
                errors = [np.abs(f - e).sum() / np.abs(e).sum() for f, e in zip(found, exact, strict=True)]
                order = f"{np.log2(before / errors[0]):.2f}" if before else ""
                writer.writerow([name, cells, *(f"{e:.3e}" for e in errors), order])
                before = errors[0]
