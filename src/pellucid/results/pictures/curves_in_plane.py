"""Pictures of bodies that are curves: films in the plane, or meridians of surfaces of revolution with their mirror image."""

from typing import TYPE_CHECKING

import numpy as np

from pellucid.results.pictures.bodies_in_plane import INSTANTS
from pellucid.results.pictures.quantities import limits
from pellucid.results.pictures.style import label, new_figure, with_unit
from pellucid.state import FIELDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pellucid.results.storage.run import Run

ARROWS = 40  # on a film, at most
LONGEST = 0.12  # of the picture's width, of an arrow


def are_curves(run: "Run") -> bool:
    """Whether every body of a run is a curve."""
    cells = [run.cells(body.name) for body in run.stored.bodies]
    return all(len(of.lines) and not len(of.triangles) for of in cells) and all(
        "areal_density" in run.fields(body.name, 0.0) for body in run.stored.bodies
    )


def curves_in_plane(run: "Run") -> "Figure":
    """All films at some instants, coloured by their density, with arrows of the velocity."""
    from matplotlib.collections import LineCollection

    names = [body.name for body in run.stored.bodies]
    times = run.times(names[0])
    chosen = times[np.unique(np.linspace(0, len(times) - 1, INSTANTS).astype(int))]
    states = [[run.fields(name, time) for name in names] for time in chosen]
    lines = [run.cells(name).lines for name in names]
    flat = [_flat(fields["position"]) for fields in states[0]]
    together = np.concatenate(
        [_mirrored(fields["position"][:, axes], axes) for s in states for fields, axes in zip(s, flat, strict=True)]
    )
    colours = limits([fields["areal_density"] for bodies in states for fields in bodies])
    low, high = together.min(axis=0), together.max(axis=0)
    margin = 0.08 * float((high - low).max())
    ratio = float((high - low)[1] / (high - low)[0])
    down = 1 if ratio > 0.7 else 2
    figure = new_figure(height=min(6.5, 0.9 + down * ratio * 8.0 * down / len(chosen) * 0.9), layout="compressed")
    panels = figure.subplots(down, -(-len(chosen) // down), sharex=True, sharey=True, squeeze=False).ravel()
    for unused in panels[len(chosen) :]:
        unused.remove()
    for axes, bodies, time in zip(panels, states, chosen, strict=False):
        fastest = max(float(np.linalg.norm(fields["velocity"], axis=1).max()) for fields in bodies)
        for fields, ends, plane in zip(bodies, lines, flat, strict=True):
            place, speed, density = fields["position"][:, plane], fields["velocity"][:, plane], fields["areal_density"]
            for sign in (1.0, -1.0) if plane == [0, 2] else (1.0,):
                turned = np.array([sign, 1.0])
                drawn = LineCollection(turned * place[ends], linewidths=3.0, capstyle="round")
                drawn.set_array(density[ends].mean(axis=1))
                drawn.set_clim(colours.low, colours.high)
                axes.add_collection(drawn)
                if fastest > 0.0:
                    some = slice(None, None, -(-len(place) // ARROWS))
                    arrows = turned * speed[some] * (LONGEST * float((high - low)[0]) / fastest)
                    x, y = (turned * place[some]).T
                    axes.quiver(x, y, *arrows.T, angles="xy", scale_units="xy", scale=1.0, width=0.004, color="#334", zorder=3)
        axes.set_xlim(low[0] - margin, high[0] + margin)
        axes.set_ylim(low[1] - margin, high[1] + margin)
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_title(f"t = {time:.4g} s\nfastest {fastest:.3g} m/s")
        label(axes, "r" if flat[0] == [0, 2] else "x", "z" if flat[0] == [0, 2] else "y", "m", "m")
        axes.label_outer()
    bar = figure.colorbar(drawn, ax=list(panels[: len(chosen)]), shrink=0.9, pad=0.01, aspect=25, extend=colours.extend)
    bar.set_label(with_unit("density in the surface", FIELDS["areal_density"].unit))
    bar.outline.set_visible(False)
    return figure


def _flat(position: np.ndarray) -> list[int]:
    """The axes of the plane in which a curve lies: x and y, or of a meridian x, which is r, and z."""
    return [0, 1] if np.ptp(position[:, 1]) > 0.0 else [0, 2]


def _mirrored(places: np.ndarray, axes: list[int]) -> np.ndarray:
    return np.concatenate([places, places * np.array([-1.0, 1.0])]) if axes == [0, 2] else places
