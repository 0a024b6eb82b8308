"""Figures and films of a run that are drawn by the Python module of its gallery case."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pellucid import catalogue
from pellucid.errors import UsageError
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.storage.files import OutputError


def drawn_by_module(run: Run, kind: str) -> dict[str, Any]:
    """Return the figures or the films (`kind`: "figures" or "films") that the Python module of the gallery case defines, by
    name.

    A figure is a matplotlib figure or a function that returns one; a film is an `Animation`. The result is empty if the case
    has no module. It is also empty, with a warning, if the module cannot draw this run.
    """
    make = getattr(catalogue.module(run.stored.id), kind, None)
    try:
        return dict(make(run)) if make else {}
    except Exception as error:  # a run stopped early or changed by settings may be none that the module can draw
        _warn(run, kind, error)
        return {}


def drawn(run: Run, figure: "Figure | Callable[[], Figure]") -> "Figure | None":
    """Return a figure that the Python module of the gallery case provides; `figure` is the figure or a function that
    returns the figure. Return None, with a warning, if the module cannot draw this run."""
    try:
        return figure() if callable(figure) else figure
    except OutputError:
        raise
    except Exception as error:
        _warn(run, "figures", error)
        return None


def _warn(run: Run, kind: str, error: Exception) -> None:
    warnings.warn(f"the {kind} of {run.stored.id} could not be drawn for this run: {error}", stacklevel=3)


@contextmanager
def noticed(notices: list[str], name: str = "") -> Iterator[None]:
    """Skip the picture drawn in the block if its files are damaged or missing, or if it would be empty, and append the reason
    to `notices`. name: name of the picture, put before the reason."""
    try:
        yield
    except (OutputError, UsageError) as error:
        text = str(error) if isinstance(error, OutputError) or not name else f"{name}: {error}"  # damage stops them all
        if text not in notices:
            notices.append(text)


def captions(run: Run) -> dict[str, str]:
    """Return the captions of the figures and films that the module of the gallery case draws, by name; empty if the module
    has no captions."""
    return dict(getattr(catalogue.module(run.stored.id), "CAPTIONS", {}))
