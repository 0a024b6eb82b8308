"""The contact surface of a solid of material points.

Each surface point belongs to a material point (its host) at x and lies at x + o, plus a constant depth along its normal. It
moves with the linear part of the velocity field around the host: v + L o, with the velocity v and its gradient L at x. A
force f on it acts on the nodes with the same weights, N_I + o·∇N_I. Momentum and energy are therefore transferred
consistently, and all nodes that receive forces have mass. v and L are computed from the velocity that strains the points,
since forces on nodes do work on this velocity. The material points move with another velocity, which differs by the
smoothing of the transfers; surfaces under pressure that moved with it would gain energy in each step. The vector area a
changes by tr(L) a - Lᵀ a, like a material area. With USF the surface moves when the points are strained, before the forces.
"""

from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy import uintp
from scipy.spatial import cKDTree

from pellucid.bodies.material_points.edge_points import EdgePoints
from pellucid.contact.contact_surface import ContactSurface
from pellucid.geometry.shapes.contract import FLAT, SHARP
from pellucid.grid.lattice import Lattice
from pellucid.grid.points import Slabs
from pellucid.grid.stencil import add_affine, gather_affine, stencil
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.memory import numbers
from pellucid.ranks.domain import domain

CHUNK = 256  # points that a thread processes at a time
ON_A_FACE = 1e-6  # tolerance of the distance of a point from a face of the grid, in cells
WIDTHS = 2.5  # range of the weights of a surface point, in distances between the points


class MovedSurface(NamedTuple):
    """Data of m surface points for the kernels that move them, and the nodal velocities with which they move.

    A surface point lies at the end of the offset (a vector from its host material point) plus a constant depth along its
    normal.
    """

    functions: Any  # shape functions along x, y, z
    lattice: Lattice  # cells of the grid
    velocities: np.ndarray  # (4 nodes,) rows of the nodal velocities that strain the points, on which forces do work [m/s]
    host: np.ndarray  # (m, 3) positions of the host material points at the start of the step [m]
    offset: np.ndarray  # (m, 3) vectors from the hosts to the surface points, less a constant depth along the normal [m]
    area: np.ndarray  # (m, 3) outward vector areas of the surface points [m²]
    motion: np.ndarray  # (m, 3) velocities of the surface points in the last step [m/s]


@parallel_loop()
def _follow(chunk, surface, step, dt):
    """Update, for a chunk of surface points, the velocities and vector areas over a step dt [s], and over `step` [s] their
    offsets (vectors from their host material points); positions of the hosts are not changed. surface: a `MovedSurface`.
    """
    functions, lattice, o, a, found = surface.functions, surface.lattice, surface.offset, surface.area, numbers(16)
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(o))):
        about = stencil(functions, lattice, surface.host, uintp(p))
        gather_affine(about, lattice, surface.velocities, found)
        o0, o1, o2, a0, a1, a2 = o[p, 0], o[p, 1], o[p, 2], a[p, 0], a[p, 1], a[p, 2]
        growth = dt * (found[4] + found[9] + found[14])
        for d in range(3):
            surface.motion[p, d] = found[d] + (found[4 + d] * o0 + found[8 + d] * o1 + found[12 + d] * o2)
            o[p, d] += step * surface.motion[p, d]
            k = 4 + 4 * d  # derivatives along this axis
            a[p, d] += growth * a[p, d] - dt * (found[k] * a0 + found[k + 1] * a1 + found[k + 2] * a2)


@kernel()
def _put_on_hosts(surface, position, stored, stays, depth, place):
    """Compute the positions `place` of the surface points [m], shape (m, 3): position of the host material point, plus the
    offset, plus a constant depth along the normal.

    surface: a `MovedSurface`; position: positions of all material points [m], shape (n, 3); stored: row of each host in
    `position`, shape (m,); stays: True if the point at the end of the offset does not move with the host, so that the
    offset changes; depth: the constant depths [m], shape (m, 1).
    """
    host, offset, area = surface.host, surface.offset, surface.area
    for p in range(len(place)):
        size = sqrt(area[p, 0] * area[p, 0] + area[p, 1] * area[p, 1] + area[p, 2] * area[p, 2])
        above = depth[p, 0] / size if size > 0.0 else 0.0
        for d in range(3):
            x = position[stored[p], d]
            if stays:
                offset[p, d] -= x - host[p, d]
            host[p, d] = x
            place[p, d] = x + offset[p, d] + above * area[p, d]


