"""Oscillation of a plane drop in a liquid of the same density and viscosity, independent of the package.

python reference.py              the drop of drop.toml: periods for several viscosities and amplitudes (six minutes)
python reference.py smoothing    the same with smoothed forces and motion of the surface (two minutes)
python reference.py exact        small oscillations in an unbounded liquid, exact, and in a box of edge 2 (two minutes)

Navier-Stokes equations in a periodic box. Since the drop is symmetric, the faces of the box are slip walls. The vorticity is
a Fourier series of n x n terms (products on the grid, without the upper third); the surface is a closed curve of markers,
whose derivatives along the curve are spectral too. The tension σ dt/ds of the curve with the unit tangent t is transformed to
the series by a sum over the markers, and the series is summed at the markers for their velocity. Fourth order Runge-Kutta
steps, with the viscosity integrated exactly.

The initial velocity (g x, -g y) inside the drop and 0 outside has a jump along the normal of the surface. The curl of this
field starts the computation, so the jump disappears as in a liquid that is suddenly incompressible.
"""

import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ive, kve

RADIUS, TENSION, DENSITY = 0.1875, 1.0, 1.0
RAYLEIGH = 2.0 * np.pi * np.sqrt(2.0 * DENSITY * RADIUS**3 / (6.0 * TENSION))  # both liquids unbounded and inviscid


