"""Shape functions of radial point interpolation, vectorised over stencils.

The interpolant of values f at the nodes x_j of a stencil is Σ λ_j φ(|x - x_j|) + Σ μ_k p_k(x) with Σ λ_j p_k(x_j) = 0 (Liu & Gu
2005; Benet 2015, section 4), in coordinates relative to the mean node position and divided by the largest distance from it, the
radius of the stencil. With F, which fits the polynomials p to f by least squares, and Z, whose columns are an orthonormal basis
of the complement of the polynomials at the nodes, it is

    N(x) f = p(x) F f + w(x) Zᵀ f,    w(x) = (φ(x) - p(x) F A) Z (Zᵀ A Z)⁻¹,    A_ij = φ(|x_i - x_j|).

As w is of order one and Zᵀ annihilates polynomials, these are reproduced to round-off, however ill-conditioned A is.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pellucid.approximants.radial.functions import RadialModel


def exponents(degree: int, dimension: int) -> np.ndarray:
    """Return the exponents of all p monomials up to a degree in d variables (`dimension`), ordered by degree, shape (p, d)."""
    every = [powers for powers in product(range(degree + 1), repeat=dimension) if sum(powers) <= degree]
    return np.array(sorted(every, key=lambda powers: (sum(powers), powers[::-1])), dtype=np.int64).reshape(-1, dimension)


class Monomials:
    """All monomials up to a degree at positions, shape (..., d); derivatives are computed on access."""

    def __init__(self, places: np.ndarray, degree: int) -> None:
        self._dimension = places.shape[-1]
        self._powers = exponents(degree, self._dimension)
        # x^k, k x^(k-1) and k (k-1) x^(k-2) of each coordinate, shape (..., d, degree + 1)
        k = np.arange(degree + 1)
        whole = places[..., None] ** k
        once = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * whole[..., :-1]], axis=-1)
        twice = np.concatenate([np.zeros_like(whole[..., :1]), k[1:] * once[..., :-1]], axis=-1)
        self._factors = whole, once, twice

    @property
    def value(self) -> np.ndarray:
        """Values of the p monomials at the positions, shape (..., p)."""
        return self._derivative()

    @property
    def first(self) -> np.ndarray:
        """Gradients of the p monomials at the positions, shape (..., d, p)."""
        return np.stack([self._derivative(a) for a in range(self._dimension)], axis=-2)

    @property
    def second(self) -> np.ndarray:
        """Second derivatives of the p monomials at the positions, shape (..., d, d, p)."""
        axes = range(self._dimension)
        return np.stack([np.stack([self._derivative(a, b) for b in axes], axis=-2) for a in axes], axis=-3)

    def _derivative(self, *axes: int) -> np.ndarray:
        result = np.ones(1)
        for axis in range(self._dimension):
            result = result * self._factors[axes.count(axis)][..., axis, self._powers[:, axis]]
        return result


WORST_CONDITION = 1e12
RAISE = 1.25  # factor by which a shape parameter is increased
CLOSEST = 1e-6  # distance of two nodes over the radius of their stencil
UNISOLVENT = 1e-9  # smallest singular value of the polynomials at the nodes over the largest


class StencilError(ValueError):
    """Error for a stencil (a set of neighbouring nodes) without an interpolant, with the number of the stencil and the
    reason."""

    def __init__(self, number: int, text: str) -> None:
        self.number = number
        """Number of the first stencil without an interpolant."""
        self.text = text
        super().__init__(f"stencil {number} {text}")


class Functions(NamedTuple):
    """Shape functions of m nodes at q positions of each of s stencils, and derivatives by the coordinates of the stencil."""

    value: np.ndarray  # (s, q, m) shape functions
    first: np.ndarray  # (s, q, d, m) first derivatives [1/m]
    second: np.ndarray  # (s, q, d, d, m) second derivatives [1/m²]; (s, q, 0, 0, m) if not requested


class Interpolants(NamedTuple):
    """Interpolants of s stencils with m nodes in d dimensions (symbols: see `pellucid.approximants.radial.stencils`). An
    interpolant is a sum of radial functions φ of the distances from the nodes and of p polynomials."""

    radial: RadialModel  # radial function φ and degree of the polynomials
    centre: np.ndarray  # (s, d) mean node position [m]
    radius: np.ndarray  # (s,) largest distance of a node from the centre [m]
    nodes: np.ndarray  # (s, m, d) positions relative to the centre, divided by the radius
    shape: np.ndarray  # (s,) shape parameters times the radius
    fit: np.ndarray  # (s, p, m) matrix F: least-squares coefficients of p polynomials from nodal values
    across: np.ndarray  # (s, m - p, m) matrix Zᵀ: orthonormal basis of the nodal values orthogonal to the polynomials
    coefficients: np.ndarray  # (s, m + p, m - p) coefficients of (φ - p F A) Z for the radial functions φ and the monomials p
    inverse: np.ndarray  # (s, m - p, m - p) inverse of Zᵀ A Z, A: radial functions between the nodes


def interpolants(nodes: np.ndarray, radial: RadialModel) -> Interpolants:
    """Compute the interpolants of s stencils with the node positions `nodes`, shape (s, m, d) [m].

    radial: radial function and degree of the polynomials. Raises StencilError if the nodes of a stencil do not determine the
    polynomials, or if two of them coincide.
    """
    centre = nodes.mean(axis=1)
    offset = nodes - centre[:, None]
    radius = np.sqrt((offset**2).sum(axis=2).max(axis=1))
    if (flat := np.flatnonzero(radius == 0.0)).size:
        raise StencilError(int(flat[0]), "has only coincident nodes")
    scaled = offset / radius[:, None, None]
    basis = Monomials(scaled, radial.degree).value
    m, p = basis.shape[1:]
    if m < p:
        text = f"has {m} nodes, too few for the {p} polynomials of degree {radial.degree}"
        raise StencilError(0, f"{text}; set `neighbours` to {p} or more, or decrease `degree`")
    orthogonal, triangular = np.linalg.qr(basis, mode="complete")
    triangular = triangular[:, :p]
    _check_unisolvent(triangular, radial)
    within, across = orthogonal[:, :, :p], orthogonal[:, :, p:]
    square = sum((x[:, :, None] - x[:, None]) ** 2 for x in np.moveaxis(scaled, 2, 0))
    _check_apart(square)
    shape, kernel = _kernels(square, across, radial)
    turned = np.swapaxes(across, 1, 2)
    fit = np.linalg.solve(triangular, np.swapaxes(within, 1, 2))
    between = kernel @ across
    coefficients = np.concatenate([across, -fit @ between], axis=1)
    return Interpolants(radial, centre, radius, scaled, shape, fit, turned, coefficients, np.linalg.inv(turned @ between))


def _check_unisolvent(triangular: np.ndarray, radial: RadialModel) -> None:
    singular = np.linalg.svd(triangular, compute_uv=False)
    found = np.flatnonzero(singular[:, -1] < UNISOLVENT * singular[:, 0])
    if found.size:
        text = f"has nodes that do not determine polynomials of degree {radial.degree}, as they lie on a curve of that degree"
        raise StencilError(int(found[0]), f"{text}; increase `neighbours`, decrease `degree`, or use less regular nodes")


def _check_apart(square: np.ndarray) -> None:
    m = square.shape[1]
    least = square[:, ~np.eye(m, dtype=bool)].min(axis=1)
    found = np.flatnonzero(least < CLOSEST**2)
    if found.size:
        raise StencilError(int(found[0]), "has two (nearly) coincident nodes; remove one of them")


def _kernels(square: np.ndarray, across: np.ndarray, radial: RadialModel) -> tuple[np.ndarray, np.ndarray]:
    """Return the shape parameters of the stencils times their radii, shape (s,), increased where the system is
    ill-conditioned, and the radial functions between their nodes, shape (s, m, m).

    square: squared distances between the nodes in units of the radius, shape (s, m, m); across: orthonormal basis Z of the
    nodal values that are orthogonal to all polynomials, shape (s, m, m - p).
    """
    shape = np.full(len(square), radial.initial_shape)
    kernel = radial.profile(square, shape[:, None, None]).value
    ill = np.arange(len(square) if radial.initial_shape > 0.0 and across.shape[2] else 0)
    while ill.size:
        ill = ill[_condition(kernel[ill], across[ill]) > WORST_CONDITION]
        shape[ill] *= RAISE
        kernel[ill] = radial.profile(square[ill], shape[ill][:, None, None]).value
    return shape, kernel


def _condition(kernel: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Estimate the condition numbers of the systems Zᵀ A Z of stencils, shape (s,): a bound of the norm of A over the
    smallest absolute eigenvalue.

    kernel: A, the radial functions between the nodes, shape (s, m, m); across: Z, an orthonormal basis of the nodal values
    that are orthogonal to all polynomials, shape (s, m, m - p).
    """
    eigenvalues = np.linalg.eigvalsh(np.swapaxes(across, 1, 2) @ kernel @ across)
    return kernel.shape[1] * np.abs(kernel).max(axis=(1, 2)) / np.maximum(np.abs(eigenvalues).min(axis=1), 1e-300)


