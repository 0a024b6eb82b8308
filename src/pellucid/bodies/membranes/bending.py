"""Bending of membranes of triangles: selection of the bending energy of a surface, and clamps by supports."""

from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy.sparse import csr_array

from pellucid.bodies.membranes.closed_bending import Bending
from pellucid.bodies.membranes.plate_bending import PlateBending
from pellucid.bodies.membranes.plate_operators import BendingSupports, find_led_triangles
from pellucid.geometry.meshes.enclosure import rims_of
from pellucid.grid.lattice import Grid
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.parts.constraint import LeadsPoints, PointConstraint

if TYPE_CHECKING:
    from pellucid.bodies.membranes.bending_case import BendingCase

ON_FACE = 1e-6  # tolerance of the distance of a point from a face of the grid, in cells


class Resistance(Protocol):
    """Interface of the bending resistance of a closed or an open membrane of triangles.

    Attributes: energies: bending energies of the nodes in mesh order [J]; rate: upper bound of half the largest eigenfrequency
    of the nodes [1/s]; rigidity: bending rigidity κ [J]. Positions [m] have the shape (n, 3), in the storage order of the
    nodes.
    """

    energies: np.ndarray
    rate: float
    rigidity: float

    def bind(self, where: np.ndarray) -> None: ...
    def curvatures(self, position: np.ndarray) -> np.ndarray: ...
    def energy(self, position: np.ndarray) -> float: ...
    def add_forces(self, position: np.ndarray, target: np.ndarray) -> None: ...
    def linked_nodes(self) -> csr_array:
        """Return which nodes determine each term of the energy: a matrix with a row per term and a column per node."""


def make_bending(
    case: "BendingCase", material: MembraneMaterial, triangles: np.ndarray, vertices: np.ndarray, mass: np.ndarray
) -> Bending | PlateBending:
    """Build the bending resistance of a surface: on a closed surface the energy depends on the mean curvature, an open surface
    bends like a plate.

    case: settings of the bending; material: material of the membrane; triangles: shape (t, 3); vertices: initial positions
    [m], shape (n, 3); mass: nodal masses [kg], shape (n,).
    """
    shape = None if case.shape is None else case.shape.mesh("triangles").vertices
    if len(rims_of(triangles).edges):
        plate = PlateBending(triangles, vertices, mass, case.rigidity, case.plate_ratio(material))
        if case.spontaneous_curvature == "start":
            plate.relax(shape=vertices)
        else:
            plate.relax(case.spontaneous_curvature, shape)
        return plate
    bending = Bending(triangles, vertices, mass, case.rigidity)
    if case.spontaneous_curvature == "start":
        bending.reference[:] = bending.curvatures(vertices)
    elif shape is not None:
        bending.reference[:] = bending.curvatures(shape)
    else:
        bending.reference[:] = case.spontaneous_curvature
    return bending


def support_bending(bending: Resistance | None, rows: np.ndarray, on_plane: np.ndarray) -> bool:
    """Apply clamps at constrained nodes to the bending of an open membrane. Returns True if the clamps differ from the
    clamps before the call.

    rows: number of the constraint of each node along each axis, 0 if it is free, shape (n, 3); on_plane: True if the node
    lies in a plane of symmetry normal to the axis, shape (n, 3); both in the order of the mesh.
    """
    if not isinstance(bending, PlateBending):
        return False
    supports = BendingSupports(
        find_led_triangles(bending.triangles, bending.normals, rows), on_plane, np.asarray((rows > 0).all(axis=1))
    )
    if all(np.array_equal(new, old) for new, old in zip(supports, bending.supports, strict=True)):
        return False
    bending.support(supports)
    return True


def find_rows_on_grid(
    grid: Grid, position: np.ndarray, number: np.ndarray, constraint: PointConstraint | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return, for points on a grid, the number of the constraint along each axis (0 if free), and True if the point lies in a
    plane of symmetry normal to the axis; both of shape (n, 3), in the order of the point numbers.

    A support constrains a point if it constrains all of the point's nodes; a plane of symmetry is a face of the grid that is
    constrained along its normal only. position: initial positions of the points [m], shape (n, 3), by number; number: numbers
    of the points in storage order, shape (n,); constraint: constraint of the points of the body, or None.
    """
    lattice, constrained = grid.lattice, grid.nodes.constrained
    counts, strides = np.array(lattice.counts), np.array(lattice.strides)
    cells = (position - np.array(lattice.lower)) / lattice.cell
    first = np.clip(np.floor(cells), 0, counts - 1).astype(np.int64)
    share = cells - first
    rows, agree = np.zeros(position.shape, np.int64), np.ones(position.shape, bool)
    for corner in np.ndindex(2, 2, 2):
        counted = np.all(np.where(np.array(corner) == 1, share, 1.0 - share) > ON_FACE, axis=1)
        place = first + corner
        place = np.where(np.array(grid.periodic), place % counts, place)
        found = constrained[place @ strides].astype(np.int64)
        agree &= ~counted[:, None] | ((found > 0) & ((rows == 0) | (rows == found)))
        rows = np.where(counted[:, None], found, rows)
    rows[~agree] = 0
    on_face = (np.abs(cells) <= ON_FACE) | (np.abs(cells - counts) <= ON_FACE)
    on_plane = on_face & (rows > 0) & ((rows > 0).sum(axis=1) == 1)[:, None]
    corners = on_face.sum(axis=1) > 1  # of several faces each may be a plane of symmetry
    on_plane |= corners[:, None] & on_face & (rows > 0)
    if isinstance(constraint, LeadsPoints):
        led = np.zeros_like(rows)
        led[number] = constraint.rows()
        rows = np.where(led > 0, led + int(constrained.max(initial=0)), rows)
    return rows, on_plane
