"""Tetrahedral meshes that fill a shape (isosurface stuffing) or a closed surface (TetGen)."""

import subprocess
import sys
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.checks.quality import dihedral_angles
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.crossing import self_crossing
from pellucid.geometry.meshes.enclosure import enclosed_volume, inside
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh, faces_of_cells
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.region import Shape
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.rotation import Rotated
from pellucid.geometry.solid_meshes.box import Counts, box_mesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.geometry.surfaces.surface import Inside, Surface, closed_triangles
from pellucid.model import check, parameter
from pellucid.system.extras import install_command

SPACE = (True, True, True)
MOST_OFF = 0.1  # largest relative error of the volume
TOUCH = 1e-6  # of the extent: largest distance of a sharp edge from a plane in which it lies; files have single precision
FLATTEST = 0.5  # smallest ratio of the height of a lattice between two plane faces and the edge of its cubes


class FillMesh(Tetrahedral):
    """A shape filled by a lattice of tetrahedra whose outer nodes are moved to its boundary. Sharp edges in a plane face that
    is perpendicular to an axis are kept if the shape does not extend beyond the plane; others are cut off."""

    shape: Shape = parameter("", "shape that is filled, as for material points")
    size: float = parameter(
        "m",
        "edge length of the cubes of the lattice, each divided into twelve "
        "tetrahedra; at most half the thickness of thin parts",
        gt=0,
    )

    @check
    def _can_be_made(self) -> None:
        self.mesh()

    def expected_points(self) -> float:
        lower, upper = self.shape.geometry().bounds()
        return 2.0 * prod(extent / self.size + 1.0 for extent in (upper - lower).tolist())

    def make(self) -> SimplexMesh:
        """Return the mesh, built before the rotation of the shape. Warns if sharp edges are cut off. Raises ValueError if the
        lattice is too coarse or too fine."""
        geometry, chosen = self.shape.geometry(), self.shape.chosen()
        if isinstance(chosen, Inside):
            closed_triangles(chosen.surface)
        own = geometry.shape if isinstance(geometry, Rotated) else geometry
        lower, upper = own.bounds()
        edges = own.sharp_edges(SPACE, self.size)
        ends = edges.corner[edges.edge]
        slack = TOUCH * float((upper - lower).max())
        in_face = np.stack([np.abs(ends - bound).max(axis=1) <= slack for bound in (lower, upper)])  # (2, edges, axes)
        for bound, axis in np.ndindex(2, 3):
            in_face[bound, :, axis] &= _form_loops(edges.edge, in_face[bound, :, axis])
        mesh = stuffed(*_lattice(own, np.asarray(in_face.any(axis=1)), self.size, 4.0 * slack))
        share = float(mesh.volumes.sum()) / own.measure(SPACE)
        if abs(share - 1.0) > MOST_OFF:
            text = f"with `size` = {self.size:g} m the mesh has {100.0 * share:.0f} % of the volume of the shape"
            raise Refusal(f"{text}; the error must be at most {100.0 * MOST_OFF:.0f} %", "decrease `size`")
        cut = ends[np.logical_not(in_face.any(axis=(0, 2)))]
        if isinstance(geometry, Rotated):
            mesh = SimplexMesh(geometry.turn.forth(mesh.nodes), mesh.cells)
            cut = geometry.turn.forth(cut.reshape(-1, 3)).reshape(cut.shape)
        if len(cut):
            _warn_of_cut_edges(cut, self.size)
        return mesh


