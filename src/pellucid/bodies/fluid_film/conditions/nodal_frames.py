"""Directions of the nodal velocity components: the axes of space, except at nodes with a prescribed normal velocity.

At these nodes the axes are reflected so that the last one lies along the normal n: by I - 2 w wᵀ/w², with w = e + sgn(n·e)
n and the last axis e. On an axis of symmetry the first component remains perpendicular to it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, SharedRows


class Led(NamedTuple):
    """Nodes of a film whose velocity along the normal is prescribed, with these velocities."""

    nodes: np.ndarray  # (n,) True for these nodes
    rate: np.ndarray  # (n,) prescribed velocity along the outward normal [m/s]
    before: np.ndarray  # (n, d) nodal velocities in the previous step [m/s]


class Frames:
    """Orthonormal directions at n nodes, along which vectors are resolved into components. At the nodes of the mask `led` the
    last direction lies along the normal; elsewhere the directions are the axes of space. normal: normals at the nodes, shape
    (n, d).
    """

    def __init__(self, normal: np.ndarray, led: np.ndarray) -> None:
        d = normal.shape[1]
        self._way = np.where(normal[:, -1] < 0.0, 1.0, -1.0)  # sign of the last direction relative to the normal
        w = np.eye(d)[-1] - self._way[:, None] * normal
        mirrored = np.eye(d) - 2.0 * w[:, :, None] * w[:, None] / np.einsum("ni,ni->n", w, w)[:, None, None]
        self.directions = np.where(led[:, None, None], mirrored, np.eye(d))

    def of(self, vectors: np.ndarray) -> np.ndarray:
        """Return the components of nodal vectors along the orthonormal directions stored for each node, from their components
        along the axes of space, shape (n, d) both. The transformation is its own inverse.
        """
        return np.asarray(np.einsum("ncd,nd->nc", self.directions, vectors))

    def rows(self, forms: Sequence[ElementRows | SharedRows], nodes: np.ndarray) -> list[ElementRows]:
        """Convert linear forms of nodal vectors to the components of these vectors along the orthonormal directions stored for
        each node, instead of the axes of space.

        forms: coefficients of the linear forms of each element; nodes: nodes of the elements, shape (e, m).
        """
        e, m = nodes.shape
        d, directions = self.directions.shape[2], self.directions[nodes]
        whole = [form.of_components(d) for form in forms]
        found = [np.einsum("ermd,emcd->ermc", form.rows.reshape(e, -1, m, d), directions) for form in whole]
        return [
            ElementRows(np.ascontiguousarray(rows.reshape(form.rows.shape)), form.factor)
            for rows, form in zip(found, whole, strict=True)
        ]

    def known(self, led: Led, rate: np.ndarray, known: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a mask of the prescribed velocity components along the orthonormal directions stored for each node, and their
        values [m/s], shape (n, d) each.

        led: nodes with a prescribed normal velocity; rate: these velocities [m/s], shape (n,); known, velocity: mask and values
        [m/s] of the components along the axes that supports prescribe, shape (n, d).
        """
        last = np.zeros(known.shape, bool)
        last[:, -1] = led.nodes
        return known | last, np.where(last, (self._way * rate)[:, None], velocity)
