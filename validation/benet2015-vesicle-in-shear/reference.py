"""A film in a channel of viscous fluid, the same inside and out, in the plane and without inertia: boundary integrals.

The film's forces on the fluid, ∂(T t)/∂s + κ (c'' + c³/2) n with c the curvature and n outward, make the velocity of Stokes
flow by the free-space solution and what the plates add to it, which is found by Fourier series along the channel. Nodes go
with the film; derivatives are spectral, and the logarithm of the free-space solution is integrated by the rule of Kress (Linear
Integral Equations, 3rd ed., §12.3). Nothing of pellucid is used.

Run as `reference.py [nodes] [step]`; writes `reference.csv`.
"""

import sys
from pathlib import Path

import numpy as np

RADII, PLATES, SHEAR, VISCOSITY = (1.25, 0.8), 2.5, 1.0, 1.0
STIFFNESS, BENDING, FILM_VISCOSITY = 100.0, 0.2, 0.1  # aρ₀ [N/m], κ [N m for a metre of depth], 2μ + λ of the film
END, EVERY = 2.0, 0.1
PERIOD, WAVES = 40.0, 512  # of the series along the channel


class Channel:
    """What plates at ±H add to the flow of forces on a closed curve."""

    def __init__(self, half: float) -> None:
        self.half = half
        self.x = PERIOD * (np.arange(WAVES) / WAVES - 0.5)
        wave = 2.0 * np.pi * np.fft.fftfreq(WAVES, PERIOD / WAVES)
        self.used = np.flatnonzero((np.abs(wave) * half < 25.0) & (wave != 0.0))
        self.wave = wave[self.used]
        rows = [part for y in (half, -half) for part in self._basis(np.full(len(self.wave), y))]
        self.inverse = np.linalg.inv(np.stack(rows, axis=1))

    def _basis(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """u and v of the four solutions ψ = cosh ky, sinh ky, y sinh ky, y cosh ky, scaled by exp(-|k| H)."""
        k, small = self.wave, np.exp(-np.abs(self.wave) * self.half)
        c, s = np.cosh(k * y) * small, np.sinh(k * y) * small
        u = np.stack([k * s, k * c, s + k * y * c, c + k * y * s], axis=-1)
        return u, -1j * k[..., None] * np.stack([c, s, y * s, y * c], axis=-1)

    def velocity(self, place: np.ndarray, at_plates: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """At places, shape (n, 2), of the flow that takes back these velocities at the upper and lower plate."""
        wanted = -np.fft.fft(np.concatenate(at_plates, axis=1), axis=0)
        factor = np.einsum("kij,kj->ki", self.inverse, wanted[self.used])
        u, v = self._basis(place[:, 1:2])
        phase = np.exp(1j * self.wave * (place[:, :1] - self.x[0]))
        upper, lower = wanted[0, 0].real, wanted[0, 2].real  # of the mean flow
        mean = 0.5 * (upper + lower) + 0.5 * (upper - lower) * place[:, 1] / self.half
        along, across = (((of * factor).sum(axis=-1) * phase).sum(axis=1).real for of in (u, v))
        return np.stack([along + mean, across], axis=1) / WAVES


class Film:
    """A closed curve of n nodes, counterclockwise."""

    def __init__(self, place: np.ndarray) -> None:
        n = len(place)
        self.angle, self.wave = 2.0 * np.pi * np.arange(n) / n, np.fft.fftfreq(n, 1.0 / n)
        m = np.arange(1, n // 2)
        weight = -4.0 * np.pi / n * (np.cos(np.outer(self.angle, m)) / m).sum(axis=1)
        weight -= 4.0 * np.pi / n**2 * np.cos(n // 2 * self.angle)
        j = np.arange(n)
        self.logarithm = weight[(j[:, None] - j[None, :]) % n]
        self.chord = 4.0 * np.sin(0.5 * (self.angle[:, None] - self.angle[None, :])) ** 2
        np.fill_diagonal(self.chord, 1.0)
        self.place, self.channel, self.moving = place, Channel(PLATES), np.zeros_like(place)
        self.at_rest = np.linalg.norm(self.slope(place), axis=1)

    def slope(self, values: np.ndarray) -> np.ndarray:
        """d/dθ of values at the nodes, shape (n, ...)."""
        wave = np.where(np.abs(self.wave) == len(self.wave) // 2, 0.0, self.wave)
        flat = values.reshape(len(values), -1)
        return np.fft.ifft(1j * wave[:, None] * np.fft.fft(flat, axis=0), axis=0).real.reshape(values.shape)

    def force(self, place: np.ndarray) -> np.ndarray:
        """On the fluid, for unit of θ."""
        along = self.slope(place)
        speed = np.linalg.norm(along, axis=1)
        tangent = along / speed[:, None]
        normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
        curvature = -np.einsum("ni,ni->n", self.slope(tangent), normal) / speed
        bent = self.slope(self.slope(curvature) / speed) / speed
        rate = np.einsum("ni,ni->n", self.slope(self.moving), tangent) / speed
        tension = STIFFNESS * (1.0 - self.at_rest / speed) + FILM_VISCOSITY * rate
        across = speed * BENDING * (bent + 0.5 * curvature**3)
        return self.slope(tension[:, None] * tangent) + across[:, None] * normal

    def velocity(self, place: np.ndarray) -> np.ndarray:
        """Of the nodes."""
        force, along, n = self.force(place), self.slope(place), len(place)
        speed = np.linalg.norm(along, axis=1)
        apart = place[:, None] - place[None]
        square = np.einsum("ijk,ijk->ij", apart, apart)
        np.fill_diagonal(square, 1.0)
        smooth = -0.5 * np.log(square / self.chord)
        np.fill_diagonal(smooth, -np.log(speed))
        dyad = np.einsum("ijk,jk->ij", apart, force)[..., None] * apart / square[..., None]
        tangent = along / speed[:, None]
        dyad[np.arange(n), np.arange(n)] = tangent * np.einsum("nk,nk->n", tangent, force)[:, None]
        step = 2.0 * np.pi / n
        own = (step * (smooth @ force + dyad.sum(axis=1)) - 0.5 * self.logarithm @ force) / (4.0 * np.pi * VISCOSITY)
        x = self.channel.x
        plates = tuple(self._free(np.stack([x, np.full_like(x, y)], axis=1), place, force) for y in (PLATES, -PLATES))
        shear = SHEAR * np.stack([place[:, 1], np.zeros(n)], axis=1)
        self.moving = own + self.channel.velocity(place, plates) + shear
        return self.moving

    @staticmethod
    def _free(at: np.ndarray, place: np.ndarray, force: np.ndarray) -> np.ndarray:
        """The free-space flow of the forces at other places."""
        apart = at[:, None] - place[None]
        square = np.einsum("ijk,ijk->ij", apart, apart)
        dyad = np.einsum("ijk,jk->ij", apart, force)[..., None] * apart / square[..., None]
        every = (-0.5 * np.log(square)[..., None] * force[None] + dyad).sum(axis=1)
        return every * (2.0 * np.pi / len(place)) / (4.0 * np.pi * VISCOSITY)

    def advance(self, step: float) -> None:
        """By the midpoint rule; waves in the upper third of those that the nodes bear are taken out."""
        half = self.place + 0.5 * step * self.velocity(self.place)
        waves = np.fft.fft(self.place + step * self.velocity(half), axis=0)
        waves[np.abs(self.wave) > len(self.wave) / 3] = 0.0
        self.place = np.fft.ifft(waves, axis=0).real

    def shape(self) -> tuple[float, float, float]:
        """Deformation and inclination [°] of the ellipse with the same second moments of area; length."""
        x, y = self.place.T
        dx, dy = self.slope(self.place).T
        step = 2.0 * np.pi / len(x)
        area = step * np.sum(x * dy)
        middle = step * np.sum(x * x * dy) / (2.0 * area), -step * np.sum(y * y * dx) / (2.0 * area)
        xx = step * np.sum(x**3 * dy) / (3.0 * area) - middle[0] ** 2
        yy = -step * np.sum(y**3 * dx) / (3.0 * area) - middle[1] ** 2
        xy = step * np.sum(x * x * y * dy) / (2.0 * area) - middle[0] * middle[1]
        square, axes = np.linalg.eigh([[xx, xy], [xy, yy]])
        short, long = np.sqrt(square)
        angle = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
        return (long - short) / (long + short), (angle + 90.0) % 180.0 - 90.0, step * np.hypot(dx, dy).sum()


def evenly(n: int) -> np.ndarray:
    """Nodes at equal distances on the ellipse."""
    angle = np.linspace(0.0, 2.0 * np.pi, 40001)
    curve = np.stack([RADII[0] * np.cos(angle), RADII[1] * np.sin(angle)], axis=1)
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1)))
    angle = np.interp(np.arange(n) / n * along[-1], along, angle)
    return np.stack([RADII[0] * np.cos(angle), RADII[1] * np.sin(angle)], axis=1)


def main(n: int = 64, step: float = 5e-4) -> None:
    film, lines = Film(evenly(n)), ["time,deformation,angle,length"]
    steps, between = round(END / step), round(EVERY / step)
    for number in range(steps + 1):
        if number % between == 0:
            lines.append(f"{number * step:.6g}," + ",".join(f"{value:.6f}" for value in film.shape()))
            print(lines[-1], flush=True)
        film.advance(step)
    Path(__file__).with_name("reference.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False)))
