"""The shape functions of a meshless solid; they are built when the conditions that prescribe the field are known."""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.approximants.nodal.consistency import correct
from pellucid.approximants.nodal.contract import Evaluator, Lists, NoFunctions
from pellucid.approximants.nodal.table import PointRows, evaluate, face_shares
from pellucid.bodies.meshless_solid.forces import in_kernels, internal_forces
from pellucid.bodies.meshless_solid.prescribed import ForceCorrection, PrescribedField, values_at_nodes
from pellucid.bodies.meshless_solid.skin import SkinPoints, skin_points
from pellucid.bodies.meshless_solid.solid import (
    CHUNK,
    PACKS,
    Blocks,
    Elastic,
    Functions,
    Solid,
    pack_gradients,
    pack_lists,
    pack_numbers,
)
from pellucid.errors import CaseError, Problem
from pellucid.findings import Refusal
from pellucid.geometry.meshes.cells import FaceShares, cells_of_faces
from pellucid.geometry.meshes.quadrature import TETRAHEDRON
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import kernel
from pellucid.jit.vector import LANES
from pellucid.materials.law import Law
from pellucid.parts.body import in_metres

if TYPE_CHECKING:
    from pellucid.bodies.meshless_solid.model import MeshlessSolidCase


STORAGE: Any = np.float32  # number type of gradients: double precision needs a third more time and nearly twice the memory


class Tables(NamedTuple):
    """Data of a solid at its quadrature points for kernels (`solid`); the volume of each node [m³], shape (n,) (`node_volume`);
    and bounds of the rows of the stiffness matrix, divided by a modulus [m], shape (n,) (`row_sums`): Σ_q w |∇p_a| Σ_b |∇p_b|
    of each node a, with shape functions p and quadrature weights w.
    """

    solid: Solid  # data at the quadrature points
    node_volume: np.ndarray  # (n,) volumes of the nodes [m³]
    row_sums: np.ndarray  # (n,) bounds of the rows of the stiffness matrix over a modulus [m]


def at_quadrature_points(mesh: SimplexMesh, evaluator: Evaluator, n_points: int) -> PointRows:
    """Return the values and gradients of the shape functions at n_points quadrature points of each cell. evaluator: shape
    functions at any point. Raises NoFunctions if a point has none.
    """
    return evaluate(evaluator, np.repeat(np.arange(len(mesh.cells)), n_points), quadrature_places(mesh, n_points))


def quadrature_places(mesh: SimplexMesh, n_points: int) -> np.ndarray:
    """Return the positions of n_points quadrature points per cell [m], shape (cells × n_points, 3)."""
    return np.asarray(np.einsum("qk,cki->cqi", TETRAHEDRON[n_points], mesh.nodes[mesh.cells]).reshape(-1, 3))


