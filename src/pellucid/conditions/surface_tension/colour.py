"""Surface energy of a fluid as a function of the nodal volumes of its points, and the derivative of this energy.

The fraction of the volume around a node that the fluid fills is smoothed by (1, 2, 1)/4 along each axis. The colour c is 0
for a very small filled fraction, increases with it, and is 1 for an almost completely filled node. Thus c is constant
within the fluid even if points are distributed unevenly, and there is no force. The area of the surface is ∫|∇c| dV,
independently of the width over which c decreases (the mean of the areas of its level sets, by the coarea formula). It is
summed over the cells with the gradients at their centres:

    E = σ Σ_c V_c (√(|∇c|² + ε²/h²) - ε/h)  -  σ cos θ Σ_I A_I c_I over the nodes of walls,

with the surface tension σ, the volume V_c and size h of a cell, ε = SOFTNESS, the contact angle θ, and the wall area A_I
around node I. Across walls c is continued as a mirror image: without the second term, the contact angle is a right angle.
With it, a wet wall has the energy -σ cos θ per area (Young).

Averages over volumes shift a curved surface. This reduces E by a share of the order (h/R)² for a radius of curvature R, and
the stiffness of a shape by more. E is therefore computed twice: from fractions smoothed once, and smoothed once more with twice
the distance of nodes. The combination of both that is free of this error is used (`LEVELS`; Richardson's extrapolation).

Near planes that cut cells (`planes`), the volume around a node is multiplied by its open fraction, in front of the planes,
and the energy of a cell by its open fraction. A face of the grid counts with the fraction of its area in front of the
planes: behind a plane, or where a plane coincides with the face, neither the support nor the end of the grid touches fluid.

A film on a wall that is thinner than a cell fills the fraction s < 1 of its nodes. A film of any thickness has the energy σ
(1 - cos θ) per area. The two terms give only the fraction c(s) of this energy, i.e. the colour of a node with the filled
fraction s. It increases with the square of s, so that the film would gain energy by spreading: single points would creep
ahead of a drop without end. Nodes of walls therefore have the additional energy

    σ (1 - cos θ) Σ_I A_I (s (2 - s) - c(s)) ,

which vanishes where a wall is dry or the fluid is thick: a film contracts. For contact angles from 60° to 90° this term is
multiplied by a factor proportional to cos θ. For larger angles, where the edge of the fluid is not a wedge, it is zero.
"""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, NamedTuple

import numpy as np

from pellucid.approximants import GridFunctions, image_along
from pellucid.conditions.surface_tension.planes import OpenSpace, WettedPlane, find_open_space
from pellucid.grid.folding import add_to_component
from pellucid.grid.full_cells import axis_integrals
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_fields import FOUND, STEP, SUM, NodalField, allocate
from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, number_at, stencil
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour


@parallel_loop_by_colour(gives="target")
def scatter_volumes(s, mapped, target):
    """Add the volumes of the points of slab s, times the shape functions N, to the nodes: `target`, shape (nodes,) [m³].
    mapped: bundle (arrays as the compiled code receives them) of the fluid's `MappedPoints`."""
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about, V = stencil(functions, lattice, points.position, p), points.volume[p]
        wx, wy, wz = about.wx, about.wy, about.wz
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    target[node_at(about, lattice, a, b, c)] += wx[a] * wy[b] * wz[c] * V


