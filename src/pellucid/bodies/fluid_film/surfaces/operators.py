"""Operators of a film: coefficients that map nodal velocities to strain rate, change of curvature and slope at its quadrature
points.

A row contains the coefficients of the velocity components of the nodes of an element, node by node, so that `row · v` is the
rate. The virtual power uses the same rows, and the dissipation their squares. The operator is therefore symmetric, and rigid
motions have no strain rate, to round-off.
"""

from typing import NamedTuple

import numpy as np


class Operators(NamedTuple):
    """Shape functions, strain operators and geometry at the q quadrature points of e elements with m nodes each, in d
    dimensions, for given node positions."""

    area: np.ndarray  # (e, q) area that belongs to a quadrature point [m²]
    position: np.ndarray  # (e, q, d) positions of the quadrature points [m]
    normal: np.ndarray  # (e, q, d) outward unit normal
    value: np.ndarray  # (e, q, m, d) shape functions, for each component of the velocity
    strain: np.ndarray  # (e, q, s, m, d) s = 1, 2 or 3 rates of deformation D₁₁, D₂₂, 2 D₁₂ in an orthonormal frame [1/m]
    slope: np.ndarray  # (e, q, c, m, d) gradient of the normal velocity along the c = 1 or 2 axes of this frame [1/m]
    curvature: np.ndarray  # (e, q) J = 2H, the sum of the principal curvatures [1/m], positive for a sphere
    bending: np.ndarray  # (e, q, m, d) rate of change of J at a material point [1/m²]

    def dilatation(self) -> np.ndarray:
        """Return the coefficients that map nodal velocities to the relative rate of change of area, tr D [1/m], shape (e, q,
        m, d).
        """
        first = self.strain[:, :, 0]
        return first if self.strain.shape[2] == 1 else first + self.strain[:, :, 1]

    def volume_rate(self) -> np.ndarray:
        """Return the coefficients that map nodal velocities to the rate of change of the enclosed volume [m²], shape (e, q, m,
        d).
        """
        return np.asarray(self.area[..., None, None] * self.normal[:, :, None, :] * self.value)

    def volume(self) -> float:
        """Return the enclosed volume [m³] by the divergence theorem; for a closed curve, the enclosed area times a depth of
        1 m."""
        d = self.position.shape[2] if self.strain.shape[2] != 2 else 3
        return float(np.einsum("eq,eqi,eqi->", self.area, self.normal, self.position) / d)
