"""Fields that are worked out from what points carry."""

import numpy as np

from pellucid.jit import kernel
from pellucid.materials.law import point_pressure, stored_energy
from pellucid.materials.point_state import load


@kernel()
def _fill_pressures(law, carried, density, result):
    for p in range(len(density)):
        result[p] = point_pressure(law, load(carried, p), density[p])


def point_pressures(law, carried, density: np.ndarray) -> np.ndarray:
    """Pressures of a law [Pa], shape (n,), without artificial viscosity; `carried` as from `point_state.in_arrays`."""
    result = np.empty_like(density)
    _fill_pressures(law, carried, density, result)
    return result


@kernel()
def _fill_energies(law, carried, density, result):
    for p in range(len(density)):
        result[p] = stored_energy(law, load(carried, p), density[p])


def point_energies(law, carried, density: np.ndarray) -> np.ndarray:
    """Internal or strain energies of unit mass [J/kg], shape (n,); `carried` as from `point_state.in_arrays`."""
    result = np.empty_like(density)
    _fill_energies(law, carried, density, result)
    return result