@parallel_loop()
def gather_potential(s, mapped, potential, values, sums):
    """Interpolate a nodal potential [J/m³], shape (nodes,), and its gradient [N/m³] to the points of slab s, and store both
    in `values`, shape (points, 4). mapped: bundle of the fluid's `MappedPoints`.

    sums: for each slab the sum of volume times gradient over its points [N], shape (slabs, 3), set here.
    """
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    h, fx, fy, fz = lattice.inverse_cell, 0.0, 0.0, 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        here = x = y = z = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                line = slope = 0.0
                for c in range(len(wz)):
                    at_node = potential[node_at(about, lattice, a, b, c)]
                    line += wz[c] * at_node
                    slope += gz[c] * at_node
                here += wx[a] * wy[b] * line
                x += gx[a] * wy[b] * line
                y += wx[a] * gy[b] * line
                z += wx[a] * wy[b] * slope
        values[p, 0], values[p, 1], values[p, 2], values[p, 3] = here, h * x, h * y, h * z
        V = points.volume[p]
        fx += V * h * x
        fy += V * h * y
        fz += V * h * z
    sums[s, 0], sums[s, 1], sums[s, 2] = fx, fy, fz


@parallel_loop_by_colour(gives="target")
def scatter_forces(s, mapped, values, acceleration, target):
    """Add the forces -V (N ∇φ + φ ∇N) + N m a [N] of the points of slab s to the nodal forces `target`, shape (nodes, 3);
    V: volume and m: mass of a point, N: shape function of a node.

    mapped: bundle of the fluid's `MappedPoints`; values: potential φ [J/m³] and gradient ∇φ [N/m³] at the points, shape
    (points, 4); acceleration: a [m/s²], shape (3,).
    """
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about, V, m = stencil(functions, lattice, points.position, p), points.volume[p], points.mass[p]
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        slope = -V * lattice.inverse_cell * values[p, 0]
        x, y, z = (
            m * acceleration[0] - V * values[p, 1],
            m * acceleration[1] - V * values[p, 2],
            m * acceleration[2] - V * values[p, 3],
        )
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I, w = number_at(about, lattice, a, b, c), wx[a] * wy[b] * wz[c]
                    add_to_component(lattice.folding, target, I, 0, w * x + slope * gx[a] * wy[b] * wz[c])
                    add_to_component(lattice.folding, target, I, 1, w * y + slope * wx[a] * gy[b] * wz[c])
                    add_to_component(lattice.folding, target, I, 2, w * z + slope * wx[a] * wy[b] * gz[c])


BENDS, FULL = 0.75, 0.96
"""Filled fractions: the colour increases linearly with the filled fraction up to BENDS, and is constant from FULL on, since
points fill a node within the fluid to 1 ± 0.03. Below one half the function is point-symmetric, so that the surface keeps
its position."""
SOFTNESS = 1e-3
"""ε: the energy is smoothed where the colour changes by less than ε over a cell, so that its derivative exists everywhere.
This reduces the tension by some tenths of a per cent."""
WETTING = 0.5
"""Smallest cosine of the contact angle for which the energy of thin films is used in full; it is zero on walls that the
fluid does not wet."""
LEAST_OPEN = 0.02  # smallest open fraction of the volume around a node in front of planes


class Level(NamedTuple):
    """A smoothing of the filled fractions, in addition to those of the levels before, and the weight of the surface energy of
    the smoothed fractions."""

    distance: int  # distance of the smoothed nodes [nodes]
    weight: float


def _levels() -> tuple[Level, Level]:
    spline, gradient, first, second = 0.25, 0.125, 0.5, 2.0
    share = (spline + gradient + first) / second
    return Level(1, 1.0 + share), Level(2, -share)


LEVELS = _levels()
"""Smoothings and weights of the energy. Along a surface, volumes are averaged by B-splines of the variance 1/4 (in cells²), by
the gradients at the centres of cells, on average over all directions 1/8, and by the smoothing (1, 2, 1)/4 of nodes at the
distance d, d²/2. A total variance s² moves the surface towards its centre of curvature by s²κ/2 with its curvature κ, which
reduces the energy by σ s²/2 ∫κ² dA. The weights cancel this between both levels."""
MARGIN = 2 + sum(level.distance for level in LEVELS)
"""Layers of nodes around those that points reach: those that smoothing reaches, the adjacent cells, and one more."""


