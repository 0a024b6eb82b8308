"""A liquid-filled elastic membrane, a sphere at the start, pressed between two smooth rigid plates: force against displacement.

    python exact.py table > ../../src/pellucid/references/pressed_membrane.csv
    python exact.py checks

The sheet is a chain of cones from the pole to the equator. Its elastic energy and that of the liquid are minimised with no
node above the plate, by Newton's method; the set of nodes on the plate follows from the sign of their forces. `checks` compares
with three independent solutions:

1. Shooting of the equations of the membrane (W. W. Feng & W. H. Yang 1973, J. Appl. Mech. 40, 209; T. J. Lardner &
   P. Pujara 1980, Mechanics Today 5, 161). psi is the angle on the sphere at rest, a0 its radius, t the slope. On the plate

       r' = a0 l1,  T1' = (T2 - T1) r'/r,  l2 = r/(a0 sin psi),

   and from the rim of the plate's contact to the equator

       r' = a0 l1 cos t,  z' = a0 l1 sin t,  t' = a0 l1 (P - T2 sin(t)/r)/T1,  T1' = (T2 - T1) r'/r.

   The stretch of the pole and the pressure P are such that t = 90 degrees at the equator and the liquid keeps its volume. The
   force is P pi rc^2 with the radius rc of the contact.
2. A drop, whose tension is the same everywhere: sin t = re (r^2 - rc^2)/(r (re^2 - rc^2)), with the radius re of the equator;
   its height and its volume are quadratures. The chain has the energy of such a film, tension times area, and a
   thousandth of the sheet's.
3. Work: the force is the slope of the energy against the height of the plate.

The law is W = mu/2 (l1^2 + l2^2 + l3^2 - 3) - mu ln J + lambda/2 (ln J)^2 on unit of volume at rest in plane stress, the
compressible neo-Hookean solid. Lengths are over the radius a at the start, tensions over E h, forces over E h a and pressures
over E h/a. h is the thickness at the start, when the sheet is stretched by 1 + inflation; at rest it is h/l3. The displacement
is that of one plate from first touch on. Heights are those of the mid-surface: the face of the plate lies half a thickness of
the sheet above it, which is taken to stay as it is. Needs scipy.
"""

import sys
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

POISSON_RATIO, INFLATION = 0.49, 0.02
DISPLACEMENTS = np.arange(1, 41) * 0.01
HEADER = "# validation/cells-oocyte-between-plates: lengths over a, forces over E h a, pressures over E h/a"
CONES, FINE, BULK, STEP, LEAST = 100, 200, 1e5, 0.02, 1e-3
ACCURATE = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}


class NeoHookean:
    """Energy of unit volume at rest over E, and its derivatives, as functions of the stretches."""

    def __init__(self, poisson_ratio: float) -> None:
        self.mu = 0.5 / (1 + poisson_ratio)
        self.lam = poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))

    def third(self, l1, l2):
        """l3 at which no stress acts across the sheet, by Newton's method."""
        third = (l1 * l2) ** (-self.lam / (self.lam + 2 * self.mu))
        for _ in range(8):
            off = self.mu * (third**2 - 1) + self.lam * np.log(l1 * l2 * third)
            third = third - off / (2 * self.mu * third + self.lam / third)
        return third

    def derivatives(self, l1, l2):
        """W, W_1, W_2, W_11, W_12, W_22 with l3 eliminated."""
        mu, lam, l3 = self.mu, self.lam, self.third(l1, l2)
        log = np.log(l1 * l2 * l3)
        W = mu / 2 * (l1**2 + l2**2 + l3**2 - 3) - mu * log + lam / 2 * log**2
        c = lam * log - mu
        W33 = mu + (lam - c) / l3**2
        W13, W23, W12 = lam / (l1 * l3), lam / (l2 * l3), lam / (l1 * l2)
        W11, W22 = mu + (lam - c) / l1**2 - W13**2 / W33, mu + (lam - c) / l2**2 - W23**2 / W33
        return W, mu * l1 + c / l1, mu * l2 + c / l2, W11, W12 - W13 * W23 / W33, W22


class Film(NeoHookean):
    """A film of the tension 1, W = J with the change of area J, in a skin so soft that it only keeps the nodes apart."""

    softness = 1e-3

    def derivatives(self, l1, l2):
        film = l1 * l2, l2, l1, 0.0, 1.0, 0.0
        return tuple(a + self.softness * b for a, b in zip(film, super().derivatives(l1, l2), strict=True))


