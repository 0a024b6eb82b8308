"""Data of a body of points for the transfers between points and nodes, and the division of its points into slabs."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.grid.folding import in_period
from pellucid.grid.lattice import Lattice, Nodes
from pellucid.grid.nodal_fields import FOUND, RUN, STEP, SUM, NodalField
from pellucid.jit import generic, point_function, pointwise

OK, NOT_FINITE, INVERTED, LOST, FOLDED, COLLAPSED = range(6)


class Fault(NamedTuple):
    """Reason why a run stops at a point, for example because the point left the grid or its volume would become negative,
    as texts for the user."""

    meaning: str  # what is wrong with the point
    remedy: str  # what the user can change


FAULTS = {
    NOT_FINITE: Fault(
        "its state is not a finite number",
        "use a smaller time.step or time.courant, or a material law that is defined at larger strains; its state is in "
        "forensics/failure.json",
    ),
    INVERTED: Fault(
        "its volume would become zero or negative in this step",
        "use a smaller time.step or time.courant, a finer grid.cell, or artificial viscosity for shocks",
    ),
    FOLDED: Fault(
        "the surface folded onto itself at this point within one step",
        "use a smaller time.step, or more triangles where the surface bends",
    ),
    COLLAPSED: Fault(
        "the element at this node turned over in this step, or its area or thickness became zero",
        "use a smaller time.step or time.courant, finer elements, or `wrinkling` if the membrane is compressed",
    ),
    LOST: Fault("it left the grid", "enlarge the grid, or add a support at the face that it crossed"),
}


def fault_at_held_face(face: str, outward: float) -> Fault:
    """Return the fault (reason and remedy) of a point that left the grid through a face on which a support constrains the
    nodes.

    face: name of the face, such as "x-lower"; outward: velocity of the support out of the grid [m/s].
    """
    if outward > 0.0:
        text = f"it crossed the face {face}, whose support moves out of the grid at {outward:.3g} m/s"
        remedy = f"set the velocity of this support along {face[0]} to 0"
        return Fault(text, f"{remedy}, or enlarge the grid and prescribe a solid by a [[motion]]")
    text = f"it crossed the face {face}, which a support constrains along its normal: it moved too far in one step"
    return Fault(text, "use a smaller time.step or time.courant, or more points_per_cell")


class PointArrays(NamedTuple):
    """State of the n points of a body: position, velocity, mass, volume and stress, sorted from time to time by the first
    grid node that each point reaches."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    mass: np.ndarray  # (n,) [kg]
    volume: np.ndarray = np.zeros(0)  # (n,) [m³]; without rows for nodes of elements, where elements store it
    stress: np.ndarray = np.zeros((0, 6))  # (n, 6) Cauchy stress xx, yy, zz, yz, xz, xy [Pa]; without rows like `volume`


class Slabs(NamedTuple):
    """Division of points into slabs: when last sorted, the first nodes of points first[s]:first[s+1] lay within slab s.

    Slabs are layers of the grid along the slowest axis in memory, each cut into `across` pieces along another axis; the
    pieces of a layer form a row. Points may move one layer beyond their slab before they must be sorted again. Slabs of one
    colour, i.e. every other slab along both axes, are far enough apart that their points then still contribute to no common
    node, so threads process them at the same time (`pellucid.grid.sorting`).
    """

    first: np.ndarray  # (s + 1,) first point of each slab, and the end of the last
    layers: np.ndarray  # (s, 4) first layer and end along the slowest axis, and along the axis of the cuts
    across: int  # number of slabs in a row
    bounds: np.ndarray  # (s, 4) lower and upper bound of the points along both axes [cells from the wall]
    fault: np.ndarray  # (s, 2) fault code, and the first point with this fault
    left_slab: np.ndarray  # (s,) 1 if a point left its slab by more than a layer
    sums: np.ndarray  # (s, columns) sums over the points of each slab, see the columns at the end of this module
    of_lost: np.ndarray  # (s, columns) part of the sums from points that left the grid in the last pass that moved points

    def reached(self, layers: tuple[int, int], stencil: int) -> np.ndarray:
        """Return a mask of the slabs (blocks of grid cells) whose points may contribute to nodes in the grid layers from
        layers[0] to layers[1] along the slowest axis, shape (slabs,); stencil: number of nodes of a shape function along an
        axis."""
        return (self.layers[:, 0] - 1 - stencil <= layers[1]) & (self.layers[:, 1] + 1 + stencil >= layers[0])


class InOrder(NamedTuple):
    """Value of `MappedPoints.index` for a body whose point arrays have the order of the slabs (blocks of grid cells, see
    `Slabs`)."""


