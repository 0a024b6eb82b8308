"""Tables of shape functions and their gradients at given points in cells of a mesh, and means of shape functions over faces."""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import (
    FACE_BLOCK,
    FACE_COLUMNS,
    FAILURES,
    Evaluator,
    NoFunctions,
    Scratch,
    shape_functions,
)
from pellucid.geometry.meshes.cells import FaceShares, vector_areas
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop

NO_NORMALS = np.zeros((0, 3))
CHUNK = 256  # points per chunk of a parallel loop


class Points(NamedTuple):
    """Points in cells at which shape functions are evaluated, and the arrays for the results, in the form used by kernels."""

    functions: object  # `Evaluator.functions`
    first: np.ndarray  # start of the active nodes of each cell
    active: np.ndarray  # active nodes of all cells, one cell after the other
    position: np.ndarray  # (m, 3) [m]
    cell: np.ndarray  # (m,) cell of each point
    row: np.ndarray  # (m + 1,) index in `values` of the first entry of each point
    values: np.ndarray  # shape functions, layout of `PointRows.values`
    gradients: np.ndarray  # gradients of the functions [1/m], layout of `PointRows.gradients`
    failure: np.ndarray  # (m,) `OK` or a code of `FAILURES`
    normal: np.ndarray  # (m, 3) normals of faces on which the points lie, or (0, 3)
    longest: int  # largest number of nodes of a point


class PointRows(NamedTuple):
    """Shape functions at m points, stored one point after the other.

    Point k has the entries row[k]:row[k + 1] of `nodes` (node numbers) and `values` (shape functions). The gradients [1/m]
    of point k start at 3 row[k] in `gradients`, all x-components first. The nodes are the active nodes of the cell of the
    point.
    """

    row: np.ndarray
    nodes: np.ndarray
    values: np.ndarray
    gradients: np.ndarray

    def at(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the nodes of point k, shape (n,), their shape functions, shape (n,), and their gradients [1/m], shape (3,
        n)."""
        here = slice(self.row[k], self.row[k + 1])
        gradients = self.gradients[3 * here.start : 3 * here.stop] if len(self.gradients) else np.zeros(0)
        return self.nodes[here], self.values[here], gradients.reshape(3, -1)


@parallel_loop(allocates=True)
def _evaluate(chunk, points):
    n = points.longest
    faces = np.zeros(FACE_COLUMNS * FACE_BLOCK)
    scratch = Scratch(
        np.empty((n, 3)), np.empty(n), np.empty((n, 3)), np.empty((4, 10, 10)), np.empty((5, 10)), faces, np.zeros(3)
    )
    none = np.empty((3, 0))
    for k in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(points.cell))):
        cell, start, end = points.cell[k], points.row[k], points.row[k + 1]
        active = points.active[points.first[cell] : points.first[cell + 1]]
        if len(points.normal) > 0:
            for d in range(3):
                scratch.normal[d] = points.normal[k, d]
        gradients = points.gradients[3 * start : 3 * end].reshape((3, end - start)) if len(points.gradients) > 0 else none
        points.failure[k] = shape_functions(
            points.functions, cell, points.position[k], active, scratch, points.values[start:end], gradients
        )


def evaluate(
    evaluator: Evaluator, cells: np.ndarray, points: np.ndarray, gradients: bool = True, normals: np.ndarray = NO_NORMALS
) -> PointRows:
    """Compute the shape functions of an approximant at points, shape (m, 3) [m], in given cells, shape (m,), and their
    gradients [1/m] if `gradients` is set.

    evaluator: defines the shape functions; normals: if the points lie on boundary faces, the unit normals of these faces,
    shape (m, 3); gradients must then not be requested. Raises NoFunctions with the position if the approximant has no
    functions at a point.
    """
    row, nodes = evaluator.active.of(cells)
    size = int(row[-1])
    rows = PointRows(row, nodes, np.empty(size), np.empty(3 * size if gradients else 0))
    failure = np.zeros(len(cells), np.int64)
    position, cells = np.ascontiguousarray(points, float), np.ascontiguousarray(cells, np.int64)
    arrays = position, cells, row, rows.values, rows.gradients, failure, np.ascontiguousarray(normals, float)
    longest = int(np.diff(row).max(initial=0))
    bundle = Bundle(Points(evaluator.functions, *evaluator.active, *arrays, longest))
    _evaluate((len(cells) + CHUNK - 1) // CHUNK, bundle)
    if failure.any():
        k = int(np.flatnonzero(failure)[0])
        place = ", ".join(f"{value:.6g}" for value in position[k])
        raise NoFunctions(f"no shape functions at ({place}) m: {FAILURES[int(failure[k])]}")
    return rows


SMALLEST = 1e-16  # smaller values are dropped: functions of nodes off a face vanish on it up to rounding


def unit_normals(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return unit normals of triangles, shape (f, 3); their sign is arbitrary.

    nodes: positions, shape (n, 3) [m]; faces: node numbers of the corners, shape (f, 3).
    """
    areas = vector_areas(nodes, faces)
    return np.asarray(areas / np.linalg.norm(areas, axis=1)[:, None])


def face_shares(evaluator: Evaluator, nodes: np.ndarray, faces: np.ndarray, cells: np.ndarray) -> FaceShares:
    """Return the means ∫ p_a dA / A of the shape functions p_a over triangles of area A, with the numbers a of the nodes.

    evaluator: defines the shape functions; nodes: positions, shape (n, 3) [m]; faces: corners of the triangles, shape (f,
    3); cells: number of the cell that contains each face, shape (f,). The means reproduce constant and linear fields: on
    each face the sum of the means is 1, and the sum of means times nodal positions is the centroid of the face.
    """
    means, normals = np.zeros(0), unit_normals(nodes, faces)
    for place, weight in zip(TRIANGLE, TRIANGLE_WEIGHTS, strict=True):
        rows = evaluate(evaluator, cells, np.einsum("k,fki->fi", place, nodes[faces]), False, normals)
        means = weight * rows.values + (means if len(means) else 0.0)
    kept = abs(means) > SMALLEST
    return FaceShares(np.repeat(np.arange(len(faces)), np.diff(rows.row))[kept], rows.nodes[kept], means[kept])
