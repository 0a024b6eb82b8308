"""Between the arrays of a body and the state of one point: what each family of laws carries beside volume."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.jit import generic, point_function
from pellucid.materials.fluid import FluidState
from pellucid.materials.linear_elastic import HypoelasticState
from pellucid.materials.neo_hookean import FiniteStrainState


class FluidArrays(NamedTuple):
    """Arrays of a fluid."""

    stress: np.ndarray  # (n, 6) [Pa]
    internal_energy: np.ndarray  # (n,) [J/kg]


class HypoelasticArrays(NamedTuple):
    """Arrays of a solid in rate form."""

    stress: np.ndarray  # (n, 6) [Pa]
    strain_energy: np.ndarray  # (n,) [J/kg]


class FiniteStrainArrays(NamedTuple):
    """Arrays of a hyperelastic solid."""

    stress: np.ndarray  # (n, 6) [Pa]
    deformation_gradient: np.ndarray  # (n, 9)


# which arrays hold which state; their fields stand in the same order
ARRAYS_OF: dict[type, Any] = {
    FluidState: FluidArrays,
    HypoelasticState: HypoelasticArrays,
    FiniteStrainState: FiniteStrainArrays,
}


@generic
def load(arrays: Any, p: int) -> Any:
    """The state of point p."""


@generic
def store(arrays: Any, p: int, state: Any) -> None:
    """Keep the state of point p."""


@point_function(load, HypoelasticArrays)
def _load_hypoelastic(arrays, p):
    s = arrays.stress
    return HypoelasticState((s[p, 0], s[p, 1], s[p, 2], s[p, 3], s[p, 4], s[p, 5]), arrays.strain_energy[p])


@point_function(store, HypoelasticArrays)
def _store_hypoelastic(arrays, p, state):
    for k in range(6):
        arrays.stress[p, k] = state.stress[k]
    arrays.strain_energy[p] = state.work


@point_function(load, FluidArrays)
def _load_fluid(arrays, p):
    s = arrays.stress
    return FluidState((s[p, 0], s[p, 1], s[p, 2], s[p, 3], s[p, 4], s[p, 5]), arrays.internal_energy[p])


@point_function(store, FluidArrays)
def _store_fluid(arrays, p, state):
    for k in range(6):
        arrays.stress[p, k] = state.stress[k]
    arrays.internal_energy[p] = state.energy


@point_function(load, FiniteStrainArrays)
def _load_finite_strain(arrays, p):
    s = arrays.stress
    F = arrays.deformation_gradient
    return FiniteStrainState(
        (s[p, 0], s[p, 1], s[p, 2], s[p, 3], s[p, 4], s[p, 5]),
        (F[p, 0], F[p, 1], F[p, 2], F[p, 3], F[p, 4], F[p, 5], F[p, 6], F[p, 7], F[p, 8]),
    )


@point_function(store, FiniteStrainArrays)
def _store_finite_strain(arrays, p, state):
    for k in range(6):
        arrays.stress[p, k] = state.stress[k]
    for k in range(9):
        arrays.deformation_gradient[p, k] = state.deformation_gradient[k]
