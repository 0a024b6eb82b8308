"""What does not go with a film that shares its velocity field with other bodies."""

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np

from pellucid.bodies.placing import longest_edge, place_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.film_shapes import FilmShape
from pellucid.parts.part import Parts


class Film(Protocol):
    """A film, as its model describes it."""

    @property
    def shape(self) -> FilmShape: ...
    @property
    def volume(self) -> Any: ...
    @property
    def area(self) -> str: ...
    @property
    def has_drag(self) -> bool: ...
    @property
    def is_around(self) -> bool: ...
    def positions(self) -> np.ndarray: ...
    def sides(self) -> np.ndarray: ...
    def bounds(self) -> tuple[np.ndarray, np.ndarray]: ...


def problems_in_fluid(film: Film, path: Path, parts: Parts) -> Iterator[Finding]:
    """Findings of a film at a path."""
    grid, shape = parts.grid, (*path, "shape")
    if grid is None:
        return
    plane = film.shape.span == "plane"
    if film.is_around:
        text = "a surface of revolution does not share the velocity field of other bodies, which are in space"
        yield Finding(shape, text, "use a `surface`, or an `ellipse` or a `curve` in a plane grid")
        return
    if grid.thin() != (False, False, plane):
        needed = "one cell thick along z, and along z alone" if plane else "more than one cell thick along every axis"
        text = f"shares the velocity field of other bodies: the grid must be {needed}"
        yield Finding(shape, text, "change grid.lower or grid.upper, or the shape")
    else:
        yield from place_problems(shape, film.bounds(), grid, is_surface=True)
    for key, given, why in (
        ("volume", film.volume is not None, "the fluid inside holds the volume"),
        ("area", film.area == "kept", "a `stiffness` of the material holds the area"),
        ("drag", film.has_drag, "the fluid about it is there itself"),
    ):
        if given:
            text = f"is for films that share their velocity field with no other body; with others {why}"
            yield Finding((*path, key), text, "leave it out")
    spacing = longest_edge(film.positions()[film.sides()])
    if spacing > grid.cell:
        text = f"has nodes up to {spacing:.3g} m apart, more than a cell of {grid.cell:g} m: fluid would pass between them"
        yield Finding(shape, text, "use more nodes, or a larger grid.cell")
