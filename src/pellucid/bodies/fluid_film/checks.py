"""Checks of the settings of a fluid film, with its own velocity field or in one that it shares with other bodies."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.conditions.volume_constraints import reduced_to_volume
from pellucid.bodies.placing import longest_edge, place_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.meshes.points import coincident
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.bodies.fluid_film.model import FluidFilmCase

THINNEST = 0.05  # smallest density of a film, relative to its rest density


def own_problems(film: "FluidFilmCase", path: Path) -> Iterator[Finding]:
    """Yield findings (errors of the case) for settings of a film that do not depend on other bodies: its volume, its shape and
    the interpolation between its nodes. path: path of the film in the data of the case.
    """
    if film.volume is not None:
        yield from film.volume.problems((*path, "volume"), film.shape.span == "plane", film.area == "kept")
    interpolation, surface, rest = (*path, "interpolation"), film.shape.surface, film.material.density
    if film.initial_density < THINNEST * rest:
        text = f"{film.initial_density:g} kg/m^2 is below {THINNEST:g} of the rest density {rest:g} kg/m^2: too thin for a film"
        yield Finding((*path, "density"), text, "increase it, or reduce the density of the material")
    if surface is None and film.interpolation == "loop":
        text = "Loop subdivision applies to surfaces in space, but this film is described by a curve"
        yield Finding(interpolation, text, "remove `interpolation`")
    yield from _place_problems(film, (*path, "shape"))
    if surface is not None and film.interpolation == "radial" and film.material.bending_rigidity > 0.0:
        text = "a surface of radial functions with bending does not reach equilibrium: its curvature is too noisy"
        yield Finding(interpolation, text, 'use "loop", or remove `bending_rigidity`')


def _thickness_problems(film: "FluidFilmCase", path: Path) -> Iterator[Finding]:
    """Yield a finding (an error of the case) if the reduced volume is so small that opposite sides of the film would be closer
    than the node spacing. path: path of the film in the data of the case.
    """
    if film.volume is None or film.volume.reduced is None:
        return
    reduced, plane, in_space = film.volume.reduced, film.shape.span == "plane", film.shape.span == "space"
    corners = film.positions()[film.sides()]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    if plane:
        area = float(edges[:, 0].sum())
    elif in_space:
        area = float(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()) / 2.0
    else:
        area = float(2.0 * np.pi * corners[:, :, 0].mean(axis=1) @ edges[:, 0])
    spacing, full = float(np.median(edges)), reduced_to_volume(1.0, area, plane)
    least = 0.5 * area * spacing / full  # of a disc or a band of thickness 2 V/A, or a tube of that radius
    if reduced >= least:
        return
    text = f"a reduced volume of {reduced:g} would leave {2.0 * reduced * full / area:.2g} m between the sides of the film, "
    text += f"but its nodes are {spacing:.2g} m apart"
    more = (least / reduced) ** (2 if in_space else 1)
    remedy = (
        f"use a value of at least {np.ceil(1000.0 * least) / 1000.0:g}, or {np.ceil(11.0 * more) / 10.0:g} times as many nodes"
    )
    yield Finding((*path, "volume", "reduced"), text, remedy)


def _place_problems(film: "FluidFilmCase", path: Path) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a surface that is open or invalid, coincident nodes, and too few nodes for the
    volume.

    path: path of the film in the data of the case.
    """
    surface = film.shape.surface
    if surface is not None:
        place = (*path, "surface")
        if not surface.closed:
            yield Finding(place, "the surface is open, but a film must be closed", "use a surface that encloses a volume")
            return
        found = [Finding(place, text, remedy) for text, remedy in faults(*surface.triangulate(), closed=True)]
        yield from found
        if found:
            return
    places = film.positions()
    if pair := coincident(places, film.sides()):
        at = ", ".join(f"{value:g}" for value in places[pair[0]])
        text = f"the film has two nodes at one position, ({at}) m: a film cannot touch itself"
        yield Finding(path, text, "move the two nodes apart, or merge them into one")
        return
    yield from _thickness_problems(film, path[:-1])


def problems_alone(film: "FluidFilmCase", path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a film that has its own velocity field, or no grid.

    path: path of the film in the data of the case; parts: all parts of the case.
    """
    if film.velocity != (0.0, 0.0, 0.0) or film.initial:
        text = (
            "an initial velocity applies to films that share their velocity field; the "
            "velocity of other films follows from their loads"
        )
        yield Finding((*path, "initial" if film.initial else "velocity"), text, "remove it")
    if other := next((body for body in parts.of(BodyModel) if body.kind != film.kind), None):
        text = f"the film has its own velocity field and cannot touch body {other.name}: a film has no inertia for contact"
        yield Finding((*path, "field"), text, f'use field = "{other.field}", to move it with that body')
    bends, some = film.material.bending_rigidity > 0.0, min(film.drag.normal, film.drag.tangential) > 0.0
    if film.shape.span == "plane" and bends and not some:
        text = "a curve with bending needs drag: otherwise nothing resists motions that bend it without stretching"
        yield Finding((*path, "drag"), text, "add `drag`, the drag coefficients of the surrounding fluid")


def problems_in_fluid(film: "FluidFilmCase", path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a film that shares its velocity field with other bodies.

    path: path of the film in the data of the case; parts: all parts of the case.
    """
    grid, shape = parts.grid, (*path, "shape")
    if grid is None:
        return
    plane = film.shape.span == "plane"
    if film.is_around:
        text = "a surface of revolution cannot share the velocity field of other bodies, which are three-dimensional"
        yield Finding(shape, text, "use a `surface`, or an `ellipse` or a `curve` in a plane grid")
        return
    if grid.thin() != (False, False, plane):
        needed = "one cell thick along z only" if plane else "more than one cell thick along every axis"
        text = f"the film shares the velocity field of other bodies: the grid must be {needed}"
        yield Finding(shape, text, "change grid.lower or grid.upper, or the shape")
    else:
        yield from place_problems(shape, film.bounds(), grid, is_surface=True)
    for key, given, why in (
        ("volume", film.volume is not None, "the fluid inside determines the volume"),
        ("area", film.area == "kept", "set the `stiffness` of the material instead, which resists changes of the area"),
        ("drag", film.has_drag, "the surrounding fluid is computed"),
    ):
        if given:
            text = f"this key applies to films with their own velocity field; in a shared field {why}"
            yield Finding((*path, key), text, "remove this key")
    spacing = longest_edge(film.positions()[film.sides()])
    if spacing > grid.cell:
        more = np.ceil(11.0 * spacing / grid.cell) / 10.0
        text = (
            f"the film has nodes up to {spacing:.3g} m apart, more than a cell of "
            f"{grid.cell:g} m: fluid would pass between them"
        )
        yield Finding(shape, text, f"use {more:g} times as many nodes along it, or a larger grid.cell")