@kernel()
def _turn(surface, depth, centre, rotation, new_centre, dt):
    """Turn the offsets (vectors from the host material points) and vector areas of the surface points of a rigid body by a
    rotation matrix (3, 3), and compute the velocities of the points over a step dt [s], in which the centre of the rotation
    moves from `centre` to `new_centre` [m], (3,).

    surface: a `MovedSurface`; depth: distances along the normals from the ends of the offsets to the surface [m], shape (m, 1).
    """
    host, offset, area, R = surface.host, surface.offset, surface.area, rotation
    for p in range(len(host)):
        o, a = (offset[p, 0], offset[p, 1], offset[p, 2]), (area[p, 0], area[p, 1], area[p, 2])
        size = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
        above = depth[p, 0] / size if size > 0.0 else 0.0
        r0 = host[p, 0] + o[0] + above * a[0] - centre[0]
        r1 = host[p, 1] + o[1] + above * a[1] - centre[1]
        r2 = host[p, 2] + o[2] + above * a[2] - centre[2]
        r = (r0, r1, r2)
        for d in range(3):
            offset[p, d] = R[d, 0] * o[0] + R[d, 1] * o[1] + R[d, 2] * o[2]
            area[p, d] = R[d, 0] * a[0] + R[d, 1] * a[1] + R[d, 2] * a[2]
            if dt > 0.0:
                turned = R[d, 0] * r0 + R[d, 1] * r1 + R[d, 2] * r2
                surface.motion[p, d] = (new_centre[d] - centre[d] + turned - r[d]) / dt


@kernel()
def _add_forces(surface, listed, force, target):
    """Add forces on n surface points [N], shape (n, 3), to the nodal forces `target` of the grid [N], shape (nodes, 3).
    surface: a `MovedSurface`; listed: numbers of the n points.
    """
    for e in range(len(listed)):
        p = uintp(listed[e])
        about = stencil(surface.functions, surface.lattice, surface.host, p)
        offset = (surface.offset[p, 0], surface.offset[p, 1], surface.offset[p, 2])
        add_affine(about, surface.lattice, target, (force[e, 0], force[e, 1], force[e, 2]), offset)


@kernel()
def _find_powers(surface, listed, force, velocities, powers):
    """Compute the powers [W] of the forces on n of the surface points; force: forces on all points [N], shape (m, 3).

    surface: a `MovedSurface`; listed: numbers of the n points; velocities: rows of the nodal velocities, shape (4 nodes,);
    powers: output, shape (n,).
    """
    found = numbers(16)
    for e in range(len(listed)):
        p = uintp(listed[e])
        gather_affine(stencil(surface.functions, surface.lattice, surface.host, p), surface.lattice, velocities, found)
        power = 0.0
        for d in range(3):
            along = found[d]
            for axis in range(3):
                along += found[4 + 4 * axis + d] * surface.offset[p, axis]
            power += force[p, d] * along
        powers[e] = power


@kernel()
def _list_pushed(force, listed):
    """List the numbers of the points with non-zero forces [N], shape (m, 3), into `listed`; return the number of points
    listed."""
    n = 0
    for p in range(len(force)):
        if force[p, 0] != 0.0 or force[p, 1] != 0.0 or force[p, 2] != 0.0:
            listed[n] = p
            n += 1
    return n


