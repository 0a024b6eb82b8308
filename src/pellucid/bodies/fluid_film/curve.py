"""Films described by a curve: closed curves in the plane, and surfaces of revolution about the z axis.

Between two neighbours the curve is interpolated by radial functions of a parameter that grows by 1 from node to node,
blended from the stencils around both nodes. Its tangent is continuous, and it passes through the nodes. Source: Benet 2015,
§§6.3 and 7.1.
"""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import PchipInterpolator

from pellucid.approximants.radial.blending import Simplices, blended
from pellucid.approximants.radial.functions import RadialModel
from pellucid.approximants.radial.stencils import Stencils, interpolants
from pellucid.bodies.fluid_film.film_geometry import Operators, Redistributed, Shares
from pellucid.geometry.meshes.cells import Cells

GAUSS = 3  # quadrature points of a segment; with fewer, hoop strain would have modes without energy
SAMPLES = 8  # parts into which a segment is divided to compute its length
EVEN = 0.01  # relative difference of segment lengths above which nodes are redistributed


def segment_functions(radial: RadialModel, places: np.ndarray) -> np.ndarray:
    """Return the shape functions of the m nodes of a segment and their first and second derivatives, shape (3, q, m), at
    parameters `places`, shape (q,), from 0 at the first node of the segment to 1 at the second. All segments have the same
    functions.

    radial: settings of the radial functions. The m nodes extend from half a stencil before the first node to half a stencil
    after the second.
    """
    reach = radial.stencil_size(1) // 2
    ends, offset = np.arange(2), np.arange(-reach, reach + 1)
    near = Stencils(ends[:, None] + offset, np.ones((2, 1, 1)), np.tile(offset[:, None], (2, 1, 1)).astype(float))
    segment = Simplices(ends[:, None].astype(float), ends[None], None)
    shares = np.stack([1.0 - places, places], axis=1)
    rows = blended(segment, near, interpolants(near.coordinates, radial), shares, derivatives=2)
    rows = rows.united(np.arange(-reach, reach + 2)[None], near.nodes[None] + reach)
    return np.stack([rows.value[0], rows.first[0, :, 0], rows.second[0, :, 0]])


