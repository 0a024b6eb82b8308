"""Metrics and figures of a vesicle constricted by a belt: waist, density and flow of a film of revolution, and a surface in
space compared with it."""

from types import SimpleNamespace

import numpy as np
from scipy.interpolate import CubicSpline

from pellucid.gallery.benet2015.films import film_of, films_of, lipid_of
from pellucid.gallery.exact_curves import compared, vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

RING_CAPTIONS = {
    "flow": "Density and velocity along the meridian at the end, displacement from the waist, and radius of the waist."
}

RING_METRICS = ("waist", "energy", "mass")

BANDS = {10.0: (0.41, 0.43), 0.01: (0.36, 0.37)}
"""Range of the waist radius [m] at t = 0.35 for each stiffness a of the equation of state, from a separate low-order
solution of the same problem, accurate to 5 %."""


def ring_metrics(run: Run) -> dict[str, Metric]:
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


def ring_figures(run: Run) -> dict[str, Figure]:
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


SPACE_CAPTIONS = {
    "profile": "Profiles at the end, and difference between the radii of the film in space and of the film of revolution."
}

SPACE_METRICS = ("waist", "profile", "energy", "mass")

BELT = 0.15  # height about the equator within which nodes tell the waist [m]
SIDE = 0.6  # height up to which profiles are compared: nearer to the poles radii change fast with z [m]


def _films(run: Run) -> tuple[str, str]:
    """Return the names of the film computed as a surface of revolution and of the film computed as a surface in space."""
    revolved, in_space = sorted(films_of(run), key=lambda film: film.shape.span == "space")
    return revolved.name, in_space.name


def _profiles(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return distance from the axis and height (r, z) of the nodes at the end [m], shape (n, 2): of the film of revolution,
    from pole to pole, and of the film in space."""
    revolved, in_space = (run.fields(name)["position"] for name in _films(run))
    around = np.stack([np.hypot(in_space[:, 0], in_space[:, 1]), in_space[:, 2]], axis=1)
    return revolved[:, [0, 2]], around


def _differences(revolved: np.ndarray, in_space: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the heights of the nodes of the film in space [m], without the nodes near the poles, and at these heights the
    radius of this film minus the radius of the film of revolution [m]. revolved, in_space: distance from the axis and
    height of the nodes of both films [m], shape (n, 2) each."""
    side = in_space[np.abs(in_space[:, 1]) <= SIDE]
    return side[:, 1], side[:, 0] - CubicSpline(revolved[:, 1], revolved[:, 0])(side[:, 1])


def space_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: radius of the waist and largest difference of the radii between the film in space and the
    film of revolution, largest error of the energy balance, change of the mass."""
    revolved, in_space = _profiles(run)
    height, off = _differences(revolved, in_space)
    waist = float(CubicSpline(revolved[:, 1], revolved[:, 0])(0.0))
    found = waist + float(off[np.abs(height) <= BELT].mean())
    worst = float(np.abs(off).max())
    mass = abs(float(run.summary["conservation"]["mass"]))
    return {
        "waist": compared(found, waist, 1e-2, "m", "waist radius of the film in space; reference: film of revolution"),
        "profile": Metric(
            worst, 0.0, worst / waist, 1e-2, "m", "largest difference of the radii; error relative to the waist radius"
        ),
        "energy": worst_balance(
            run, 5e-3, "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
        ),
        "mass": vanishing(mass, 1e-13, "relative change of the mass"),
    }


def space_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the meridians of both films at the end and the difference of their radii."""
    revolved, in_space = _profiles(run)
    height, off = _differences(revolved, in_space)
    figure, (left, right) = new_panels(1, 2, width_ratios=(2, 3), width=10.0, height=4.0, title=run.case.title)
    left.plot(*revolved.T, color="black", linewidth=1, label="of revolution")
    left.plot(*in_space.T, ".", color=COLOURS[1], markersize=3, label="in space")
    left.set_aspect("equal")
    figure.legend(loc="outside lower center", ncols=2)
    label(left, "distance from the axis", "z", "m", "m")
    right.plot(height, 1e3 * off, ".", color=COLOURS[1], markersize=3)
    label(right, "z", "difference of the radii", "m", "mm")
    return {"profile": figure}


CASES = {
    "ring": SimpleNamespace(METRICS=RING_METRICS, CAPTIONS=RING_CAPTIONS, metrics=ring_metrics, figures=ring_figures),
    "ring-in-space": SimpleNamespace(
        METRICS=SPACE_METRICS, CAPTIONS=SPACE_CAPTIONS, metrics=space_metrics, figures=space_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
