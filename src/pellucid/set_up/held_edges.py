"""Warnings about constrained edges of membranes with bending stiffness: edges that act as hinges because only one row of
nodes is constrained, and clamps whose region ends between rows of nodes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.constrained_nodes import nodes_of
from pellucid.conditions.support import on_each_face
from pellucid.geometry.meshes.enclosure import rims_of
from pellucid.geometry.region import Region, Selectable, Where, chosen_nodes, needs_mesh
from pellucid.parts.body_model import selectable_of

BESIDE = 3e-3  # of the extent of the free part, from which on the distance of a clamp from the edge of its region is reported
HALVINGS = 30  # of an edge of the mesh, to find where a region ends


class _Holding(NamedTuple):
    """A support or motion, and the nodes of a membrane that it constrains in all directions."""

    label: str  # name of the support or motion in messages
    region: Where | None  # region on which it acts; None for a face of the grid
    nodes: np.ndarray  # (n,) mask of the constrained nodes


def held_edges(case: Case) -> Iterator[str]:
    """Yield a warning for each support or motion that acts as a hinge, and for each clamp whose region ends at a distance
    from the last row of nodes that it clamps.

    A support or motion that constrains a single row of nodes of a membrane with bending stiffness is a hinge.
    """
    parts = parts_of(case)
    for body in case.body:
        of = selectable_of(body, parts) if isinstance(body, MembraneCase) and _bends(body) else None
        if of is None or not len(rims_of(of.faces).edges):
            continue
        mirrored = _find_mirrored(case, of)
        for holding in _find_holdings(case, body.name, of):
            yield from _warnings(body.name, holding, of, mirrored)


def _bends(body: MembraneCase) -> bool:
    return getattr(body, "bending", None) is not None


def _find_mirrored(case: Case, of: Selectable) -> np.ndarray:
    """Return a mask of the nodes of a membrane (`of`) that lie in planes of symmetry, shape (n,)."""
    mirrored = np.zeros(len(of.position), bool)
    for support in on_each_face(case.support):
        if support.fix == "normal" and support.face() is not None and case.grid_or_none is not None:
            mirrored |= nodes_of(support, case.grid, of)
    return mirrored


def _find_holdings(case: Case, body: str, of: Selectable) -> Iterator[_Holding]:
    for number, whole in enumerate(case.support):
        for support in whole.on_each_face():
            if support.holds_all() and support.body in (None, body) and (support.region() or support.face()):
                yield _Holding(whole.label(number), support.region(), nodes_of(support, case.grid_or_none, of))
    active = tuple(not thin for thin in case.thin)
    for motion in case.motion:
        if motion.body == body and motion.axes() == {0, 1, 2} and motion.part is not None:
            nodes = chosen_nodes(motion.part, of, (active[0], active[1], active[2]))
            yield _Holding(f"motion `{motion.name}`", motion.part, nodes)


def _warnings(body: str, holding: _Holding, of: Selectable, mirrored: np.ndarray) -> Iterator[str]:
    from pellucid.bodies.membranes.plate_operators import find_led_triangles  # imports scipy

    rims, held = rims_of(of.faces), holding.nodes
    corners = of.position[of.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    led = find_led_triangles(of.faces, normals, np.repeat(held.astype(int)[:, None], 3, axis=1))
    clamped = np.zeros(len(held), bool)
    clamped[of.faces[led]] = True
    row = held[rims.edges].all(axis=1) & ~mirrored[rims.edges].all(axis=1)
    if row.any() and not clamped[rims.edges[row]].any():
        nodes = len(np.unique(rims.edges[row]))
        width = _find_row_width(of.position, rims.edges[row], rims.beside[row])
        yield (
            f"{holding.label} constrains a single row of {nodes} nodes on the rim of body {body}: for bending this is a hinge, "
            "so the membrane rotates freely about it. For a clamp, constrain two rows of nodes: set as region a box or "
            "another shape "
            f"that ends at the second row, {width:.3g} m from the rim; or place the rim on a face of the grid with a support "
            'with fix = "normal" (a plane of symmetry). For a hinge, no change is needed.'
        )
    elif led.any() and not held.all():
        yield from _distance_warning(body, holding, of, clamped)


def _find_row_width(position: np.ndarray, edges: np.ndarray, beside: np.ndarray) -> float:
    """Return the width of a row of elements at the rim: the largest distance of the third corners of triangles from their
    edges on the rim [m]. position: nodes [m], shape (n, 3); edges: node numbers of the edges, shape (e, 2); beside:
    number of the third corner for each edge, shape (e,)."""
    along, away = position[edges[:, 1]] - position[edges[:, 0]], position[beside] - position[edges[:, 0]]
    return float((np.linalg.norm(np.cross(along, away), axis=1) / np.linalg.norm(along, axis=1)).max())


def _distance_warning(body: str, holding: _Holding, of: Selectable, clamped: np.ndarray) -> Iterator[str]:
    """Yield a warning if the region of a support ends well beyond the last row of nodes that the support clamps. body: name
    of the membrane; holding: the support; of: nodes and faces of the membrane; clamped: mask of the clamped nodes."""
    from scipy.spatial import cKDTree

    region = holding.region
    if not isinstance(region, Region) or needs_mesh(region):
        return
    ways = np.concatenate([of.faces[:, [0, 1]], of.faces[:, [1, 2]], of.faces[:, [2, 0]]])
    ways = np.concatenate([ways, ways[:, ::-1]])
    ways = ways[clamped[ways[:, 0]] & ~holding.nodes[ways[:, 1]]]
    if not len(ways):
        return
    start, along = of.position[ways[:, 0]], of.position[ways[:, 1]] - of.position[ways[:, 0]]
    inside, outside = np.zeros(len(ways)), np.ones(len(ways))
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        within = chosen_nodes(region, Selectable(start + middle[:, None] * along, periods=of.periods))
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    distance = np.full(len(of.position), np.inf)
    np.minimum.at(
        distance, ways[:, 0], inside * np.linalg.norm(along, axis=1)
    )  # the edge that goes straight on is the shortest
    between = float(np.median(distance[np.isfinite(distance)]))
    extent = float(np.max(cKDTree(of.position[clamped]).query(of.position)[0]))
    if between > BESIDE * extent:
        yield (
            f"{holding.label}: the region ends {between:.3g} m beyond the last constrained row of nodes of body {body}. The "
            f"membrane is clamped at this row, so its free length is {extent:.4g} m. To clamp it at the edge of the region, "
            "choose a mesh with a row of nodes on this edge."
        )
