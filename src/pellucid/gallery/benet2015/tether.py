"""Metrics and figures of a tether pulled from a vesicle, compared with the force and radius of a tube."""

import numpy as np

from pellucid.gallery.benet2015.films import film_of, pressures_of, radius_of
from pellucid.gallery.exact_curves import compared, worst_balance
from pellucid.references.membranes import Tether, tether
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"tether": "Force at the pole against its displacement, compared with a tube, and the meridian at the end."}

METRICS = ("force", "radius", "thin_force", "energy")


def _tube(run: Run) -> tuple[Tether, Tether]:
    """Return force and radius of the exact tube at the final tension of the run: with its inner pressure, and without
    pressure."""
    rigidity, tension = film_of(run).material.bending_rigidity, float(run.history["tension"][-1])
    return tether(tension, rigidity, pressures_of(run)[0].value), tether(tension, rigidity)


def _radius(run: Run) -> float:
    """Return the mean radius of the middle third of the tube [m]; towards both ends the radius oscillates about the radius
    of a long tube.

    The tube extends from its narrowest position near the vesicle to its widest position near the pole.
    """
    r, z = run.fields(film_of(run).name)["position"][:, [0, 2]].T
    widest = len(r) - 1 - int(np.argmax(np.diff(r[::-1]) < 0.0))
    equator = int(np.argmax(r))
    narrowest = equator + int(np.argmax(np.diff(r[equator:]) > 0.0))
    third = (z[widest] - z[narrowest]) / 3.0
    middle = (z >= z[narrowest] + third) & (z <= z[widest] - third)
    return float(r[middle].mean())


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: force on the pole and radius of the tether, compared with a tube at the same tension; largest
    error of the energy balance."""
    tube, thin = _tube(run)
    force, radius = float(run.history["force"][-1]), _radius(run)
    share = 0.5 * thin.radius / radius_of(film_of(run))  # πr²P/F with P = 2σ/R
    text = "force on the pole; reference: 2π√(2κσ), which neglects the pressure in the tube"
    return {
        "force": compared(force, tube.force, 0.02, "N", "force on the pole; reference: tube with pressure inside"),
        "radius": compared(radius, tube.radius, 0.02, "m", "radius of the tube; reference: tube with pressure inside"),
        "thin_force": compared(force, thin.force, 0.005 + share, "N", text),
        "energy": worst_balance(
            run, 1e-3, "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
        ),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the pulling force against the displacement of the pole, and the meridian of the vesicle
    at the end."""
    tube, thin = _tube(run)
    figure, (left, right) = new_panels(1, 2, width_ratios=(3, 2), width=10.0, height=4.2, title=run.case.title)
    speed = run.case.support[0].velocity[2]
    left.plot(speed * run.history["time"][1:], run.history["force"][1:], color=COLOURS[1], label="film")
    left.axhline(tube.force, color="black", linewidth=1, linestyle="--", label="tube with the pressure inside")
    left.axhline(thin.force, color="#889", linewidth=1, linestyle=":", label="2π√(2κσ)")
    label(left, "displacement of the pole", "force", "m", "N", legend=True)
    place = run.fields(film_of(run).name)["position"]
    for sign in (1.0, -1.0):
        right.plot(sign * place[:, 0], place[:, 2], color=COLOURS[0])
    right.set_aspect("equal")
    label(right, "r", "z", "m", "m")
    return {"tether": figure}