class Sheet(NamedTuple):
    law: object
    inflation: float = 0.0

    @property
    def at_rest(self):
        """Thickness at rest over that at the start."""
        return 1 / self.law.third(1 + self.inflation, 1 + self.inflation)

    def tensions(self, l1, l2):
        """T1, T2 and the slopes of T1."""
        _, W1, W2, W11, W12, _ = self.law.derivatives(l1, l2)
        h = self.at_rest
        return h * W1 / l2, h * W2 / l1, h * W11 / l2, h * (W12 - W1 / l2) / l2

    @property
    def pressure(self):
        """That of the sphere at the start."""
        return 2 * self.tensions(1 + self.inflation, 1 + self.inflation)[0]


class Pressed(NamedTuple):
    displacement: float
    force: float
    pressure: float
    contact: float  # radius
    equator: float  # radius
    energy: float
    rim: float  # angle on the sphere at rest
    pole: float  # stretch


class Chain:
    """Half a sphere of cones, pressed farther and farther. `bulk`: of the liquid over E h/a."""

    def __init__(self, sheet: Sheet, n: int = CONES, bulk: float = BULK) -> None:
        self.sheet, self.n, self.bulk, self.begin = sheet, n, bulk, sheet.pressure
        self.angles = np.linspace(0, np.pi / 2, n + 1)
        sphere = np.stack([np.sin(self.angles), np.cos(self.angles)], axis=1)
        rest = sphere / (1 + sheet.inflation)
        self.length = np.hypot(*np.diff(rest, axis=0).T)
        self.middle = 0.5 * (rest[1:, 0] + rest[:-1, 0])
        self.weight = 2 * np.pi * self.middle * self.length * sheet.at_rest
        self.numbers = 2 * np.arange(n)[:, None] + np.arange(4)
        self.x, self.volume = sphere, self._volume(sphere)[0].sum()
        self.on_plate, self.pressed = np.zeros(n + 1, bool), 0.0

    def press(self, displacement: float) -> Pressed:
        """The state of least energy, in several steps if far. Raises RuntimeError where Newton's method finds none."""
        steps = max(1, int(np.ceil(abs(displacement - self.pressed) / STEP - 1e-9)))
        for way in np.linspace(self.pressed, displacement, steps + 1)[1:]:
            found = self._press(float(way))
        self.pressed = displacement
        return found

    def _press(self, displacement: float) -> Pressed:
        height, held = 1 - displacement, np.zeros(2 * self.n + 2, bool)
        held[[0, 2 * self.n + 1]] = True
        x, on = self.x.copy(), self.on_plate.copy()
        for _ in range(300):
            on |= x[:, 1] > height
            x[on, 1] = height
            U, g, H, pressure = self._energy(x)
            free = ~held
            free[1::2] &= ~on
            step = np.zeros(2 * self.n + 2)
            step[free] = descend(H[np.ix_(free, free)], g[free])
            share = min(1.0, 0.02 / np.abs(step).max())
            while share > LEAST and self._energy(x + share * step.reshape(-1, 2), alone=True) > U + 1e-4 * share * g @ step:
                share /= 2
            x = x + share * step.reshape(-1, 2)
            if np.abs(step).max() < 1e-10 and not np.any(x[:, 1] > height + 1e-12):
                pulled = on & (self._energy(x)[1][1::2] > 1e-12)
                if not pulled.any():
                    break
                on[np.flatnonzero(pulled)[-1]] = False
        else:
            raise RuntimeError(f"no equilibrium at {displacement:g}")
        self.x, self.on_plate = x, on
        U, g, _, pressure = self._energy(x)
        force, last = -float(g[1::2][on].sum()), int(np.flatnonzero(on)[-1])
        contact, pole = np.sqrt(force / (np.pi * pressure)), np.hypot(*(x[1] - x[0])) / self.length[0]
        rim = np.interp(contact, x[: last + 2, 0], self.angles[: last + 2])
        return Pressed(displacement, force, float(pressure), float(contact), float(x[-1, 0]), float(U), float(rim), float(pole))

    def _volume(self, x):
        a, b, d = x[:-1, 0], x[1:, 0], x[:-1, 1] - x[1:, 1]
        q = np.pi / 3 * (a * a + a * b + b * b)
        return q * d, np.pi / 3 * np.stack([(2 * a + b) * d, 3 / np.pi * q, (2 * b + a) * d, -3 / np.pi * q], axis=1)

    def _energy(self, x, alone=False):
        """Energy of sheet and liquid, its gradient and second derivatives, the pressure."""
        along = np.diff(x, axis=0)
        now = np.hypot(*along.T)
        stretches = now / self.length, 0.5 * (x[1:, 0] + x[:-1, 0]) / self.middle
        W, W1, W2, W11, W12, W22 = self.sheet.law.derivatives(*stretches)
        volumes, of_volume = self._volume(x)
        more = volumes.sum() / self.volume - 1
        U = self.weight @ W - self.begin * more * self.volume + 0.5 * self.bulk * more**2 * self.volume
        if alone:
            return U
        pressure = self.begin - self.bulk * more
        unit = along / now[:, None]
        first = np.concatenate([-unit, unit], axis=1) / self.length[:, None]
        second = np.zeros((self.n, 4))
        second[:, [0, 2]] = 0.5 / self.middle[:, None]
        turn = (np.eye(2) - unit[:, :, None] * unit[:, None, :]) / (now * self.length)[:, None, None]
        bend = np.block([[turn, -turn], [-turn, turn]])
        g, H, liquid = np.zeros(2 * self.n + 2), np.zeros((2 * self.n + 2,) * 2), np.zeros(2 * self.n + 2)
        np.add.at(g, self.numbers, self.weight[:, None] * (W1[:, None] * first + W2[:, None] * second))
        np.add.at(liquid, self.numbers, of_volume)
        a, b, d = x[:-1, 0], x[1:, 0], x[:-1, 1] - x[1:, 1]
        curved = np.zeros((self.n, 4, 4))
        for i, j, value in ((0, 0, 2 * d), (2, 2, 2 * d), (0, 2, d), (0, 1, 2 * a + b), (0, 3, -2 * a - b)):
            curved[:, i, j] = curved[:, j, i] = np.pi / 3 * value
        for i, j, value in ((2, 1, 2 * b + a), (2, 3, -2 * b - a)):
            curved[:, i, j] = curved[:, j, i] = np.pi / 3 * value
        own = W1[:, None, None] * bend
        for w, u, v in ((W11, first, first), (W22, second, second), (W12, first, second), (W12, second, first)):
            own = own + (w[:, None] * u)[:, :, None] * v[:, None, :]
        own = self.weight[:, None, None] * own - pressure * curved
        np.add.at(H, (self.numbers[:, :, None], self.numbers[:, None, :]), own)
        return U, g - pressure * liquid, H + self.bulk / self.volume * np.outer(liquid, liquid), pressure


