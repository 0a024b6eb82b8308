"""Metrics and figures of a vesicle constricted by a belt: waist, density and flow."""

import numpy as np

from pellucid.gallery.benet2015.films import film_of, lipid_of
from pellucid.gallery.exact_curves import compared, vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"flow": "Density and velocity along the meridian at the end, displacement from the waist, and radius of the waist."}

METRICS = ("waist", "energy", "mass")

BANDS = {10.0: (0.41, 0.43), 0.01: (0.36, 0.37)}
"""Range of the waist radius [m] at t = 0.35 for each stiffness a of the equation of state, from a separate low-order
solution of the same problem, accurate to 5 %."""


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: radius of the waist (the narrowest section) at the end, compared with a separate low-order
    numerical solution; largest error of the energy balance; change of the mass."""
    mass = abs(float(run.summary["conservation"]["mass"]))
    result = {
        "energy": worst_balance(
            run, 5e-3, "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
        ),
        "mass": vanishing(mass, 1e-13, "relative change of the mass"),
    }
    band = BANDS.get(lipid_of(film_of(run)).stiffness)
    if band and run.history["time"][-1] >= 0.35 * (1.0 - 1e-9):
        found, middle = float(run.history["waist"][-1]), 0.5 * sum(band)
        allowed = 0.05 + 0.5 * (band[1] - band[0]) / middle  # what the reference is good to
        result["waist"] = compared(found, middle, allowed, "m", "radius of the waist at the end")
    return result


def _half(run: Run, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return for the upper half of the vesicle the arc lengths along the meridian from the waist to the nodes [m], and the mass
    of the film between the waist and each node [kg], shape (m,) each, in the stored frame nearest to a time [s]."""
    fields = run.fields(film_of(run).name, time)
    place, mass = fields["position"][:, [0, 2]], fields["mass"]
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1)))
    upper = slice(len(arc) // 2, None)
    below = np.cumsum(mass) - 0.5 * mass
    below[-1] = mass.sum()  # at the pole
    return arc[upper] - 0.5 * arc[-1], below[upper] - 0.5 * mass.sum()


def _moved(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return the initial arc lengths of the nodes from the waist [m], and the displacements of the film along the meridian away
    from the waist at the end [m], shape (m,) each."""
    start, before = _half(run, 0.0)
    end, after = _half(run, float(run.times(film_of(run).name)[-1]))
    return start, np.interp(before, after, end) - start


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show density, velocity and displacement of the film along the meridian at the end, and the
    radius of the waist against time."""
    fields = run.fields(film_of(run).name)
    place, velocity = fields["position"][:, [0, 2]], fields["velocity"][:, [0, 2]]
    along = np.gradient(place, axis=0)
    length = np.linalg.norm(along, axis=1)
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1)))
    arc -= 0.5 * arc[-1]
    speed = np.sign(arc) * np.einsum("ij,ij->i", velocity, along) / length
    figure, ((dense, fast), (moved, waist)) = new_panels(2, 2, width=9.5, height=5.6)
    dense.plot(arc, fields["areal_density"], ".-", color=COLOURS[0])
    label(dense, "length from the waist", "density", "m", "kg/m^2")
    fast.plot(arc, speed, ".-", color=COLOURS[1])
    label(fast, "length from the waist", "velocity from the waist", "m", "m/s")
    moved.plot(*_moved(run), ".-", color=COLOURS[3])
    label(moved, "length from the waist at the start", "displacement from the waist", "m", "m")
    waist.plot(run.history["time"], run.history["waist"], color=COLOURS[2])
    label(waist, "time", "radius of the waist", "s", "m")
    figure.suptitle(f"{run.case.title}, a = {lipid_of(film_of(run)).stiffness:g} N m/kg")
    return {"flow": figure}
