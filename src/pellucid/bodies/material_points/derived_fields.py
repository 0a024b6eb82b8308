"""Pressures and stored energies of material points, computed from their state by the material law."""

import numpy as np

from pellucid.jit import kernel
from pellucid.materials.law import point_pressure, stored_energy
from pellucid.materials.point_state import load


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
