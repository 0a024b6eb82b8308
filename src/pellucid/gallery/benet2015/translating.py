"""Common metrics and figures of the cases of translating vesicles: the steady motion compared with the exact motion."""

import numpy as np

from pellucid.gallery.benet2015.films import film_of, pressures_of
from pellucid.gallery.exact_curves import compared, vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {
    "translation": "Error of the velocity against time; tension along the axis of motion at the end, with the exact one."
}
METRICS = ("velocity", "rigidity", "tension", "energy")


def _drive(run: Run) -> tuple[float, float, int]:
    """Return the inner pressure P [Pa], the driving load p along an axis [Pa], and the number of this axis (0 to 2)."""
    inside = next(load.value for load in pressures_of(run) if load.along is None)
    driving, along = next((load.value, load.along) for load in pressures_of(run) if load.along is not None)
    axis = int(np.flatnonzero(along)[0])
    return inside, driving * float(np.sign(along[axis])), axis


def _velocity(run: Run) -> float:
    """Return the exact velocity of the vesicle [m/s]: p/2ζ for a circle, p/3ζ for a sphere, with the load p and the drag ζ."""
    film = film_of(run)
    return _drive(run)[1] / ((2.0 if film.shape.span == "plane" else 3.0) * film.drag.normal)


def _tensions(run: Run) -> "tuple[np.ndarray, np.ndarray]":
    """Return the computed tension at the nodes at the end [N/m], and the exact tension there, shape (n,) each: R (P + (p/2)
    n·e) for a circle, R (P/2 + (p/3) n·e) for a sphere.

    R: radius, P: inner pressure, p: load, n: unit normal, e: direction of the load.
    """
    film = film_of(run)
    inside, load, axis = _drive(run)
    fields = run.fields(film.name)
    radius = fields["distance"]
    centre = 0.5 * (fields["position"][:, axis].max() + fields["position"][:, axis].min())
    towards = (fields["position"][:, axis] - centre) / radius
    halves = (1.0, 0.5) if film.shape.span == "plane" else (0.5, 1.0 / 3.0)
    return fields["tension"], radius * (halves[0] * inside + halves[1] * load * towards)


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: mean velocity of the vesicle at the end, largest difference of a node from the mean velocity,
    largest error of the tension, largest error of the energy balance."""
    film = film_of(run)
    axis = _drive(run)[2]
    exact, found = _velocity(run), float(run.history["velocity"][-1])
    velocity = run.fields(film.name)["velocity"]
    spread = float(np.abs(velocity[:, axis] - velocity[:, axis].mean()).max() / abs(exact))
    tension, expected = _tensions(run)
    error = float(np.abs(tension - expected).max() / np.abs(expected).max())
    # the radius has grown by the tension over a, a share of 0.002 that `tension` allows for; of nodes, tension is a mean of two
    # segments, second order in their length; in space one of the triangles about, in which cosθ is off by a quarter of the
    # square of an edge, and no more than half of the tension goes by it
    n = len(velocity)
    off = (2.0 * np.pi / n) ** 2 if film.shape.span != "space" else np.pi / (np.sqrt(3.0) * n)
    return {
        "velocity": compared(found, exact, 1e-3, "m/s", "mean velocity of the nodes at the end"),
        "rigidity": vanishing(spread, 1e-3, "largest difference from the mean velocity, relative to the exact velocity"),
        "tension": vanishing(error, 2e-3 + off, "largest error of the tension at the nodes, relative to the largest tension"),
        "energy": worst_balance(
            run, 1e-3, "largest relative error of the energy balance (work of loads, stored energy, dissipation)"
        ),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the error of the mean velocity against time, and the tension against the position along
    the axis of motion."""
    axis = _drive(run)[2]
    figure, (left, right) = new_panels(1, 2, width=10.0, height=3.4, title=run.case.title)
    exact = _velocity(run)
    left.semilogy(run.history["time"][1:], np.abs(run.history["velocity"][1:] / exact - 1.0), color=COLOURS[1], label="film")
    label(left, "time", "relative error of the velocity", "s", "")
    tension, expected = _tensions(run)
    place = run.fields(film_of(run).name)["position"][:, axis]
    order = np.argsort(place)
    right.plot(place[order] - place.mean(), expected[order], color="black", linewidth=1, label="exact")
    right.plot(place - place.mean(), tension, "o", color=COLOURS[1], markersize=4, label="film")
    label(right, "distance from the centre along the axis", "tension", "m", "N/m", legend=True)
    return {"translation": figure}
