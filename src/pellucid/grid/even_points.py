"""Even density and spacing of the points of a liquid.

The density of a point, m/V, follows the divergence of the velocity at the point. The nodes resist only its mean over some
points: single densities drift without a force, and with them the pressures. Where the velocity of the grid varies within a
cell, as at the corner below a moving lid, points also gather or leave gaps, so that the sum of their volumes in a cell differs
from the volume of the cell, and integrals over the points are wrong. Before each step, with linear functions N that are 1 at
the centre of a cell and constant between the last centre and a wall:

1. The specific volume V/m of the points loses the part that the cells cannot represent: (1 - S)² V/m, where S maps means over
   the cells back to the points, S s = Σ_c N_c Σ_q m_q N_c s_q / Σ_q m_q N_c. The total volume and linear fields remain. The
   squared operator leaves waves of some cells almost unchanged.
2. The volumes approach the space that the points have, with the relative error e_c = Σ_p V_p M_c/V_c - 1 of the cells: V is
   multiplied by 1 - FILLING r e, where r is the step times the largest speed per cell. The pressure then drives points from
   crowded to sparse cells, and no cell gains or loses volume in the course of time. The functions M_c are linear too, but twice
   as wide and half as high along each axis.
3. Points move by -SPREADING r h² ∇e, at most by LARGEST_SHIFT of a cell along an axis. They take the velocity of their new
   place, v + C δ, with the affine field C of APIC, so that the field of velocities remains. (Position correction: Baumgarten &
   Kamrin 2023, Int. J. Numer. Methods Eng. 124, 2589; shifting by Fick's law: Lind et al. 2012, J. Comput. Phys. 231, 1499.)

M_c are wider than N_c because steps 2 and 3 cause velocities of about e times the largest speed, on any grid. Points of a flow
along a wall lie in rows, whose distances the flow changes. Although such points are even, sums of N_c over n rows in a cell
vary by 2 (sin πn/πn)²: by 3 % for n = 2.5, and by 9 % for n = 1.5. Sums of M_c, which are (1, 2, 1)/4 of those of N_c along
each axis, vary by a factor cos² πn of this: here not at all. Narrow functions thus would lead to errors of some percent in a
flow, which do not decrease with the cell.

Momentum and energy are conserved: the mean of m C δ is subtracted from the velocities of the points, except along the normals
of planes of symmetry, where the mirror image has the opposite mean. The change of the kinetic energy is taken from their
internal energy, on which the pressure of a liquid does not depend. A cell with e < 0 counts as filled if a cell within
three cells has no points: the surface of the liquid is there. Within three cells of the shape of a wall, N_c replace M_c:
points gather in front of obstacles and leave gaps behind them that are narrower than M_c. There, V_c = ∫N_c dV over the
space outside the shape. Cells with little such space get the mean error of the cells next to them, so that points beside a wall
are not driven into it: a crowded cell is not less crowded towards the wall.

e_c is the mean of two steps. With an implicit pressure that is solved for in the middle of a step, u = (v⁻ + v)/2 expands a
cell by r e, and its points move with v = 2u - v⁻. A displacement δ = e of the points in the cell thus follows δ⁺ = δ + w⁺,
w⁺ = -2 r e - w: with the present e it would change its sign in each step and grow by √(1 + r²) + r, fast where a wall leaves
little space and e is a multiple of δ. With the mean of two steps δ decays by the factor 1 - r in each step, and an alternation
keeps its size.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Annotated, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy import floor, uintp

from pellucid.approximants import GridFunctions
from pellucid.approximants.grid_functions import LinearFunctions
from pellucid.energy import StepWork, no_work
from pellucid.grid.folding import cell_in_period, in_period
from pellucid.grid.nodal_fields import FOUND, STEP, SUM, NodalField, allocate
from pellucid.grid.passes.moving import displacement, move_points, moving
from pellucid.grid.point_storage import PointStorage
from pellucid.grid.points import place_of
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour
from pellucid.ranks.domain import domain
from pellucid.reductions import ordered_sum
from pellucid.step.part import StepPart

FILLING, SPREADING = 1.0, 0.5
"""Relative correction of volumes, and diffusivity of the points in h², while the fastest point crosses a cell. With a FILLING
of 5, errors of sums over points become pressures that stir the liquid: velocities fluctuate two to four times as much."""
LARGEST_SHIFT = 0.1
"""Largest shift along an axis in a step [cells]."""


SAMPLES = 4
"""Number of samples along an axis of a cell that a wall may cut."""
LEAST_SPACE = 0.25
"""Smallest part of a cell outside of walls with which it is corrected."""


class EvenCells(NamedTuple):
    """Values of cells for the correction of densities and positions, by the storage index of the first node of the cell."""

    liquid_mass: Annotated[np.ndarray, NodalField(1, SUM, STEP, "kg", "mass of the points of a liquid")]
    volume_sums: Annotated[np.ndarray, NodalField(1, SUM, STEP, "m3", "sum of volumes, or of parts of volumes, of points")]
    mean: Annotated[np.ndarray, NodalField(1, FOUND, STEP, "m3/kg", "`volume_sums` divided by `liquid_mass`")]
    error: Annotated[np.ndarray, NodalField(1, FOUND, STEP, "", "volume of all points divided by that of the cell, minus 1")]


class Shift(NamedTuple):
    """Rule for `move_points`: each point moves by its row of `shift` [m], shape (points, 3)."""

    shift: np.ndarray


@point_function(displacement, Shift)
def _by_shift(rule, mapped, p, dt):
    return rule.shift[p, 0], rule.shift[p, 1], rule.shift[p, 2]


@pointwise
def _between(lattice, axis, x):
    """Return the offsets in memory of the two cells between whose centres a coordinate x [m] lies, and the share of the second
    cell; both are the same cell between the last centre and a wall."""
    n, stride, folding = lattice.counts[axis], lattice.strides[axis], lattice.folding
    u = in_period(folding, axis, (x - lattice.lower[axis]) * lattice.inverse_cell) - 0.5
    i = int(floor(u))
    lower, upper = cell_in_period(folding, axis, i), cell_in_period(folding, axis, i + 1)
    return max(lower, 0) * stride, min(upper, n - 1) * stride, u - i


@pointwise
def _around(lattice, position, p):
    """Return for each axis the result of `_between` for point p of `position` [m], shape (points, 3)."""
    x, y, z = position[p, 0], position[p, 1], position[p, 2]
    return _between(lattice, 0, x), _between(lattice, 1, y), _between(lattice, 2, z)


@pointwise
def _interpolate(around, cells):
    """Return a value of cells at a point, and its derivatives along the axes [1/cell]; around: result of `_around`."""
    (i, k, f), (j, l, g), (m, n, w) = around
    a, b, c = 1.0 - f, 1.0 - g, 1.0 - w
    v0, v1, v2, v3 = cells[uintp(i + j + m)], cells[uintp(i + j + n)], cells[uintp(i + l + m)], cells[uintp(i + l + n)]
    v4, v5, v6, v7 = cells[uintp(k + j + m)], cells[uintp(k + j + n)], cells[uintp(k + l + m)], cells[uintp(k + l + n)]
    q0, q1, q2, q3 = c * v0 + w * v1, c * v2 + w * v3, c * v4 + w * v5, c * v6 + w * v7
    lower, upper = b * q0 + g * q1, b * q2 + g * q3
    along_z = a * (b * (v1 - v0) + g * (v3 - v2)) + f * (b * (v5 - v4) + g * (v7 - v6))
    return a * lower + f * upper, upper - lower, a * (q1 - q0) + f * (q3 - q2), along_z


@parallel_loop_by_colour(gives="cells")
def sum_cells(s, mapped, values, cells):
    """Add a value of each point of slab s to the cells around it, `cells`, by the linear functions of the cells."""
    slabs = mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        (i, k, f), (j, l, g), (m, n, w) = _around(mapped.lattice, mapped.points.position, p)
        value = values[p]
        lower, upper = (1.0 - f) * value, f * value
        for start, part in ((i, lower), (k, upper)):
            for row, share in ((start + j, (1.0 - g) * part), (start + l, g * part)):
                cells[uintp(row + m)] += (1.0 - w) * share
                cells[uintp(row + n)] += w * share


@parallel_loop()
def subtract_means(s, mapped, mean, values):
    """Compute V/m minus the mean of the cells at each point of slab s, times the mass, in `values` [m³], shape (points,)."""
    points, slabs = mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        found, _, _, _ = _interpolate(_around(mapped.lattice, points.position, p), mean)
        values[p] = points.volume[p] - points.mass[p] * found


@parallel_loop()
def correct_points(s, mapped, C, cells, values, filling, spreading, shift, sums):
    """Correct volumes and velocities of the points of slab s, and compute their shifts.

    C: affine fields of the points [1/s], shape (points, 10); values: see `subtract_means`; filling, spreading: factors of the
    step; shift: [m], shape (points, 3); sums: momentum that the slab gains [N s], shape (slabs, 3).
    """
    points, slabs, lattice = mapped.points, mapped.slabs, mapped.lattice
    x, v = points.position, points.velocity
    px = py = pz = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(mapped.index, q)
        around, m = _around(lattice, x, p), points.mass[p]
        mean, _, _, _ = _interpolate(around, cells.mean)
        e, ex, ey, ez = _interpolate(around, cells.error)
        points.volume[p] = (points.volume[p] - (values[p] - m * mean)) * (1.0 - filling * e)
        dx = lattice.cell * min(max(-spreading * ex, -LARGEST_SHIFT), LARGEST_SHIFT)
        dy = lattice.cell * min(max(-spreading * ey, -LARGEST_SHIFT), LARGEST_SHIFT)
        dz = lattice.cell * min(max(-spreading * ez, -LARGEST_SHIFT), LARGEST_SHIFT)
        vx = C[p, 0] * dx + C[p, 1] * dy + C[p, 2] * dz
        vy = C[p, 3] * dx + C[p, 4] * dy + C[p, 5] * dz
        vz = C[p, 6] * dx + C[p, 7] * dy + C[p, 8] * dz
        shift[p, 0], shift[p, 1], shift[p, 2] = dx, dy, dz
        v[p, 0] += vx
        v[p, 1] += vy
        v[p, 2] += vz
        px += m * vx
        py += m * vy
        pz += m * vz
    sums[s, 0], sums[s, 1], sums[s, 2] = px, py, pz


@runtime_checkable
class FillsSpace(Protocol):
    """Interface of a body of material points whose points `EvenPoints` reads, and corrects if the body `keeps_even`."""

    n_slabs: int  # number of slabs into which the points are divided
    mapped: Bundle  # the points, bundle of `MappedPoints`
    storage: PointStorage
    arrays: dict[str, np.ndarray]

    @property
    def keeps_even(self) -> bool:
        """True if density and spacing of the points are corrected."""

    @property
    def functions(self) -> GridFunctions: ...
    def fastest(self) -> float: ...
    def remove_momentum(self, gained: np.ndarray) -> None: ...


class EvenPoints(StepPart):
    """Correction of densities and positions of the points of liquids in a velocity field, see `pellucid.grid.even_points`.

    field: the velocity field; bodies: the liquids to correct; others: all bodies of material points in the field; n_supports:
    number of supports, whose impulses the works of a step contain.
    """

    def __init__(
        self, field: VelocityField, bodies: Sequence[FillsSpace], others: Sequence[FillsSpace], n_supports: int
    ) -> None:
        grid = self._grid = field.grid
        self._to_planes, self._given = np.any(grid.mirrored, axis=1), no_work(0, n_supports)
        self._bodies, self._others = bodies, others
        counts, strides = grid.lattice.counts, grid.lattice.strides
        x, y, z = (np.arange(n) * stride for n, stride in zip(counts, strides, strict=True))
        self._index = x[:, None, None] + y[None, :, None] + z[None, None, :]
        self._cells = allocate(EvenCells, grid.n_nodes)
        self._walls, self._space, self._at_shapes = field.walls, np.ones(counts), np.zeros(counts, bool)
        if self._walls:
            self._measure_space()
        self._error: np.ndarray | None = None  # of the last step
        self._values = {body: np.zeros(len(body.arrays["mass"])) for body in bodies}
        self._shifts = {body: np.zeros((len(body.arrays["mass"]), 3)) for body in bodies}
        self._moving = {body: moving(body.mapped.content, Shift(shift)) for body, shift in self._shifts.items()}

    def begin(self, time: float, dt: float) -> None:
        self._given.impulse[:] = 0.0
        if dt == 0.0:
            return
        rate = dt * max(body.fastest() for body in self._bodies) * self._grid.lattice.inverse_cell
        for body in self._others:
            if isinstance(body.functions, LinearFunctions):  # cells around strayed points may belong to two slabs
                body.storage.sort()
        self._find_errors()
        present = self._cells.error[self._index]
        if self._error is not None:
            self._cells.error[self._index] = 0.5 * (self._error + present)
        self._error = present
        for body in self._bodies:
            self._correct(body, min(FILLING * rate, 1.0), min(SPREADING * rate, 0.25))

    def _sum(self, body: FillsSpace, values: np.ndarray, cells: np.ndarray) -> None:
        sum_cells(body.n_slabs, body.mapped, values, cells)

    def _find_errors(self) -> None:
        """Compute the relative error of the volume of the points of each cell; 0 where it is negative near the surface, and the
        mean of the cells next to it where walls leave little space."""
        total = self._cells.volume_sums
        total.fill(0.0)
        for body in self._others:
            self._sum(body, body.arrays["volume"], total)
        domain.spread(total)
        filled = total[self._index] / self._grid.cell_volume
        if not all(wall.stands for wall in self._walls):
            self._measure_space()
        has_space = self._space >= LEAST_SPACE
        narrow = np.divide(filled, self._space, out=np.ones_like(filled), where=has_space)
        error = np.where(self._at_shapes, narrow, self._widen(filled)) - 1.0
        if np.any(empty := has_space & (filled == 0.0)):
            np.maximum(error, 0.0, out=error, where=self._near(empty, 3))
        if self._walls:
            known = np.where(has_space, self._space, 0.0)
            around, total = self._widen(known), self._widen(known * error)
            beside = np.divide(total, around, out=np.zeros_like(error), where=around > 0.0)
            error = np.where(has_space, error, beside)
        self._cells.error[self._index] = error

    def _widen(self, sums: np.ndarray) -> np.ndarray:
        """Return sums with the functions M_c of the cells from sums with N_c; mirrored at the faces of the grid."""
        for axis, (thin, periodic) in enumerate(zip(self._grid.thin, self._grid.periodic, strict=True)):
            if not thin:
                ends = [(1, 1) if along == axis else (0, 0) for along in range(3)]
                padded = np.moveaxis(np.pad(sums, ends, mode="wrap" if periodic else "edge"), axis, 0)
                sums = np.moveaxis(0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:], 0, axis)
        return sums

    def _measure_space(self) -> None:
        """Find the space of the cells outside of walls, and the cells near shapes, which keep the functions N_c."""
        self._space = self._find_space()
        self._at_shapes = self._near(self._space < 1.0, 3)

    def _find_space(self) -> np.ndarray:
        """Return the integrals of the functions N_c of the cells over the space outside of walls, over the volume of a cell."""
        grid = self._grid
        middle = grid.lattice.lower + (np.indices(grid.lattice.counts).reshape(3, -1).T + 0.5) * grid.lattice.cell

        def outside(by: np.ndarray, chosen: np.ndarray) -> np.ndarray:
            place = middle[chosen] + by * grid.lattice.cell
            return ~np.any([wall.fills(place) for wall in self._walls], axis=0)

        every = np.ones(len(middle), bool)
        uniform = outside(np.zeros(3), every).reshape(grid.lattice.counts)
        near = (self._near(uniform, 1) & self._near(~uniform, 1)).ravel()
        steps = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
        total, count = np.zeros(grid.lattice.counts), 0
        for by in product(*(np.zeros(1) if thin else steps for thin in grid.thin)):
            free = uniform.astype(float).ravel()
            free[near] = outside(np.array(by), near)
            part = free.reshape(grid.lattice.counts)
            for axis, share in enumerate(by):
                part = self._shared(part, axis, share)
            total, count = total + part, count + 1
        return total / count

    def _shared(self, values: np.ndarray, axis: int, share: float) -> np.ndarray:
        """Return values of cells, of which a part |share| goes to the next cells along an axis, or back if it is negative; at
        walls of the grid it stays."""
        given = np.roll(values, 1 if share > 0.0 else -1, axis)
        if not self._grid.periodic[axis]:
            last, first = (-1, 0) if share > 0.0 else (0, -1)
            np.moveaxis(given, axis, 0)[first] = 0.0
            np.moveaxis(given, axis, 0)[last] += np.moveaxis(values, axis, 0)[last]
        return (1.0 - abs(share)) * values + abs(share) * given

    def _near(self, found: np.ndarray, cells: int) -> np.ndarray:
        """Return a mask of the cells that have a cell of the mask `found` within a number of cells."""
        for axis, (thin, periodic) in enumerate(zip(self._grid.thin, self._grid.periodic, strict=True)):
            if thin:
                continue
            before, found = found, found.copy()
            for distance in range(1, cells + 1):
                for ahead in (distance, -distance):
                    moved = np.roll(before, ahead, axis)
                    if not periodic:
                        np.moveaxis(moved, axis, 0)[slice(0, ahead) if ahead > 0 else slice(ahead, None)] = False
                    found |= moved
        return found

    def _correct(self, body: FillsSpace, filling: float, spreading: float) -> None:
        cells, values, affine = self._cells, self._values[body], body.arrays["affine"]
        cells.liquid_mass.fill(0.0)
        self._sum(body, body.arrays["mass"], cells.liquid_mass)
        domain.spread(cells.liquid_mass)
        self._find_mean(body, body.arrays["volume"])
        subtract_means(body.n_slabs, body.mapped, cells.mean, values)
        self._find_mean(body, values)
        sums = np.zeros((body.n_slabs, 3))
        correct_points(body.n_slabs, body.mapped, affine, cells, values, filling, spreading, self._shifts[body], sums)
        move_points(self._moving[body], 0.0)
        body.storage.complete("position", "volume")
        gained = ordered_sum(domain.complete(sums))
        self._given.impulse[:] += np.where(self._to_planes, gained, 0.0)  # the mirror image gains the opposite
        body.remove_momentum(np.where(self._to_planes, 0.0, gained))

    def work(self) -> StepWork:
        return self._given

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {} if self._error is None else {"error": self._error}

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        self._error = arrays["error"].copy() if "error" in arrays else None

    def _find_mean(self, body: FillsSpace, values: np.ndarray) -> None:
        """Compute the sums of values of the points over the cells [m³], divided by the masses of the points."""
        cells = self._cells
        cells.volume_sums.fill(0.0)
        self._sum(body, values, cells.volume_sums)
        domain.spread(cells.volume_sums)
        np.divide(cells.volume_sums, cells.liquid_mass, out=cells.mean, where=cells.liquid_mass > 0.0)


def even_points(field: VelocityField, bodies: Iterable[Any], n_supports: int) -> list[EvenPoints]:
    """Return the correction of the points of the liquids of a velocity field in a list, or none if no liquid has it.

    bodies: all bodies of the field on the grid; n_supports: see `EvenPoints`.
    """
    several = [body for body in bodies if isinstance(body, FillsSpace)]
    liquids = [body for body in several if body.keeps_even]
    return [EvenPoints(field, liquids, several, n_supports)] if liquids else []
