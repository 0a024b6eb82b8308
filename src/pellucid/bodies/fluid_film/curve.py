"""Films that a curve describes: closed curves in the plane, and surfaces of revolution about the z axis.

A curve is interpolated between each two neighbours by radial functions, blended from those of both, so that its tangent is
continuous, over a parameter that grows by 1 from node to node. Source: Benet 2015, §§6.3 and 7.1.
"""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.operators import Operators

GAUSS = 3  # points of a segment: with fewer, hoop strain has modes without energy


class Tables(NamedTuple):
    """Functions of the nodes of a segment at its quadrature points, the same for all."""

    value: np.ndarray  # (q, m)
    first: np.ndarray  # (q, m)
    second: np.ndarray  # (q, m)
    weight: np.ndarray  # (q,)


class Curve(NamedTuple):
    """Nodes in order along a curve, its interior to the left; `around` the z axis or in the plane.

    nodes: (e, m) those of each segment; sign: (e, m, 2) -1 for components of the mirror images of nodes across the axis.
    """

    nodes: np.ndarray
    sign: np.ndarray
    tables: Tables
    around: bool

    def operators(self, x: np.ndarray) -> Operators:
        """Rows for nodes at x [m], shape (n, 2)."""
        table, corner = self.tables, x[self.nodes] * self.sign
        place = np.einsum("qm,emi->eqi", table.value, corner)
        along = np.einsum("qm,emi->eqi", table.first, corner)
        bend = np.einsum("qm,emi->eqi", table.second, corner)
        g = np.einsum("eqi,eqi->eq", along, along)
        length = np.sqrt(g)
        tangent = along / length[..., None]
        normal = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
        value = table.value[None, :, :, None] * self.sign[:, None]
        first = table.first[None, :, :, None] * self.sign[:, None]
        second = table.second[None, :, :, None] * self.sign[:, None]
        stretch = tangent[:, :, None, :] * first / length[..., None, None]
        slope = normal[:, :, None, :] * first / length[..., None, None]
        gamma = np.einsum("eqi,eqi->eq", along, bend) / g
        kappa = -np.einsum("eqi,eqi->eq", normal, bend) / g
        turning = -normal[:, :, None, :] * (second - gamma[..., None, None] * first) / g[..., None, None]
        bending = turning - 2.0 * kappa[..., None, None] * stretch
        area, strain = length * table.weight, stretch[:, :, None]
        if self.around:
            r = place[..., 0]
            hoop = np.zeros_like(value)
            hoop[..., 0] = value[..., 0] / r[..., None]
            n_r, t_r = normal[..., 0] / r, tangent[..., 0] / r
            bending = bending - t_r[..., None, None] * slope - n_r[..., None, None] * hoop
            kappa = kappa + n_r
            area, strain = 2.0 * np.pi * r * area, np.stack([stretch, hoop], axis=2)
        return Operators(area, place, normal, value, strain, slope[:, :, None], kappa, bending)
