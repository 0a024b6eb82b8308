"""Reference curves of gan2011/piezo-icsi-held: an axisymmetric membrane full of liquid, held and pushed at its poles.

    python validation/gan2011-piezo-icsi-held/exact.py 5 > src/pellucid/gallery/gan2011/held-at-rest-tip.csv
    python validation/gan2011-piezo-icsi-held/exact.py 12.5 > src/pellucid/gallery/gan2011/held-at-rest-cell.csv
    python validation/gan2011-piezo-icsi-held/exact.py table

The meridian of a sphere is a chain of cones. Their energy of unit initial area is that of the linear membrane, Eh/2(1 - ν²)
(e₁² + 2ν e₁e₂ + e₂²) with logarithmic strains, which the rates of strain along fixed principal axes add up to. (The
membrane's stress is that slope per present volume, less than .3 % off: ν/(1 - ν) = .96.) The liquid has the bulk modulus
ρc² of the case; suction acts on the part in the mouth, whose rim is held. A disc about the pole, of the given radius in um,
moves as a whole by the depth: the force on it is the slope of the least energy. A chain without any resistance to bending
crumples where it is compressed, link by link: a hundredth of what a zona of this thickness has keeps it smooth. Lengths in
um, energies in Eh um². Needs scipy.
"""

import sys

import numpy as np
from scipy.optimize import minimize

E, THICKNESS, NU = 17900.0, 8e-6, 0.49
STIFFNESS = E * THICKNESS  # N/m
RADIUS, MOUTH, TIP = 50.0, 20.0, 5.0  # um
SUCTION, BULK = 200.0, 1000 * 4.0**2  # Pa
PRESSURE = 1e-6 / STIFFNESS  # of one Pa, in Eh/um
FORCE = STIFFNESS * 1e-6  # of one Eh um, in N
BENDING = 0.01 * 64.0 / 12 / (1 - NU**2)  # um²


def stretching(first, last, length, width):
    """Energies of cones between places (r, z), their slopes and second slopes."""
    d = last - first
    long = np.linalg.norm(d, axis=1)
    e1, e2 = np.log(long / length), np.log((first[:, 0] + last[:, 0]) / width)
    k = np.pi * width * length / (2 * (1 - NU**2))
    t = d / long[:, None]
    along = np.concatenate([-t, t], axis=1) / long[:, None]  # slope of e1
    around = np.array([1.0, 0, 1, 0]) / (first[:, 0] + last[:, 0])[:, None]  # of e2
    turning = np.tile((np.eye(2) - 2 * t[:, :, None] * t[:, None, :]) / (long**2)[:, None, None], (1, 2, 2))
    turning *= np.kron([[1, -1], [-1, 1]], np.ones((2, 2)))
    f1, f2 = 2 * k * (e1 + NU * e2), 2 * k * (e2 + NU * e1)
    second = outer(2 * k, along, along) + outer(2 * k, around, around) - outer(f2, around, around)
    second += outer(2 * NU * k, along, around) + outer(2 * NU * k, around, along) + f1[:, None, None] * turning
    return k * (e1**2 + 2 * NU * e1 * e2 + e2**2), f1[:, None] * along + f2[:, None] * around, second


def volumes(first, last):
    """Volumes between cones and the axis."""
    (r, a), (s, b) = first.T, last.T
    wide, tall, zero = r * r + r * s + s * s, b - a, np.zeros(len(r))
    slope = np.stack([tall * (2 * r + s), -wide, tall * (2 * s + r), wide], axis=1)
    second = [
        [2 * tall, -(2 * r + s), tall, 2 * r + s],
        [-(2 * r + s), zero, -(2 * s + r), zero],
        [tall, -(2 * s + r), 2 * tall, 2 * s + r],
        [2 * r + s, zero, 2 * s + r, zero],
    ]
    return np.pi / 3 * tall * wide, np.pi / 3 * slope, np.pi / 3 * np.moveaxis(np.array(second), 2, 0)


