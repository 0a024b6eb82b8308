"""Deformation gradient of a hyperelastic solid for a given stress, for bodies with initial stress."""

import numpy as np

from pellucid.materials.law import Law, cauchy_stress
from pellucid.tensors import IDENTITY, NO_STRESS, Symmetric, Tensor

CLOSE = 1e-8  # of the stress: what the solution may leave
PROBE = 1e-6  # stretch by which the stiffness at rest is measured


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
