"""Seeding: fills shapes with material points, and returns their initial arrays."""

from collections.abc import Callable, Mapping, Sequence
from math import fsum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.material_points.cutting import FilledRegion
from pellucid.bodies.material_points.hydrostatic import REMEDY, NoRest, states_by_height
from pellucid.bodies.material_points.seed_lattice import SeedLattice
from pellucid.errors import CaseError, Problem
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.implicit_viscosity import VISCOUS_STRESS
from pellucid.grid.model import GridCase
from pellucid.materials.point_state import initial_arrays
from pellucid.model import Vector
from pellucid.ranks.domain import domain
from pellucid.reductions import exact_parts

if TYPE_CHECKING:
    from pellucid.bodies.material_points.seeded_body import SeededBody


def points_along_axes(
    points_per_cell: int | tuple[int, int, int] | None, thin: tuple[bool, bool, bool]
) -> tuple[int, int, int]:
    """Return the number of points per cell along x, y, z.

    points_per_cell: number in a cell, or numbers along the axes; None: two along each axis that is not thin; thin: True for
    axes along which the grid has one cell. A single number is distributed equally over the axes with more than one cell.
    Raises ValueError if an equal distribution is impossible.
    """
    if isinstance(points_per_cell, tuple):
        return points_per_cell
    active = 3 - sum(thin)
    each = 2 if points_per_cell is None else round(float(points_per_cell) ** (1.0 / active))
    if points_per_cell is not None and each**active != points_per_cell:
        listed = ", ".join(str(n**active) for n in range(1, 6))
        raise ValueError(
            f"points_per_cell = {points_per_cell} cannot be distributed equally among {active} axes; "
            f"use one of {listed}, or list the points along x, y, z"
        )
    x, y, z = (1 if flat else each for flat in thin)
    return x, y, z


Wanted = Callable[[np.ndarray], np.ndarray]
"""Function that selects points by their positions [m], shape (k, 3): returns the indices of the selected ones in ascending
order."""


class Seeds(NamedTuple):
    """Numbers, positions and volumes of m selected material points among the n points that fill a region."""

    number: np.ndarray  # (m,) numbers of the selected points among all, ascending
    position: np.ndarray  # (m, 3) [m]
    volume: np.ndarray  # (m,) [m³]
    n: int  # number of all points


def everywhere(position: np.ndarray) -> np.ndarray:
    """Return the indices of all positions, shape (n,): a selection function that selects every point."""
    return np.arange(len(position))


def seed(
    shape: Geometry,
    grid: GridCase,
    per_cell: tuple[int, int, int],
    left_out: Sequence[Geometry] = (),
    wanted: Wanted = everywhere,
) -> Seeds:
    """Fill a shape, minus the excluded regions, with material points, and return the points that `wanted` selects.

    per_cell: number of points per grid cell along x, y and z; left_out: excluded regions; wanted: function that returns the
    indices of the selected positions. A box, and any other shape that provides its own lattice, is filled by that lattice with
    equal volumes. Other shapes are filled by the points of the grid's lattice that lie inside: each has the volume of the part
    of its lattice cell inside the shape, and lies at the centroid of this part. A box with excluded regions is filled in the
    same way, but its points stay on the lattice (see `pellucid.bodies.material_points.cutting`). The sum of the volumes is
    exactly the volume of the shape. Points that are not selected are dropped, some layers of the lattice at a time. Raises
    ValueError if remaining parts are too thin for the spacing of the points.
    """
    if shape.n_own_points() is not None and not left_out:
        position, volume = shape.own_points()
        number = wanted(position)
        return Seeds(number, position[number], volume[number], len(position))
    x, y, z = (not flat for flat in grid.thin())
    cells = SeedLattice.of(shape, grid, per_cell)
    region = FilledRegion(shape, left_out, cells, (x, y, z))
    n, total, found = 0, list[float](), list[tuple[np.ndarray, ...]]()
    for position, share in region.points():
        chosen = wanted(position)
        found.append((n + chosen, position[chosen], share[chosen]))
        total += exact_parts(share)
        n += len(position)
    number, position, share = (np.concatenate(parts) for parts in zip(*found, strict=True))
    shares = fsum(total)
    whole = region.measure(shares) * grid.slice_thickness() ** sum(grid.thin()) / (shares or 1.0)
    return Seeds(number, position, share * whole, n)


def seeded_arrays(case: "SeededBody", grid: GridCase, here: Wanted, gravity: Vector) -> tuple[dict[str, np.ndarray], int]:
    """Return the initial arrays of the points that `here` selects, in memory with room for all points of the body, and the
    number of selected points. here: function that returns the indices of the selected positions; gravity: [m/s²].
    """
    seeds = case.seeded(grid, everywhere if case.has_users_fields else here)
    arrays = {"id": seeds.number, **arrays_at(case, seeds.position, seeds.volume, gravity)}
    if case.has_users_fields:
        chosen = here(seeds.position)
        arrays = {name: values[chosen] for name, values in arrays.items()}
    return {name: with_room(values, seeds.n) for name, values in arrays.items()}, len(arrays["id"])


def arrays_at(case: "SeededBody", position: np.ndarray, volume: np.ndarray, gravity: Vector) -> dict[str, np.ndarray]:
    """Build the initial arrays (mass, velocity, material state) of points at positions [m], shape (n, 3), with volumes [m³],
    shape (n,). gravity: [m/s²], for a hydrostatic start.
    """
    density, state = _initial_state(case, position, gravity)
    velocity = case.initial_velocity(position)
    arrays = {"position": position, "velocity": velocity, "mass": density * volume, "volume": volume, **state}
    if case.material.implicit_viscosities() is not None:
        arrays[VISCOUS_STRESS] = np.zeros((len(position), 6))
    case.add_initial_state(arrays)
    return arrays


def with_room(values: np.ndarray, n: int) -> np.ndarray:
    """Return an array of n rows, of which the first are `values`, one for each point; the memory of the other rows is
    allocated on first use.
    """
    if len(values) == n:
        return values
    array = np.zeros((n, *values.shape[1:]), values.dtype)
    array[: len(values)] = values
    return array


def _initial_state(case: "SeededBody", position: np.ndarray, gravity: Vector) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
    material, n = case.material, len(position)
    if case.initial_stress is not None:
        density, state = material.stressed(case.initial_stress)
        return np.full(n, density), initial_arrays(state, n)
    if case.hydrostatic is None:
        return np.full(n, material.density), initial_arrays(material.initial_state(), n)
    try:
        return states_by_height(case.hydrostatic, material, case.bounds(), gravity, position, domain.largest)
    except NoRest as error:
        raise CaseError(Problem(str(error), f"body.{case.name}.hydrostatic", remedy=REMEDY)) from None