def descend(H, g):
    """The step of Newton's method, with as much of the unit matrix as makes H positive definite."""
    shift = 0.0
    while True:
        try:
            L = np.linalg.cholesky(H + shift * np.eye(len(H)))
            return -np.linalg.solve(L.T, np.linalg.solve(L, g))
        except np.linalg.LinAlgError:
            shift = max(4 * shift, 1e-6)


def shoot(sheet: Sheet, rim: float, pole: float, pressure: float):
    """l1, r, height, slope and volume at the equator, and the radius of contact."""
    a0, start = 1 / (1 + sheet.inflation), 1e-5

    def flat(psi, y):
        l1, r = y
        l2 = r / (a0 * np.sin(psi))
        T1, T2, T11, T12 = sheet.tensions(l1, l2)
        grows = (l1 - l2 * np.cos(psi)) / np.sin(psi)
        return ((T2 - T1) * a0 * l1 / r - T12 * grows) / T11, a0 * l1

    def free(psi, y):
        l1, r, _, slope, _ = y
        l2, out, down = r / (a0 * np.sin(psi)), a0 * l1 * np.cos(slope), a0 * l1 * np.sin(slope)
        T1, T2, T11, T12 = sheet.tensions(l1, l2)
        grows = (out / a0 - l2 * np.cos(psi)) / np.sin(psi)
        turns = a0 * l1 * (pressure - T2 * np.sin(slope) / r) / T1
        return ((T2 - T1) * out / r - T12 * grows) / T11, out, down, turns, np.pi * r**2 * down

    l1, contact = solve_ivp(flat, (start, rim), [pole, pole * a0 * np.sin(start)], **ACCURATE).y[:, -1]
    return solve_ivp(free, (rim, np.pi / 2), [l1, contact, 0.0, 0.0, 0.0], **ACCURATE).y[:, -1], contact


