"""Metrics and figures of small disturbances of round films: decay rates compared with linear theory."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.gallery.benet2015.films import films_of, lipid_of, pressures_of
from pellucid.references.membranes import curve_mode_rate, sphere_mode_rate
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"decay": "Amplitudes, divided by the initial amplitude, against time, with the exact decay."}

WAVES = {"two-waves": 2, "three-waves": 3, "sphere": 2}
"""Number of waves about the circle, or degree of the spherical harmonic, by name of the film."""

METRICS = tuple(WAVES)

FINE = 720  # angles at which the radius of a curve is taken from a spline through its nodes

RADIUS = 1.0  # mean [m]

ALLOWED = 0.01  # of the rate: linear theory is off by some amplitudes over the radius, a sphere of 162 nodes by 1e-3


class Decay(NamedTuple):
    """Decay of a mode (small periodic disturbance of the radius of a film): times, relative amplitudes, computed and exact
    rates."""

    times: np.ndarray  # times of the stored frames [s]
    amplitudes: np.ndarray  # amplitudes of the mode divided by the radius
    rate: float  # decay rate of the run [1/s]
    exact: float  # decay rate by linear theory [1/s]


def _waves(places: np.ndarray, waves: int) -> float:
    """Return the amplitude of the Fourier component with `waves` periods of the radius of a curve about its centroid,
    divided by the mean radius; places: positions of the nodes, shape (n, 2)."""
    x, y = (places - places.mean(axis=0)).T
    angle, radius = np.unwrap(np.arctan2(y, x)), np.hypot(x, y)
    closed = np.append(angle, angle[0] + 2.0 * np.pi), np.append(radius, radius[0])
    even = angle[0] + np.linspace(0.0, 2.0 * np.pi, FINE, endpoint=False)
    radii = CubicSpline(*closed, bc_type="periodic")(even)
    return float(2.0 * abs(np.mean(radii * np.exp(1j * waves * even))) / radii.mean())


def _harmonic(places: np.ndarray) -> float:
    """Return the amplitude of the Legendre polynomial of degree 2 about z in the distances of nodes from the centre,
    divided by the mean radius; places: positions of the nodes, shape (n, 3)."""
    from_middle = places - places.mean(axis=0)
    radius = np.linalg.norm(from_middle, axis=1)
    wave = 1.5 * (from_middle[:, 2] / radius) ** 2 - 0.5
    wave -= wave.mean()
    return float(abs(wave @ radius) / (wave @ wave) / radius.mean())


def _amplitude(run: Run, film: FluidFilmCase, time: float) -> float:
    places = run.fields(film.name, time)["position"]
    return _waves(places[:, :2], WAVES[film.name]) if film.shape.span == "plane" else _harmonic(places)


def _exact(run: Run, film: FluidFilmCase) -> float:
    material = lipid_of(film)
    if film.shape.span == "space":
        viscosities = material.viscosity, material.dilatational_viscosity
        return sphere_mode_rate(WAVES[film.name], material.bending_rigidity, *viscosities, RADIUS)
    (pressure,) = (load.value for load in pressures_of(run) if load.body == film.name)
    return curve_mode_rate(WAVES[film.name], pressure, material.bending_rigidity, film.drag.normal, RADIUS)


def decay_of(run: Run, film: FluidFilmCase) -> Decay:
    """Return the decay of the disturbance of one film. Its rate is the slope of ln(amplitude) in the stored frames after the
    first, in which the tension of the film balances the load."""
    times = run.times(film.name)
    amplitudes = np.array([_amplitude(run, film, float(time)) for time in times])
    slope = np.polyfit(times[1:], np.log(amplitudes[1:]), 1)[0]
    return Decay(times, amplitudes, -float(slope), _exact(run, film))


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: decay rate of the disturbance of each film."""
    result = {}
    for film in films_of(run):
        of = decay_of(run, film)
        error = abs(of.rate / of.exact - 1.0)
        result[film.name] = Metric(of.rate, of.exact, error, ALLOWED, "1/s", "decay rate of the amplitude")
    return result


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the amplitudes of the disturbances of the films against time."""
    figure, axes = new_panels(height=3.8, title=run.case.title)
    for film, colour in zip(films_of(run), COLOURS, strict=False):
        of = decay_of(run, film)
        axes.semilogy(of.times, np.exp(-of.exact * of.times), color="black", linewidth=1)
        name = f"{film.name.replace('-', ' ')}: {of.rate:.4f}/s, exact {of.exact:.4f}/s"
        axes.semilogy(of.times, of.amplitudes / of.amplitudes[0], "o", color=colour, markersize=4, label=name)
    axes.plot([], [], color="black", linewidth=1, label="exact")
    label(axes, "time", "amplitude / initial amplitude", "s", "", legend=True)
    return {"decay": figure}
