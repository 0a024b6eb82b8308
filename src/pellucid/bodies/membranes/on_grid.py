"""Bending of membranes moved by the nodes of a grid: suitable shape functions, and clamps by supports of the grid.

A clamp consists of prescribed nodes of the grid and, within the region of the support, prescribed points. The shape
functions of prescribed nodes extend beyond the region, and free points there would move as if the membrane were hinged one
cell away. For the bending, prescribed nodes g near the edge of a clamp therefore get the velocity along the normal n of the
clamp that extrapolates the velocity of free nodes I beyond the edge,

    v_g·n = b_g Σ m_I b_I v_I·n / Σ m_I b_I²,    b = d² - (p + 1) h²/12,

with the distances d from the edge, the mass m of the membrane at the nodes, and the cell size h. The b are the coefficients
with which B-splines of degree p have the value d², the deflection of a plate near a clamp. Forces on these nodes are
distributed to the free nodes in the same proportions, so that their work is the same on the grid. Prescribed nodes keep the
tangential velocities of the support.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pellucid.approximants import GridFunctions
from pellucid.bodies.membranes.bending import Resistance, find_rows_on_grid, support_bending
from pellucid.bodies.membranes.plate_bending import PlateBending
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.geometry.meshes.triangulation import pair_edges
from pellucid.grid.lattice import Grid
from pellucid.grid.transfer import scatter_listed, scatter_listed_numbers, scatter_vectors
from pellucid.parts.constraint import LeadsPoints
from pellucid.ranks.domain import domain
from pellucid.step.limit import StepLimit, bending_in_cells

DEGREES = {"gimp": 2, "quadratic-bspline": 2, "cubic-bspline": 3}  # B-spline degree of the functions of a plate on such a grid
REACH = 2.0  # distance from the edge of a clamp within which prescribed nodes are extrapolated, in cells
ASIDE = 4.0  # distance from the tangent plane of a clamp within which nodes are extrapolated, in cells
DONORS = 2  # number of free nodes from which the velocity of a prescribed node is extrapolated
FARTHEST = 5  # largest distance between these nodes, in cells
ON_EDGE = 1e-6  # tolerance of the distance of a node from the edge of a clamp, in cells
LEAST_SHARE = 1e-9  # smallest weight of a point at a node that counts
NEAR = 7.0  # distance from the edge of a clamp within which points may have weight at these nodes, in cells


def membrane_functions(grid: Grid, bends: bool) -> GridFunctions:
    """Return the shape functions with which the points of a membrane interact with the grid. bends: True for an open
    membrane that resists bending.

    Points have no extent normal to the membrane; GIMP assumes half a cell. The slopes of the GIMP functions change only
    within half a cell around each node, where the points of a plate then bend twice as much as they should. An open
    membrane that resists bending uses B-splines instead of GIMP; with B-splines the bending converges.
    """
    name = "quadratic-bspline" if bends and grid.case.functions == "gimp" else None
    return grid.functions((2, 2, 2), name)


class ClampEdges(NamedTuple):
    """The e edges between triangles that a clamp moves and other triangles."""

    start: np.ndarray  # (e, 3) start points of the edges [m]
    along: np.ndarray  # (e, 3) vectors from the start to the end [m]
    inward: np.ndarray  # (e, 3) unit vectors in the plane of the clamped triangle, from the edge out of the triangle
    normal: np.ndarray  # (e, 3) unit normals of the clamped triangles


def find_clamp_edges(triangles: np.ndarray, position: np.ndarray, led: np.ndarray, held: np.ndarray) -> ClampEdges:
    """Return the edges between clamped triangles with only prescribed nodes, and triangles that are not clamped.

    triangles: shape (t, 3); position: nodal positions [m], shape (n, 3); led: mask of the clamped triangles, shape (t,); held:
    mask of the prescribed nodes, shape (n,).
    """
    t = len(triangles)
    chosen, partner = pair_edges(triangles)
    both = np.concatenate([chosen, partner]), np.concatenate([partner, chosen])
    clamps = led & held[triangles].all(axis=1)
    own = both[0][clamps[both[0] % t] & ~led[both[1] % t]]
    corners = [position[triangles[own % t, (own // t + k) % 3]] for k in range(3)]
    along = corners[1] - corners[0]
    normal = np.cross(along, corners[2] - corners[0])
    inward = np.cross(along, normal)
    normal, inward = (each / np.linalg.norm(each, axis=1)[:, None] for each in (normal, inward))
    return ClampEdges(corners[0], along, inward, normal)


class Extension:
    """For the motion of the free points of a membrane near a clamp, replaces the normal velocities of prescribed grid nodes
    near the edges of the clamp by values extrapolated from free nodes, so that the membrane has zero slope at the edge
    (equation: see `pellucid.bodies.membranes.on_grid`)."""

    def __init__(self, grid: Grid, edges: ClampEdges, degree: int, held: np.ndarray, free: np.ndarray) -> None:
        """grid: the grid; edges: edges of the clamps; degree: degree p of the B-splines; held: mask of the grid nodes that are
        fixed along all axes; free: mask of the grid nodes that are free along all axes; shape (nodes,).
        """
        lattice = grid.lattice
        cell, lower, strides = lattice.cell, np.array(lattice.lower), np.array(lattice.strides)
        last = np.array(lattice.counts)
        middle = edges.start + 0.5 * edges.along
        first = np.clip(np.floor((middle.min(axis=0) - lower) / cell - ASIDE - 2), 0, last).astype(int)
        end = np.clip(np.ceil((middle.max(axis=0) - lower) / cell + ASIDE + 2), 0, last).astype(int) + 1
        at = np.stack(np.meshgrid(*map(np.arange, first, end), indexing="ij"), axis=-1).reshape(-1, 3)
        at = at[held[at @ strides]]
        foot, edge = _find_feet(edges, lower + cell * at)
        away = lower + cell * at - foot
        distance, aside = (np.sum(away * way[edge], axis=1) / cell for way in (edges.inward, edges.normal))
        near = (np.abs(distance) <= REACH) & (np.abs(aside) <= ASIDE) & (np.linalg.norm(away, axis=1) <= 2.0 * ASIDE * cell)
        at, foot, edge, distance = at[near], foot[near], edge[near], distance[near]
        inward, rows = edges.inward[edge], np.arange(len(at))
        axis = np.argmax(np.abs(inward), axis=1)
        step = np.zeros(at.shape, int)
        step[rows, axis] = np.sign(inward[rows, axis]).astype(int)
        donors, found = np.zeros((len(at), DONORS), int), np.zeros(len(at), int)
        offset = np.zeros((len(at), DONORS))
        for k in range(1, FARTHEST + 1):
            place = at + k * step
            gives = np.all((place >= 0) & (place <= last), axis=1) & (found < DONORS)
            gives[gives] = free[place[gives] @ strides]
            which = np.flatnonzero(gives)
            donors[which, found[which]] = place[which] @ strides
            offset[which, found[which]] = np.sum((lower + cell * place[which] - foot[which]) * inward[which], axis=1) / cell
            found[which] += 1
        whole = found == DONORS
        self.nodes, self.donors, self.normal = (at @ strides)[whole], donors[whole], edges.normal[edge][whole]
        shift = (degree + 1) / 12.0
        self._own, self._theirs = distance[whole] ** 2 - shift, offset[whole] ** 2 - shift
        self._weights = np.zeros(self.donors.shape)
        self._sources = np.unique(self.donors)
        self._touched = np.union1d(self.nodes, self._sources)
        self._buffer = np.zeros((grid.n_nodes, 3))  # only the values at `_touched` nodes are valid

    def share_forces(self, body: PointsOnGrid, listed: np.ndarray, forces: np.ndarray, target: np.ndarray) -> None:
        """Transfer the normal forces on prescribed grid nodes near clamps to free nodes.

        body: the membrane; listed: rows of the points whose functions may be non-zero at these nodes; forces: forces on the
        points [N], shape (n, 3), already scattered to the nodes; target: the nodal forces [N], shape (nodes, 3), which are
        changed.
        """
        values = np.zeros((len(listed), 3))
        values[:, 0] = body.points.mass[listed]
        mass = self._at_nodes(body, listed, values)[self.donors, 0]
        total = np.sum(mass * self._theirs**2, axis=1)
        scale = np.divide(self._own, total, out=np.zeros_like(total), where=total > 0.0)
        self._weights = scale[:, None] * mass * self._theirs
        across = np.sum(self.normal * self._at_nodes(body, listed, forces[listed])[self.nodes], axis=1)
        given = (self._weights * across[:, None])[:, :, None] * self.normal[:, None, :]
        np.add.at(target, self.donors, given)
        target[self.nodes] -= given.sum(axis=1)

    def _at_nodes(self, body: PointsOnGrid, listed: np.ndarray, values: np.ndarray) -> np.ndarray:
        self._buffer[self._touched] = 0.0
        scatter_listed(body.mapped, body.points.position, listed, values, self._buffer)
        return self._buffer

    def extend(self, velocity: np.ndarray) -> np.ndarray:
        """Add the extrapolated normal velocities of the prescribed nodes to the nodal velocities of the grid [m/s], shape
        (nodes, 3), in place. Returns the velocities of the prescribed nodes before the change.
        """
        known = domain.of_nodes(velocity[self._sources], self._sources)
        theirs = known[np.searchsorted(self._sources, self.donors)]
        along = np.sum(self._weights * np.einsum("gkd,gd->gk", theirs, self.normal), axis=1)
        before = velocity[self.nodes].copy()
        velocity[self.nodes] += along[:, None] * self.normal
        return before


def _find_feet(edges: ClampEdges, position: np.ndarray, within: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return the projections of positions [m], shape (k, 3), onto the lines of the nearest clamp edges (`within`: onto the
    edges themselves), and the numbers of these edges, shape (k,).
    """
    square = np.sum(edges.along**2, axis=1)
    nearest, number = np.full(len(position), np.inf), np.zeros(len(position), int)
    foot = np.zeros(position.shape)
    for e in range(len(square)):
        away = position - edges.start[e]
        share = away @ edges.along[e] / square[e]
        line = edges.start[e] + share[:, None] * edges.along[e]
        inside = edges.start[e] + np.clip(share, 0.0, 1.0)[:, None] * edges.along[e]
        flat = position - inside
        flat = flat - (flat @ edges.normal[e])[:, None] * edges.normal[e]
        distance = np.linalg.norm(flat, axis=1)
        closer = distance < nearest
        nearest[closer], number[closer], foot[closer] = distance[closer], e, (inside if within else line)[closer]
    return foot, number


