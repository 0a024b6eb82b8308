"""Metrics and figures of the flow in a lid-driven cavity: velocities on its centre lines, means of the last frames, beside
those of finite differences on 256 x 256 cells."""

from pathlib import Path

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing, worst_balance
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {
    "profiles": "Velocities on the centre lines, means of the last quarter of the run and their standard deviations in time. "
    "Lines: finite differences.",
}
METRICS = ("least_u", "greatest_v", "least_v", "density", "energy")
KNOWN = (100, 400)  # Reynolds numbers of the tables beside this file
ALLOWED = {100: (0.04, 0.015), 400: (0.04, 0.015)}  # relative errors with 32 and with 64 cells
LAST = 0.6  # share of the time after which frames count
PLACES = np.linspace(0.02, 0.98, 97)


def reynolds(run: Run) -> int:
    """Return the Reynolds number of the case; ValueError if there is no reference for it."""
    body = run.case.body[0]
    found = round(body.material.density / body.shear_viscosity)
    if found not in KNOWN:
        raise ValueError(f"Reynolds number {found}: there are references for {' and '.join(map(str, KNOWN))}")
    return found


def reference(number: int) -> tuple[Array, Array, Array]:
    """Return place, u on the vertical and v on the horizontal centre line, shape (n,) each, for a Reynolds number."""
    table = np.loadtxt(Path(__file__).with_name(f"lid-driven-cavity-{number}.csv"), delimiter=",", skiprows=1)
    return table[:, 0], table[:, 1], table[:, 2]


def profile(place: Array, value: Array, cell: float) -> Array:
    """Return values at PLACES along a line by least squares of a parabola around each, with the weights of a Gaussian one cell
    wide. place, value: of the points within a cell of the line, shape (n,)."""
    found = list[float]()
    for at in PLACES:
        off = place - at
        root = np.exp(-0.5 * (off / cell) ** 2)
        terms = np.stack([np.ones_like(off), off, off**2], axis=1)
        found.append(np.linalg.lstsq(terms * root[:, None], value * root, rcond=None)[0][0])
    return np.array(found)


def frames(run: Run) -> tuple[Array, Array]:
    """Return u on the vertical and v on the horizontal centre line at PLACES in each of the last frames, shape (frames, n)."""
    name, cell = run.case.body[0].name, run.case.grid.cell
    times = np.asarray(run.times(name), dtype=float)
    us, vs = list[Array](), list[Array]()
    for time in times[times >= LAST * times[-1]]:
        fields = run.fields(name, float(time), names=("position", "velocity"))
        x, v = np.asarray(fields["position"]), np.asarray(fields["velocity"])
        for axis, of, found in ((0, 0, us), (1, 1, vs)):
            near = np.abs(x[:, axis] - 0.5) < cell
            found.append(profile(x[near, 1 - axis], v[near, of], cell))
    return np.array(us), np.array(vs)


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: extremes of the velocities on the centre lines, deviation of the densities, and the error of
    the energy balance."""
    _, u, v = reference(reynolds(run))
    mean_u, mean_v = (found.mean(axis=0) for found in frames(run))
    name = run.case.body[0].name
    density = np.asarray(run.fields(name, float(run.times(name)[-1]), names=("density",))["density"])
    uneven = np.abs(np.percentile(density / run.case.body[0].material.density, [1, 99]) - 1.0).max()
    coarse, fine = ALLOWED[reynolds(run)]
    allowed = fine if run.case.grid.cell < 0.02 else coarse
    source = "reference: finite differences"
    return {
        "least_u": compared(float(mean_u.min()), float(u.min()), allowed, "m/s", f"least u on x = 0.5; {source}"),
        "greatest_v": compared(float(mean_v.max()), float(v.max()), allowed, "m/s", f"greatest v on y = 0.5; {source}"),
        "least_v": compared(float(mean_v.min()), float(v.min()), allowed, "m/s", f"least v on y = 0.5; {source}"),
        "density": vanishing(float(uneven), 0.03, "relative deviation of the 1st or 99th percentile of the densities"),
        "energy": worst_balance(run, 1e-9),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return a figure of the velocities on the centre lines."""
    place, *exact = reference(reynolds(run))
    figure, panels = new_panels(1, 2, width=10.0, height=3.8)
    titles = ("u on the vertical centre line", "v on the horizontal centre line")
    for axes, line, found, title, along in zip(panels, exact, frames(run), titles, ("y", "x"), strict=True):
        mean, deviation = found.mean(axis=0), found.std(axis=0)
        axes.plot(place, line, color="black", linewidth=1, label="finite differences")
        axes.fill_between(PLACES, mean - deviation, mean + deviation, color=COLOURS[1], alpha=0.3, linewidth=0)
        axes.plot(PLACES, mean, color=COLOURS[1], linewidth=1.5, linestyle="--", label="pellucid")
        axes.set_title(title)
        label(axes, along, "velocity", "m", "m/s", legend=True)
    return {"profiles": figure}
