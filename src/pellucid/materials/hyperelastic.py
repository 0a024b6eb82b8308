"""Hyperelastic solids: the rate form for material points, derived from energy and stress as functions of F, and the
deformation gradient for a given stress, for bodies with initial stress.

The parameters of a law include the initial density `rho0` [kg/m³]. Its file registers `energy`, `cauchy_stress` and
`wave_speed`; `neo_hookean` is an example. A law whose stress depends on F and on other variables is decorated with
`finite_strain` and registers `update`, `signal_speed` and `stored_energy` itself.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import isfinite
from typing import NamedTuple

import numpy as np

from pellucid.jit import implementation_of, point_function
from pellucid.materials.contract import PointMaterial
from pellucid.materials.law import (
    Law,
    LawType,
    cauchy_stress,
    energy,
    energy_and_stress,
    first_piola_kirchhoff,
    rate_type,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
    wave_speed,
)
from pellucid.materials.point_state import point_state
from pellucid.materials.trial import Operation
from pellucid.tensors import IDENTITY, NO_STRESS, Symmetric, Tensor, deformed, determinant, piola_transform

CLOSE = 1e-8  # of the stress: what the solution may leave
PROBE = 1e-6  # stretch by which the stiffness at rest is measured
AHEAD = 1.5  # times the strain of a point: where its law should be defined for the next step


def stretch_under(law: Law, stress: Symmetric) -> Tensor:
    """Return a deformation gradient without rotation (9-tuple) at which the law of a hyperelastic solid has this Cauchy
    stress [Pa]. Raises ValueError if none is found."""
    from scipy.optimize import root

    at_rest, wanted = np.array(cauchy_stress(law, IDENTITY)), np.array(stress)
    if stress == NO_STRESS:
        return IDENTITY
    stiffness = np.abs(np.array(cauchy_stress(law, _symmetric(np.array([PROBE, 0, 0, 0, 0, 0])))) - at_rest).max() / PROBE

    def left(strain: np.ndarray) -> np.ndarray:
        if not _possible(strain):
            return np.full(6, 1e3)  # turns the search back
        return (np.array(cauchy_stress(law, _symmetric(strain))) - wanted) / stiffness

    try:
        found = root(left, np.zeros(6), tol=1e-14)
        close = _possible(found.x) and np.abs(left(found.x)).max() * stiffness <= CLOSE * np.abs(wanted).max()
    except (ValueError, OverflowError, ZeroDivisionError):
        close = False
    if not close:
        raise ValueError(f"no deformation was found with the stress {', '.join(f'{value:g}' for value in stress)} Pa")
    return _symmetric(found.x)


def _possible(strain: np.ndarray) -> bool:
    """Return True if the strain (xx, yy, zz, yz, xz, xy), shape (6,), belongs to a finite deformation with positive volume."""
    F = np.array(_symmetric(strain)).reshape(3, 3)
    return bool(np.isfinite(F).all() and np.linalg.det(F) > 0.0)


def _symmetric(strain: np.ndarray) -> Tensor:
    """Return the sum of the unit tensor and a symmetric tensor (xx, yy, zz, yz, xz, xy), as a 9-tuple."""
    xx, yy, zz, yz, xz, xy = (float(value) for value in strain)
    return (1.0 + xx, xy, xz, xy, 1.0 + yy, yz, xz, yz, 1.0 + zz)


def undefined_strain(law: Law, F: Tensor) -> float | None:
    """Return a factor, 1 or more, by which the stretches of a deformation gradient F are farther from 1 where the energy of a
    law is no finite number; None if there is none up to `AHEAD`."""
    with np.errstate(all="ignore"):
        C = np.reshape(F, (3, 3)).T @ np.reshape(F, (3, 3))
    if implementation_of(energy, type(law)) is None or not np.isfinite(C).all():
        return None
    squares, axes = np.linalg.eigh(C)
    for factor in np.linspace(1.0, AHEAD, 11):
        stretches = 1.0 + factor * (np.sqrt(squares) - 1.0)
        if not stretches.min() > 0.0:
            return None
        with suppress(ArithmeticError, ValueError), np.errstate(all="ignore"):
            if isfinite(energy(law, tuple(((axes * stretches) @ axes.T).ravel().tolist()))):
                continue
        return float(factor)
    return None


@point_state()
class FiniteStrainState(NamedTuple):
    """State of a point of a hyperelastic solid: Cauchy stress [Pa] and deformation gradient."""

    stress: Symmetric
    deformation_gradient: Tensor


class HyperelasticMaterial(PointMaterial):
    """Base of the materials of hyperelastic solids, whose stress follows from a strain energy of the deformation gradient."""

    def initial_state(self) -> FiniteStrainState:
        return FiniteStrainState(NO_STRESS, IDENTITY)

    def stressed(self, stress: Symmetric) -> tuple[float, FiniteStrainState]:
        """Return the density [kg/m³] and the state of a point that is stretched so that it has this Cauchy stress [Pa]."""
        F = stretch_under(self.law(), stress)
        return self.density / determinant(F), FiniteStrainState(stress, F)

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        return {law: (*super().operations(law)[law], energy, cauchy_stress, wave_speed)}


def finite_strain(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the default functions of `rate_type` for a law that integrates the deformation gradient, F ←
    (I + dt L) F, with the velocity gradient L."""
    point_function(volume_growth, rate_type(law))(_volume_growth)
    return law


def hyperelastic(law: type[LawType]) -> type[LawType]:
    """Class decorator: register the rate form of a law (functions of the velocity gradient) and its first Piola-Kirchhoff
    stress, derived from its energy, Cauchy stress and wave speed."""
    finite_strain(law)
    point_function(update, law)(_update)
    point_function(signal_speed, law)(_signal_speed)
    point_function(stored_energy, law)(_stored_energy)
    point_function(first_piola_kirchhoff, law)(_first_piola_kirchhoff)
    point_function(energy_and_stress, law)(_energy_and_stress)
    return law


def _volume_growth(law, L, dt):
    return determinant(deformed(L, dt, IDENTITY))


def _update(law, state, density, L, dt, length):
    F = deformed(L, dt, state.deformation_gradient)
    return FiniteStrainState(cauchy_stress(law, F), F)


def _signal_speed(law, state, density, L, length):
    return wave_speed(law, state.deformation_gradient)


def _stored_energy(law, state, density):
    return energy(law, state.deformation_gradient) * (1.0 / law.rho0)


def _first_piola_kirchhoff(law, F):
    return piola_transform(cauchy_stress(law, F), F)


def _energy_and_stress(law, F):
    return energy(law, F), first_piola_kirchhoff(law, F)