def oscillate(
    viscosity: float,
    gradient: float = 4.0,
    n: int = 128,
    dt: float = 2e-4,
    end: float = 0.36,
    variance: float = 0.0,
    edge: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and the difference x² - y² of the second moments of the drop, divided by R², shape (steps + 1,).

    viscosity: of both liquids [Pa s]; gradient: g of the initial velocity [1/s]; n: terms along an axis, and number of
    markers; variance: width σ² of a Gaussian kernel [m²] by half of which the force of the surface is smoothed, and by half
    its motion; edge: of the box [m].
    """
    number = np.fft.fftfreq(n, 1.0 / n)
    k = 2.0 * np.pi / edge * number
    kx, ky = k[:, None], k[None, :]
    squares = kx**2 + ky**2
    inverse = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > 0.0)
    kept = (np.abs(number)[:, None] < n / 3) & (np.abs(number)[None, :] < n / 3)
    cut = kept * np.exp(-36.0 * (np.sqrt(squares) / (k.max() * 2.0 / 3.0)) ** 12)
    surface = cut * np.exp(-0.25 * variance * squares)
    shift = np.exp(0.5j * k * edge)
    shift = shift[:, None] * shift[None, :]  # the grid begins at -edge/2

    fine = 8 * n
    x = (np.arange(fine) / fine - 0.5) * edge
    inside = x[:, None] ** 2 + x[None, :] ** 2 < RADIUS**2
    rows = number.astype(int) % fine
    u, v = (
        shift * np.fft.fft2(inside * field)[np.ix_(rows, rows)] / fine**2
        for field in (gradient * x[:, None], -gradient * x[None, :])
    )
    vorticity = cut * 1j * (kx * v - ky * u)

    marker = np.fft.fftfreq(n, 1.0 / n)
    along = 1j * marker
    along[n // 2] = 0.0
    smooth = np.exp(-36.0 * (np.abs(marker) / (n / 2)) ** 16)
    place = RADIUS * np.exp(2j * np.pi * np.arange(n) / n)

    def derivative(values: np.ndarray) -> np.ndarray:
        return np.fft.ifft(along * np.fft.fft(values))

    def on_grid(series: np.ndarray) -> np.ndarray:
        return np.fft.ifft2(series * shift.conj()).real * n**2

    def rates(vorticity: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u, v = 1j * ky * vorticity * inverse, -1j * kx * vorticity * inverse
        ex, ey = np.exp(1j * np.outer(k, place.real)), np.exp(1j * np.outer(k, place.imag))
        moves = [np.einsum("km,km->m", ex, (surface * field) @ ey).real for field in (u, v)]
        tangent = derivative(place)
        pull = TENSION / DENSITY / edge**2 * derivative(tangent / np.abs(tangent)) * (2.0 * np.pi / n)
        fx, fy = ((ex.conj() * part) @ ey.conj().T for part in (pull.real, pull.imag))
        w = on_grid(vorticity)
        flux = [np.fft.fft2(on_grid(field) * w) * shift / n**2 for field in (u, v)]
        gained = -1j * kept * (kx * flux[0] + ky * flux[1]) + surface * 1j * (kx * fy - ky * fx)
        return gained, moves[0] + 1j * moves[1]

    half = np.exp(-0.5 * viscosity / DENSITY * squares * dt)
    steps = round(end / dt)
    moments = np.zeros(steps + 1)
    for step in range(steps + 1):
        slope = derivative(place)
        moment = np.mean(place.real**3 * slope.imag + place.imag**3 * slope.real) * 2.0 * np.pi / 3.0
        moments[step] = moment / (np.pi * RADIUS**4)
        w1, z1 = rates(vorticity, place)
        w2, z2 = rates(half * (vorticity + 0.5 * dt * w1), place + 0.5 * dt * z1)
        w3, z3 = rates(half * vorticity + 0.5 * dt * w2, place + 0.5 * dt * z2)
        w4, z4 = rates(half * half * vorticity + dt * half * w3, place + dt * z3)
        vorticity = half * half * vorticity + dt / 6.0 * (half * half * w1 + 2.0 * half * (w2 + w3) + w4)
        place = np.fft.ifft(smooth * np.fft.fft(place + dt / 6.0 * (z1 + 2.0 * z2 + 2.0 * z3 + z4)))
    return dt * np.arange(steps + 1), moments


def exact(viscosity: float, gradient: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and moments as `oscillate` does, for small amplitudes in an unbounded liquid.

    A radial force cos 2θ on the circle moves it at the rate of the inviscid liquid times G(s) = 1 - 4 I₂(mR) K₂(mR), with the
    variable s of the Laplace transform, m² = ρ s/μ and modified Bessel functions. With the frequency ω of Rayleigh and Lamb,
    the moments are the inverse transform of g/2 G/(s² + ω² G), computed by Talbot's method with fixed points.
    """

    def transform(s: np.ndarray) -> np.ndarray:
        m = RADIUS * np.sqrt(DENSITY * s / viscosity + 0j)
        slowed = 1.0 - 4.0 * ive(2, m) * kve(2, m) * np.exp(np.abs(m.real) - m)
        return 0.5 * gradient * slowed / (s * s + (2.0 * np.pi / RAYLEIGH) ** 2 * slowed)

    count, time = 40, np.linspace(0.0, 0.36, 181)
    angle = np.arange(1, count) * np.pi / count
    cotangent = 1.0 / np.tan(angle)
    slope = angle + (angle * cotangent - 1.0) * cotangent
    moments = np.zeros(len(time))
    for i, t in enumerate(time[1:], 1):
        r = 2.0 * count / (5.0 * t)
        s = r * angle * (cotangent + 1j)
        first = 0.5 * np.exp(r * t) * transform(np.array([r]))[0].real
        moments[i] = r / count * (first + np.sum((np.exp(t * s) * transform(s) * (1.0 + 1j * slope)).real))
    return time, moments


def measure(time: np.ndarray, moments: np.ndarray) -> str:
    """Return half a period and a period [s], when the moments are zero again, and their extremes as a row of a table."""
    curve = CubicSpline(time, moments)
    zeros = [zero for zero in curve.roots(extrapolate=False) if zero > 0.05]
    extremes = curve(curve.derivative().roots(extrapolate=False))
    return f"{zeros[0]:.4f} | {zeros[1]:.4f} | {extremes.max():.4f} | {extremes.min():.4f} |"


if __name__ == "__main__":
    if sys.argv[1:] == ["smoothing"]:
        for share in (0.0, 0.34, 0.5, 1.0, 1.35, 2.0):
            result = oscillate(0.005, n=80, dt=4e-4, variance=share * 0.025**2)
            print(f"| {share:.2f} h² |", measure(*result), flush=True)
    elif sys.argv[1:] == ["exact"]:
        print("| exact |", measure(*exact(0.005, 0.4)))
        print("| edge 2 |", measure(*oscillate(0.005, 0.4, n=192, dt=4e-4, edge=2.0)))
    else:
        print(f"Rayleigh and Lamb: {RAYLEIGH:.4f}")
        for viscosity, gradient, n in (
            (0.005, 4.0, 96), (0.005, 4.0, 128), (0.005, 0.4, 128), (0.02, 4.0, 96), (0.00125, 4.0, 128)
        ):  # fmt: skip
            print(f"| {viscosity} | {gradient} | {n} |", measure(*oscillate(viscosity, gradient, n)), flush=True)
