"""Metrics and figures of a vesicle constricted by a belt: a surface in space compared with a surface of revolution."""

import numpy as np
from scipy.interpolate import CubicSpline

from pellucid.gallery.benet2015.films import films_of
from pellucid.gallery.exact_curves import compared, vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {
    "profile": "Profiles at the end, and difference between the radii of the film in space and of the film of revolution."
}

METRICS = ("waist", "profile", "energy", "mass")

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


def metrics(run: Run) -> dict[str, Metric]:
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


def figures(run: Run) -> dict[str, Figure]:
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