def make_tables(
    mesh: SimplexMesh, evaluator: Evaluator, law: Any, n_points: int, consistent: bool, averaged: bool, storage: Any = None
) -> Tables:
    """Compute the shape functions at the quadrature points of a mesh whose cells are in spatial order, and arrange them for
    kernels.

    evaluator: shape functions at any point; law: hyperelastic law for kernels; n_points: quadrature points per cell;
    consistent: True to correct the gradients for consistent quadrature; averaged: True to average the volume ratio around the
    corners; storage: number type of the gradients, by default `STORAGE`. Raises NoFunctions if the approximant has no
    functions, Refusal if a node has no volume or no correction exists.
    """
    weights = np.repeat(mesh.volumes / n_points, n_points)
    rows = at_quadrature_points(mesh, evaluator, n_points)
    if consistent:
        correct(mesh, evaluator, rows, weights)
    n = len(mesh.nodes)
    if evaluator.positive:
        node_volume = np.bincount(rows.nodes, rows.values * np.repeat(weights, np.diff(rows.row)), n)
    else:  # such sums could be negative: the corners of a cell share it
        node_volume = np.bincount(mesh.cells.ravel(), np.repeat(mesh.volumes / 4.0, 4), n)
    lost = np.flatnonzero(node_volume <= 0.0)
    if len(lost):
        place = ", ".join(f"{value:.6g}" for value in mesh.nodes[lost[0]])
        text = (
            f"node {lost[0]} at ({place}) m has the volume {node_volume[lost[0]]:.3g} m^3, but nodal volumes must be positive"
        )
        raise Refusal(text, "improve the tetrahedra at this node, or use another approximant")
    row_sums = np.zeros(n)
    _add_row_sums(rows.row, rows.nodes, rows.gradients, weights, row_sums)
    packs = pack_lists(evaluator.active, n_points)
    gradients, turns = pack_gradients(evaluator.active, packs, n_points, rows.gradients, mesh.nodes, storage or STORAGE)
    del rows
    blocks, places = make_blocks(packs, n)
    n_packs = len(packs.first) - 1
    lanes = np.zeros(LANES * n_packs)
    lanes[: len(weights)] = weights
    solid = Solid(
        law=law,
        points=Elastic(law),
        n_points=n_points,
        gradients=Functions(packs.first, places, gradients),
        turns=turns,
        corners=_corners(mesh, blocks, n_points, weights),
        weights=lanes,
        blocks=blocks,
        displacement=np.zeros((n, 3)),
        deformation=np.zeros(9 * LANES * n_packs),
        block_force=np.zeros((len(blocks.nodes), 3)),
        block_volume=np.zeros(len(blocks.nodes) if averaged else 0),
        volume=np.ones(n),
        volume_ratio=np.ones(n),
        mean_stress=np.zeros(n),
        sums=np.zeros((len(blocks.first) - 1, 3)),
        node_sums=np.zeros(((n + CHUNK - 1) // CHUNK, 2)),
    )
    if averaged:
        _measure_volumes(solid)
    return Tables(solid, node_volume, row_sums)


@kernel()
def _add_row_sums(row, nodes, gradients, weights, sums):
    """Add Σ_q w |∇p_a| Σ_b |∇p_b| over quadrature points q to `sums` of the nodes a [m], shape (n,), in place; times a modulus,
    this bounds a row of the stiffness matrix.

    row: index of the first entry of each point; nodes, gradients: node and gradient ∇p_a of its shape function [1/m] of each
    entry; weights: quadrature weights w [m³].
    """
    for k in range(len(row) - 1):
        start, n = row[k], row[k + 1] - row[k]
        at, total = 3 * start, 0.0
        for pair in range(2):  # first Σ_b |∇p_b|, then the products with it
            for j in range(n):
                x, y, z = gradients[at + j], gradients[at + n + j], gradients[at + 2 * n + j]
                size = sqrt(x * x + y * y + z * z)
                if pair == 0:
                    total += size
                else:
                    sums[nodes[start + j]] += weights[k] * size * total


def _measure_volumes(solid: Solid) -> None:
    """Compute the reference volume around each node, `solid.volume`, with the same sums as in a step, so that the volume ratio
    at rest is exactly 1.
    """
    internal_forces(len(solid.sums), len(solid.node_sums), in_kernels(solid), 0.0, False, np.zeros_like(solid.displacement))
    solid.volume.fill(0.0)
    np.add.at(solid.volume, solid.blocks.nodes, solid.block_volume)


def make_blocks(packs: Lists, n_nodes: int) -> tuple[Blocks, np.ndarray]:
    """Divide packs (groups of four quadrature points) into blocks. Returns the blocks, and for each entry of the packs' node
    lists the index of its node in the block, times the number of lanes of a SIMD vector. packs: nodes of each pack; n_nodes:
    number of nodes of the solid.
    """
    n_blocks = (len(packs.first) - 2) // PACKS + 1
    block = np.repeat(np.arange(len(packs.first) - 1) // PACKS, np.diff(packs.first))
    pairs, local = np.unique(block * n_nodes + packs.items, return_inverse=True)
    first = np.searchsorted(pairs, np.arange(n_blocks + 1) * n_nodes)
    nodes = pairs % n_nodes
    places = np.argsort(nodes, kind="stable")
    node_first = np.searchsorted(nodes[places], np.arange(n_nodes + 1))
    return Blocks(first, nodes, node_first, places), (LANES * (local.ravel() - first[block])).astype(np.int32)


def _corners(mesh: SimplexMesh, blocks: Blocks, n_points: int, weights: np.ndarray) -> Functions:
    """Return the linear shape functions of the cell corners at the quadrature points, times the weights [m³], arranged in
    packs. n_points: quadrature points per cell; weights: one for each point.
    """
    order, shares = np.argsort(mesh.cells, axis=1), TETRAHEDRON[n_points]
    cells = Lists(4 * np.arange(len(mesh.cells) + 1), np.take_along_axis(mesh.cells, order, axis=1).ravel())
    values = shares[:, order].swapaxes(0, 1) * weights.reshape(-1, n_points, 1)
    packs, n = pack_lists(cells, n_points), len(mesh.nodes)
    block = np.repeat(np.arange(len(packs.first) - 1) // PACKS, np.diff(packs.first))
    keys = np.repeat(np.arange(len(blocks.first) - 1), np.diff(blocks.first)) * n + blocks.nodes
    place = LANES * (np.searchsorted(keys, block * n + packs.items) - blocks.first[block])
    return Functions(packs.first, place.astype(np.int32), pack_numbers(cells, packs, n_points, values.ravel()))


MISSED = 0.01  # weight of other nodes at a prescribed node from which a warning is issued


@contextmanager
def refused(case: "MeshlessSolidCase", key: str | None = None) -> Iterator[None]:
    """Convert errors about shape functions or settings that are raised inside the `with` statement to CaseError at `key`
    (default: the mesh)."""
    approximant, body = case.approximant, f"body.{case.name}"
    try:
        yield
    except NoFunctions as error:
        reach = approximant.reach
        where = f"{body}.approximant.{reach}" if reach else f"{body}.{case.place}"
        value = getattr(approximant, reach) if reach else None
        raise CaseError(Problem(str(error), where, value, approximant.remedy or "")) from None
    except Refusal as error:
        text, remedy = error.reason
        raise CaseError(Problem(text, f"{body}.{key or case.place}", remedy=remedy)) from None


def check_functions(case: "MeshlessSolidCase", mesh: SimplexMesh) -> None:
    """Raise CaseError if the approximant has no functions at a quadrature point or a node."""
    with refused(case):
        evaluator = case.approximant.evaluator(mesh)
        at_quadrature_points(mesh, evaluator, case.points_per_cell)
        values_at_nodes(mesh, evaluator)


class SolidFunctions:
    """Shape functions of a solid over its mesh. If nodal values are prescribed directly, functions of nodes with another
    prescribed displacement, or none, are made zero on prescribed faces, provided that the approximant supports this.

    Attributes: tables: gradients of the functions and weights at the quadrature points; at_nodes: values of the functions
    at the nodes, shape (n, n); residuals: evaluator of the difference between the displacement field and its prescribed
    values. law: hyperelastic law; prescribed: prescribed displacements. Raises CaseError if the approximant has no
    functions.
    """

    def __init__(self, case: "MeshlessSolidCase", mesh: SimplexMesh, law: Law, prescribed: PrescribedField) -> None:
        self._case, self._mesh, self._prescribed, approximant = case, mesh, prescribed, case.approximant
        with refused(case):
            self.evaluator: Evaluator = approximant.evaluator(mesh)
            if self.prescribes_nodes and len((disturbing := prescribed.disturbing(self.evaluator))[0]):
                self.evaluator = approximant.vanishing(self.evaluator, mesh, *disturbing)
            how = case.points_per_cell, case.consistent, case.averages_volume
            self.tables: Tables = make_tables(mesh, self.evaluator, law, *how)
            self.at_nodes = values_at_nodes(mesh, self.evaluator)
            self.residuals = prescribed.residuals(self.at_nodes, self.evaluator)
        if self.prescribes_nodes:
            self._warn_of_lone_nodes()

    def _warn_of_lone_nodes(self) -> None:
        nodes, missed = self._prescribed.lone(self.at_nodes)
        if not len(nodes) or missed.max() < MISSED:
            return
        count, node = int((missed >= MISSED).sum()), int(nodes[missed.argmax()])
        text = (
            f"body {self._case.name}: supports or motions select {count} of its nodes that do not form a whole "
            f"face, such as {node} at "
            f"{in_metres(self._mesh.nodes[node])}; other nodes have a weight of up to {missed.max():.2g} there: "
            'extend the regions to whole faces, or, in a case without a grid, set `essential = "sebciem"`'
        )
        warnings.warn(text, stacklevel=2)

    def follow(self, prescribed: PrescribedField) -> None:
        """Use a new set of prescribed nodes, for example after supports were released. The shape functions do not change."""
        self._prescribed, self.residuals = prescribed, prescribed.residuals(self.at_nodes, self.evaluator)

    @property
    def prescribes_nodes(self) -> bool:
        """True if nodal coefficients are prescribed directly; False if forces enforce the prescribed values of the field."""
        return self._case.essential == "direct"

    def correction(self, position: np.ndarray, inertia: np.ndarray, motions: tuple[int, int]) -> ForceCorrection | None:
        """Return the object that computes constraint forces for the prescribed displacement field; None if nodal coefficients
        are prescribed directly, or no node is prescribed.

        position: nodal positions of the body [m], shape (n, 3); inertia: nodal masses [kg], shape (n,); motions: first row of
        the prescribed values that belongs to a motion, and the row after the last.
        """
        if self.prescribes_nodes or not len(self._prescribed.nodes):
            return None
        how = position, inertia, motions, self._case.essential == "ebciem"
        with refused(self._case, "essential"):
            return ForceCorrection(self._prescribed, self.at_nodes, self.evaluator, *how)

    def face_shares(self, faces: np.ndarray) -> FaceShares:
        """Return the means of the shape functions over outer faces of the mesh with corners `faces`, shape (f, 3)."""
        with refused(self._case):
            return face_shares(self.evaluator, self._mesh.nodes, faces, cells_of_faces(self._mesh.cells, faces))

    def skin_points(self, mass: np.ndarray, longest: float, closed: Sequence[np.ndarray] = ()) -> SkinPoints:
        """Build the contact points on the outer faces of the solid, at most `longest` [m] apart.

        mass: nodal masses [kg], shape (n,); closed: masks, shape (n,), of sets of nodes that stay on a wall; faces with all
        nodes in one set have no contact.
        """
        return skin_points(self._mesh, self.evaluator, mass, longest, closed)
