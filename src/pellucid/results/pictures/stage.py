"""Drawing of bodies at several times with the same scales, side by side or as a film."""

from collections.abc import Sequence
from typing import Protocol

from pellucid.results.pictures.annotations import Axes, Figure
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.style import WIDTH, new_figure, panels

MOST_HEIGHT = 7.0  # of the panels together [inch]
BAR, WORDS = 1.4, 0.3  # beside the panels, and above each [inch]
FILM_SIDE = 5.5  # of a picture of a film, at most [inch]


class Stage(Protocol):
    """Object that draws the bodies of a run at any time; all pictures of a figure or film have the same scales of position
    and colour. Figures and films are composed with it (`side_by_side`, `film_of`)."""

    @property
    def ratio(self) -> float:
        """Ratio of height to width of a picture."""

    def draw(self, axes: Axes, time: float, width: float) -> None:
        """Draw the frame nearest to a time [s] on axes; width: width of the axes [inch]."""

    def bar(self, figure: Figure) -> None:
        """Draw the colour bar of the shown quantity, or a legend if each body has its own colour."""


def side_by_side(stage: Stage, times: Sequence[float]) -> Figure:
    """Return a figure of the bodies at several times [s], one panel each, as large as the page allows."""
    down, width = _arrangement(stage.ratio, len(times))
    across = -(-len(times) // down)
    size = {"width": min(WIDTH, across * width + BAR), "height": down * (width * stage.ratio + WORDS) + 0.75}
    figure, drawn = panels(len(times), across, layout="compressed", sharex=True, sharey=True, **size)
    for axes, time in zip(drawn, times, strict=True):
        stage.draw(axes, float(time), width)
    stage.bar(figure)
    return figure


def film_of(stage: Stage, times: Sequence[float]) -> Animation:
    """Return a film of the bodies at several times [s]."""
    width = FILM_SIDE * min(1.0, 1.0 / stage.ratio)

    def draw(time: float) -> Figure:
        figure = new_figure(width + BAR, width * stage.ratio + 2.0 * WORDS, layout="compressed")
        stage.draw(figure.subplots(), time, width)
        stage.bar(figure)
        return figure

    return Animation(draw, [float(time) for time in times])


def _arrangement(ratio: float, panels: int) -> tuple[int, float]:
    """Arrange panels on a page so that they are as large as possible; return the number of rows and the width of a panel
    [inch]. ratio: height to width of a panel."""
    best = (1, 0.0)
    for down in range(1, panels + 1):
        across = -(-panels // down)
        width = min((WIDTH - BAR) / across, (MOST_HEIGHT / down - WORDS) / ratio)
        if width > best[1]:
            best = (down, width)
    return best
