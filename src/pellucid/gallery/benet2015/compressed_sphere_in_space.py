"""Compressed sphere in space against the exact motion."""

from pellucid.gallery.benet2015.films import film_of
from pellucid.gallery.benet2015.growing import CAPTIONS, METRICS, figures, metrics
from pellucid.results.pictures.annotations import Run
from pellucid.results.pictures.films import Animation
from pellucid.results.pictures.surfaces_in_space import film_of_surfaces

__all__ = ["CAPTIONS", "METRICS", "figures", "films", "metrics"]


def films(run: Run) -> dict[str, Animation]:
    """The sphere with its density and what flows in it."""
    return {"motion": film_of_surfaces(run, [film_of(run).name])}
