"""Metrics and figures of strong explosions: radius of the shock, density around the centre and total energy, compared with
the similarity solution."""

import numpy as np

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.references import Array
from pellucid.references.gas_dynamics import MEASURE, Blast
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

DISPLACED = 2.0  # cells: a front is caught within some cells, an error of first order
ENERGY = 1e-12  # of its scale: rounding
SAMPLES = 20  # of the exact density in a ring of one cell

CAPTIONS = {
    "blast": "Shock radius against time, and density at the end against radius. The density is the mass in radial bins "
    "of one cell divided by their volume. The shock is spread over a few cells: the position at which the pressure is "
    "half of the exact one may differ from the exact shock by at most two cells (dotted).",
    "bodies_speed": "The bodies, coloured by speed. The density of the hot gas inside is so low that cells contain few "
    "points or none. With FLIP these points keep velocities that the grid, which stores only mean velocities, cannot "
    "reduce; they move at several times the speed of the exact flow, each with its mirror image. Their share of the "
    "mass is small. With APIC they follow the exact flow.",
}

METRICS = ("radius", "worst_radius", "density_l1", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: shock radius at the end, shock radius with the largest error in the second half of the run,
    L1 error of the density profile, largest error of the energy balance."""
    blast, cell = Blast.of(run.case), run.case.grid.cell
    times, found = fronts(run, blast)
    exact = blast.radius(times)
    errors = np.abs(found / exact - 1.0)
    later = times >= 0.5 * times[-1]
    worst = int(np.argmax(np.where(later, errors, 0.0)))
    edges = rings(run)
    wanted = exact_density(blast, edges, times[-1])
    density = ring_density(run, blast, edges, times[-1])
    displaced = exact_density(blast, edges, times[-1], DISPLACED * cell)
    volumes = np.diff(edges**blast.dimensions)
    scale = np.sum(wanted * volumes)
    error, tolerance = (float(np.sum(np.abs(other - wanted) * volumes) / scale) for other in (density, displaced))

    def at(frame: int, text: str) -> Metric:
        allowed = DISPLACED * cell / exact[frame]
        return Metric(float(found[frame]), float(exact[frame]), float(errors[frame]), float(allowed), "m", text)

    text = "radius at which the binned pressure passes half of the exact pressure behind the shock"
    farthest = "shock radius in the frame of the second half of the run with the largest error"
    rings_off = "relative L1 error of the binned density; tolerance: exact profile displaced by two cells"
    return {
        "radius": at(-1, f"{text}, at the end"),
        "worst_radius": at(worst, farthest),
        "density_l1": vanishing(error, tolerance, rings_off),
        "energy": worst_balance(run, ENERGY),
    }


def rings(run: Run) -> Array:
    """Return the radii of the edges of concentric rings (shells in space) that are one cell wide [m], from the centre to the
    wall, shape (rings + 1,)."""
    cell, width = run.case.grid.cell, float(run.case.grid.extent_upper()[0] - run.case.grid.lower[0])
    return np.arange(0.0, width + 0.5 * cell, cell)


def gas(run: Run, blast: Blast, time: float) -> tuple[Array, Array, Array, Array]:
    """Return radius [m], mass [kg], volume [m³] and pressure [Pa] of all points in the stored frame at a time [s], shape
    (n,) each; blast: exact solution, which defines the number of dimensions."""
    frames = [run.fields(body.name, time) for body in run.case.body]
    names = ("position", "mass", "density", "pressure")
    position, mass, density, pressure = (np.concatenate([np.asarray(frame[name]) for frame in frames]) for name in names)
    return np.linalg.norm(position[:, : blast.dimensions], axis=1), mass, mass / density, pressure


def ring_density(run: Run, blast: Blast, edges: Array, time: float) -> Array:
    """Return the density in the stored frame at a time [s] in rings with the given edges [m]: mass of the points in a ring
    divided by its volume [kg/m³], shape (rings,). blast: exact solution, which defines the number of dimensions."""
    radius, mass, _, _ = gas(run, blast, time)
    n = blast.dimensions
    across = run.case.grid.slice_thickness() ** (3 - n)
    volumes = MEASURE[n] / 2.0**n * across * np.diff(edges**n) / n
    return np.asarray(np.histogram(radius, edges, weights=mass)[0] / volumes)


def exact_density(blast: Blast, edges: Array, time: float, displaced: float = 0.0) -> Array:
    """Return the mean density of the exact solution `blast` at a time [s] in rings with the given edges [m], shape (rings,)
    [kg/m³]. displaced: distance by which the exact profile is moved outwards [m]."""
    width = edges[1] - edges[0]
    radius = (edges[:-1, None] + width * (np.arange(SAMPLES) + 0.5) / SAMPLES).ravel()
    weight = (radius ** (blast.dimensions - 1)).reshape(-1, SAMPLES)
    density = blast.at(np.abs(radius - displaced), time)["density"].reshape(-1, SAMPLES)
    return np.asarray((density * weight).sum(axis=1) / weight.sum(axis=1))


def fronts(run: Run, blast: Blast) -> tuple[Array, Array]:
    """Return the times of the stored frames after the start [s] and the radius of the shock in each stored frame [m]: the
    radius at which the mean pressure of the rings crosses half of the exact pressure behind the shock."""
    edges, times = rings(run), np.asarray(run.times(run.case.body[0].name), dtype=float)[1:]
    middles, found = 0.5 * (edges[1:] + edges[:-1]), []
    for time in times:
        radius, _, volume, pressure = gas(run, blast, float(time))
        filled = np.histogram(radius, edges, weights=volume)[0]
        mean = np.histogram(radius, edges, weights=volume * pressure)[0] / np.maximum(filled, 1e-300)
        half = 0.5 * float(blast.at(blast.radius(time), float(time))["pressure"])
        last = int(np.flatnonzero(mean > half)[-1])
        beyond = mean[last + 1] if last + 1 < len(mean) else 0.0
        found.append(middles[last] + (edges[1] - edges[0]) * (mean[last] - half) / (mean[last] - beyond))
    return times, np.array(found)


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the shock radius against time, and the density against the radius at the end, with the
    exact solution."""
    blast = Blast.of(run.case)
    figure, (fronts_axes, profile) = new_panels(1, 2, width=10.0, height=3.6)
    times, found = fronts(run, blast)
    line = np.linspace(0.0, times[-1], 200)
    fronts_axes.plot(line, blast.radius(line), color="black", linewidth=1, label="exact")
    fronts_axes.plot(times, found, "o", color=COLOURS[1], markersize=4, label="pellucid")
    for side, name in ((-1.0, "two cells off"), (1.0, None)):
        off = blast.radius(line) + side * DISPLACED * run.case.grid.cell
        fronts_axes.plot(line[off > 0.0], off[off > 0.0], color="grey", linestyle=":", linewidth=1, label=name)
    ahead = float(found[-1] / blast.radius(times[-1:])[0] - 1.0)
    fronts_axes.set_title(f"at the end {100.0 * abs(ahead):.1f} % {'ahead' if ahead > 0.0 else 'behind'}")
    label(fronts_axes, "time", "radius of the shock", "s", "m", legend=True)
    edges = rings(run)
    radii = np.linspace(edges[0], edges[-1], 2000)[1:]
    profile.plot(radii, blast.at(radii, times[-1])["density"], color="black", linewidth=1, label="exact")
    profile.stairs(ring_density(run, blast, edges, times[-1]), edges, baseline=None, color=COLOURS[1], label="pellucid")
    label(profile, "radius", "density", "m", "kg/m^3")
    profile.legend(loc="upper left")
    profile.set_title(f"t = {times[-1]:.4g} s")
    return {"blast": figure}
