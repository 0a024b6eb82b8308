"""Pressure of walls on fluids at nodes next to a surface that cuts cells.

A fluid of uniform pressure p has the internal force p G_I at node I, with

    G_I = Σ_p V_p ∇N_I(x_p) ≈ ∮ N_I n dA ,

summed over the points p with the volumes V_p and positions x_p; n is the normal out of the fluid. G_I is zero inside the fluid.
At a node that moves across the surface of a wall, and whose shape function reaches the surface, the wall exerts the opposite
force. Without it, the liquid in a cell that is partly in the wall would be at rest only with a pressure that is higher by the
inverse of the filled part of the cell. The wall therefore exerts

    R_I = -p_I G_I

with the mean pressure p_I of the fluid at the node. G_I is the same sum over the points as in the internal force, so that a
fluid of uniform pressure stays at rest to rounding, wherever the surface cuts the cells; an integral over the surface would
leave the errors of the quadrature by points.

G_I is that of the points in the first step after the wall was found, i.e. at the start or after its last motion. With the
present sum the work of R_I over a cycle of a disturbance would not be zero, and disturbances that a flow along the wall
carries with it would grow. This sum belongs to the wall alone if the node is full of fluid. Where it was not or is not so full
any more, for example at a free surface, the wall exerts only the normal part -p_I a_I a_I·G_I of the present sum, with the
unit vector a_I along ∮ N_I n dA over the surface. At the ends of the grid, too, the part along the surface is not that of the
wall.
"""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.bodies.material_points.body import MaterialPoints
from pellucid.conditions.rigid.no_slip import DEGREES, NoSlip
from pellucid.grid.clearing import Clearing
from pellucid.grid.folding import add_to_component
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_fields import FOUND, RUN, STEP, SUM, NodalField, allocate
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, number_at, stencil
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.ranks.domain import domain

VOLUME, PRODUCT = 3, 4
"""Columns of `WalledNodes.pressed` after those of the vector."""


class WalledNodes(NamedTuple):
    """Nodal sums over the points of fluids near walls."""

    pressed: Annotated[
        np.ndarray, NodalField(5, SUM, STEP, "m², m³, Pa m³", "Σ V ∇N of fluids; their volume; their volume times pressure")
    ]
    near: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "1 if a stencil that starts here may contain a wall", np.uint8)]


@parallel_loop_by_colour(gives="pressed")
def _sum_near(s, mapped, near, pressed):
    """Add V ∇N, the volume, and the volume times pressure of the points of slab s to the nodes. mapped: the points
    (`MappedPoints`); near: mask of the nodes that are the first nodes of points near walls; pressed: see `WalledNodes`."""
    functions, lattice, slabs, points = mapped.functions, mapped.lattice, mapped.slabs, mapped.points
    folding, h = lattice.folding, lattice.inverse_cell
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        about = stencil(functions, lattice, points.position, p)
        if not near[node_at(about, lattice, 0, 0, 0)]:
            continue
        V, stress = points.volume[p], points.stress
        pressure = -(stress[p, 0] + stress[p, 1] + stress[p, 2]) / 3.0
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    number, I = number_at(about, lattice, a, b, c), node_at(about, lattice, a, b, c)
                    share = V * wx[a] * wy[b] * wz[c]
                    pressed[I, VOLUME] += share
                    pressed[I, PRODUCT] += share * pressure
                    add_to_component(folding, pressed, number, 0, h * V * gx[a] * wy[b] * wz[c])
                    add_to_component(folding, pressed, number, 1, h * V * wx[a] * gy[b] * wz[c])
                    add_to_component(folding, pressed, number, 2, h * V * wx[a] * wy[b] * gz[c])


class FluidAtNodes(NamedTuple):
    """Fluid at the nodes near the surface of a wall."""

    ends: np.ndarray  # (n, 3) sums G_I of V ∇N over the points [m²]
    volume: np.ndarray  # (n,) volume of the fluid [m³]
    pressure: np.ndarray  # (n,) its mean pressure [Pa]