class BendsOnGrid(PointsOnGrid):
    """A membrane whose points move with the nodes of the grid, with or without resistance to bending."""

    bending: Resistance | None = None
    """Object that computes bending energy and bending forces of the membrane; None without bending resistance."""
    start_positions: np.ndarray
    """Initial positions of the points [m], shape (n, 3), by number."""
    areal_density: float
    _held_rows: np.ndarray | None = None
    _extension: Extension | None = None
    _held: np.ndarray  # numbers of the points that clamps fix
    _anchors: np.ndarray  # prescribed node nearest to each of these points
    _near: np.ndarray  # numbers of the points near the edges of clamps

    def hold_in_regions(self, rows: np.ndarray) -> None:
        """Set which points are fixed because they lie in the region of a support at rest. rows: 1 + the number of the support,
        0 for other points, shape (n,), in the order of the point numbers."""
        self._held_rows = rows

    def complete(self) -> None:
        self.let_go(())
        super().complete()

    def let_go(self, supports: Collection[int]) -> None:
        """Release the points and the bending clamps of supports with these numbers, after the supports released the grid
        nodes."""
        bending, start = self.bending, self.start_positions
        if bending is None:
            return
        rows, on_plane = find_rows_on_grid(self.grid, start, self.arrays["id"], self.constraint)
        held = np.zeros(len(rows), np.int64) if self._held_rows is None else self._held_rows.copy()
        held[np.isin(held, np.array([*supports], int) + 1)] = 0
        support_bending(bending, np.where((held > 0)[:, None], held[:, None], rows), on_plane)
        self._extension = None
        if isinstance(bending, PlateBending):
            self._extend_clamps(bending, held > 0)

    def _extend_clamps(self, bending: PlateBending, held: np.ndarray) -> None:
        grid, start, constrained = self.grid, self.start_positions, self.grid.nodes.constrained
        triangles, led_triangles = bending.triangles, bending.supports.led
        held_nodes, free_nodes = np.all(constrained > 0, axis=1), np.all(constrained == 0, axis=1)
        constraint = self.constraint
        if isinstance(constraint, LeadsPoints):
            led = constraint.rows() > 0
            reached = self._reached_by(np.any(led, axis=1))
            if constraint.top_speed == 0.0:
                whole = np.all(led, axis=1)
                held[self.arrays["id"][whole]] = True
                beyond = np.flatnonzero(reached & free_nodes)
                edges = find_clamp_edges(triangles, start, led_triangles, held)
                if len(edges.start):
                    beyond = beyond[_find_beyond(grid, edges, beyond)]
                    constraint.release_nodes(beyond)
                    reached[beyond] = False
                held_nodes |= self._reached_by(whole) & reached
            free_nodes &= ~reached
        edges = find_clamp_edges(triangles, start, led_triangles, held)
        if not len(edges.start):
            return
        extension = Extension(grid, edges, DEGREES[grid.case.functions], held_nodes, free_nodes)
        if len(extension.nodes):
            self._extension, self._held = extension, np.flatnonzero(held)
            self._anchors = _find_nearest(grid, extension.nodes, start[self._held])
            foot, _ = _find_feet(edges, start, within=True)
            self._near = np.flatnonzero(np.linalg.norm(start - foot, axis=1) <= NEAR * grid.lattice.cell)

    def _bending_limit(self) -> StepLimit:
        rigidity = 0.0 if self.bending is None else self.bending.rigidity
        return bending_in_cells(self.grid.lattice.cell, rigidity / self.areal_density)

    def _reached_by(self, chosen: np.ndarray) -> np.ndarray:
        """Return a mask of the grid nodes at which shape functions of the chosen points are non-zero, shape (nodes,). chosen:
        mask of the points in storage order, shape (n,).
        """
        listed, found = np.flatnonzero(chosen), np.zeros((self.grid.n_nodes, 3))
        scatter_listed_numbers(self.mapped, self.points.position, listed, np.ones((len(listed), 3)), found)
        return found[:, 0] > LEAST_SHARE

    def _scatter_internal_forces(self, forces: np.ndarray, target: np.ndarray) -> None:
        """Scatter forces on the points [N], shape (n, 3), to the nodal forces `target`, shape (nodes, 3). Near clamps, the
        forces on prescribed nodes are transferred to free nodes; forces on clamped points act on prescribed nodes.
        """
        extension = self._extension
        if extension is None:
            scatter_vectors(self.n_slabs, self.mapped, forces, target)
            return
        where = np.argsort(self.arrays["id"])
        held = where[self._held]
        np.add.at(target, self._anchors, forces[held])  # the support carries these forces
        forces[held] = 0.0
        scatter_vectors(self.n_slabs, self.mapped, forces, target)
        extension.share_forces(self, where[self._near], forces, target)

    def _move_by_nodes(self, dt: float) -> None:
        extension = self._extension
        if extension is None:
            super()._move_by_nodes(dt)
            return
        held, velocity = np.argsort(self.arrays["id"])[self._held], self._moving_velocity
        stay, before = self.points.position[held], extension.extend(velocity)
        super()._move_by_nodes(dt)
        velocity[extension.nodes] = before
        self.points.position[held] = stay


def _find_beyond(grid: Grid, edges: ClampEdges, nodes: np.ndarray) -> np.ndarray:
    """Return a mask of the grid nodes numbered in `nodes`, shape (k,), that lie on the free side of the nearest of the clamp
    edges `edges`.
    """
    place = grid.find_positions(nodes)
    foot, edge = _find_feet(edges, place)
    return np.asarray(np.sum((place - foot) * edges.inward[edge], axis=1) > ON_EDGE * grid.lattice.cell)


def _find_nearest(grid: Grid, nodes: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return for each position [m], shape (n, 3), the nearest of the grid nodes numbered in `nodes`, shape (n,)."""
    _, nearest = cKDTree(grid.find_positions(nodes)).query(position)
    return np.asarray(nodes[nearest])