class GridSurface(ContactSurface):
    """Contact surface of a body of material points: surface points that move with the nodes of the grid.

    arrays, mapped: arrays and kernel data of the material points of the body; hosts: number (`id`) of the material point of
    each surface point, shape (m,); place, area, velocity: initial positions [m], outward vector areas [m²] and velocities
    [m/s] of the surface points, shape (m, 3); spacing: distance of the surface points [m]; load: function that returns the
    nodal forces, shape (nodes, 3), to which the surface forces are added; edges: points on the edges of a body that does not
    deform, stored last and without area.
    """

    serves_deformed = True

    def __init__(
        self,
        arrays: Mapping[str, np.ndarray],
        mapped: Bundle,
        hosts: np.ndarray,
        place: np.ndarray,
        area: np.ndarray,
        spacing: float,
        load: Callable[[], np.ndarray],
        velocity: np.ndarray,
        edges: EdgePoints | None = None,
    ) -> None:
        self._points, self._hosts, self._load, self._slabs = arrays, hosts, load, mapped.slabs
        self.place, self.area = place.copy(), area.copy()
        self.velocity, self.slip = velocity.copy(), np.zeros_like(place)
        self._rests = False
        self._listed = np.zeros(len(place), np.int64)
        self.reach = np.full(len(place), WIDTHS * spacing)
        self._weights, self._edge_normal = self.sizes(), np.zeros((0, 3))
        self.edge_tangent = np.zeros((0, 3))
        if edges is not None:
            self.n_edge_points = n = len(edges.place)
            self._weights[len(place) - n :], self._edge_normal = edges.weight, edges.normal.copy()
            self.edge_tangent = edges.tangent.copy()
            self.on_flat_side = find_flat_sides(self.place, self.normals(), WIDTHS * spacing)
            if len(edges.face):
                self.faces = np.where(edges.face < 0, -1, edges.face + len(place) - n)
            self.thin_axis = np.array(edges.thin, float)
        self.find_hosts()
        self._host = arrays["position"][self._stored].copy()
        size = np.linalg.norm(area, axis=1, keepdims=True)
        self._depth = np.sum((place - self._host) * area / np.where(size > 0.0, size, 1.0), axis=1, keepdims=True)
        self._offset = place - self._above() - self._host
        self._nodes = nodes = mapped.nodes
        moved = MovedSurface(
            mapped.functions, mapped.lattice, nodes.strain_velocities, self._host, self._offset, self.area, self.velocity
        )
        self._moved = Bundle(moved)

    def _above(self) -> np.ndarray:
        """Return the vectors along the normals from the ends of the offsets (vectors that start at the host material points) to
        the surface points [m], shape (m, 3).
        """
        size = np.linalg.norm(self.area, axis=1, keepdims=True)
        return self._depth * self.area / np.where(size > 0.0, size, 1.0)

    def find_hosts(self) -> None:
        """Find the row in which the arrays of the body store the host material point of each surface point; surface points
        whose hosts left the grid get zero area.
        """
        numbers = self._points["id"]
        stored = np.empty(len(numbers), np.int64)
        stored[numbers] = np.arange(len(numbers))
        self._stored = stored[self._hosts]
        self.area[self._points["mass"][self._stored] == 0.0] = 0.0

    def end_at(self, faces: Sequence[tuple[int, float]]) -> None:
        """Set the areas of surface points to zero if they lie on these faces and their area vectors are normal to the faces.
        faces: axis and coordinate [m] of each face.
        """
        near = ON_A_FACE / self._moved.content.lattice.inverse_cell
        for axis, place in faces:
            on = np.abs(self.place[:, axis] - place) < near
            self.area[on & (np.abs(self.area[:, axis]) > 0.5 * self.sizes())] = 0.0

    def weights(self) -> np.ndarray:
        """Return the initial areas of the surface points [m²], shape (m,), which weight the contact forces."""
        return self._weights

    def find_directions(self, normal: np.ndarray, size: np.ndarray) -> None:
        super().find_directions(normal, size)
        if self.n_edge_points:
            normal[len(normal) - self.n_edge_points :] = self._edge_normal

    def begin(self) -> None:
        self.stands = self._rests
        if self.stands:
            return
        _put_on_hosts(self._moved, self._points["position"], self._stored, not self.is_hard, self._depth, self.place)

    def follow(self, dt: float) -> None:
        """Move the surface points over a step dt [s] with the velocities of the grid nodes; if the motion of the body is
        prescribed, with its material points.
        """
        self._rests = False
        _follow(len(self._host) // CHUNK + 1, self._moved, 0.0 if self.is_hard else dt, dt)
        if domain.is_cut:  # nodes are whole about points in the slabs of this process
            here = _list_here(self._stored, self._slabs)
            numbers = domain.group.joined(here)
            for values in (self._offset, self.area, self.velocity):
                values[numbers] = domain.group.joined(values[here])

    def rest(self) -> None:
        """Set the velocities to zero: the surface does not move in this step."""
        if not self._rests:
            self.velocity[...] = 0.0
            self._rests = True

    def turn(self, centre: np.ndarray, rotation: np.ndarray, new_centre: np.ndarray, dt: float) -> None:
        """Move the surface as a rigid body over dt [s]: its centre moves to the position `new_centre` [m], shape (3,), and it
        turns by a rotation matrix (3, 3).
        """
        self._rests = False
        _turn(self._moved, self._depth, centre, rotation, new_centre, dt)
        self._edge_normal[...] = self._edge_normal @ rotation.T
        self.edge_tangent[...] = self.edge_tangent @ rotation.T

    def list_pushed(self, force: np.ndarray) -> np.ndarray:
        """Return the numbers of the surface points on which the contact forces [N], shape (m, 3), are not zero."""
        return self._listed[: _list_pushed(force, self._listed)]

    def add_forces(self, force: np.ndarray) -> None:
        listed = self.list_pushed(force)
        _add_forces(self._moved, listed, force[listed], self._load())

    def power(self, force: np.ndarray, mean: bool) -> float:
        """Return the power [W] of forces on the surface points [N], shape (m, 3), along the mean velocities of the nodes, with
        which the work of forces is computed, if `mean` is True, else along the velocities that strain the points."""
        listed, rows = self.list_pushed(force), self._nodes.mean_velocities if mean else self._nodes.strain_velocities
        powers = np.zeros(len(listed))
        fill(
            self._stored[listed],
            self._slabs,
            lambda at, target: _find_powers(self._moved, listed[at], force, rows, target),
            powers,
        )
        return float(powers.sum())

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        own = {
            "offset": self._offset,
            "host": self._host,
            "depth": self._depth,
            "area": self.area,
            "velocity": self.velocity,
            "slip": self.slip,
            "weight": self._weights,
            "edge_normal": self._edge_normal,
            "edge_tangent": self.edge_tangent,
        }
        return {f"surface/{name}": array for name, array in own.items()}


def fill(stored: np.ndarray, slabs: Slabs, find: Callable[[np.ndarray, np.ndarray], object], target: np.ndarray) -> None:
    """Fill `target`, shape (n, ...), with values computed from nodes: each process computes those of the points in its slabs,
    about which its nodes are complete.

    stored: rows of n points in the arrays of their body, shape (n,). find: function that computes the values of the points with
    given indices, shape (k,), into an array of shape (k, ...).
    """
    if not domain.is_cut:
        find(np.arange(len(stored)), target)
        return
    here = _list_here(stored, slabs)
    own = np.zeros((len(here), *target.shape[1:]))
    find(here, own)
    target[domain.group.joined(here)] = domain.group.joined(own)


def _list_here(stored: np.ndarray, slabs: Slabs) -> np.ndarray:
    """Return the indices of those points that lie in the slabs of this process, from their rows in the arrays of the body."""
    return np.flatnonzero((stored >= slabs.first[0]) & (stored < slabs.first[-1]))


def find_flat_sides(place: np.ndarray, normal: np.ndarray, about: float) -> np.ndarray:
    """Return a mask, shape (m,), of the surface points on a flat side.

    All neighbours of a point on a flat side have the same normal as the point, except neighbours beyond a sharp edge.
    place: positions [m], shape (m, 3); normal: unit normals, shape (m, 3), where zero counts as flat; about: search
    distance for neighbours [m].
    """
    pairs = cKDTree(place).query_pairs(about, output_type="ndarray")
    cosine = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]])
    curved = np.zeros(len(place), bool)
    curved[pairs[(cosine > SHARP) & (cosine < np.cos(FLAT))]] = True
    return ~curved
