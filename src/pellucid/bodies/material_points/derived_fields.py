"""Fields that are worked out from what points carry."""

import numpy as np

from pellucid.jit import kernel
from pellucid.materials.energy_update import pressure
from pellucid.materials.law import stored_energy
from pellucid.materials.point_state import load


@kernel()
def _fill_pressures(eos, density, energy, result):
    for p in range(len(density)):
        result[p] = pressure(eos, density[p], energy[p])


def point_pressures(eos, density: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Pressures of an equation of state [Pa], shape (n,), without artificial viscosity."""
    result = np.empty_like(density)
    _fill_pressures(eos, density, energy, result)
    return result


@kernel()
def _fill_energies(law, carried, density, result):
    for p in range(len(density)):
        result[p] = stored_energy(law, load(carried, p), density[p])


def point_energies(law, carried, density: np.ndarray) -> np.ndarray:
    """Internal or strain energies of unit mass [J/kg], shape (n,); `carried` as in `point_state.ARRAYS_OF`."""
    result = np.empty_like(density)
    _fill_energies(law, carried, density, result)
    return result
