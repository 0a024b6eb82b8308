"""Nodal fields of the conjugate gradient method in `pellucid.grid.implicit_viscosity`."""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, RUN, SUM, rows


class ViscousRows(NamedTuple):
    """Nodal vectors of the conjugate gradient method, stored in rows of four numbers."""

    inertia: Annotated[np.ndarray, rows(FOUND, RUN, "kg", "effective mass along each axis; 0 if prescribed")]
    target: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "velocity without viscosity")]
    solution: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "velocity with viscosity")]
    latest: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "solution of the last step; fourth number 1 where there was fluid")]
    before: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "solution of the step before the last; fourth number as in `latest`")]
    residual: Annotated[np.ndarray, rows(FOUND, RUN, "N s", "residual of the solution")]
    preconditioned: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "preconditioned residual")]
    direction: Annotated[np.ndarray, rows(FOUND, RUN, "m/s", "search direction: next change of the solution")]
    inverse: Annotated[np.ndarray, rows(SUM, RUN, "1/kg", "inverse of the operator's diagonal; 0 if prescribed")]
    weight: Annotated[np.ndarray, rows(FOUND, RUN, "1/kg", "weight of the squared residual in its norm")]
    earlier_force: Annotated[np.ndarray, rows(FOUND, RUN, "N", "explicit share of the viscous force")]
    viscous_force: Annotated[np.ndarray, rows(SUM, RUN, "N", "viscous force of the search direction, finally of the solution")]
    normal: Annotated[
        np.ndarray, rows(FOUND, RUN, "", "unit normal along which a wall prescribes the velocity; zero for other nodes")
    ]