def functions_at(found: Interpolants, places: np.ndarray, of: np.ndarray | None = None, derivatives: int = 2) -> Functions:
    """Return the shape functions of stencils and their derivatives at q positions each (`places`), shape (s, q, d) [m].

    found: interpolants. of: numbers of the stencils, shape (s,); None for all stencils. derivatives: order of the highest
    derivatives, 1 or 2. Raises ValueError if the radial function does not have this number of derivatives.
    """
    radial = found.radial
    if derivatives > radial.derivatives:
        text = f'a radial function of kind "{radial.kind}" has only {radial.derivatives} derivative at its nodes'
        raise ValueError(f"{text}, but {derivatives} are needed; use a smoother radial function")
    which = slice(None) if of is None else of
    radius = found.radius[which]
    x = (places - found.centre[which][:, None]) / radius[:, None, None]
    offset = x[:, :, None] - found.nodes[which][:, None]  # (s, q, m, d)
    profile = radial.profile((offset**2).sum(axis=3), found.shape[which][:, None, None])
    basis = Monomials(x, radial.degree)
    s, q, m, d = offset.shape
    slope = np.moveaxis(2.0 * profile.first[..., None] * offset, 3, 2)
    first = _combined(found, which, slope, basis.first) / radius[:, None, None, None]
    if derivatives < 2:
        return Functions(_combined(found, which, profile.value, basis.value), first, np.zeros((s, q, 0, 0, m)))
    bend = 4.0 * profile.second[..., None, None] * offset[..., :, None] * offset[..., None, :]
    bend += 2.0 * profile.first[..., None, None] * np.eye(d)
    second = _combined(found, which, np.moveaxis(bend, 2, 4), basis.second) / (radius**2)[:, None, None, None, None]
    return Functions(_combined(found, which, profile.value, basis.value), first, second)


