"""The velocity that a fluid has at nodes near the surface of a rigid body, so that it does not slip on the surface itself.

Nodes do not lie on the surface. If each of them moved either with the body or with the fluid, the fluid would meet the body up
to half a cell away from the surface. At a node with the signed distance d from the surface, positive outside, the fluid
therefore gets the rigid velocity and in addition the tangential velocity

    δ(d) = g d + c d² ,

where g and c follow from the velocities relative to the body at two places on the normal, at the distances SAMPLES. A linear or
quadratic velocity profile is thus continued through the surface, with any position of the surface between the nodes.

Distance and normal follow from the share f of the volume of a node that the body fills: a plane face at the distance d gives a
known profile f(d). On a curved face the shape functions average over the tangential plane as well: the surface seems farther
away by h²κ v/2, where v is the variance of the shape functions in cells and κ the sum of the principal curvatures, as a mean
over the surface.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import MASS_EPS

SAMPLES = (2.0, 3.5)  # cells outside the surface: shape functions of points of the body hardly reach the first
DEGREES = {"trilinear": 1, "gimp": 1, "quadratic-bspline": 2, "cubic-bspline": 3}
LEAST_SLOPE = 1e-6  # of the share filled, per cell: where it changes less, the body has no face


class Surface(NamedTuple):
    """The surface of a body as seen from nodes."""

    distance: np.ndarray  # (n,) signed, positive outside [m]
    normal: np.ndarray  # (n, 3) out of the body
    certainty: np.ndarray  # (n,) 1 near a plane face, 0 where faces on both sides are equally near


class NoSlip:
    """Finds the surface of a rigid body near nodes of a grid, and the velocity profile outside."""

    def __init__(self, grid: Grid) -> None:
        self._cell, self._lower = grid.lattice.cell, np.array(grid.lattice.lower)
        self._strides, self._thin, self._periodic = np.array(grid.lattice.strides), np.array(grid.thin), np.array(grid.periodic)
        self._counts = np.where(self._thin, 1, np.array(grid.lattice.counts) + ~self._periodic)
        degree = DEGREES[grid.case.functions]
        self._variance = (degree + 1) / 12.0
        half = 0.5 * (degree + 1)
        self._distances = np.linspace(-half, half, 601)
        function = BSpline.basis_element(np.arange(degree + 2) - half, extrapolate=False)
        covered = function.antiderivative()(self._distances)
        self._filled = 1.0 - (covered - covered[0]) / (covered[-1] - covered[0])

    def find_surface(self, filled: np.ndarray, place: np.ndarray) -> Surface:
        """Return the surface near nodes.

        Parameters
        ----------
        filled : (nodes,) share of the volume of each node of the grid that the body fills
        place : (n, 3) of the nodes near which it is wanted [m]
        """
        at = np.rint((place - self._lower) / self._cell).astype(int)
        here = filled[self._node(at)]
        slope, curved = np.zeros(at.shape), np.zeros((len(at), 3, 3))
        axes = np.flatnonzero(~self._thin)
        step = np.eye(3, dtype=int)
        for i in axes:
            up, down = filled[self._node(at + step[i])], filled[self._node(at - step[i])]
            slope[:, i], curved[:, i, i] = 0.5 * (up - down), up - 2.0 * here + down
            for j in axes[axes > i]:
                ends = [filled[self._node(at + a * step[i] + b * step[j])] for a, b in ((1, 1), (-1, -1), (1, -1), (-1, 1))]
                curved[:, i, j] = curved[:, j, i] = 0.25 * (ends[0] + ends[1] - ends[2] - ends[3])
        steepness = np.linalg.norm(slope, axis=1)
        normal = -slope / np.maximum(steepness, LEAST_SLOPE)[:, None]
        tangential = np.einsum("kii->k", curved) - np.einsum("ki,kij,kj->k", normal, curved, normal)
        curvature = -float(np.sum(tangential)) / max(float(np.sum(steepness)), LEAST_SLOPE)
        seen = np.interp(-np.clip(here, 0.0, 1.0), -self._filled, self._distances)
        expected = 0.5 * (self._share_at(seen - 1.0) - self._share_at(seen + 1.0))
        # in a thin body the slopes of both faces cancel; half the slope of a plane face is still one that is curved or oblique
        single = np.where(seen > 0.0, 1.0, np.minimum(1.0, 2.0 * steepness / np.maximum(expected, LEAST_SLOPE)))
        certainty = np.where(steepness > LEAST_SLOPE, single, 0.0)
        return Surface(self._cell * (seen - 0.5 * self._variance * curvature), normal, certainty)

    def sample(self, velocity: np.ndarray, mass: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return nodal velocities interpolated linearly at places, (n, 3) each, and whether all nodes around them have mass."""
        s = np.where(self._thin, 0.0, (place - self._lower) / self._cell)
        first = np.floor(s).astype(int)
        rest, known = s - first, np.all((s >= 0.0) & (s <= self._counts - 1) | self._thin | self._periodic, axis=1)
        found = np.zeros(place.shape)
        for corner in np.ndindex(*np.where(self._thin, 1, 2)):
            node = self._node(first + corner)
            weight = np.prod(np.where(self._thin, 1.0, np.where(corner, rest, 1.0 - rest)), axis=1)
            found += weight[:, None] * velocity[node]
            known &= (mass[node] > MASS_EPS) | (weight == 0.0)
        return found, known

    @property
    def heights(self) -> tuple[float, float]:
        """Distances from the surface at which velocities are sampled [m]."""
        return SAMPLES[0] * self._cell, SAMPLES[1] * self._cell

    def continue_profile(self, surface: Surface, near: np.ndarray, far: np.ndarray, far_known: np.ndarray) -> np.ndarray:
        """Return δ at the nodes [m/s], (n, 3), from velocities relative to the body at `heights`; where the farther one is not
        known, the profile is linear."""
        a, b = self.heights
        d = surface.distance[:, None]
        bend = np.where(far_known[:, None], (far / b - near / a) / (b - a), 0.0)
        profile = (near / a - a * bend) * d + bend * d * d
        along = np.sum(profile * surface.normal, axis=1)[:, None] * surface.normal
        return surface.certainty[:, None] * (profile - along)

    def _share_at(self, distance: np.ndarray) -> np.ndarray:
        return np.interp(distance, self._distances, self._filled)

    def _node(self, at: np.ndarray) -> np.ndarray:
        """Numbers of nodes, of those outside the walls the ones on them."""
        within = np.where(self._periodic, np.mod(at, self._counts), np.clip(at, 0, self._counts - 1))
        return within @ self._strides
