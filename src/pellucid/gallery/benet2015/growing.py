"""Common metrics and figures of the cases of growing vesicles: radius and density compared with the exact motion."""

from types import SimpleNamespace

import numpy as np

from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.gallery.benet2015.films import films_of, lipid_of, pressures_of, radius_of
from pellucid.gallery.exact_curves import compared, worst_balance
from pellucid.references.membranes import Growing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"growth": "Radius, density and speed of the film against time, compared with the exact solution."}
METRICS = ("radius", "density", "energy")


def exact(run: Run, film: FluidFilmCase) -> Growing:
    """Return the exact motion of a film of a run that starts as a circle or sphere and grows or shrinks."""
    material = lipid_of(film)
    load = next((load for load in pressures_of(run) if load.body == film.name), None)
    pressure, dead = (load.value, load.on == "initial-area") if load else (0.0, False)
    sphere = film.shape.span != "plane"
    viscosities = material.viscosity, material.dilatational_viscosity
    return Growing(
        sphere, radius_of(film), film.initial_density, material.density, material.stiffness, *viscosities, pressure, dead
    )


def _columns(run: Run, film: FluidFilmCase) -> tuple[str, str, str]:
    """Return the names of the history columns of a film's radius, density and radial velocity; names of the first film have
    no suffix."""
    ending = "" if film is films_of(run)[0] else f"-{film.name}"
    return f"radius{ending}", f"density{ending}", f"radial_velocity{ending}"


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: radius and density of each film at the end, largest error of the energy balance."""
    allowed = 1e-3  # the steps keep errors of this share of the distance of nodes; that of the curve's geometry is far below
    result = {}
    for film in films_of(run):
        motion, history, (at, dense, _) = exact(run, film), run.history, _columns(run, film)
        radius = float(motion.radii(history["time"])[-1])
        density = float(motion.densities(np.array(radius)))
        result[at] = compared(float(history[at][-1]), radius, allowed, "m", "radius at the end")
        result[dense] = compared(float(history[dense][-1]), density, 2.0 * allowed, "kg/m^2", "density at the end")
    text = "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
    return {**result, "energy": worst_balance(run, allowed, text)}


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show radius, density and radial velocity of the films against time with the exact
    solutions."""
    films, times = films_of(run), run.history["time"]
    figure, panels = new_panels(1, 3, width=10.0, height=3.2, title=run.case.title)
    for film, colour in zip(films, COLOURS[1:], strict=False):
        motion = exact(run, film)
        radii = motion.radii(times)
        name = "film" if len(films) == 1 else f"μ = {lipid_of(film).viscosity:g} N s/m"
        exact_ones = radii, motion.densities(radii), motion.speed(radii)
        for axes, values, column in zip(panels, exact_ones, _columns(run, film), strict=True):
            axes.plot(times, values, color="black", linewidth=1, label="exact" if film is films[0] else None)
            some = slice(1 if column.startswith("radial_velocity") else 0, None, max(len(times) // 25, 1))
            axes.plot(times[some], run.history[column][some], "o", color=colour, markersize=4, label=name)
    for axes, name, unit in zip(panels, ("radius", "density", "speed of the film"), ("m", "kg/m^2", "m/s"), strict=True):
        label(axes, "time", name, "s", unit)
    panels[-1].legend()
    return {"growth": figure}


CASES = {
    "compressed-vesicle": SimpleNamespace(
        METRICS=(*METRICS, *(f"{name}-{film}" for film in ("less-viscous", "more-viscous") for name in ("radius", "density"))),
        CAPTIONS={"growth": "Radius, density and speed of the films against time, compared with the exact solution."},
        metrics=metrics,
        figures=figures,
    )
}
"""Metrics, captions and figures of each case, by its name without the group."""