class SurfaceFields(NamedTuple):
    """Nodal fields from which the energy of a fluid's surface is computed."""

    volume: Annotated[np.ndarray, NodalField(1, SUM, STEP, "m3", "volume of the fluid's points")]
    potential: Annotated[
        np.ndarray, NodalField(1, FOUND, STEP, "J/m3", "derivative of the surface energy with respect to `volume`")
    ]


class Faces(NamedTuple):
    """Cosines of the contact angles of a fluid at the two faces of the grid normal to an axis; the constant FREE for a face
    that no support constrains."""

    lower: float  # cosine of the contact angle at the lower face
    upper: float  # cosine of the contact angle at the upper face


FREE = -1.0


def _along(axis: int, part: slice) -> tuple[slice, ...]:
    return tuple(part if other == axis else slice(None) for other in range(3))


FIRST, LAST, BUT_FIRST, BUT_LAST = slice(0, 1), slice(-1, None), slice(1, None), slice(None, -1)


_Wetted = tuple[Any, float, np.ndarray]
"""Nodes of a wall, cosine of its contact angle, and areas of the wall around the nodes [m²]."""


class _Beside(NamedTuple):
    """Space in front of wall planes (on the side of the fluid), and the wetted planes, for the nodes in a box."""

    per_share: np.ndarray
    """Reciprocal of the fraction of the volume around a node, smoothed, that lies in front of the planes; 0 behind the
    planes."""
    cells: np.ndarray
    """Fraction of the volume of each cell in front of the planes."""
    planes: list[_Wetted]