def _form_loops(edge: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return a mask of the edges among the `chosen` ones, shape (e,), that form closed loops, as those around a face do; edge:
    corners at the ends of each edge, shape (e, 2). A shape may also touch a plane with an edge alone, which has loose ends."""
    kept = chosen.copy()
    while kept.any():
        number = np.bincount(np.unique(np.sort(edge[kept], axis=1), axis=0).ravel(), minlength=int(edge.max()) + 1)
        loose = kept & (number[edge] < 2).any(axis=1)
        if not loose.any():
            break
        kept &= ~loose
    return kept


def _lattice(shape: Geometry, flat: np.ndarray, size: float, depth: float) -> "_Lattice":
    """Return the arguments of `stuffed` for a shape: the lattice ends at its bounds where these are plane faces, and has a
    margin of half a cube elsewhere.

    flat: True where the lower and upper bound along each axis is a plane face, shape (2, 3); size: edge of the cubes [m];
    between two plane faces the nearest edge that fits; depth: the shape at a plane face is its section at this depth [m].
    Raises ValueError if two plane faces are much closer than `size`.
    """
    lower, upper = shape.bounds()
    extent, spacing = upper - lower, np.full(3, size)
    n = np.ceil(extent / size - 0.5 * flat.sum(axis=0)).astype(int) + 1
    both = flat.all(axis=0)
    for axis in np.flatnonzero(both & (extent < FLATTEST * size)).tolist():
        text = f"`size` = {size:g} m is too large: the shape extends only {extent[axis]:.3g} m along {'xyz'[axis]}"
        most, good = extent[axis] / FLATTEST, 0.5 * extent[axis]
        raise Refusal(text, f"decrease `size` to at most {most:.3g}, for good accuracy to {good:.3g}")
    n[both] = np.maximum(np.round(extent / size), 1.0).astype(int)[both]
    spacing[both] = (extent / n)[both]
    start = np.select([flat[0], flat[1]], [lower, upper - spacing * n], 0.5 * (lower + upper - spacing * n))
    low, high = np.where(flat[0], lower + depth, -np.inf), np.where(flat[1], upper - depth, np.inf)
    counts = int(n[0]), int(n[1]), int(n[2])
    return lambda points: shape.contains(np.clip(points, low, high), SPACE), start, counts, spacing


def _warn_of_cut_edges(ends: np.ndarray, size: float) -> None:
    """Warn of sharp edges that a lattice with cubes of edge `size` [m] cuts off; ends: their ends [m], shape (e, 2, 3)."""
    length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
    place = ", ".join(f"{x:.4g}" for x in ends[0].mean(axis=0))
    text = (
        f"the mesh `fill` cuts off sharp edges of the shape, {length:.3g} m in total, such as one at ({place}) m, by up to "
        f"`size` = {size:g} m: faces that meet there lose area, and a load on one of them is too small. Use the mesh `inside`, "
        "which keeps all edges of a closed surface, or place the shape so that its plane faces are perpendicular to the axes "
        "(`rotate` can turn it afterwards)"
    )
    warnings.warn(text, stacklevel=2)


REGULAR = 6.0 * np.sqrt(2.0)  # cube of the edge of a regular tetrahedron over its volume
ROUNDING = 1e-9  # of the volume
AWAY = 1e-6  # of the extent: largest mean distance between mesh and surface where triangles meet at almost 180 degrees
MOST_OFF_SURFACE = 1e-5  # of the volume inside a surface

# TetGen (Si 2015, ACM Trans. Math. Softw. 41, 11) terminates the whole process on some self-intersecting surfaces, so it runs
# in a separate process
_TETGEN = """
import sys, numpy, tetgen
given = numpy.load(sys.argv[1])
mesher = tetgen.TetGen(given["vertices"], given["triangles"])
nodes, cells = mesher.tetrahedralize(
    plc=True, quality=True, minratio=1.5, mindihedral=10.0, fixedvolume=True, maxvolume=float(given["volume"]),
    nomergefacet=bool(given["apart"]))[:2]
numpy.savez(sys.argv[2], nodes=nodes, cells=cells)
"""


class InsideMesh(Tetrahedral):
    """A closed surface, such as an STL file, filled with tetrahedra by TetGen; its vertices become nodes, and sharp edges
    are kept."""

    surface: Surface = parameter("", "closed surface; a piece inside another piece is a hole")
    size: float = parameter("m", "approximate edge length of the largest tetrahedra", gt=0)

    @check
    def _can_be_made(self) -> None:
        self.mesh()

    def expected_points(self) -> float:
        corners = self.surface.mesh().vertices
        return prod(extent / self.size + 1.0 for extent in np.ptp(corners, axis=0).tolist())

    def make(self) -> SimplexMesh:
        """Return the mesh generated by TetGen. Raises ValueError if TetGen is not installed, or the surface is not closed."""
        if find_spec("tetgen") is None:
            raise Refusal("the package tetgen, which is needed to fill a surface, is not installed", install_command("mesh"))
        surface = closed_triangles(self.surface)
        largest, reason = self.size**3 / REGULAR, Refusal("", "")
        for apart in (False, True):
            try:
                mesh = _filled(surface, largest, apart)
            except Refusal as refusal:
                reason = refusal
                continue
            if (off := _off(mesh, surface, ROUNDING if apart else None)) is None:
                return mesh
            reason = off
        raise reason


def _off(mesh: SimplexMesh, surface: Triangulation, slack: float | None) -> Refusal | None:
    """Return a refusal if the volume of the mesh differs too much from the volume inside the surface; None otherwise.

    The tolerance is a fraction `slack` of the volume. If `slack` is None, the mesh may deviate from the surface as much as
    flat parts are uneven when a file rounds their corners to six digits: TetGen treats triangles that meet at more than
    179.9 degrees as one flat part and does not keep the edges inside it. If the deviation is too large, the edges are kept;
    this requires up to five times as many tetrahedra, of lower quality.
    """
    volume, found = enclosed_volume(*surface), float(mesh.volumes.sum())
    area = float(np.linalg.norm(vector_areas(*surface), axis=1).sum())
    extent = float(np.ptp(surface.vertices, axis=0).max())
    limit = slack * volume if slack is not None else min(AWAY * extent * area, MOST_OFF_SURFACE * volume)
    if abs(found - volume) <= limit:
        return None
    text = f"the volume of the tetrahedra is {found:.10g} m^3, but the surface encloses {volume:.10g} m^3"
    return Refusal(text, "check whether pieces of the surface overlap, and remove one of them")


def _filled(surface: Triangulation, volume: float, apart: bool) -> SimplexMesh:
    """Return a mesh of tetrahedra of at most `volume` [m³] inside a closed surface, generated by TetGen; apart: keep every
    edge of the surface, also within flat parts."""
    with TemporaryDirectory() as folder:
        given, made = Path(folder, "given.npz"), Path(folder, "made.npz")
        np.savez(given, vertices=surface.vertices, triangles=surface.triangles.astype(np.int32), volume=volume, apart=apart)
        call = [sys.executable, "-c", _TETGEN, str(given), str(made)]
        done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=folder)  # a failed run leaves files behind
        if done.returncode or not made.is_file():
            raise _refusal(surface, done.stderr)
        with np.load(made) as found:
            nodes, cells = found["nodes"], found["cells"]
    within = inside(nodes[cells].mean(axis=1), *surface)  # TetGen fills holes as well
    used, which = np.unique(cells[within], return_inverse=True)
    return SimplexMesh(nodes[used], which.reshape(-1, 4))


def _refusal(surface: Triangulation, said: str) -> Refusal:
    place = self_crossing(surface)
    if place is not None:
        text = f"the surface intersects itself near ({', '.join(f'{x:.4g}' for x in place)}) m"
        return Refusal(text, "repair the surface at this point, or remove one of the overlapping pieces")
    last = said.strip().splitlines()[-1] if said.strip() else "no reason reported"
    return Refusal(f"TetGen could not fill the surface: {last}", "repair the surface, or use the more robust mesh `fill`")


Contains = Callable[[np.ndarray], np.ndarray]
_Lattice = tuple[Contains, np.ndarray, Counts, np.ndarray]
Corners = tuple[np.ndarray, ...]

HALVINGS = 36  # bisections of an edge that crosses the boundary, which locate the crossing to 1e-11 of its length
NEAR_LONG, NEAR_SHORT = 0.24999, 0.41189
"""Nodes closer to the boundary are moved there: fractions of a cube edge and of an edge from a corner to a centre (Labelle
& Shewchuk 2007, for the best bound on dihedral angles)."""
_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


class _Cuts(NamedTuple):
    """Sorted edges of the lattice that cross the boundary of the region, from a node inside to a node outside."""

    inner: np.ndarray  # (k,) number of the node inside the region
    outer: np.ndarray  # (k,) number of the node outside the region
    place: np.ndarray  # (k, 3) position at which the edge crosses the boundary [m]
    share: np.ndarray  # (k,) distance of the crossing from the inner node, as a fraction of the edge


def stuffed(contains: Contains, lower: np.ndarray, counts: Counts, size: float | np.ndarray) -> SimplexMesh:
    """Return a tetrahedral mesh of the part of a region that lies in a box of cubes with edge `size` [m], whose lower corner
    is `lower` [m]; counts: number of cubes along each axis. With three sizes, shape (3,), the cubes are cuboids.

    `contains` returns a mask of the points [m], shape (n, 3), that lie inside, shape (n,). Boundary nodes lie on the
    boundary of the region. Its sharp edges are cut off within a cube; the faces of the box stay flat with sharp edges.
    Raises ValueError if no node of the lattice lies inside.

    Source: Labelle & Shewchuk 2007, ACM Transactions on Graphics 26, 57; but quadrilaterals are divided from their deeper
    corner, which in tests gave larger angles than the guaranteed 10.7 degrees.
    """
    lattice = box_mesh(lower, lower + size * np.array(counts), counts)
    nodes, sign = lattice.nodes.copy(), np.where(contains(lattice.nodes), 1, -1)
    if not (sign > 0).any():
        text = f"`size` = {np.max(size):g} m is too large: no node of the lattice lies inside the region"
        raise Refusal(text, "decrease `size`")
    cuts = _cuts(contains, nodes, lattice.cells, sign)
    places = np.round((nodes - lower) / (0.5 * size)).astype(int)
    _move(nodes, sign, cuts, _limits(places, cuts), (places == 0, places == 2 * np.array(counts)))
    left = (sign[cuts.inner] != 0) & (sign[cuts.outer] != 0)
    cuts = _Cuts(*(part[left] for part in cuts))
    cells = lattice.cells[(sign[lattice.cells] > 0).any(axis=1)]
    cut = (sign[cells] < 0).any(axis=1)
    whole = np.concatenate([cells[~cut], _pieces(nodes, cells[cut], sign, cuts)])
    moved = np.append(sign == 0, np.zeros(len(cuts.place), bool))
    every = np.concatenate([nodes, cuts.place])
    return _upright(every, _joined(every, whole, lattice.cells[(sign[lattice.cells] == 0).all(axis=1)], moved))


def _cuts(contains: Contains, nodes: np.ndarray, cells: np.ndarray, sign: np.ndarray) -> _Cuts:
    mixed = cells[np.abs(sign[cells].sum(axis=1)) < 4]
    pairs = mixed[:, _PAIRS].reshape(-1, 2)
    pairs = pairs[sign[pairs[:, 0]] != sign[pairs[:, 1]]]
    pairs = np.where((sign[pairs[:, 0]] < 0)[:, None], pairs[:, ::-1], pairs)
    inner, outer = np.divmod(np.unique(pairs[:, 0] * len(nodes) + pairs[:, 1]), len(nodes))
    start, edge = nodes[inner], nodes[outer] - nodes[inner]
    low, high = np.zeros(len(inner)), np.ones(len(inner))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = contains(start + middle[:, None] * edge)
        low, high = np.where(found, middle, low), np.where(found, high, middle)
    share = 0.5 * (low + high)
    return _Cuts(inner, outer, start + share[:, None] * edge, share)


def _limits(places: np.ndarray, cuts: _Cuts) -> np.ndarray:
    """Return, for each edge in `cuts`, the distance from the boundary within which an end of the edge is moved to the
    boundary, as a fraction of the edge, shape (k,). places: nodes of the lattice in halves of a cube, shape (n, 3)."""
    from_centre = (places[cuts.outer] != places[cuts.inner]).all(axis=1)
    return np.where(from_centre, NEAR_SHORT, NEAR_LONG)


def _move(nodes: np.ndarray, sign: np.ndarray, cuts: _Cuts, limits: np.ndarray, faces: tuple[np.ndarray, np.ndarray]) -> None:
    """Move nodes near the boundary onto it, each along its shortest cut edge, and set their sign (1 inside, -1 outside,
    shape (n,)) to 0. cuts: the cut edges; limits: as `_limits` returns them.

    A node on a face of the box (faces: masks of the lower and upper faces, shape (n, 3) each) stays on it. A moved node
    is no longer the end of a cut edge.
    """
    node, other = np.concatenate([cuts.inner, cuts.outer]), np.concatenate([cuts.outer, cuts.inner])
    share, edge = np.concatenate([cuts.share, 1.0 - cuts.share]), np.tile(np.arange(len(cuts.inner)), 2)
    near = share < limits[edge]
    for face in faces:
        near &= (face[other] | ~face[node]).all(axis=1)
    node, other, edge = node[near], other[near], edge[near]
    order = np.lexsort((np.linalg.norm(cuts.place[edge] - nodes[node], axis=1), node))
    for a, b, k in zip(node[order].tolist(), other[order].tolist(), edge[order].tolist(), strict=True):
        if sign[a] and sign[b]:
            sign[a], nodes[a] = 0, cuts.place[k]


def _pieces(nodes: np.ndarray, cells: np.ndarray, sign: np.ndarray, cuts: _Cuts) -> np.ndarray:
    """Return the inner parts of cut cells as tetrahedra, shape (m, 4); crossings are numbered after the nodes. cells: nodes
    of the tetrahedra of the lattice, shape (c, 4); sign: 1 for nodes inside, -1 outside, 0 on the boundary; cuts: the cut
    edges.

    A quadrilateral on a face of the lattice is divided from the deeper of its inner nodes, or from the smaller number if
    they are equally deep. Both cells at the face choose the same diagonal, and the diagonals of a prism never form a
    cycle.
    """
    n = len(nodes)
    code = cuts.inner * n + cuts.outer
    depth = np.full(n, np.inf)
    np.minimum.at(depth, cuts.inner, np.linalg.norm(cuts.place - nodes[cuts.inner], axis=1))
    rank = np.empty(n, int)
    rank[np.lexsort((np.arange(n), -depth))] = np.arange(n)
    key = np.choose(
        sign[cells] + 1, (2 * n, n, rank[cells])
    )  # inner nodes by depth, then those on the boundary, then outer ones
    cells = np.take_along_axis(cells, np.argsort(key, axis=1, kind="stable"), axis=1)
    inside, outside = (sign[cells] > 0).sum(axis=1), (sign[cells] < 0).sum(axis=1)

    def at(inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        return n + np.searchsorted(code, inner * n + outer)

    p, *others = cells[inside == 1].T
    tip = tuple(np.where(sign[other] < 0, at(p, other), other) for other in others)
    found: list[Corners] = [(p, *tip)]
    p, q, zero, out = cells[(inside == 2) & (outside == 1)].T
    found += [(p, q, at(q, out), zero), (p, at(p, out), at(q, out), zero)]
    p, q, r, out = cells[inside == 3].T
    found += [(p, q, r, at(r, out)), (p, q, at(q, out), at(r, out)), (p, at(p, out), at(q, out), at(r, out))]
    p, q, one, two = cells[(inside == 2) & (outside == 2)].T
    a, b, c, d = at(p, one), at(p, two), at(q, one), at(q, two)
    found += [
        (p, q, c, d),
        *_better(np.concatenate([nodes, cuts.place]), ((p, a, b, d), (p, a, d, c)), ((p, a, b, c), (p, b, d, c))),
    ]
    return np.concatenate([np.stack(corners, axis=1) for corners in found])


def _better(nodes: np.ndarray, one: tuple[Corners, Corners], other: tuple[Corners, Corners]) -> list[Corners]:
    """Return for each cell the division (`one` or `other`, each into two tetrahedra) whose dihedral angles are farther from
    0 and 180 degrees; nodes: positions [m], shape (n, 3)."""
    margins = []
    for pair in (one, other):
        angles = np.concatenate([dihedral_angles(nodes, np.stack(corners, axis=1)) for corners in pair], axis=1)
        margins.append(np.minimum(angles, 180.0 - angles).min(axis=1))
    first = margins[0] >= margins[1]
    return [tuple(np.where(first, a, b) for a, b in zip(*halves, strict=True)) for halves in zip(one, other, strict=True)]


def _joined(nodes: np.ndarray, cells: np.ndarray, spare: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Add spare cells at edges where two parts of the boundary would otherwise touch, as in a narrow notch; return all
    cells, shape (c, 4).

    spare: cells whose nodes were all moved to the boundary; moved: mask of the nodes that were moved, shape (n,). Raises
    Refusal if parts still touch.
    """
    while True:
        faces, count = np.unique(faces_of_cells(cells[moved[cells].sum(axis=1) >= 2]), axis=0, return_counts=True)
        edges = faces[count == 1][:, _PAIRS[:2] + _PAIRS[3:4]].reshape(-1, 2)
        edges, count = np.unique(edges[moved[edges].all(axis=1)], axis=0, return_counts=True)
        touching = edges[count > 2]
        if not len(touching):
            return cells
        at_spare = np.sort(spare[:, _PAIRS], axis=2) @ [len(nodes), 1]
        wanted = np.isin(at_spare, touching @ [len(nodes), 1]).any(axis=1)
        if not wanted.any():
            place = "({:.6g}, {:.6g}, {:.6g}) m".format(*nodes[touching[0]].mean(axis=0))
            raise Refusal(f"two parts of the mesh are connected only by an edge at {place}", "decrease `size`")
        cells, spare = np.concatenate([cells, spare[wanted]]), spare[~wanted]


def _upright(nodes: np.ndarray, cells: np.ndarray) -> SimplexMesh:
    """Return a mesh of the cells and the nodes that they use, with corners ordered so that volumes are positive."""
    used, which = np.unique(cells, return_inverse=True)
    cells = which.reshape(cells.shape)
    turned = SimplexMesh(nodes[used], cells).volumes < 0.0
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    return SimplexMesh(nodes[used], cells)