class Curve:
    """n nodes in order along a curve with its interior to the left, in two coordinates.

    radial: settings of the shape functions; around: True for the meridian of a surface of revolution in r and z, from the
    lower pole to the upper one, continued by its mirror image beyond the poles; False for a closed curve in x and y.
    """

    def __init__(self, n: int, radial: RadialModel, around: bool) -> None:
        self.n, self.around = n, around
        self.axes: tuple[int, ...] = (0, 2) if around else (0, 1)
        reach = radial.stencil_size(1) // 2
        segments = n - 1 if around else n
        self.nodes = np.arange(segments)[:, None] + np.arange(-reach, reach + 2)
        self.sign = np.ones((*self.nodes.shape, 2))
        self.held = np.zeros((n, 2), bool)
        if around:
            self.sign[(self.nodes < 0) | (self.nodes >= n), 0] = -1.0
            self.nodes = np.abs(self.nodes)
            self.nodes = np.where(self.nodes >= n, 2 * (n - 1) - self.nodes, self.nodes)
            self.held[[0, -1], 0] = True
        else:
            self.nodes %= n
        point, weight = np.polynomial.legendre.leggauss(GAUSS)
        self.radial, self._weight = radial, 0.5 * weight
        self._tables = segment_functions(radial, 0.5 * (1.0 + point))
        self.shares = Shares(np.arange(segments)[:, None], np.ones((GAUSS, 1)))
        self._ends = segment_functions(radial, np.array([0.0, 1.0]))
        places = (np.arange(SAMPLES)[:, None] + 0.5 * (1.0 + point)).ravel() / SAMPLES
        self._samples = segment_functions(radial, places)

    def operators(self, x: np.ndarray) -> Operators:
        """Return the geometry of the film at its quadrature points and the operators that map nodal velocities to strain rate,
        slope and change of curvature (see `Operators`), for nodes at x [m], shape (n, 2).
        """
        table, corner = self._tables, self._about(x)
        place, along, bend = (np.einsum("qm,emi->eqi", functions, corner) for functions in table)
        square = np.einsum("eqi,eqi->eq", along, along)
        length = np.sqrt(square)
        tangent = along / length[..., None]
        normal = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
        value, first, second = (functions[None, :, :, None] * self.sign[:, None] for functions in table)
        stretch = tangent[:, :, None, :] * first / length[..., None, None]
        slope = normal[:, :, None, :] * first / length[..., None, None]
        gamma = np.einsum("eqi,eqi->eq", along, bend) / square
        kappa = -np.einsum("eqi,eqi->eq", normal, bend) / square
        bending = -normal[:, :, None, :] * (second - gamma[..., None, None] * first) / square[..., None, None]
        bending -= 2.0 * kappa[..., None, None] * stretch
        area, strain = length * self._weight, stretch[:, :, None]
        if self.around:
            r = place[..., 0]
            hoop = np.zeros_like(value)
            hoop[..., 0] = value[..., 0] / r[..., None]
            bending -= (tangent[..., 0] / r)[..., None, None] * slope + (normal[..., 0] / r)[..., None, None] * hoop
            kappa = kappa + normal[..., 0] / r
            area, strain = 2.0 * np.pi * r * area, np.stack([stretch, hoop], axis=2)
        return Operators(area, place, normal, value, strain, slope[:, :, None], kappa, bending)

    def places(self, x: np.ndarray) -> np.ndarray:
        """Return x: the film passes through its nodes."""
        return x

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Return the outward unit normals of the curve at its nodes, shape (n, 2), with nodes at x [m], shape (n, 2)."""
        along = np.einsum("qm,emi->qei", self._ends[1], self._about(x))
        at_nodes = np.append(along[0], along[1, -1:], axis=0)[: self.n]
        normal = np.stack([at_nodes[:, 1], -at_nodes[:, 0]], axis=1)
        normal[self.held] = 0.0
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    def spacing(self, x: np.ndarray) -> np.ndarray:
        """Return the distance of each node from its nearest neighbour [m], shape (n,), with nodes at x [m], shape (n, 2)."""
        ends = self.cells().lines
        length = np.linalg.norm(x[ends[:, 1]] - x[ends[:, 0]], axis=1)
        nearest = np.full(self.n, np.inf)
        for corner in (0, 1):
            np.minimum.at(nearest, ends[:, corner], length)
        return nearest

    def cells(self) -> Cells:
        """Return the segments between neighbouring nodes, which the results contain as cells."""
        first = np.arange(len(self.nodes))
        return Cells(lines=np.stack([first, (first + 1) % self.n], axis=1))

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return no arrays: the functions are the same for all positions of the nodes."""
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Do nothing: a curve has no arrays."""

    def redistributed(self, x: np.ndarray, mass: np.ndarray, moved: np.ndarray) -> Redistributed:
        """Return n nodes at equal distances along the curve, or the nodes x if their distances are already equal, and the
        new mass of each segment [kg], taken from the mass distribution before.

        x: nodal positions [m], shape (n, 2); mass: masses of the segments [kg]; moved: not used. The cumulative mass is
        interpolated monotonically between the nodes, so that no density becomes negative.
        """
        lengths, areas = self._samples_of(x)
        of_segments = lengths.reshape(-1, SAMPLES).sum(axis=1)
        if np.ptp(of_segments) <= EVEN * of_segments.mean():
            return Redistributed(x, mass)
        parameter = np.arange(len(lengths) + 1) / SAMPLES
        along, area = (np.append(0.0, np.cumsum(parts)) for parts in (lengths, areas))
        goals = np.linspace(0.0, along[-1], len(of_segments) + 1)
        place = PchipInterpolator(along, parameter)(goals)
        place[0], place[-1] = 0.0, parameter[-1]
        segment = np.minimum(place.astype(np.int64), len(of_segments) - 1)
        value = segment_functions(self.radial, place - segment)[0]
        moved = np.einsum("em,emi->ei", value, self._about(x)[segment])[: self.n]
        moved[self.held] = 0.0
        covered = PchipInterpolator(parameter, area)(place)
        below = np.append(0.0, np.cumsum(mass))
        masses = np.diff(PchipInterpolator(area[::SAMPLES], below)(covered))
        return Redistributed(moved, masses * (below[-1] / masses.sum()))

    def can_wait(self, x: np.ndarray) -> bool:
        """Return False: redistribution is never postponed. On a curve, redistributing the nodes adds less energy than a time
        step dissipates, down to round-off.
        """
        return False

    def _about(self, x: np.ndarray) -> np.ndarray:
        """Return the positions of the nodes of each segment [m], shape (e, m, 2), including mirror images. x: nodal positions
        [m], shape (n, 2).
        """
        return np.asarray(x[self.nodes] * self.sign)

    def _samples_of(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the lengths [m] and areas [m²] of the SAMPLES parts into which each segment is divided, shape (e SAMPLES,).
        x: nodal positions [m], shape (n, 2).
        """
        corner = self._about(x)
        along = np.einsum("qm,emi->eqi", self._samples[1], corner)
        length = np.hypot(along[..., 0], along[..., 1])
        area = length
        if self.around:
            area = 2.0 * np.pi * length * np.einsum("qm,em->eq", self._samples[0], corner[..., 0])
        weight = np.tile(self._weight / SAMPLES, SAMPLES)
        of_lengths, of_areas = ((values * weight).reshape(-1, GAUSS).sum(axis=1) for values in (length, area))
        return of_lengths, of_areas
