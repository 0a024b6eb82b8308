"""Fields that are worked out from what points carry."""

import numpy as np

from pellucid.jit import kernel
from pellucid.materials.energy_update import pressure


@kernel()
def _fill_pressures(eos, density, energy, result):
    for p in range(len(density)):
        result[p] = pressure(eos, density[p], energy[p])


def point_pressures(eos, density: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Pressures of an equation of state [Pa], shape (n,), without artificial viscosity."""
    result = np.empty_like(density)
    _fill_pressures(eos, density, energy, result)
    return result