class SurfaceEnergy:
    """Energy of the surface of a fluid with a surface tension [N/m].

    functions: shape functions of the grid along each axis; faces: cosines of the contact angles at the grid faces, for
    each axis; planes: wall planes that the fluid wets.
    """

    def __init__(
        self,
        grid: Grid,
        functions: GridFunctions,
        tension: float,
        faces: tuple[Faces, Faces, Faces],
        planes: Sequence[WettedPlane] = (),
    ) -> None:
        lattice = grid.lattice
        self._grid, self._tension, self._faces, self._cell = grid, tension, faces, lattice.cell
        self._axes = [axis for axis in range(3) if not grid.thin[axis]]
        self._order = sorted(range(3), key=lambda axis: -lattice.strides[axis])
        self._layers = grid.layers
        self.volume, self.potential = allocate(SurfaceFields, grid.n_nodes)
        """Nodal volumes of the fluid, which the caller sets, and the potential, which `find` computes from them."""
        widths = [_widths(function, count) for function, count in zip(functions, lattice.counts, strict=True)]
        self._widths = [
            np.full(1, grid.slice_thickness) if grid.thin[axis] else lattice.cell * widths[axis] for axis in range(3)
        ]
        self._planes = planes
        self._open = find_open_space(grid, functions, planes) if planes else None
        self.at_wall = np.zeros(3, bool)
        """Mask of the axes along which the fluid has reached a wall."""

    def _nodes(self, stored: np.ndarray) -> np.ndarray:
        """Return a view of a nodal array in storage order, shape (nodes,), as an array indexed by the node indices along the
        axes, shape (x, y, z), without nodes beyond the walls of the grid."""
        view = stored.reshape([self._layers[axis] for axis in self._order]).transpose(np.argsort(self._order))
        nx, ny, nz = (len(width) for width in self._widths)
        return view[:nx, :ny, :nz]

    def find(self) -> float:
        """Compute the surface energy of the fluid and return it [J]; store its derivative with respect to the nodal
        volumes, the potential [J/m³]."""
        volume, potential = self._nodes(self.volume), self._nodes(self.potential)
        box, walls = self._box(volume)
        x, y, z = (width[part] for width, part in zip(self._widths, box, strict=True))
        about = x[:, None, None] * y[None, :, None] * z[None, None, :]
        filled, energy, slopes, space = volume[box] / about, 0.0, [], self._open
        share = None if space is None else space.nodes[box]
        for level in LEVELS:
            for axis in self._axes:
                filled = _smooth(filled, axis, walls[axis], level.distance)
                if share is not None:
                    share = _smooth(share, axis, walls[axis], level.distance)
            beside = None if space is None or share is None else self._beside_planes(space, box, share)
            found, slope = self._of_level(filled, beside, box, walls)
            energy += level.weight * found
            slopes.append(level.weight * slope)
        total = np.zeros_like(filled)
        for level, slope in zip(reversed(LEVELS), reversed(slopes), strict=True):
            total += slope
            for axis in self._axes:
                total = _smooth_transposed(total, axis, walls[axis], level.distance)
        potential[box] = total / about
        return energy

    def _of_level(
        self,
        smoothed: np.ndarray,
        beside: _Beside | None,
        box: tuple[slice, slice, slice],
        walls: list[tuple[bool, bool]],
    ) -> tuple[float, np.ndarray]:
        """Return the surface energy [J] for the smoothed filled fractions of the nodes in a box, and its derivative with
        respect to these fractions [J]; record which wall planes the fluid has reached. beside: space in front of wall planes,
        None without planes; box, walls: as `_box` returns them."""
        filled = smoothed if beside is None else smoothed * beside.per_share
        colour, grows = _colour(filled)
        energy, slope = self._of_slopes(colour, 1.0 if beside is None else beside.cells)
        wetted = [*self._wall_nodes(colour.shape, box, walls), *([] if beside is None else beside.planes)]
        energy += self._of_walls(colour, slope, wetted)
        slope *= grows
        energy += self._of_films(filled, colour, grows, slope, wetted)
        if beside is not None:
            slope *= beside.per_share
            self._reach(colour, beside)
        return energy, slope

    def _box(self, volume: np.ndarray) -> tuple[tuple[slice, slice, slice], list[tuple[bool, bool]]]:
        """Return the box of nodes around the fluid, as slices along the axes, and for each axis whether its lower and upper
        end are faces of the grid; set `at_wall`, the mask of the axes along which the fluid has reached a wall. volume:
        nodal volumes [m³], shape (x, y, z)."""
        filled, box, walls = volume != 0.0, [], []
        for axis in range(3):
            n = volume.shape[axis]
            reached = np.flatnonzero(filled.any(axis=tuple(other for other in range(3) if other != axis)))
            first, last = (int(reached[0]), int(reached[-1])) if len(reached) else (0, 0)
            lower, upper = self._faces[axis]
            self.at_wall[axis] = n > 1 and ((first == 0 and lower > -1.0) or (last == n - 1 and upper > -1.0))
            box.append(slice(max(first - MARGIN, 0), min(last + MARGIN + 1, n)))
            walls.append((box[-1].start == 0, box[-1].stop == n))
        return (box[0], box[1], box[2]), walls

    def _beside_planes(self, space: OpenSpace, box: tuple[slice, slice, slice], share: np.ndarray) -> _Beside:
        """Return the space in front of wall planes for the nodes in a box; space: that of the whole grid; share: fraction of
        the volume around each node, smoothed, that lies in front of the planes."""
        per_share = np.where(share > LEAST_OPEN, 1.0 / np.maximum(share, LEAST_OPEN), 0.0)
        cells = tuple(slice(part.start, part.stop - 1) if axis in self._axes else part for axis, part in enumerate(box))
        planes = [(..., plane.cosine, area[box]) for plane, area in zip(self._planes, space.areas, strict=True)]
        return _Beside(per_share, space.cells[cells], planes)

    def _reach(self, colour: np.ndarray, beside: _Beside) -> None:
        """Record along which axes the fluid has reached wall planes (`at_wall`). colour: 1 at nodes within the fluid, 0
        outside, see `_colour`; beside: space in front of the planes."""
        for plane, (_, _, area) in zip(self._planes, beside.planes, strict=True):
            if float(np.sum(area * colour)) > 0.0:
                self.at_wall |= plane.wall.normal != 0.0

    def _of_slopes(self, colour: np.ndarray, share: np.ndarray | float) -> tuple[float, np.ndarray]:
        """Return the energy of the surface [J], computed from the gradient of the nodal colour (1 within the fluid, 0
        outside, see `_colour`), and the derivative of this energy with respect to the nodal colour [J]; share: fraction of
        each cell in front of planes."""
        slopes = []
        for axis in self._axes:
            along = np.diff(colour, axis=axis) / self._cell
            for other in self._axes:
                if other != axis:
                    along = 0.5 * (along[_along(other, BUT_LAST)] + along[_along(other, BUT_FIRST)])
            slopes.append(along)
        soft = SOFTNESS / self._cell
        size = np.sqrt(sum(slope * slope for slope in slopes) + soft * soft)
        scale = self._tension * self._grid.cell_volume
        energy = scale * float(np.sum(share * (size - soft)))
        derivative = np.zeros_like(colour)
        for axis, slope in zip(self._axes, slopes, strict=True):
            back = share * ((scale / self._cell) * slope / size)
            for other in self._axes:
                if other != axis:
                    back = _spread(back, other)
            derivative[_along(axis, BUT_FIRST)] += back
            derivative[_along(axis, BUT_LAST)] -= back
        return energy, derivative

    def _wall_nodes(
        self, shape: tuple[int, ...], box: tuple[slice, slice, slice], walls: list[tuple[bool, bool]]
    ) -> Iterator[_Wetted]:
        """Yield for each face of the grid that is not a plane of symmetry its nodes, the cosine of its contact angle, and
        its areas around the nodes in front of planes [m²]; shape: counts of nodes in the box; box, walls: as `_box`
        returns them."""
        for axis in self._axes:
            others = [self._grid.slice_thickness if self._grid.thin[o] else self._cell for o in range(3) if o != axis]
            open_shares = (None, None) if self._open is None else self._open.faces[axis]
            for end, is_wall, cosine, share in zip((FIRST, LAST), walls[axis], self._faces[axis], open_shares, strict=True):
                if not is_wall or cosine == 0.0:
                    continue
                area = np.full([1 if other == axis else n for other, n in enumerate(shape)], others[0] * others[1])
                for other in self._axes:  # at edges of the grid
                    for edge, ends in zip((FIRST, LAST), walls[other], strict=True):
                        if other != axis and ends:
                            area[_along(other, edge)] *= 0.5
                if share is not None:
                    area *= share[tuple(slice(None) if other == axis else part for other, part in enumerate(box))]
                yield _along(axis, end), cosine, area

    def _of_walls(self, colour: np.ndarray, slope: np.ndarray, wetted: Sequence[_Wetted]) -> float:
        """Return the surface energy of wet walls [J] for the nodal colour (1 within the fluid, 0 outside, see `_colour`),
        and add its derivative with respect to the colour [J] to `slope`; wetted: nodes, cosine of the contact angle and
        nodal areas of each wall."""
        energy = 0.0
        for nodes, cosine, area in wetted:
            energy -= self._tension * cosine * float(np.sum(area * colour[nodes]))
            slope[nodes] -= self._tension * cosine * area
        return energy

    def _of_films(
        self,
        filled: np.ndarray,
        colour: np.ndarray,
        grows: np.ndarray,
        slope: np.ndarray,
        wetted: Sequence[_Wetted],
    ) -> float:
        """Return the additional energy [J] of fluid on walls in films thinner than a cell, which keeps the films from
        spreading without end, and add its derivative with respect to the filled fraction [J] to `slope`.

        filled: fraction of the volume around each node that the fluid fills; colour: nodal colour, 1 within the fluid, 0
        outside; grows: derivative of the colour with respect to the filled fraction; wetted: nodes, cosine of the contact
        angle and nodal areas of each wall.
        """
        energy = 0.0
        for nodes, cosine, area in wetted:
            if cosine > 0.0:
                share, empty = min(1.0, cosine / WETTING), np.maximum(1.0 - filled[nodes], 0.0)
                scale = share * self._tension * (1.0 - cosine) * area
                energy += float(np.sum(scale * (1.0 - empty * empty - colour[nodes])))
                slope[nodes] += scale * (2.0 * empty - grows[nodes])
        return energy


