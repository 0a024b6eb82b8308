"""Nodal fields of the conjugate gradient method in `pellucid.grid.implicit_viscosity`."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, RUN, SUM, rows


class ViscousRows(NamedTuple):
    """Nodal vectors of the conjugate gradient method, stored in rows of four numbers."""

    inertia: Annotated[np.ndarray, rows(FOUND, RUN, "kg", "mass that a force along each axis moves; 0 where it is led")]
    target: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "velocity that it would have without viscosity")]
    solution: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "velocity with it")]
    residual: Annotated[np.ndarray, rows(FOUND, RUN, "N s", "of the solution")]
    direction: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "in which it is changed next")]
    inverse: Annotated[np.ndarray, rows(SUM, RUN, "1/kg", "of the operator's diagonal; 0 where it is led")]
    weight: Annotated[np.ndarray, rows(FOUND, RUN, "1/kg", "of the square of the residual")]
    viscous_force: Annotated[np.ndarray, rows(SUM, RUN, "N", "of the direction, at last of the solution")]
