"""Metrics and figures of a drop in a shear flow: deformation compared with Taylor's theory; conservation of the film's mass
and of the enclosed volume."""

from typing import Any, NamedTuple

from pellucid.gallery.benet2015.films import kept
from pellucid.gallery.exact_curves import compared
from pellucid.geometry.meshes.enclosure import ellipsoid_of
from pellucid.references.flows import drop_approach, drop_deformation
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CLOSE, CELLS = 0.05, 6.0  # error at so many cells a radius; it falls at second order

CAPTIONS = {
    "deformation": "Deformation of the drop against time, compared with small-deformation theory between plates.",
}

METRICS = ("deformation", "volume", "film_mass")


class Drop(NamedTuple):
    """Parameters of the drop in a shear flow between two plates."""

    radius: float  # initial radius of the drop [m]
    capillary: float  # capillary number: outer viscosity times shear rate times radius, divided by surface tension
    ratio: float  # viscosity of the drop divided by that of the outer fluid
    confinement: float  # radius divided by the distance of the plates
    shear: float  # shear rate [1/s]

    def expected(self, time: float) -> float:
        """Return the deformation (L - B)/(L + B) of the drop by small-deformation theory at a time [s]; L and B: largest and
        smallest diameter."""
        steady = drop_deformation(self.capillary, self.ratio, self.confinement)
        return steady * drop_approach(self.capillary, self.ratio, self.shear * time)


def drop_of(run: Run) -> Drop:
    """Return the parameters of the drop in the case of a run."""
    fluid, drop, film = (_body(run, name) for name in ("fluid", "drop", "film"))
    radius, shear = film.surface.sphere.radius, fluid.initial[0].x[1]
    viscosity, tension = fluid.material.viscosity, film.material.tension * film.thickness
    gap = run.case.grid.upper[1] - run.case.grid.lower[1]
    return Drop(radius, viscosity * shear * radius / tension, drop.material.viscosity / viscosity, radius / gap, shear)


def _body(run: Run, name: str) -> Any:
    return next(body for body in run.case.body if body.name == name)


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: deformation (L - B)/(L + B) of the drop at the end, L and B being its largest and smallest
    diameter; largest changes of the enclosed volume and of the film's mass."""
    times, drop, triangles = run.times("film"), drop_of(run), run.triangles("film")
    end = float(times[-1])
    found, expected = ellipsoid_of(run.fields("film", end)["position"], triangles).deformation, drop.expected(end)
    tolerance = CLOSE * (CELLS * run.case.grid.cell / drop.radius) ** 2
    return {
        "deformation": compared(
            found,
            expected,
            tolerance,
            "",
            "deformation (L - B)/(L + B) at the end; reference: Taylor, Cox; effect of the plates: Shapira & Haber",
        ),
        **kept(run, "film"),
    }


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the deformation and the semi-axes of the drop against time."""
    return {"deformation": _deformation(run)}


def _deformation(run: Run) -> Figure:
    times, drop, triangles = run.times("film"), drop_of(run), run.triangles("film")
    shapes = [ellipsoid_of(run.fields("film", float(time))["position"], triangles) for time in times]
    figure, (left, right) = new_panels(1, 2, height=3.4)
    left.plot(times, [shape.deformation for shape in shapes], "o-", color=COLOURS[0], markersize=3, label="drop")
    left.plot(times, [drop.expected(float(time)) for time in times], "--", color=COLOURS[1], label="small-deformation theory")
    free = drop_deformation(drop.capillary, drop.ratio)
    left.axhline(free, color="0.5", linewidth=1, linestyle=":", label="steady state without plates")
    label(left, "time", "deformation", "s", "", legend=True)
    for axis, name, colour in zip((2, 1, 0), ("shortest", "middle", "longest"), COLOURS, strict=False):
        right.plot(times, [shape.axes[axis] for shape in shapes], color=colour, label=name)
    label(right, "time", "semi-axis", "s", "m", legend=True)
    return figure