class FluidAtWalls:
    """Sums over the points of the fluids of a velocity field at the nodes near walls.

    fluids: bodies of the velocity field; grid: its grid.
    """

    def __init__(self, fluids: Sequence[MaterialPoints], grid: Grid) -> None:
        self._fluids, self._grid, self._no_slip = fluids, grid, NoSlip(grid)
        self._sums = allocate(WalledNodes, grid.n_nodes)
        self._clear = Clearing(STEP, grid.rows, self._sums)

    def mark(self, walls: Sequence[np.ndarray]) -> None:
        """Set the nodes at which the sums are needed; walls: numbers of the nodes near each wall."""
        self._sums.near[:] = 0
        reach = DEGREES[self._grid.case.functions] + 1
        steps = [range(-reach, reach + 1) if on else [0] for on in self._grid.active_axes]
        node = np.unique(np.concatenate(walls))
        for by in np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3):
            there, inside = self._no_slip.find_next(node, by)
            self._sums.near[there[inside]] = 1

    def sum(self) -> None:
        """Sum over the points, for their positions and stresses in this step."""
        self._clear()
        for fluid in self._fluids:
            _sum_near(fluid.n_slabs, fluid.mapped, self._sums.near, self._sums.pressed)

    def at(self, node: np.ndarray) -> FluidAtNodes:
        """Return the fluid at nodes with the ascending numbers `node`, shape (n,)."""
        sums = domain.of_nodes(self._sums.pressed[node], node)
        volume = sums[:, VOLUME]
        pressure = np.divide(sums[:, PRODUCT], volume, out=np.zeros(len(node)), where=volume > 0.0)
        return FluidAtNodes(sums[:, :VOLUME], volume, pressure)


class WallPressure:
    """Pressure of one wall on the fluids at the nodes near its surface.

    Attributes
    ----------
    found : FluidAtNodes or None
        Fluid at these nodes in the first step after the wall was found; None before.
    """

    def __init__(self, node: np.ndarray, normal: np.ndarray, room: np.ndarray, inner: np.ndarray) -> None:
        """node: numbers of the nodes, shape (n,); normal: unit vectors along the integral of shape function times normal over
        the surface, into the wall, shape (n, 3), zero where the wall does not stop fluids; room: volume of each node outside
        walls [m³], shape (n,); inner: mask of the axes along which the node lies inside the grid, shape (n, 3), see
        `inner_axes`."""
        self._node, self._normal, self._room, self._inner = node, normal, room, inner
        self.found: FluidAtNodes | None = None

    def forces(self, fluid: FluidAtWalls) -> np.ndarray:
        """Return the forces of the wall on the nodes in this step [N], shape (n, 3)."""
        now = fluid.at(self._node)
        if self.found is None:
            self.found = now
        normal = np.sum(now.ends * self._normal, axis=1)[:, None] * self._normal
        less, more = np.minimum(now.volume, self.found.volume), np.maximum(now.volume, self.found.volume)
        full = (_fullness(self.found.volume, self._room) * _fullness(less, more) * self._normal.any(axis=1))[:, None]
        found = np.sum(self.found.ends * self._normal, axis=1)[:, None] * self._normal
        found += np.where(self._inner, self.found.ends - found, 0.0)
        return -now.pressure[:, None] * (normal + full * (found - normal))


def inner_axes(grid: Grid, place: np.ndarray) -> np.ndarray:
    """Return a mask of the axes along which nodes at the positions `place` [m], shape (n, 3), lie inside the grid or on a plane
    of symmetry; shape (n, 3). The shape functions of nodes inside the grid are zero on its faces."""
    lattice = grid.lattice
    lower, size = np.array(lattice.lower), np.array(lattice.counts) * lattice.cell
    on_face = np.abs(np.stack([place - lower, lower + size - place], axis=2)) < 0.5 * lattice.cell
    return np.asarray(np.array(grid.periodic) | ~(on_face & ~np.array(grid.mirrored, bool)).any(axis=2))


def _fullness(volume: np.ndarray, room: np.ndarray) -> np.ndarray:
    """Return 1 where volumes fill three quarters of a room, as the points of a fluid do with the errors of their quadrature, 0
    where they fill less than half, as at a free surface, and values between; shape (n,) each."""
    filled = np.divide(volume, room, out=np.zeros(len(volume)), where=room > 0.0)
    return np.asarray(np.clip(4.0 * filled - 2.0, 0.0, 1.0))
