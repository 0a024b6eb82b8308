"""Fast diagonalisation: a preconditioner for the equations of implicit viscosity and pressure on a grid full of liquid.

If a liquid with the density ρ and the viscosities μ and λ fills all cells of the edge h and volume V, the matrix for the
velocities along axis d is nearly

    A = V (ρ L⊗L⊗L + Δt/h² Σ_e k_e S_e⊗M⊗M),    k_e = 2μ + λ if e = d, else μ,

with the lumped masses L, the masses M and the stiffnesses S of the shape functions along an axis [in cells], S in the place of
axis e. The eigenvectors X of S x = s L x along each axis turn S into a diagonal and M nearly so; A is therefore inverted by
products with X along the three axes (Lynch, Rice & Thomas 1964, Numer. Math. 6, 185). Layers of nodes that supports constrain
as a whole are left out.

Cells that are not full, membranes and several liquids change the diagonal D of the matrix. With the diagonal D° of A the
preconditioner is R A⁻¹ R, R = √(D°/D); it is zero at prescribed nodes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from pellucid.approximants import GridFunctions, MirroredAxis, image_along
from pellucid.approximants.grid_functions import axis_weights
from pellucid.grid.lattice import Grid
from pellucid.jit import pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, store
from pellucid.materials.contract import ImplicitStress
from pellucid.ranks.domain import domain

SAMPLES = 4  # sampling points per cell for the integrals of shape functions


class Modes(NamedTuple):
    """Eigenvectors for the velocities along one axis, and scratch memory. In storage order the axes have n nodes and m
    eigenvectors each; matrices are stored row by row."""

    component: int  # axis of the velocities
    steps: tuple[int, int, int]  # differences of the storage indices of neighbouring nodes
    n: tuple[int, int, int]
    m: tuple[int, int, int]
    x: np.ndarray  # (n, m) eigenvectors along the first axis
    y: np.ndarray  # (n, m) along the second
    z: np.ndarray  # (n, m) along the third
    z_turned: np.ndarray  # (m, n) transpose of z
    inverse: np.ndarray  # (m, m, m) inverse of A in the basis of eigenvectors [1/kg]
    diagonal: np.ndarray  # (n, n, n) diagonal of A [kg]; 0 in layers that are left out
    given: np.ndarray  # (n, n, n) scaled residual
    planes: np.ndarray  # (m, n, n) its components along the first axis
    lines: np.ndarray  # (m, m, n) its components along the first two axes
    found: np.ndarray  # (m, m, m) its components


@parallel_loop()
def _take(i, modes, residual, inverse):
    c, (s, t, u), (_, n1, n2) = modes.component, modes.steps, modes.n
    for j in range(n1):
        for k in range(n2):
            I, q = 4 * (i * s + j * t + k * u) + c, (i * n1 + j) * n2 + k
            modes.given[q] = np.sqrt(modes.diagonal[q] * inverse[I]) * residual[I]


@pointwise
def combine(out, o, size, factors, f, step, rows, r, n):
    """Set `size` numbers of `out` from index o on to the sum of n rows of this size in `rows`, from index r on, times the
    factors factors[f], factors[f + step], ..."""
    whole = size - size % LANES
    for q in range(size):
        out[o + q] = 0.0
    j = 0
    while j + 4 <= n:
        a, b, c, d = factors[f], factors[f + step], factors[f + 2 * step], factors[f + 3 * step]
        s, t, u = r + size, r + 2 * size, r + 3 * size
        for q in range(0, whole, LANES):
            two = a * load(rows, r + q) + b * load(rows, s + q)
            store(out, o + q, load(out, o + q) + (two + (c * load(rows, t + q) + d * load(rows, u + q))))
        for q in range(whole, size):
            two = a * rows[r + q] + b * rows[s + q]
            out[o + q] += two + (c * rows[t + q] + d * rows[u + q])
        j, f, r = j + 4, f + 4 * step, r + 4 * size
    while j < n:
        a = factors[f]
        for q in range(size):
            out[o + q] += a * rows[r + q]
        j, f, r = j + 1, f + step, r + size


@parallel_loop()
def _invert(i, modes):
    (n0, n1, n2), (m0, m1, m2), size = modes.n, modes.m, modes.n[1] * modes.n[2]
    plane, lines, found = i * size, i * m1 * n2, i * m1 * m2
    combine(modes.planes, plane, size, modes.x, i, m0, modes.given, 0, n0)
    for a in range(m1):
        line, inner = lines + a * n2, found + a * m2
        combine(modes.lines, line, n2, modes.y, a, m1, modes.planes, plane, n1)
        combine(modes.found, inner, m2, modes.lines, line, 1, modes.z, 0, n2)
        for q in range(inner, inner + m2):
            modes.found[q] *= modes.inverse[q]
        combine(modes.lines, line, n2, modes.found, inner, 1, modes.z_turned, 0, m2)
    for j in range(n1):
        combine(modes.planes, plane + j * n2, n2, modes.y, j * m1, 1, modes.lines, lines, m1)


@parallel_loop()
def _give(i, modes, inverse, preconditioned):
    c, (s, t, u), (_, n1, n2), m0 = modes.component, modes.steps, modes.n, modes.m[0]
    size = n1 * n2
    combine(modes.given, i * size, size, modes.x, i * m0, 1, modes.planes, 0, m0)
    for j in range(n1):
        for k in range(n2):
            I, q = 4 * (i * s + j * t + k * u) + c, (i * n1 + j) * n2 + k
            preconditioned[I] = np.sqrt(modes.diagonal[q] * inverse[I]) * modes.given[q]


class Axis(NamedTuple):
    """Matrices of the shape functions along an axis of n nodes, in cells."""

    lumped: np.ndarray  # (n,) lumped masses
    masses: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n, n)
    squares: tuple[np.ndarray, np.ndarray]  # (n,) each: parts of both on the diagonal of A, without products of images


def axis_matrices(function: object, count: int, thin: bool, periodic: bool, odd: bool = False) -> Axis:
    """Return masses and stiffnesses of the shape functions along an axis with `count` cells; thin: True for an axis of a single
    cell; periodic: True if the last node is the first; odd: True for velocities along this axis, whose sign planes of symmetry
    change."""
    if thin:
        return Axis(np.ones(1), np.ones((1, 1)), np.zeros((1, 1)), (np.ones(1), np.zeros(1)))
    n = count if periodic else count + 1
    values, slopes, shares = np.zeros((3, count * SAMPLES, n))
    of_images = np.zeros((2, n))
    for q in range(count * SAMPLES):
        first, weights, derivatives = axis_weights(function, (q + 0.5) / SAMPLES, count)
        for k, (weight, slope) in enumerate(zip(weights, derivatives, strict=True)):
            number = first + k
            image = image_along(function, number, count)
            node = image % n if periodic else min(image, n - 1)  # listed beyond a wall with weight zero
            sign = -1.0 if odd and image != number else 1.0
            values[q, node] += sign * weight
            slopes[q, node] += sign * slope
            shares[q, node] += weight
            of_images[:, node] += np.square((weight, slope)) / SAMPLES
    masses, stiffness = (np.einsum("qi,qj->ij", table, table) / SAMPLES for table in (values, slopes))
    on_diagonal = of_images if isinstance(function, MirroredAxis) else (np.diag(masses), np.diag(stiffness))
    return Axis(shares.sum(axis=0) / SAMPLES, masses, stiffness, (on_diagonal[0], on_diagonal[1]))


class Diagonals(NamedTuple):
    """Lumped masses of an axis of n nodes, and parts of its matrices on the diagonal of A, in cells; 0 at nodes that are left
    out."""

    lumped: np.ndarray  # (n,)
    masses: np.ndarray  # (n,)
    stiffness: np.ndarray  # (n,)


class Spectrum(NamedTuple):
    """Eigenvalues along an axis with m eigenvectors, in which the lumped masses are 1, and the diagonals of the matrices."""

    stiffness: np.ndarray  # (m,) eigenvalues of the stiffness [1/cell²]
    masses: np.ndarray  # (m,) diagonal of the masses in the basis of eigenvectors
    on_diagonal: Diagonals  # of the nodes


def _product(axes: Sequence[Diagonals | Spectrum], place: int) -> np.ndarray:
    """Return the products of stiffness along the axis at `place` and masses along the others, shape (m, m, m)."""
    along = (axis.stiffness if other == place else axis.masses for other, axis in enumerate(axes))
    return np.einsum("i,j,k->ijk", *along)


def _on_all_processes(rows: np.ndarray) -> np.ndarray:
    """Return nodal rows, shape (4 nodes,), with the values of all processes."""
    return domain.of_nodes(rows.reshape(-1, 4)).reshape(-1)


class FastDiagonalisation:
    """Preconditioner for the equations of implicit viscosity and pressure of a velocity field, see the module.

    grid: the grid of the field; functions: shape functions of the liquids; density: mean density ρ in the grid [kg/m³].
    """

    def __init__(self, grid: Grid, functions: GridFunctions, density: float) -> None:
        self._grid, self._density = grid, density
        self._step: tuple[float, float, ImplicitStress] | None = None
        strides = grid.lattice.strides
        slab = grid.lattice.slab_axis
        self._order = [slab, *(axis for axis in range(3) if axis != slab)]  # as nodes are stored
        counts, thin, periodic = grid.lattice.counts, grid.thin, grid.periodic
        along = [(functions[axis], counts[axis], thin[axis], periodic[axis]) for axis in self._order]
        self._axes = [axis_matrices(*axis) for axis in along]
        self._own_axes = [axis_matrices(*axis, odd=True) for axis in along]
        n = [len(axis.lumped) for axis in self._axes]
        steps = [strides[axis] for axis in self._order]
        x, y, z = (step * np.arange(count) for step, count in zip(steps, n, strict=True))
        constrained = grid.nodes.constrained[np.add.outer(np.add.outer(x, y), z)] > 0
        self._modes = [self._modes_of(c, constrained[..., c], n, steps) for c in range(3) if not grid.thin[c]]
        self._bundles = [Bundle(modes) for modes, _ in self._modes]

    def _modes_of(
        self, component: int, constrained: np.ndarray, n: Sequence[int], steps: Sequence[int]
    ) -> tuple[Modes, Sequence[Spectrum]]:
        """Return eigenvectors for the velocities along the axis `component`, and the eigenvalues and matrices along each axis
        in storage order.

        constrained: mask of the nodes that supports constrain along this axis, shape (n, n, n); n: numbers of nodes; steps:
        differences of the storage indices of neighbouring nodes.
        """
        vectors, spectra = [], []
        for place, (across, own) in enumerate(zip(self._axes, self._own_axes, strict=True)):
            axis = own if self._order[place] == component else across
            others = tuple(other for other in range(3) if other != place)
            free = np.flatnonzero(~np.all(constrained, axis=others))
            among = np.ix_(free, free)
            values, x = eigh(axis.stiffness[among], np.diag(axis.lumped[free]))
            whole = np.zeros((n[place], len(free)))
            whole[free] = x
            inside = np.zeros(n[place])
            inside[free] = 1.0
            on_diagonal = Diagonals(inside * axis.lumped, inside * axis.squares[0], inside * axis.squares[1])
            spectra.append(Spectrum(np.maximum(values, 0.0), np.einsum("ij,ik,kj->j", x, axis.masses[among], x), on_diagonal))
            vectors.append(whole)
        m0, m1, m2 = (len(spectrum.stiffness) for spectrum in spectra)
        n0, n1, n2 = n
        sizes = (m0, m1, m2), (n0, n1, n2), (n0, n1, n2), (m0, n1, n2), (m0, m1, n2), (m0, m1, m2)
        along = (np.ascontiguousarray(each).ravel() for each in (*vectors, vectors[2].T))
        memory = (np.zeros(a * b * c) for a, b, c in sizes)
        return Modes(component, (steps[0], steps[1], steps[2]), (n0, n1, n2), (m0, m1, m2), *along, *memory), spectra

    def begin(self, dt: float, pressing: float, stress: ImplicitStress, inverse: np.ndarray) -> None:
        """Begin the solve of a step.

        dt: step over which viscous forces act [s]; pressing: time by which the stiffness of the pressure is multiplied [s];
        stress: mean parameters of the implicit stress; inverse: inverse of the diagonal of the matrix, nodal rows, shape (4
        nodes,); 0 where the velocity is prescribed.
        """
        self._inverse = _on_all_processes(inverse)
        if self._step == (dt, pressing, stress):
            return
        self._step = dt, pressing, stress
        mu, lam, stiffness, *_ = stress
        factor, volume = dt / self._grid.lattice.cell**2, self._grid.cell_volume
        for modes, spectra in self._modes:
            own = [spectrum.on_diagonal for spectrum in spectra]
            total = np.full(modes.m, self._density)
            diagonal = self._density * np.einsum("i,j,k->ijk", *(axis.lumped for axis in own))
            for place, axis in enumerate(self._order):
                k = factor * (2.0 * mu + lam + stiffness * pressing if axis == modes.component else mu)
                total += k * _product(spectra, place)
                diagonal += k * _product(own, place)
            modes.inverse[:] = (1.0 / (volume * total)).ravel()
            modes.diagonal[:] = (volume * diagonal).ravel()

    def apply(self, residual: np.ndarray, preconditioned: np.ndarray) -> None:
        """Compute the preconditioned residual from the residual, nodal rows, shape (4 nodes,)."""
        residual, inverse = _on_all_processes(residual), self._inverse
        for bundle in self._bundles:
            modes = bundle.content
            _take(modes.n[0], bundle, residual, inverse)
            _invert(modes.m[0], bundle)
            _give(modes.n[0], bundle, inverse, preconditioned)
