"""Velocity of a fluid at nodes near the surface of a rigid body, for no slip on the surface itself.

Nodes do not lie on the surface. If each node moved either with the body or with the fluid, the fluid would meet the body up
to half a cell away from the surface. At a node with the signed distance d from the surface, positive outside, the fluid
therefore gets the rigid velocity plus the tangential velocity

    δ(d) = (g d + c d²) / (1 + κ d) ,    κ: the sum of the principal curvatures, positive on a convex body,

where g and c follow from the velocities relative to the body at two positions on the normal, SAMPLES cells from the
surface. The velocity profile is thus continued through the surface, for any position of the surface between the nodes. The
denominator is the growth of the area of a parallel surface. Around a cylinder with a radius of five cells, a polynomial
alone has a third-order error: the torque is 2 % too large, and 5 % with a quarter of the time step. The profile δ is exact
for steady shear flow around a rotating cylinder.

Distance and normal follow from the fraction f of the volume of a node that the body fills: a plane face at the distance d
gives a known profile f(d). On a curved face the shape functions also average over the tangential plane: the surface appears
farther away by h²κ v/2, where h is the cell size and v the variance of the shape functions in cells. κ is averaged over the
surface. Where the shape of the body is known, distances along the normals are those of the shape: from the points, balls of
four to six cells in the radius appear smaller by 0.03 to 0.06 cells.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import MASS_EPS

SAMPLES = (2.0, 3.5)  # cells outside the surface; points of the body barely reach the first
DEGREES = {"trilinear": 1, "gimp": 1, "quadratic-bspline": 2, "cubic-bspline": 3}
FLATTEST, SHARPEST = -0.15, 0.5  # curvatures per cell that the profile uses: 1 + κ d stays positive from -1.5 to 3.5 cells
AROUND = 2  # cells along each axis within which the curvature of a surface is averaged
MARGIN = 6  # cells around a body that are read: the farther sample and the functions of the points
LEAST_RATIO, FULL_RATIO = 0.2, 0.5  # ratios of node masses around a sample with reliability 0 and 1, see `NoSlip.sample`
REFINEMENTS = 2  # iterations for distances; further ones change them by less than 0.01 cells
ROUNDING = 1e-9  # of a cell
LEAST_SLOPE = 1e-6  # smallest gradient of the filled fraction at a face of the body [1/cell]


class Surface(NamedTuple):
    """Surface of a region or rigid body at which a fluid does not slip, described by data at the nodes near it."""

    distance: np.ndarray  # (n,) signed distance of each node from the surface, positive outside [m]
    normal: np.ndarray  # (n, 3) unit normal at each node, out of the body
    certainty: np.ndarray  # (n,) reliability of distance and normal: 1 near a plane face, 0 midway between two faces
    curvature: float | np.ndarray = 0.0  # sum of the principal curvatures [1/m], positive on a convex body; mean, or (n,)


class Window(NamedTuple):
    """A box of nodes. It may extend across the faces of a periodic grid; at other faces it is mirrored."""

    node: np.ndarray  # (m,) node numbers, ascending, each once
    place: np.ndarray  # (nx, ny, nz) index in `node` of each node of the box
    first: np.ndarray  # (3,) first nodes of the box, in cells from the lower corner of the grid
    last: np.ndarray  # (3,) last nodes of the box, in cells from the lower corner of the grid
    share: np.ndarray  # (m,) volume of each node divided by the volume of an interior node


class NoSlip:
    """Computes the surface of a rigid body at nodes of a grid near it, and the velocity profile of the fluid outside the
    body."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._window: Window | None = None
        self._cell, self._lower = grid.lattice.cell, np.array(grid.lattice.lower)
        self._strides, self._thin, self._periodic = np.array(grid.lattice.strides), np.array(grid.thin), np.array(grid.periodic)
        self._counts = np.where(self._thin, 1, np.array(grid.lattice.counts) + ~self._periodic)
        degree = DEGREES[grid.case.functions]
        self._variance = (degree + 1) / 12.0
        half = 0.5 * (degree + 1)
        self._distances = np.linspace(-half, half, 601)
        function = BSpline.basis_element(np.arange(degree + 2) - half, extrapolate=False)
        self._function, self._half = function, half
        covered = function.antiderivative()(self._distances)
        self._beyond = float(np.interp(-1.0, self._distances, covered - covered[0]) / (covered[-1] - covered[0]))
        self._filled = 1.0 - (covered - covered[0]) / (covered[-1] - covered[0])

    def find_window(self, nodes: np.ndarray) -> Window:
        """Return the box of nodes around the given nodes (node numbers) whose data is needed for the surface of the body
        and the velocity profile near it."""
        at = self._indices(nodes)
        at = at if len(at) else np.zeros((1, 3), int)
        margin = np.where(self._thin, 0, MARGIN)
        first, last = at.min(axis=0) - margin, at.max(axis=0) + margin
        if self._window is None or not np.array_equal([self._window.first, self._window.last], [first, last]):
            axes = (np.arange(a, b + 1) for a, b in zip(first, last, strict=True))
            box = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
            node, index = np.unique(self._node(box), return_inverse=True)
            self._window = Window(node, index.reshape(box.shape[:3]), first, last, self.share_in_grid(node))
        return self._window

    def share_in_grid(self, node: np.ndarray) -> np.ndarray:
        """Return the volumes of nodes (numbers, shape (n,)) divided by the volume of an interior node, (n,)."""
        return np.asarray(self.shares_along(node).prod(axis=1))

    def shares_along(self, node: np.ndarray) -> np.ndarray:
        """Return factors of the volumes of nodes (numbers, shape (n,)) along the axes, relative to an interior node, (n, 3):
        about 1/2 on a face, where the shape functions of nodes beyond the face are added to the next two nodes; 1/2 on a plane
        of symmetry, where they are added to their mirror images."""
        at = self._indices(node)
        ends = ~self._thin & ~self._periodic
        is_upper = self._counts - 1 - at < at
        to_face = np.where(ends, np.where(is_upper, self._counts - 1 - at, at), 2)
        volumes = np.array([0.5 + 2.0 * self._beyond, 1.0 - 2.0 * self._beyond, 1.0])
        mirrored = np.where(is_upper, *np.array(self._grid.mirrored).T[::-1])
        return np.where(mirrored, np.where(to_face == 0, 0.5, 1.0), volumes[np.minimum(to_face, 2)])

    def find_next(self, node: np.ndarray, by: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the nodes at an offset of `by` nodes along the axes, shape (3,), from each node, shape (n,),
        and a mask of the offset nodes that lie inside the grid."""
        at = self._indices(node)
        to = np.where(self._thin, 0, at) + by
        return self._node(to), np.all(self._periodic | ((to >= 0) & (to < self._counts)), axis=1)

    def find_surface(self, window: Window, filled: np.ndarray, place: np.ndarray) -> Surface:
        """Return the surface of a body at nodes near it: distance, normal and further data, see `Surface`.

        Parameters
        ----------
        window : Window
            nodes with known data, see `find_window`
        filled : ndarray, shape (nodes of the window,)
            fraction of the volume of each node that the body fills
        place : ndarray, shape (n, 3)
            positions of the nodes at which the surface is computed [m]
        """
        share = filled[window.place]
        axes = np.flatnonzero(~self._thin)
        slopes = np.zeros((*share.shape, 3))
        for i in axes:
            slopes[..., i] = np.gradient(share, axis=i)
        at = np.rint((place - self._lower) / self._cell).astype(int) - window.first
        here, slope = share[tuple(at.T)], slopes[tuple(at.T)]
        steepness = np.linalg.norm(slope, axis=1)
        normal = -slope / np.maximum(steepness, LEAST_SLOPE)[:, None]
        curvature = self._mean_curvature(share, at, normal, steepness)
        seen = self._distance_to(here)
        certainty = self.certainty(here, steepness)
        distance = seen.copy()
        for _ in range(REFINEMENTS):  # few points fill nodes far outside: the surface is found again from the nodes next to it
            nearer = at - distance[:, None] * normal
            rest, slope = self._interpolate(self._distance_to(share), nearer), self._interpolate(slopes, nearer)
            steepness = np.linalg.norm(slope, axis=1)
            found = 2.0 * steepness > self._slope_at(rest)
            normal = np.where(found[:, None], -slope / np.maximum(steepness, LEAST_SLOPE)[:, None], normal)
            distance = np.where(found, np.sum((at - nearer) * normal, axis=1) + rest, distance)
        distance -= 0.5 * self._variance * curvature
        return Surface(self._cell * distance, normal, certainty, curvature / self._cell)

    @property
    def half(self) -> float:
        """Half of the width of the shape functions in cells."""
        return self._half

    def functions(self, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the shape function of a node along one axis and its derivative [1/cell] at distances `offset` from the
        node in cells, shape (n,) each."""
        offset = np.clip(offset, -self._half, self._half)
        return np.nan_to_num(self._function(offset)), np.nan_to_num(self._function.derivative()(offset))

    def certainty(self, share: np.ndarray, steepness: np.ndarray) -> np.ndarray:
        """Return the reliability, between 0 and 1, of the computed distance and normal of the surface at nodes, shape (n,).
        share: fraction of the volume of each node that the body fills, shape (n,); steepness: magnitude of the gradient of
        `share` [1/cell], shape (n,)."""
        seen = self._distance_to(share)
        # in a thin body the slopes of both faces cancel; half the slope of a plane face is still one that is curved or oblique
        single = np.where(seen > 0.0, 1.0, np.minimum(1.0, 2.0 * steepness / np.maximum(self._slope_at(seen), LEAST_SLOPE)))
        return np.where(steepness > LEAST_SLOPE, single, 0.0)

    def curvatures_of(
        self,
        window: Window,
        node: np.ndarray,
        normal: np.ndarray,
        certainty: np.ndarray,
        distance: np.ndarray,
        sharp: np.ndarray,
    ) -> np.ndarray:
        """Return the sum of the principal curvatures at nodes [1/m], shape (n,): the mean divergence of the normals at nodes
        within half a cell of the surface and at most AROUND cells away along each axis, without edges; 0 if there is none.

        The normals at an edge have no curvature that a profile could use, and the faces beside it have none.

        window: box that contains the nodes; node: node numbers, shape (n,); normal, certainty, distance: as in `Surface`;
        sharp: mask of the nodes at edges, shape (n,).
        """
        at = np.searchsorted(window.node, node)
        normals, use = np.zeros((len(window.node), 3)), np.zeros((2, len(window.node)), bool)
        normals[at] = normal
        use[0, at] = (certainty > 0.0) & ~sharp
        use[1, at] = np.abs(distance) < 0.5 * self._cell
        dense, smooth, near = self.continued(window, normals), use[0][window.place], use[1][window.place]
        divergence, whole = np.zeros(smooth.shape), smooth & near
        for i in np.flatnonzero(~self._thin):
            divergence += np.gradient(dense[..., i], axis=i)
            whole &= np.roll(smooth, 1, axis=i) & np.roll(smooth, -1, axis=i)
            if not self._periodic[i]:  # beyond a face that is no plane of symmetry there is no surface
                index = np.arange(window.first[i], window.last[i] + 1)
                below, above = self._grid.mirrored[i]
                inside = ((index > 0) | below) & ((index < self._counts[i] - 1) | above)
                whole &= inside.reshape(np.where(np.arange(3) == i, -1, 1))
        total, count = np.where(whole, divergence, 0.0), whole.astype(float)
        for i in np.flatnonzero(~self._thin):
            steps = range(-AROUND, AROUND + 1)
            total, count = (np.sum([np.roll(one, k, axis=i) for k in steps], axis=0) for one in (total, count))
        place = tuple((self._indices(node) - window.first).T)
        return np.asarray((total / np.maximum(count, 1.0))[place] / self._cell)

    def _mean_curvature(self, share: np.ndarray, at: np.ndarray, normal: np.ndarray, steepness: np.ndarray) -> float:
        """Return the sum of the principal curvatures [1/cell], averaged over the surface near nodes of a window. share:
        fraction of the volume of each node of the window that the body fills; at: indices of the nodes in the window,
        shape (n, 3); normal: shape (n, 3); steepness: magnitude of the gradient of `share` [1/cell], shape (n,)."""
        curved, step = np.zeros((len(at), 3, 3)), np.eye(3, dtype=int)
        axes = np.flatnonzero(~self._thin)
        here = share[tuple(at.T)]
        for i in axes:
            up, down = share[tuple((at + step[i]).T)], share[tuple((at - step[i]).T)]
            curved[:, i, i] = up - 2.0 * here + down
            for j in axes[axes > i]:
                ends = [share[tuple((at + a * step[i] + b * step[j]).T)] for a, b in ((1, 1), (-1, -1), (1, -1), (-1, 1))]
                curved[:, i, j] = curved[:, j, i] = 0.25 * (ends[0] + ends[1] - ends[2] - ends[3])
        tangential = np.einsum("kii->k", curved) - np.einsum("ki,kij,kj->k", normal, curved, normal)
        return -float(np.sum(tangential)) / max(float(np.sum(steepness)), LEAST_SLOPE)

    def sample(
        self, window: Window, velocity: np.ndarray, mass: np.ndarray, place: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return velocities interpolated linearly from the nodes of the window to positions [m/s], shape (n, 3), and their
        reliability as velocities of a fluid, shape (n,).

        velocity: (nodes of the window, 3) [m/s]; mass: (nodes of the window,) [kg]; place: (n, 3) [m]. The reliability is
        between 0 and 1. It is 0 at positions outside the grid, and where a node around the position has almost no mass
        compared with its neighbours, as beyond a free surface.
        """
        s = np.where(self._thin, 0.0, (place - self._lower) / self._cell)
        inside = (s >= -ROUNDING) & (s <= self._counts - 1 + ROUNDING) | self._thin | self._periodic
        inside = np.all(inside, axis=1)
        of_nodes = mass[window.place]
        least, most = of_nodes, of_nodes
        for axis in np.flatnonzero(~self._thin):
            least, most = self._along(np.minimum, least, int(axis)), self._along(np.maximum, most, int(axis))
        at = np.floor(s).astype(int) - window.first
        at = np.where(self._thin, 0, np.clip(at, 0, np.array(least.shape) - 1))
        ratio = least[tuple(at.T)] / np.maximum(most[tuple(at.T)], MASS_EPS)
        known = np.clip((ratio - LEAST_RATIO) / (FULL_RATIO - LEAST_RATIO), 0.0, 1.0)
        return self._interpolate(velocity[window.place], s - window.first), np.where(inside, known, 0.0)

    @staticmethod
    def _along(function: np.ufunc, values: np.ndarray, axis: int) -> np.ndarray:
        """Apply a binary function to each value of a window, shape (x, y, z), and the next value along an axis; return the
        results, one fewer along this axis."""
        n = values.shape[axis]
        return np.asarray(function(values.take(range(n - 1), axis), values.take(range(1, n), axis)))

    def _interpolate(self, values: np.ndarray, place: np.ndarray) -> np.ndarray:
        """Return nodal values of a window, interpolated linearly to positions `place`, shape (n, 3), in cells from the first
        node of the window."""
        most = np.array(values.shape[:3]) - 1
        s = np.where(self._thin, 0.0, np.clip(place, 0.0, most))
        first = np.minimum(s.astype(int), np.maximum(most - 1, 0))
        rest, found = s - first, np.zeros((len(place), *values.shape[3:]))
        for corner in np.ndindex(*np.where(self._thin, 1, 2)):
            weight = np.prod(np.where(self._thin, 1.0, np.where(corner, rest, 1.0 - rest)), axis=1)
            found += (weight[:, None] if found.ndim > 1 else weight) * values[tuple((first + corner).T)]
        return found

    def sample_as_points(
        self, window: Window, velocity: np.ndarray, mass: np.ndarray, open_share: np.ndarray, place: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the velocities that points at the positions would have [m/s], (n, 3), their reliability, (n,), and the mass
        of a node full of fluid there [kg], (n,); arguments as in `sample`.

        open_share: (nodes of the window,) part of the volume of each node that lies outside walls. The mass of a node is
        divided by it before it is compared with that of other nodes. Otherwise a node would appear to lack fluid where the
        wall fills a part of its volume: diagonally to the grid, the nodes around a position two cells from a wall reach into
        the wall.

        In APIC, the velocities of nodes exceed those of points by half of their curvature times the variance of the shape
        functions. Parabolas through three nodes along each axis, with this variance, compensate the difference. The mass
        of a node on a face is divided by its relative volume before it is compared with other nodes.
        """
        s = np.where(self._thin, 0.0, (place - self._lower) / self._cell)
        ends = ~self._thin & ~self._periodic
        inside = np.all((s >= -ROUNDING) & (s <= self._counts - 1 + ROUNDING) | ~ends, axis=1)
        below, above = np.array(self._grid.mirrored).T  # there the window continues the fluid by its mirror image
        low = np.where(ends & ~below, 1, window.first + 1)
        high = np.where(ends & ~above, self._counts - 2, window.last - 1)
        middle = np.where(self._thin, 0, np.clip(np.rint(s).astype(int), low, np.maximum(high, low)))
        rest = s - middle
        weights = np.stack([0.5 * rest * (rest - 1.0), 1.0 - rest * rest, 0.5 * rest * (rest + 1.0)])
        averaging = 0.5 * self._variance * np.array([1.0, -2.0, 1.0])[:, None, None]
        of_nodes = mass / window.share
        open_mass = np.divide(of_nodes, open_share, out=np.zeros(len(mass)), where=open_share > 0.0)
        masses, open_masses = (values[window.place] for values in (of_nodes, open_mass))
        dense = self.continued(window, velocity)
        found, full = np.zeros((len(place), 3)), np.zeros(len(place))
        least, most = np.full(len(place), np.inf), np.zeros(len(place))
        axes = np.flatnonzero(~self._thin)
        for step in np.ndindex(*np.where(self._thin, 1, 3)):
            at = tuple((middle - window.first + np.where(self._thin, 0, np.array(step) - 1)).T)
            weight = np.prod([(weights + averaging)[step[d], :, d] for d in axes], axis=0)
            found += weight[:, None] * dense[at]
            full += np.prod([weights[step[d], :, d] for d in axes], axis=0) * masses[at]
            least, most = np.minimum(least, open_masses[at]), np.maximum(most, masses[at])
        known = (least / np.maximum(most, MASS_EPS) - LEAST_RATIO) / (FULL_RATIO - LEAST_RATIO)
        return found, np.where(inside, np.clip(known, 0.0, 1.0), 0.0), full

    def functions_at(self, window: Window, place: np.ndarray) -> csr_array:
        """Return the shape functions of the nodes of a window box at positions [m], shape (m, 3), as a sparse matrix of shape
        (m, nx ny nz); see `continued` for their velocities."""
        s = np.where(self._thin, 0.0, (place - self._lower) / self._cell)
        reach, shape, middle = int(np.ceil(self._half - 0.5)), window.place.shape, np.rint(s).astype(int)
        columns, weights = [], []
        for step in np.ndindex(*np.where(self._thin, 1, 2 * reach + 1)):
            at = np.where(self._thin, 0, middle + np.array(step) - reach)
            weights.append(np.prod([self.functions(s[:, d] - at[:, d])[0] for d in np.flatnonzero(~self._thin)], axis=0))
            columns.append(np.ravel_multi_index(tuple(np.clip(at - window.first, 0, np.array(shape) - 1).T), shape))
        rows = np.tile(np.arange(len(place)), len(columns))
        entries = (np.concatenate(weights), (rows, np.concatenate(columns)))
        return csr_array(entries, shape=(len(place), int(np.prod(shape))))

    def find_in_window(self, window: Window, node: np.ndarray) -> np.ndarray:
        """Return the indices, in the flattened box of a window, of nodes with the numbers `node`, shape (n,)."""
        return np.ravel_multi_index(tuple((self._indices(node) - window.first).T), window.place.shape)

    def continued(self, window: Window, vectors: np.ndarray) -> np.ndarray:
        """Return the vectors of the nodes of a window, shape (m, 3), in its box, shape (nx, ny, nz, 3), beyond planes of
        symmetry those of mirror images."""
        dense = vectors[window.place]
        below, above = np.array(self._grid.mirrored).T
        for d in np.flatnonzero(below | above):
            index = np.arange(window.first[d], window.last[d] + 1)
            beyond = (below[d] & (index < 0)) | (above[d] & (index > self._counts[d] - 1))
            dense[..., d] *= np.where(beyond, -1.0, 1.0).reshape(np.where(np.arange(3) == d, -1, 1))
        return dense

    @property
    def heights(self) -> tuple[float, float]:
        """Two distances from the surface of the body, along its normal, at which the velocity of the fluid is sampled [m]."""
        return SAMPLES[0] * self._cell, SAMPLES[1] * self._cell

    def continue_profile(self, surface: Surface, near: np.ndarray, far: np.ndarray, far_known: np.ndarray) -> np.ndarray:
        """Return the tangential velocity δ of the fluid relative to the body at the nodes [m/s], shape (n, 3), which
        vanishes on the surface and is continued from the velocities relative to the body at the two distances `heights`
        from the surface, `near` and `far` [m/s], shape (n, 3) each.

        far_known: reliability of the velocity at the larger height, between 0 and 1, (n,); the quadratic term of the
        profile is multiplied by it.

        """
        a, b = self.heights
        d = surface.distance[:, None]
        curvature = np.clip(np.atleast_1d(surface.curvature), FLATTEST / self._cell, SHARPEST / self._cell)[:, None]
        near, far = (1.0 + curvature * a) * near, (1.0 + curvature * b) * far
        bend = far_known[:, None] * (far / b - near / a) / (b - a)
        profile = ((near / a - a * bend) * d + bend * d * d) / (1.0 + curvature * d)
        along = np.sum(profile * surface.normal, axis=1)[:, None] * surface.normal
        return surface.certainty[:, None] * (profile - along)

    def slope_of_profile(
        self, surface: Surface, near: np.ndarray, far: np.ndarray, far_known: np.ndarray, heights: Sequence[np.ndarray]
    ) -> np.ndarray:
        """Return the normal derivative, on the surface, of the tangential velocity of the fluid relative to the body [1/s],
        shape (n, 3). Arguments and profile as in `continue_profile`, but for each node its own `heights`, two arrays of shape
        (n,) [m]. The profile is corrected for the curvature of convex surfaces only: in a tube it is that of Poiseuille
        flow."""
        a, b = (height[:, None] for height in heights)
        curvature = np.clip(np.atleast_1d(surface.curvature), 0.0, SHARPEST / self._cell)[:, None]
        near, far = (1.0 + curvature * a) * near, (1.0 + curvature * b) * far
        slope = near / a - a * far_known[:, None] * (far / b - near / a) / (b - a)
        along = np.sum(slope * surface.normal, axis=1)[:, None] * surface.normal
        return np.asarray(surface.certainty[:, None] * (slope - along))

    def _distance_to(self, share: np.ndarray) -> np.ndarray:
        """Return the distances [cells] of nodes from a plane face of a body that fills the fractions `share` of their
        volumes, shape (n,)."""
        return np.interp(-np.clip(share, 0.0, 1.0), -self._filled, self._distances)

    def _slope_at(self, distance: np.ndarray) -> np.ndarray:
        """Return the rate at which the filled fraction of a node decreases with its distance from a plane face of a body
        [1/cell], at the given distances [cells]."""
        above, below = (np.interp(distance + side, self._distances, self._filled) for side in (1.0, -1.0))
        return 0.5 * (below - above)

    def _indices(self, node: np.ndarray) -> np.ndarray:
        """Return the indices along the axes of nodes from their numbers, shape (n, 3)."""
        return np.asarray(np.rint((self._grid.find_positions(node) - self._lower) / self._cell).astype(int))

    def _node(self, at: np.ndarray) -> np.ndarray:
        """Return the numbers of the nodes from their indices along the axes, shape (..., 3); beyond a face of the grid, which
        may be a plane of symmetry, those of their mirror images."""
        last = self._counts - 1
        mirrored = np.clip(last - np.abs(last - np.abs(at)), 0, last)
        within = np.where(self._periodic, np.mod(at, self._counts), mirrored)
        return within @ self._strides
