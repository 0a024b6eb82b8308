"""Pictures of bodies that are curves: films in the plane, or meridians of surfaces of revolution with their mirror image."""

from itertools import repeat

import numpy as np

from pellucid.results.pictures.annotations import Axes, Figure, Run
from pellucid.results.pictures.quantities import BY_BODY, Fields, Look, colours_of, explain, limits_of, values_of
from pellucid.results.pictures.style import label

ARROWS = 40  # on a film, at most
LONGEST = 0.12  # of the picture's width, of an arrow


def are_curves(run: Run, names: tuple[str, ...] = ()) -> bool:
    """Return True if every body of a run, or each of the named bodies, is a fluid film that is a curve: the body has line
    elements and stores an areal density."""
    return all(_is_curve(run, name) for name in names or [body.name for body in run.stored.bodies])


def _is_curve(run: Run, name: str) -> bool:
    cells = run.cells(name)
    return bool(len(cells.lines)) and not len(cells.triangles) and "areal_density" in run.fields(name, 0.0)


class CurveStage:
    """Object that draws fluid films that are curves, with arrows of their velocity and the same scales in all pictures of a
    figure (a `Stage`).

    look: settings of the picture. times: times of all pictures [s], from which the scales follow.
    """

    def __init__(self, run: Run, look: Look, times: np.ndarray) -> None:
        self._run, self._look = run, look
        self._bodies = [body for body in run.stored.bodies if body.name in (look.names or {body.name})]
        states = [self._state(float(time)) for time in times]
        self._lines = [run.cells(body.name).lines for body in self._bodies]
        self._start = [run.fields(body.name, 0.0, ("position",))["position"] for body in self._bodies]
        # the axes of the plane in which a curve lies: x and y, or of a meridian x, which is r, and z
        self._planes = [[0, 1] if np.ptp(fields["position"][:, 1]) > 0.0 else [0, 2] for fields in states[0]]
        places = [_mirrored(f["position"][:, axes], axes) for s in states for f, axes in zip(s, self._planes, strict=True)]
        together = np.concatenate(places)
        self._colours = limits_of([values for state in states for values in self._values(state)], look)
        self._low, self._high = together.min(axis=0), together.max(axis=0)
        self._margin = (LONGEST + 0.02) * float((self._high - self._low).max())

    @property
    def ratio(self) -> float:
        """Ratio of height to width of the picture."""
        return float((self._high - self._low)[1] / (self._high - self._low)[0])

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to `time` [s] on axes. width: width of the axes [inch]."""
        from matplotlib.collections import LineCollection

        low, high, margin = self._low, self._high, self._margin
        state = self._state(time)
        fastest = max(float(np.linalg.norm(fields["velocity"], axis=1).max()) for fields in state)
        own = colours_of(body.name for body in self._bodies).values() if self._look.quantity == BY_BODY else repeat(None)
        curves = zip(state, self._lines, self._planes, self._values(state), own, strict=False)
        for fields, ends, plane, values, colour in curves:
            place, speed = fields["position"][:, plane], fields["velocity"][:, plane]
            for sign in (1.0, -1.0) if plane == [0, 2] else (1.0,):
                turned = np.array([sign, 1.0])
                drawn = LineCollection(turned * place[ends], linewidths=3.0, capstyle="round", cmap=self._colours.palette)
                if colour is None:
                    drawn.set_array(values[ends].mean(axis=1))
                    drawn.set_clim(self._colours.low, self._colours.high)
                else:
                    drawn.set_color(colour)
                axes.add_collection(drawn)
                if fastest > 0.0:
                    some = slice(None, None, -(-len(place) // ARROWS))
                    arrows = turned * speed[some] * (LONGEST * float((high - low)[0]) / fastest)
                    x, y = (turned * place[some]).T
                    axes.quiver(x, y, *arrows.T, angles="xy", scale_units="xy", scale=1.0, width=0.004, color="#334", zorder=3)
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
        axes.grid(False)
        axes.set_title(f"t = {time:.4g} s\nlargest speed {fastest:.3g} m/s")
        around = self._planes[0] == [0, 2]
        label(axes, "r" if around else "x", "z" if around else "y", "m", "m")
        axes.label_outer()

    def bar(self, figure: Figure) -> None:
        explain(figure, self._bodies, self._look, self._colours, shrink=0.9)

    def _state(self, time: float) -> list[Fields]:
        return [self._run.fields(body.name, time) for body in self._bodies]

    def _values(self, state: list[Fields]) -> list[np.ndarray]:
        of = zip(self._bodies, state, self._start, strict=True)
        return [values_of(body, fields, self._look, start) for body, fields, start in of]


def _mirrored(places: np.ndarray, axes: list[int]) -> np.ndarray:
    return np.concatenate([places, places * np.array([-1.0, 1.0])]) if axes == [0, 2] else places