def _combined(found: Interpolants, which: np.ndarray | slice, radial: np.ndarray, polynomial: np.ndarray) -> np.ndarray:
    """Return the shape functions of stencils, shape (s, ..., m), from the values (or derivatives) of radial functions, shape
    (s, ..., m), and of monomials, shape (s, ..., p).

    found: interpolants; which: numbers of the s stencils, or a slice of all.
    """
    shape = radial.shape
    rows, p = radial.reshape(shape[0], -1, shape[-1]), polynomial.reshape(shape[0], -1, polynomial.shape[-1])
    w = np.concatenate([rows, p], axis=2) @ found.coefficients[which] @ found.inverse[which]
    return (p @ found.fit[which] + w @ found.across[which]).reshape(shape)


FOLDED = "is too wide for the curvature of the {what}: projected along the normal, the stencil overlaps itself; use more nodes"


class Stencils(NamedTuple):
    """Stencils of m nodes around each of n points in k dimensions, with coordinates of the nodes along d tangents at the
    point."""

    nodes: np.ndarray  # (n, m) numbers of the points; on a surface the nearest first, on a curve in their order along it
    tangents: np.ndarray  # (n, d, k) orthonormal tangents at the points
    coordinates: np.ndarray  # (n, m, d) coordinates of the nodes along the tangents, relative to the point [m]


def along_curve(points: np.ndarray, size: int, closed: bool) -> Stencils:
    """Return stencils of `size` neighbours along a curve through ordered points, shape (n, k) [m]; closed: True if the last
    point is a neighbour of the first.

    Stencils are centred, except at the ends of an open curve. Raises StencilError if there are too few points, or if a
    stencil bends back.
    """
    n = len(points)
    if n < size:
        raise StencilError(0, f"needs {size} points, but the curve has {n}; use more points, or decrease `neighbours`")
    first = np.arange(n) - size // 2
    if not closed:
        first = np.clip(first, 0, n - size)
    nodes = (first[:, None] + np.arange(size)) % n
    number = np.arange(n)
    back, on = number - 1, (number + 1) % n
    if not closed:
        back, on = np.maximum(number - 1, 0), np.minimum(number + 1, n - 1)
    secant = points[on] - points[back]
    tangents = (secant / np.linalg.norm(secant, axis=1)[:, None])[:, None]
    coordinates = _coordinates(points, nodes, tangents)
    folded = np.flatnonzero((np.diff(coordinates[:, :, 0], axis=1) <= 0.0).any(axis=1))
    if folded.size:
        raise StencilError(int(folded[0]), FOLDED.format(what="curve"))
    return Stencils(nodes, tangents, coordinates)


def on_surface(points: np.ndarray, normals: np.ndarray, size: int) -> Stencils:
    """Return stencils of the `size` nearest points on a surface through points [m] with unit normals, shape (n, 3) each.

    Points whose normals differ by more than a right angle lie on another part of the surface, and are not neighbours. Raises
    StencilError if too few are left.
    """
    tree, n, wanted = cKDTree(points), len(points), size
    if n < size:
        raise StencilError(0, f"needs {size} points, but the surface has {n}; use more points, or decrease `neighbours`")
    while True:
        found = tree.query(points, wanted)[1].reshape(n, wanted)
        alike = np.einsum("nmk,nk->nm", normals[found], normals) > 0.0
        lacking = np.flatnonzero(alike.sum(axis=1) < size)
        if not lacking.size:
            break
        if wanted == n:
            raise StencilError(int(lacking[0]), FOLDED.format(what="surface"))
        wanted = min(2 * wanted, n)
    order = np.argsort(~alike, axis=1, kind="stable")[:, :size]
    nodes = np.take_along_axis(found, order, axis=1)
    tangents = tangents_across(normals)
    return Stencils(nodes, tangents, _coordinates(points, nodes, tangents))


def tangents_across(normals: np.ndarray) -> np.ndarray:
    """Return two unit vectors, perpendicular to each unit normal, that form a right-handed frame with it, shape (n, 2, 3);
    normals: shape (n, 3)."""
    least = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    one = np.cross(normals, least)
    one /= np.linalg.norm(one, axis=1)[:, None]
    return np.stack([one, np.cross(normals, one)], axis=1)


def _coordinates(points: np.ndarray, nodes: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    return np.einsum("nmk,ndk->nmd", points[nodes] - points[:, None], tangents)
