"""What a meshless solid keeps of its approximant: gradients and weights at the points of its cells, and lumped masses."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants.nodal.consistency import correct
from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.lists import Lists
from pellucid.approximants.nodal.table import Rows, evaluate
from pellucid.bodies.meshless_solid.forces import CELLS, CHUNK, Blocks, Solid, internal_forces
from pellucid.geometry.quadrature import TETRAHEDRON
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit.bundle import Bundle
from pellucid.jit.vector import LANES


class Tables(NamedTuple):
    """A solid as kernels take it, and the volume of each node [m³], shape (n,)."""

    solid: Solid
    node_volume: np.ndarray


def make_tables(mesh: SimplexMesh, evaluator: Evaluator, law: Any, n_points: int, consistent: bool, averaged: bool) -> Tables:
    """Shape functions at the quadrature points of a mesh whose cells stand in spatial order.

    consistent: whether the gradients are corrected for consistent quadrature; averaged: whether the volume ratio is averaged
    about the corners. Raises ValueError where the approximant has no functions, or gives a node no volume.
    """
    shares = TETRAHEDRON[n_points]
    places = np.einsum("qk,cki->cqi", shares, mesh.nodes[mesh.cells]).reshape(-1, 3)
    weights = np.repeat(mesh.volumes / n_points, n_points)
    rows = evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), n_points), places)
    if consistent:
        correct(mesh, evaluator, rows, places, weights)
    n = len(mesh.nodes)
    if evaluator.positive:
        node_volume = np.bincount(rows.nodes, rows.values * np.repeat(weights, np.diff(rows.row)), n)
    else:  # such sums could be negative: the corners of a cell share it
        node_volume = np.bincount(mesh.cells.ravel(), np.repeat(mesh.volumes / 4.0, 4), n)
    lost = np.flatnonzero(node_volume <= 0.0)
    if len(lost):
        place = ", ".join(f"{value:.6g}" for value in mesh.nodes[lost[0]])
        raise ValueError(f"node {lost[0]} at ({place}) m has the volume {node_volume[lost[0]]:.3g} m^3")
    active, gradients = _padded(evaluator.active, rows, n_points)
    blocks = make_blocks(active, n)
    n_blocks, chunks = len(blocks.first) - 1, (n + CHUNK - 1) // CHUNK
    solid = Solid(
        law=law,
        shares=shares,
        first=active.first,
        gradients=gradients,
        weights=mesh.volumes / n_points,
        blocks=blocks,
        corners=_corners(mesh, blocks),
        displacement=np.zeros((n, 3)),
        deformation=np.zeros((len(mesh.cells), n_points, 9)),
        block_force=np.zeros((len(blocks.nodes), 3)),
        block_volume=np.zeros(len(blocks.nodes) if averaged else 0),
        volume=np.ones(n),
        volume_ratio=np.ones(n),
        mean_stress=np.zeros(n),
        sums=np.zeros((n_blocks, 2)),
        node_sums=np.zeros((chunks, 2)),
    )
    if averaged:
        _measure_volumes(solid, chunks)
    return Tables(solid, node_volume)


def _measure_volumes(solid: Solid, chunks: int) -> None:
    """The volume about each corner, added up as in a step: then the volume ratio at rest is 1 to the last bit."""
    internal_forces(len(solid.sums), chunks, Bundle(solid), np.zeros_like(solid.displacement))
    solid.volume.fill(0.0)
    np.add.at(solid.volume, solid.blocks.nodes, solid.block_volume)


def make_blocks(active: Lists, n_nodes: int) -> Blocks:
    """Blocks of cells for lists of their active nodes."""
    n_blocks = (len(active.first) - 2) // CELLS + 1
    block = np.repeat(np.arange(len(active.first) - 1) // CELLS, np.diff(active.first))
    pairs, local = np.unique(block * n_nodes + active.items, return_inverse=True)
    first = np.searchsorted(pairs, np.arange(n_blocks + 1) * n_nodes)
    nodes = pairs % n_nodes
    places = np.argsort(nodes, kind="stable")
    node_first = np.searchsorted(nodes[places], np.arange(n_nodes + 1))
    return Blocks(first, nodes, (local.ravel() - first[block]).astype(np.int32), node_first, places)


def _padded(active: Lists, rows: Rows, n_points: int) -> tuple[Lists, np.ndarray]:
    """The same lists, each filled up to a multiple of the lanes of a vector with nodes that have no gradient, and the
    gradients [1/m] in the order cell, point, direction, node."""
    count = np.diff(active.first)
    room = -(-count // LANES) * LANES
    first = np.concatenate([[0], np.cumsum(room)])
    place = np.repeat(first[:-1] - active.first[:-1], count) + np.arange(len(active.items))
    items = np.repeat(active.items[active.first[:-1]], room)
    items[place] = active.items
    gradients = np.zeros(3 * n_points * int(first[-1]))
    cell = np.repeat(np.arange(len(count)), n_points)
    point = np.tile(np.arange(n_points), len(count))
    for axis in range(3):
        start = 3 * n_points * first[cell] + (3 * point + axis) * room[cell]
        source = 3 * rows.row[:-1] + axis * count[cell]
        within = np.arange(int(rows.row[-1])) - np.repeat(rows.row[:-1], np.diff(rows.row))
        gradients[np.repeat(start, np.diff(rows.row)) + within] = rows.gradients[np.repeat(source, np.diff(rows.row)) + within]
    return Lists(first, items), gradients


def _corners(mesh: SimplexMesh, blocks: Blocks) -> np.ndarray:
    """The corners of the cells by their numbers within their blocks, shape (c, 4)."""
    n, block = len(mesh.nodes), np.arange(len(mesh.cells)) // CELLS
    keys = np.repeat(np.arange(len(blocks.first) - 1), np.diff(blocks.first)) * n + blocks.nodes
    return np.asarray(np.searchsorted(keys, block[:, None] * n + mesh.cells) - blocks.first[block][:, None])
