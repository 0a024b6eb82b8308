"""What the cases of growing vesicles share: radius and density against the exact motion."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.gallery.benet2015.films import film_of, lipid_of, pressures_of, radius_of
from pellucid.references.vesicles import Growing
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

METRICS = ("radius", "density", "energy")


def exact(run: "Run") -> Growing:
    """The exact motion of the case."""
    film = film_of(run)
    material, load = lipid_of(film), next(iter(pressures_of(run)), None)
    pressure, dead = (load.value, load.on == "initial-area") if load else (0.0, False)
    sphere = film.shape.span != "plane"
    viscosities = material.viscosity, material.dilatational_viscosity
    return Growing(
        sphere, radius_of(film), film.initial_density, material.density, material.stiffness, *viscosities, pressure, dead
    )


def metrics(run: "Run") -> dict[str, Metric]:
    """Errors of the radius and the density at the end, and of the balance of power."""
    motion, history = exact(run), run.history
    radius = float(motion.radii(history["time"])[-1])
    density = float(motion.densities(np.array(radius)))
    found = float(history["radius"][-1]), float(history["density"][-1])
    allowed = 1e-3  # the steps keep errors of this share of the distance of nodes; that of the curve's geometry is far below
    text = "of the load and of what is stored and dissipated, largest so far"
    error = float(np.abs(history["energy_error"]).max())
    return {
        "radius": Metric(found[0], radius, abs(found[0] / radius - 1.0), allowed, "m", "radius at the end"),
        "density": Metric(found[1], density, abs(found[1] / density - 1.0), 2.0 * allowed, "kg/m^2", "density at the end"),
        "energy": Metric(error, 0.0, error, allowed, "", text),
    }


def figures(run: "Run") -> dict[str, "Figure"]:
    """Radius, speed and density against time with the exact ones."""
    motion, times = exact(run), run.history["time"]
    radii = motion.radii(times)
    exact_ones = {"radius": radii, "density": motion.densities(radii), "speed of the film": motion.speed(radii)}
    found = {"radius": run.history["radius"], "density": run.history["density"]}
    figure = new_figure(10.0, 3.2)
    for axes, (name, values), unit in zip(figure.subplots(1, 3), exact_ones.items(), ("m", "kg/m^2", "m/s"), strict=True):
        axes.plot(times, values, color="black", linewidth=1, label="exact")
        given = found.get(name, run.history["radial_velocity"])
        some = slice(1 if name.startswith("speed") else 0, None, max(len(times) // 25, 1))
        axes.plot(times[some], given[some], "o", color=COLOURS[1], markersize=4, label="film")
        label(axes, "time", name, "s", unit)
    figure.axes[0].legend()
    figure.suptitle(run.case.title)
    return {"growth": figure}