def bending_of(x, turn, weight):
    """Energies at the nodes between two cones, for the angle by which the meridian turns there."""
    off, slope, second = -turn, np.zeros((len(turn), 6)), np.zeros((len(turn), 6, 6))
    for sign, i in ((-1, 0), (1, 1)):
        d = x[i + 1 : len(x) - 1 + i] - x[i : len(x) - 2 + i]
        square = (d**2).sum(axis=1)
        off = off + sign * np.arctan2(d[:, 1], d[:, 0])
        normal = np.stack([-d[:, 1], d[:, 0]], axis=1) / square[:, None]
        cross, even = 2 * d[:, 0] * d[:, 1] / square**2, (d[:, 1] ** 2 - d[:, 0] ** 2) / square**2
        curved = np.moveaxis(np.array([[cross, even], [even, -cross]]), 2, 0)
        at = slice(2 * i, 2 * i + 4)
        slope[:, at] += sign * np.concatenate([-normal, normal], axis=1)
        second[:, at, at] += sign * np.tile(curved, (1, 2, 2)) * np.kron([[1, -1], [-1, 1]], np.ones((2, 2)))
    off = (off + np.pi) % (2 * np.pi) - np.pi
    return (
        weight * off**2,
        (2 * weight * off)[:, None] * slope,
        outer(2 * weight, slope, slope) + (2 * weight * off)[:, None, None] * second,
    )


def outer(factor, a, b):
    return factor[:, None, None] * a[:, :, None] * b[:, None, :]