def _widths(function: object, count: int) -> np.ndarray:
    """Return the integral of the shape function of each node along an axis with `count` cells, in units of the cell size,
    shape (nodes,)."""
    of, widths = axis_integrals(function, count), np.zeros(count + 1)
    for column in range(of.value.shape[1]):
        for first, value in zip(of.first, of.value[:, column], strict=True):
            widths[min(image_along(function, int(first) + column, count), count)] += value
    return widths


def _colour(filled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the colour of nodes, whose gradient gives the area of the surface, for the smoothed fraction `filled` of their
    volume that the fluid fills: it increases from 0 outside the fluid to 1 within it. Also return its derivative with
    respect to this fraction."""
    off, bend = np.abs(filled - 0.5), FULL - BENDS  # from where half is filled
    t = np.clip((off + 0.5 - BENDS) / bend, 0.0, 1.0)
    size = 1.0 / (BENDS + FULL - 1.0)
    half = np.minimum(off, BENDS - 0.5) + bend * (t - t * t * t * (1.0 - 0.5 * t))
    return 0.5 + size * np.copysign(half, filled - 0.5), size * (1.0 - t * t * (3.0 - 2.0 * t))


def _spread(values: np.ndarray, axis: int) -> np.ndarray:
    """Distribute values at the middles between neighbouring nodes of an axis equally to both nodes; return an array with one
    more entry along the axis."""
    shape = list(values.shape)
    shape[axis] += 1
    out = np.zeros(shape)
    out[_along(axis, BUT_FIRST)] += 0.5 * values
    out[_along(axis, BUT_LAST)] += 0.5 * values
    return out


def _smooth(values: np.ndarray, axis: int, walls: tuple[bool, bool], distance: int = 1) -> np.ndarray:
    """Return nodal values v smoothed along an axis, v_i/2 + (v_(i-d) + v_(i+d))/4 with the distance d in nodes; at ends that
    are walls (lower, upper) the values are continued as a mirror image."""
    d, out = distance, 0.5 * values
    out[_along(axis, slice(d, None))] += 0.25 * values[_along(axis, slice(None, -d))]
    out[_along(axis, slice(None, -d))] += 0.25 * values[_along(axis, slice(d, None))]
    if walls[0]:
        out[_along(axis, slice(None, d))] += 0.25 * values[_along(axis, slice(d, 0, -1))]
    if walls[1]:
        out[_along(axis, slice(-d, None))] += 0.25 * values[_along(axis, slice(-2, -2 - d, -1))]
    return out


def _smooth_transposed(values: np.ndarray, axis: int, walls: tuple[bool, bool], distance: int) -> np.ndarray:
    """Return nodal values after the adjoint (transposed) operation of `_smooth`. axis: axis of the smoothing; walls: True
    for the lower and the upper end if it is a wall; distance: d [nodes]."""
    d, out = distance, 0.5 * values
    out[_along(axis, slice(d, None))] += 0.25 * values[_along(axis, slice(None, -d))]
    out[_along(axis, slice(None, -d))] += 0.25 * values[_along(axis, slice(d, None))]
    if walls[0]:
        out[_along(axis, slice(d, 0, -1))] += 0.25 * values[_along(axis, slice(None, d))]
    if walls[1]:
        out[_along(axis, slice(-2, -2 - d, -1))] += 0.25 * values[_along(axis, slice(-d, None))]
    return out
