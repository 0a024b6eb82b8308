"""Metrics and figures of membrane laws: tension against stretch in strips and sheets, compared with derivatives of the
energies."""

import csv
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CURVES = Path(__file__).parent / "tension-curves-exact.csv"
LAWS = ("neo-hookean", "skalak", "evans-skalak", "arruda-boyce")
STRETCHES = {"strip": (1.25, 1.5), "sheet": (1.25,)}
AT_REST = {1.25: 7.75, 1.5: 15.75}
"""Times at which the elements are at rest [s], by stretch."""
TOLERANCES = {"elements": 1e-6, "points": 0.01}
HOMOGENEOUS = 0.4  # m from the planes of symmetry at the start: of points, what the loaded ends do not reach

NAMES = tuple(
    f"{law}-{pull}-{kind}"
    for law in LAWS
    for kind in TOLERANCES
    for pull in STRETCHES
    if (law, pull, kind) != ("evans-skalak", "sheet", "points")  # its ends flow away under forces: G is small beside K
)
METRICS = (*(f"{name}-{stretch:g}" for name in NAMES for stretch in STRETCHES[name.split("-")[-2]]), "balance")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: tension of each strip and sheet at given stretches, error of the energy balance."""
    exact, result = exact_curves(), {}
    for name in NAMES:
        law, pull, kind = name.rsplit("-", 2)
        _, stretches, tensions = curve(run, name)
        times = run.times(name)
        for stretch in STRETCHES[pull]:
            if kind == "elements":
                found = float(tensions[int(np.argmin(np.abs(times - AT_REST[stretch])))])
            else:
                found = float(np.interp(stretch, stretches, tensions))
            reference = float(np.interp(stretch, *exact[law, pull]))
            text = f"tension of a {pull} of {kind} at a stretch of {stretch:g}"
            result[f"{name}-{stretch:g}"] = compared(found, reference, TOLERANCES[kind], "N/m", text)
    error = abs(float(run.summary["conservation"]["energy"]))
    result["balance"] = vanishing(error, 0.005, "relative error of the energy balance at the end")
    return result


def exact_curves() -> dict[tuple[str, str], tuple[Array, Array]]:
    """Return the exact stretches and tensions divided by the modulus, shape (n,) each, by (law, specimen); the specimen is a
    strip or a sheet."""
    rows: dict[tuple[str, str], list[tuple[float, float]]] = {}
    with CURVES.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows.setdefault((row["law"], row["pull"]), []).append((float(row["stretch"]), float(row["tension"])))
    return {key: (np.array(values)[:, 0], np.array(values)[:, 1]) for key, values in rows.items()}


def curve(run: Run, name: str) -> tuple[Array, Array, Array]:
    """Return the times of the stored frames [s], and the stretch along x and the tension along x [N/m] of the body `name` at
    these times."""
    model: Any = next(body for body in run.case.body if body.name == name)
    times = run.times(name)
    start = run.fields(name, float(times[0]))["position"]
    chosen = np.all(start[:, :2] < HOMOGENEOUS, axis=1) | name.endswith("elements")
    places = np.column_stack([start[chosen, :2], np.ones(chosen.sum())])
    stretches, tensions = [], []
    for time in times:
        fields = run.fields(name, float(time))
        gradient = np.linalg.lstsq(places, fields["position"][chosen, :2], rcond=None)[0]
        along, across = gradient[0, 0], gradient[1, 1]
        stretches.append(along)
        # the material keeps its volume
        tensions.append(fields["stress"][chosen, 0].mean() * model.thickness / (along * across))
    return times, np.array(stretches), np.array(tensions)


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show tension divided by modulus against stretch, for strips and for sheets, with the exact
    curves."""
    return {"curves": _curves(run)}


CAPTIONS = {
    "curves": "Tension against stretch for strips with free sides and sheets stretched in both directions, with points "
    "(lines) and elements (crosses). Circles: derivatives of the energies."
}


def _curves(run: Run) -> Figure:
    figure, panels = new_panels(1, 2, height=4.5, title=run.case.title)
    exact = exact_curves()
    for axes, pull in zip(panels, STRETCHES, strict=True):
        axes.set_title(pull)
        for law, colour in zip(LAWS, COLOURS, strict=False):
            stretch, tension = exact[law, pull]
            axes.plot(stretch[4::5], tension[4::5], "o", color=colour, markersize=4, fillstyle="none", label=law)
            for kind in TOLERANCES:
                name = f"{law}-{pull}-{kind}"
                if name not in NAMES:
                    continue
                times, stretch, tension = curve(run, name)
                if kind == "elements":
                    rest = [int(np.argmin(np.abs(times - AT_REST[at]))) for at in STRETCHES[pull]]
                    axes.plot(stretch[rest], tension[rest], "x", color=colour, markersize=9)
                else:
                    axes.plot(stretch, tension, color=colour, linewidth=1.0)
        label(axes, "stretch", "tension / modulus", "", "")
    panels[0].legend(title="lines: points, crosses: elements")
    return figure
