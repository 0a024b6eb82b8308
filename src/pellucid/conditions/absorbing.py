"""Absorbing faces: viscous damping stresses that let waves out.

Source: Lysmer & Kuhlemeyer 1969, J. Eng. Mech. Div. 95, 859.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import field_validator

from pellucid.approximants.axis import axis_weights
from pellucid.conditions.support import Face
from pellucid.grid.lattice import Grid
from pellucid.model import Model, parameter

SAMPLES = 4000  # of the integral of a boundary function, which is piecewise quadratic or cubic


class Absorbing(Model):
    """Faces of the grid with the traction -ρ c_p v_n n - ρ c_s v_t: plane waves of a body that meet them head-on leave."""

    where: tuple[Face, ...] = parameter("", "faces of the grid", min_length=1)
    body: str = parameter("", "body whose waves leave: the speeds are those of its material at the start")

    @field_validator("where", mode="before")
    @classmethod
    def _one_or_several(cls, where: Any) -> Any:
        return (where,) if isinstance(where, str) else where


def absorption_rates(grid: Grid, functions: Any, faces: Sequence[tuple[Face, float, float]]) -> np.ndarray:
    """Rates at which faces take momentum from nodes [1/s], shape (nodes, 3).

    faces: each with the speeds of pressure and shear waves [m/s]. Only the functions of a face's own nodes do not vanish on
    it, so that a node of mass m = ρ A ∫N loses ρ c A v, that is m v c/∫N, with the integral of N across the face.
    """
    rates = np.zeros((grid.n_nodes, 3))
    index, position = grid.where()
    lattice = grid.lattice
    for face, pressure_speed, shear_speed in faces:
        axis = "xyz".index(face[0])
        if grid.thin[axis]:
            continue
        layer = 0 if face.endswith("lower") else lattice.counts[axis]
        cells = np.rint((position[:, axis] - lattice.lower[axis]) / lattice.cell)
        nodes = index[cells == layer]
        thickness = lattice.cell * _integral(functions[axis], lattice.counts[axis])
        for direction in range(3):
            rates[nodes, direction] += (pressure_speed if direction == axis else shear_speed) / thickness
    return rates


def _integral(function: Any, n: int) -> float:
    """Integral of the function of a wall's node, in cells."""
    reach = min(function.stencil, n)
    total = 0.0
    for sample in range(SAMPLES):
        first, weights, _ = axis_weights(function, reach * (sample + 0.5) / SAMPLES, n)
        total += weights[0] if first == 0 else 0.0
    return total * reach / SAMPLES