class Chain:
    """The meridian, from the pushed pole at -z to the one in the mouth; `disc` is an initial radius [um]."""

    def __init__(self, disc, cells=200, bending=BENDING, bulk=BULK, suction=SUCTION):
        self.suction, self.bulk = suction * PRESSURE, bulk * PRESSURE
        edge, rim = np.arcsin(disc / RADIUS), np.pi - np.arcsin(MOUTH / RADIUS)
        share = np.linspace(0.0, 1.0, cells + 1)
        parts = [np.linspace(0, edge, 6), edge + (rim - edge) * (0.3 * share + 0.7 * share**2)]  # finer at the disc
        parts.append(np.linspace(rim, np.pi, cells // 4 + 1))
        angle = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        self.start = RADIUS * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
        self.start[[0, -1], 0] = 0.0
        self.disc, hold = angle <= edge + 1e-12, np.abs(angle - rim) < 1e-12
        self.mouth = angle[:-1] >= rim - 1e-12
        fixed = np.repeat((self.disc | hold)[:, None], 2, axis=1)
        fixed[-1, 0] = True
        self.free = np.flatnonzero(~fixed.ravel())
        n = len(angle)
        self.pairs = np.arange(4) + 2 * np.arange(n - 1)[:, None]
        self.triples = np.arange(6) + 2 * np.arange(n - 2)[:, None]
        x = self.start
        self.length, self.width = np.linalg.norm(np.diff(x, axis=0), axis=1), x[:-1, 0] + x[1:, 0]
        along = 0.5 * (self.length[:-1] + self.length[1:])
        a, b = np.diff(x, axis=0)[:-1], np.diff(x, axis=0)[1:]
        self.turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
        self.weight = 0.5 * bending * 2 * np.pi * x[1:-1, 0] / along
        self.full = volumes(x[:-1], x[1:])[0].sum()

    def assembled(self, x):
        """Energy, slope and second slope of everything."""
        n = x.size
        parts = [
            summed(stretching(x[:-1], x[1:], self.length, self.width), self.pairs, n),
            summed(bending_of(x, self.turn, self.weight), self.triples, n),
        ]
        enclosed = volumes(x[:-1], x[1:])
        V, dV, ddV = summed(enclosed, self.pairs, n)
        cap = summed([(value.T * self.mouth).T for value in enclosed], self.pairs, n)
        pressure = -self.bulk * (V / self.full - 1)
        self.pressure = pressure / PRESSURE
        energy = sum(part[0] for part in parts) + 0.5 * self.bulk * (V - self.full) ** 2 / self.full - self.suction * cap[0]
        slope = sum(part[1] for part in parts) - pressure * dV - self.suction * cap[1]
        second = sum(part[2] for part in parts) - pressure * ddV - self.suction * cap[2]
        second += self.bulk / self.full * np.outer(dV, dV)
        return energy, slope, second

    def pushed(self, depths):
        """States at depths [um] one after the other, else in SI units; largest strains of the pushed half and in the mouth."""
        x = self.start.copy()
        for depth in depths:
            x[self.disc, 1] = self.start[self.disc, 1] + depth
            x = self.relaxed(x)
            _, slope, _ = self.assembled(x)
            yield {
                "depth": depth,
                "stored": self.stored(x),
                "force": slope.reshape(-1, 2)[self.disc, 1].sum() * FORCE,
                "pressure": self.pressure,
                "strain": self.strains(x)[:, self.start[1:, 1] < 0].max(),
                "mouth": self.strains(x)[:, self.mouth].max(),
                "drawn": 1e-6 * (x[-1, 1] - self.start[-1, 1]),
            }

    def stored(self, x):
        """Energy of the zona [J]."""
        return stretching(x[:-1], x[1:], self.length, self.width)[0].sum() * FORCE * 1e-6

    def strains(self, x):
        d = np.linalg.norm(np.diff(x, axis=0), axis=1)
        return np.log(np.stack([d / self.length, (x[:-1, 0] + x[1:, 0]) / self.width]))

    def relaxed(self, x):
        kept = {}

        def at(free):
            key = free.tobytes()
            if key not in kept:
                kept.clear()
                y = x.ravel().copy()
                y[self.free] = free
                energy, slope, second = self.assembled(y.reshape(-1, 2))
                kept[key] = energy, slope[self.free], second[np.ix_(self.free, self.free)]
            return kept[key]

        found = minimize(
            lambda v: at(v)[0],
            x.ravel()[self.free],
            jac=lambda v: at(v)[1],
            hess=lambda v: at(v)[2],
            method="trust-exact",
            options={"gtol": 1e-7, "initial_trust_radius": 1.0, "max_trust_radius": 50.0, "maxiter": 500},
        )
        if not found.success and np.abs(found.jac).max() > 1e-5:
            print("not converged:", found.message, np.abs(found.jac).max(), file=sys.stderr)
        y = x.ravel().copy()
        y[self.free] = found.x
        return y.reshape(-1, 2)


def summed(values, places, n):
    """Energies of parts, their slopes and second slopes at all nodes."""
    slope, second = np.zeros(n), np.zeros((n, n))
    np.add.at(slope, places, values[1])
    np.add.at(second, (places[:, :, None], places[:, None, :]), values[2])
    return values[0].sum(), slope, second


def main(what):
    if what == "table":
        for disc, cells, bending in ((5, 200, 1), (5, 100, 1), (12.5, 200, 1), (12.5, 100, 1), (12.5, 100, 0.1), (20, 100, 1)):
            print(f"disc {disc} um, {cells} cones, bending {bending * BENDING:.4f} um²")
            for state in Chain(disc, cells, bending * BENDING).pushed(np.arange(0.0, 20.5, 0.5)):
                if state["depth"] in (1, 2, 5, 7.5, 10, 12.5, 15, 20):
                    print("  ", *(f"{name} {value:.4g}" for name, value in state.items()), flush=True)
        return
    print("depth [m],force [N],pressure [Pa],energy [J]")
    for state in Chain(float(what)).pushed(np.arange(0.0, 20.5, 0.5)):
        print(f"{state['depth'] * 1e-6:.4g},{state['force']:.5g},{state['pressure']:.5g},{state['stored']:.5g}")


if __name__ == "__main__":
    main(sys.argv[1])