def shot(sheet: Sheet, near: Pressed) -> tuple[float, float, float]:
    """Displacement, force and pressure of the state with the rim of another one, by shooting from a guess near it.

    Raises RuntimeError where Newton's method does not find it.
    """

    def off(x):
        end, _ = shoot(sheet, near.rim, *x)
        return np.array([end[3] - np.pi / 2, 2 * end[4] / (4 / 3 * np.pi) - 1])

    x = np.array([near.pole, near.pressure])
    value = off(x)
    for _ in range(30):
        if np.abs(value).max() < 1e-7:
            end, contact = shoot(sheet, near.rim, *x)
            return 1 - end[2], x[1] * np.pi * contact**2, x[1]
        slopes = np.transpose([(off(x + d) - value) / 1e-7 for d in np.eye(2) * 1e-7])
        step = np.linalg.solve(slopes, -value)
        for _ in range(8):
            trial = off(x + step)
            if np.linalg.norm(trial) < np.linalg.norm(value):
                break
            step = step / 2
        x, value = x + step, trial
    raise RuntimeError(f"shooting finds no state near {near.displacement:g}")


def drop(displacement: float) -> tuple[float, float]:
    """Force and radius of contact of a drop of radius 1 and tension 1."""

    def shape(rc, re):
        def slope(u):  # r = re - u^2; dr = 2 u du
            r = re - u * u
            sine = re * (r * r - rc * rc) / (r * (re * re - rc * rc))
            return r, 2 * u * sine / np.sqrt(max(1 - sine**2, 1e-300))

        end = np.sqrt(re - rc)
        height = quad(lambda u: slope(u)[1], 0, end, epsrel=1e-11)[0]
        volume = quad(lambda u: np.pi * slope(u)[0] ** 2 * slope(u)[1], 0, end, epsrel=1e-11)[0]
        return height, 2 * volume / (4 / 3 * np.pi)

    def wide(rc):
        return brentq(lambda re: shape(rc, re)[1] - 1, max(1, rc) + 1e-9, 2 + rc, xtol=1e-14)

    contact = brentq(lambda rc: 1 - shape(rc, wide(rc))[0] - displacement, 1e-3, 1.5, xtol=1e-13)
    re = wide(contact)
    return 2 * re / (re**2 - contact**2) * np.pi * contact**2, contact


def checks() -> None:
    sheet = Sheet(NeoHookean(POISSON_RATIO), INFLATION)
    print("refinement: displacement, then force, pressure and equator on 25, 50, 100, 200 cones")
    ways, coarse = (0.04, 0.08, 0.16, 0.24, 0.32), {}
    for n in (25, 50, 100, 200):
        chain = Chain(sheet, n)
        coarse[n] = [chain.press(way) for way in ways]
    for i, way in enumerate(ways):
        print(way, *(f"{getattr(coarse[n][i], name):.6f}" for name in ("force", "pressure", "equator") for n in coarse))
    print("shooting: displacement, force, pressure, and the chain's at the same displacement")
    chain = Chain(sheet, FINE)
    for near in coarse[CONES]:
        way, force, pressure = shot(sheet, near)
        found = chain.press(way)
        print(*(f"{value:.6f}" for value in (way, force, pressure, found.force, found.pressure)), flush=True)
    print("work: slope of the energy, and the force")
    chain = Chain(sheet)
    for way in (0.08, 0.24):
        low, at, high = (chain.press(way + d) for d in (-1e-4, 0.0, 1e-4))
        print(way, f"{(high.energy - low.energy) / 2e-4:.6f} {at.force:.6f}")
    print("drop: displacement, force exact and of the chain; radius of contact")
    chain = Chain(Sheet(Film(POISSON_RATIO)))
    for way in (0.02, 0.08, 0.16, 0.24, 0.32):
        (force, contact), found = drop(way), chain.press(way)
        print(way, f"{force:.6f} {found.force:.6f} {contact:.5f} {found.contact:.5f}", flush=True)


def table() -> None:
    sheet = Sheet(NeoHookean(POISSON_RATIO), INFLATION)
    chain = Chain(sheet, FINE)
    print(HEADER)
    print("displacement,force,pressure,contact,equator")
    print(f"0,0,{sheet.pressure:.6g},0,1")
    for way in DISPLACEMENTS:
        found = chain.press(way)
        print(",".join(f"{value:.6g}" for value in found[:5]))


if __name__ == "__main__":
    checks() if sys.argv[1:] == ["checks"] else table()
