"""Initial arrays of material points, and the pressures and stored energies that the material law computes from their state."""

from collections.abc import Mapping

import numpy as np

from pellucid.bodies.material_points.hydrostatic import REMEDY, NoRest, states_by_height
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.seeding import Wanted, everywhere
from pellucid.errors import CaseError, Problem
from pellucid.grid.model import GridCase
from pellucid.grid.viscous_bodies import VISCOUS_STRESS
from pellucid.jit import kernel
from pellucid.materials.law import point_pressure, stored_energy
from pellucid.materials.point_state import initial_arrays, load
from pellucid.model import Vector
from pellucid.ranks.domain import domain


def seeded_arrays(case: SeededBody, grid: GridCase, here: Wanted, gravity: Vector) -> tuple[dict[str, np.ndarray], int]:
    """Return the initial arrays of the points that `here` selects, in memory with room for all points of the body, and the
    number of selected points. here: function that returns the indices of the selected positions; gravity: [m/s²].
    """
    seeds = case.seeded(grid, everywhere if case.has_users_fields else here)
    arrays = {"id": seeds.number, **arrays_at(case, seeds.position, seeds.volume, gravity)}
    if case.has_users_fields:
        chosen = here(seeds.position)
        arrays = {name: values[chosen] for name, values in arrays.items()}
    return {name: with_room(values, seeds.n) for name, values in arrays.items()}, len(arrays["id"])


def arrays_at(case: SeededBody, position: np.ndarray, volume: np.ndarray, gravity: Vector) -> dict[str, np.ndarray]:
    """Build the initial arrays (mass, velocity, material state) of points at positions [m], shape (n, 3), with volumes [m³],
    shape (n,). gravity: [m/s²], for a hydrostatic start.
    """
    density, state = _initial_state(case, position, gravity)
    velocity = case.initial_velocity(position)
    arrays = {"position": position, "velocity": velocity, "mass": density * volume, "volume": volume, **state}
    if case.material.implicit_stress() is not None:
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


def _initial_state(case: SeededBody, position: np.ndarray, gravity: Vector) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
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


@kernel()
def _fill_pressures(law, state, density, result):
    for p in range(len(density)):
        result[p] = point_pressure(law, load(state, p), density[p])


def point_pressures(law, state, density: np.ndarray) -> np.ndarray:
    """Return the pressures that the material law gives for the points [Pa], shape (n,), without artificial viscosity.

    law: material law for kernels; state: state variables of the points (from `point_state.in_arrays`); density: [kg/m³], shape
    (n,).
    """
    result = np.empty_like(density)
    _fill_pressures(law, state, density, result)
    return result


@kernel()
def _fill_energies(law, state, density, result):
    for p in range(len(density)):
        result[p] = stored_energy(law, load(state, p), density[p])


def point_energies(law, state, density: np.ndarray) -> np.ndarray:
    """Return the internal or strain energies per unit mass of the points [J/kg], shape (n,).

    law: material law for kernels; state: state variables of the points (from `point_state.in_arrays`); density: [kg/m³], shape
    (n,).
    """
    result = np.empty_like(density)
    _fill_energies(law, state, density, result)
    return result
