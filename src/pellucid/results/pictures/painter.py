"""Drawing of the pictures of a run, one at a time, in this process and in worker processes."""

import warnings
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from pellucid import catalogue
from pellucid.progress import Progress
from pellucid.results.pictures import figures
from pellucid.results.pictures.films import Animation, pixels_of, write_film
from pellucid.results.pictures.own import drawn_by_module, films, noticed
from pellucid.results.pictures.style import house_style
from pellucid.results.storage.files import drawing, explained
from pellucid.results.storage.run import Run
from pellucid.system.processes import Helper, free_cores, helped, shared

MOST_HELPERS = 3
MANY_POINTS = {True: 5_000, False: 20_000}
"""Smallest number of points for which worker processes draw, with and without a film; below, drawing takes less time than
their start."""


class FilmPicture(NamedTuple):
    """One picture of a film, as a job for `Painter.draw`."""

    film: str  # name of the film
    time: float  # time at which the picture shows the run [s]


class Painter:
    """Draws the pictures of a run, one at a time. If files of the run are damaged, `draw_or_notice` appends a text to
    `notices`.

    beside: another run, whose probes are drawn together with the probes of the run.
    """

    def __init__(self, run: Run, beside: Run | None = None) -> None:
        self._run, self._beside = run, beside
        self.notices: list[str] = []

    @cached_property
    def films(self) -> dict[str, Animation]:
        """The films that the case or the module of its gallery case defines, by name."""
        with house_style():
            return films(self._run, self.notices) | drawn_by_module(self._run, "films")

    @cached_property
    def figures(self) -> "dict[str, figures.Draw]":
        """The functions that draw the figures, by name in the order of the report."""
        with house_style():
            return figures.figures_of(self._run, self._beside, self.notices)

    def draw(self, picture: FilmPicture | str) -> Any:
        """Draw one picture and return it: the RGB pixels of a film picture, shape (rows, columns, 3), or the PNG data and
        title of the figure named `picture`. Return None if there is nothing to draw in the figure."""
        with house_style():
            if isinstance(picture, FilmPicture):
                return pixels_of(self.films[picture.film].draw(picture.time))
            figure = self.figures[picture]()
            return None if figure is None else figures.picture_of(figure)

    def draw_or_notice(self, picture: FilmPicture | str) -> Any:
        """Draw one picture and return it as `draw` does; if files of the run are damaged or missing, return None and append
        the reason to `notices`."""
        drawn = None
        with noticed(self.notices, picture.film if isinstance(picture, FilmPicture) else picture):
            drawn = self.draw(picture)
        return drawn


def write_pictures(
    run: Run, beside: Run | None, progress: Progress, notices: list[str], helpers: Sequence[Helper] | None = None
) -> dict[Path, str]:
    """Draw the films and figures of a run into its folder; return the titles of the pictures by path, in the order of the
    report.

    beside: another run, whose probes are drawn together with the probes of the run. A text is appended to `notices` for
    each picture that cannot be drawn because files of the run are damaged. helpers: worker processes of `drawing_helpers`,
    if they have already been started.
    """
    if helpers is None:
        helpers = drawing_helpers(run, beside)
    with helped(helpers):
        painter = Painter(run, beside)
        progress.begin("drawing")
        names = [FilmPicture(name, float(time)) for name, film in painter.films.items() for time in film.times]
        jobs = [*painter.figures, *names]  # what takes longest first, so that all end together
        progress.begin("drawing", len(jobs))
        drawn = dict(zip(jobs, shared(jobs, painter.draw_or_notice, helpers, progress.count), strict=True))
    titles = {}
    with explained(run.out):
        run.folder.figures.mkdir(exist_ok=True)
        for name in painter.films:
            pixels = [drawn[job] for job in names if job.film == name]
            if all(picture is not None for picture in pixels):
                path = run.folder.figures / f"{name}.gif"
                write_film(pixels, path)
                titles[path] = ""
        for name in painter.figures:
            if drawn[name] is not None:
                path = run.folder.figures / f"{name}.png"
                with drawing(path) as temporary:
                    temporary.write_bytes(drawn[name].data)
                titles[path] = drawn[name].title
    notices += painter.notices
    return titles


def drawing_helpers(run: Run, beside: Run | None = None) -> list[Helper]:
    """Start worker processes that draw the pictures of a run, and return their handles; return an empty list if the run has
    too few points for worker processes to save time. beside: another run, whose probes are drawn together with the probes
    of the run."""
    has_film = len(run.stored.film) > 0 or hasattr(catalogue.module(run.stored.id), "films")
    if run.so_far.get("points", 0) < MANY_POINTS[has_film]:
        return []
    return [Helper(_draw_in, run.out, beside and beside.out) for _ in range(min(MOST_HELPERS, free_cores()))]


def _draw_in(out: Path, beside: Path | None) -> Any:
    """Return the function `Painter.draw` for the run in the folder `out`, compared with the run in the folder `beside`.
    Called in a worker process, where warnings become errors, so that the parent process draws these pictures again and
    shows the warning."""
    warnings.simplefilter("error", UserWarning)
    return Painter(Run(out), Run(beside) if beside else None).draw