class ByIndex(NamedTuple):
    """Value of `MappedPoints.index` for a body whose point arrays keep the order of its mesh, e.g. a membrane: a table
    lists the points in the order of the slabs (blocks of grid cells, see `Slabs`)."""

    order: np.ndarray  # (n,) storage row of each point in the order of the slabs


@generic
def place_of(index: Any, q: int) -> Any:
    """Return the row in the point arrays of the point with number q in the order of the slabs (blocks of grid cells);
    index: `InOrder` or `ByIndex`."""


@point_function(place_of, InOrder)
def _in_order(index, q):
    return uintp(q)


@point_function(place_of, ByIndex)
def _by_index(index, q):
    return uintp(index.order[uintp(q)])


class NoCells(NamedTuple):
    """Type without data that kernels receive instead of `FullCells`, for bodies whose pressures are not averaged over grid
    cells: it selects the implementations that read no sums of cells."""


class FullCells(NamedTuple):
    """Sums and mean values of the points in each of n grid cells, for `pellucid.grid.full_cells`, indexed by the storage index
    of the first node of the cell."""

    sums: Annotated[
        np.ndarray,
        NodalField(4, SUM, STEP, "m³, J, m³/s, J", "sums over the points of a cell: VOLUMES, PRESSURES, RATES, STIFFNESSES"),
    ]
    found: Annotated[
        np.ndarray,
        NodalField(4, FOUND, STEP, "Pa, 1/s, 1/s, Pa", "of a full cell: PRESSURE, GROWTH, SHIFT, PRESSURE_CHANGE"),
    ]
    full: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "1 if the cell is full, else 0", np.bool_)]


class GrowingCells(NamedTuple):
    """Full cells (cells that a fluid fills) with an implicit pressure, whose points all grow as the cell; selects the
    implementation where `FullCells` adds the same to the growth of all points."""

    cells: FullCells


VOLUMES, PRESSURES, RATES, STIFFNESSES = range(4)
"""Columns of `FullCells.sums`: volume [m³], pressure times volume [J], growth rate of the volume along the mean velocity
[m³/s], and stiffness ρc² of an implicit pressure times volume [J]."""
PRESSURE, GROWTH, SHIFT, PRESSURE_CHANGE = range(4)
"""Columns of `FullCells.found`: mean pressure [Pa], relative volume growth rate of the cell [1/s], this rate minus the
relative growth rate of its points [1/s], and change of an implicit pressure in the step [Pa]."""


@pointwise
def pressure_of(stress, p):
    """Return the pressure of point p, i.e. minus its mean normal stress [Pa]; stress: shape (points, 6) [Pa]."""
    return -(stress[p, 0] + stress[p, 1] + stress[p, 2]) / 3.0


FIELD_ENERGY = 9
"""Column of `affine` with the kinetic energy of the affine field per unit mass after the last transfer [J/kg]."""


class MappedPoints(NamedTuple):
    """Points of a body, their slabs (blocks of grid cells) and shape functions, and the nodes of the velocity field of the
    body, as arguments of kernels."""

    functions: Any  # shape functions along x, y, z
    lattice: Lattice  # geometry of the grid
    nodes: Nodes  # nodal arrays of the velocity field of the body
    points: PointArrays  # state of the points
    slabs: Slabs  # division of the points into slabs
    index: Any  # `InOrder` or `ByIndex`


@pointwise
def cell_at(lattice, place):
    """Return the cell that contains a position [m], as the storage index of the first node of the cell."""
    h, low, n, stride, folding = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides, lattice.folding
    i = min(int(in_period(folding, 0, (place[0] - low[0]) * h)), n[0] - 1)
    j = min(int(in_period(folding, 1, (place[1] - low[1]) * h)), n[1] - 1)
    k = min(int(in_period(folding, 2, (place[2] - low[2]) * h)), n[2] - 1)
    return uintp(i * stride[0] + j * stride[1] + k * stride[2])


@pointwise
def cell_of(lattice, x, p):
    """Return the cell that contains point p of the positions x [m], shape (points, 3), as the storage index of the first node
    of the cell."""
    return cell_at(lattice, (x[p, 0], x[p, 1], x[p, 2]))


# columns of Slabs.sums
(
    KINETIC,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    SPEED,
    STORED,
    DISSIPATED,
    HEATING,
    RATE,
    LUMPING,
    LOSS,
    AFFINE,
    POWER,
    GAINED,
    KEPT,
    VECTORS,
    COLUMNS,
) = range(17)
