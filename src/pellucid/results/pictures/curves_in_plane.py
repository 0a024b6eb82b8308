"""Pictures of bodies that are curves: films in the plane, or meridians of surfaces of revolution with their mirror image."""

import numpy as np

from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.bodies_in_plane import INSTANTS
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.instants import evenly
from pellucid.results.pictures.quantities import limits
from pellucid.results.pictures.style import SEQUENTIAL, colour_bar, label, new_panels, panels, with_unit
from pellucid.state import FIELDS

PICTURES = 60  # of a film
ARROWS = 40  # on a film, at most
LONGEST = 0.12  # of the picture's width, of an arrow


def are_curves(run: Run) -> bool:
    """Whether every body of a run is a curve."""
    return all(_is_curve(run, body.name) for body in run.stored.bodies)


def _is_curve(run: Run, name: str) -> bool:
    cells = run.cells(name)
    return bool(len(cells.lines)) and not len(cells.triangles) and "areal_density" in run.fields(name, 0.0)


class Stage:
    """Films drawn at one instant after the other, to the same scales of place and density."""

    def __init__(self, run: Run, times: np.ndarray) -> None:
        self._run, self._names = run, [body.name for body in run.stored.bodies if _is_curve(run, body.name)]
        states = [[run.fields(name, float(time)) for name in self._names] for time in times]
        self._lines = [run.cells(name).lines for name in self._names]
        # the axes of the plane in which a curve lies: x and y, or of a meridian x, which is r, and z
        self._planes = [[0, 1] if np.ptp(fields["position"][:, 1]) > 0.0 else [0, 2] for fields in states[0]]
        places = [_mirrored(f["position"][:, axes], axes) for s in states for f, axes in zip(s, self._planes, strict=True)]
        together = np.concatenate(places)
        self.colours = limits([fields["areal_density"] for bodies in states for fields in bodies])
        self._low, self._high = together.min(axis=0), together.max(axis=0)
        self._margin = (LONGEST + 0.02) * float((self._high - self._low).max())

    @property
    def ratio(self) -> float:
        """Height over width."""
        return float((self._high - self._low)[1] / (self._high - self._low)[0])

    def draw(self, axes: Axes, time: float) -> None:
        """The films at an instant [s], coloured by their density, with arrows of the velocity."""
        from matplotlib.collections import LineCollection

        low, high, margin = self._low, self._high, self._margin
        bodies = [self._run.fields(name, time) for name in self._names]
        fastest = max(float(np.linalg.norm(fields["velocity"], axis=1).max()) for fields in bodies)
        for fields, ends, plane in zip(bodies, self._lines, self._planes, strict=True):
            place, speed, density = fields["position"][:, plane], fields["velocity"][:, plane], fields["areal_density"]
            for sign in (1.0, -1.0) if plane == [0, 2] else (1.0,):
                turned = np.array([sign, 1.0])
                drawn = LineCollection(turned * place[ends], linewidths=3.0, capstyle="round")
                drawn.set_array(density[ends].mean(axis=1))
                drawn.set_clim(self.colours.low, self.colours.high)
                axes.add_collection(drawn)
                if fastest > 0.0:
                    some = slice(None, None, -(-len(place) // ARROWS))
                    arrows = turned * speed[some] * (LONGEST * float((high - low)[0]) / fastest)
                    x, y = (turned * place[some]).T
                    axes.quiver(x, y, *arrows.T, angles="xy", scale_units="xy", scale=1.0, width=0.004, color="#334", zorder=3)
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        axes.grid(False)
        axes.set_title(f"t = {time:.4g} s\nfastest {fastest:.3g} m/s")
        around = self._planes[0] == [0, 2]
        label(axes, "r" if around else "x", "z" if around else "y", "m", "m")

    def bar(self, figure: Figure) -> None:
        """The colours of the density beside the panels."""
        colour_bar(figure, with_unit("density in the surface", FIELDS["areal_density"].unit), self.colours, SEQUENTIAL, 0.9)


def curves_in_plane(run: Run) -> Figure:
    """All films at some instants, coloured by their density, with arrows of the velocity."""
    times = run.times(run.stored.bodies[0].name)
    chosen = times[np.unique(np.linspace(0, len(times) - 1, INSTANTS).astype(int))]
    stage = Stage(run, chosen)
    down = 1 if stage.ratio > 0.7 else 2
    across, height = -(-len(chosen) // down), min(6.5, 0.9 + down * stage.ratio * 8.0 * down / len(chosen) * 0.9)
    figure, shown = panels(len(chosen), across, height=height, layout="compressed", sharex=True, sharey=True)
    for axes, time in zip(shown, chosen, strict=True):
        stage.draw(axes, float(time))
        axes.label_outer()
    stage.bar(figure)
    return figure


def film_of_curves(run: Run) -> Animation:
    """The same, moving."""
    times = evenly(run.times(run.stored.bodies[0].name), PICTURES)
    stage = Stage(run, times)

    def draw(time: float) -> Figure:
        figure, axes = new_panels(width=6.0, height=min(7.0, 1.0 + 4.6 * stage.ratio))
        stage.draw(axes, time)
        stage.bar(figure)
        return figure

    return Animation(draw, [float(time) for time in times])


def _mirrored(places: np.ndarray, axes: list[int]) -> np.ndarray:
    return np.concatenate([places, places * np.array([-1.0, 1.0])]) if axes == [0, 2] else places
