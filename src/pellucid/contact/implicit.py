"""Implicit normal contact forces, for solids whose nodal forces are known before contact.

A contact spring that is stable in an explicit step is soft: its compliance is a fraction of the compliance of a layer of
cells and decreases only with the square of the step size. Here, the forces of a step follow from the overlap at the end of
the step instead. The contact points have the depths d at the start of the step and, without contact, the approach
velocities u* at its end, which follow from the internal forces and loads on the nodes. Forces f on the points change these
velocities by -Δt G f, so that

    f = k (d + Δt u* - Δt² G f),    f ≥ 0,    G = n·S M⁻¹ Sᵀ·n

with the weights S of the nodes in the points, which also distribute the forces, and the nodal masses M. (For k → ∞ these
are the forward increment Lagrange multipliers of Carpenter, Taylor & Katona 1991, Int. J. Numer. Methods Eng. 32, 103.)
Stiffness and step size are independent of each other: stable steps of the body stay stable, and at rest f = k d. A node
that hits the surface stops there; the kinetic energy that it loses vanishes with its mass.

The system is symmetric and positive. Conjugate gradients solve it for the pressed points. An outer iteration finds these
points: it removes points with tensile force and adds points that would overlap.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface, Response
from pellucid.contact.images import NO_IMAGES, Described, Feet, Images
from pellucid.contact.overlap import Implicit, Overlap
from pellucid.contact.point_forces import TINY

ROUNDS = 6  # largest number of iterations that find the pressed points
ITERATIONS = 60  # largest number of conjugate gradient iterations
RESIDUAL = 3e-4  # relative to the residual without forces, in the norm of the scaled system
EXACTLY, TIMES = 1e-11, 10  # residual and factor of the iterations in steady states, which a larger error would disturb


class Block(NamedTuple):
    """Points of one surface that overlap with another surface or with a wall, with the data of their normal forces."""

    overlap: Overlap
    stiffness: np.ndarray  # stiffness k of each point [N/m], (n,)
    given: np.ndarray  # normal forces of the previous step, the initial guess [N], (n,)
    other: ContactSurface | None = None  # the other surface; None for a wall
    images: Images = NO_IMAGES  # images of the other surface
    feet: Feet | None = None  # feet on the other surface


class NormalForces:
    """System of equations for the implicit normal forces of several blocks over a step dt [s].

    described: points and images of each surface, by the `id` of the surface. forces: forces that other contacts exert on
    all points and images of a surface in this step [N], by the same `id`; surfaces without such forces may be missing.
    """

    def __init__(
        self, blocks: Sequence[Block], dt: float, described: Mapping[int, Described], forces: Mapping[int, np.ndarray]
    ) -> None:
        self._blocks, self._dt = blocks, dt
        surfaces = [block.overlap.one for block in blocks] + [block.other for block in blocks if block.other is not None]
        self._velocity, factors = dict[int, np.ndarray](), []
        for key, surface in {id(surface): surface for surface in surfaces}.items():
            if surface.response is None:
                self._velocity[key] = surface.velocity
                if surface.rigid_mass < np.inf:
                    factors.append(dt * sparse.csr_array(np.concatenate([self._turns(surface, b) for b in blocks])))
                continue
            pushed = described[key].fold(forces[key]) if key in forces else None
            self._velocity[key] = surface.response.velocities(dt, pushed)
            root = np.sqrt(dt * surface.response.answers(dt))
            rows = [[self._rows(surface, surface.response, b, axis) for b in blocks] for axis in range(3)]
            ways = [sparse.csr_array(sparse.vstack(of_axis)) for of_axis in rows]
            factors += [sparse.csr_array(way * root[:, axis]) for axis, way in enumerate(ways) if way.nnz]
        n = sum(len(block.given) for block in blocks)
        self._factor = sparse.csr_array(sparse.hstack(factors)) if factors else sparse.csr_array((n, 1))
        """Matrix C: normal forces f on the points reduce their depths at the end of the step by C Cᵀ f [m]."""

    @staticmethod
    def _turns(surface: ContactSurface, block: Block) -> np.ndarray:
        """Return six numbers per point of a block, shape (n, 6): the rows of `ContactSurface.mobility_rows` of the rigid
        body with this surface for a unit normal force on the point. Zeros if the surface is not part of the block."""
        place, normal = block.overlap.one.place[block.overlap.listed], block.overlap.normal
        sign = (block.overlap.one is surface) - (block.other is surface)
        return surface.mobility_rows(place, sign * normal) if sign else np.zeros((len(normal), 6))

    @staticmethod
    def _rows(surface: ContactSurface, response: Response, block: Block, axis: int) -> sparse.csr_array:
        """Return, for each point of a block, the weights of the nodal velocities of a surface along `axis` in the velocity
        of the point relative to the other surface along the normal, shape (n, nodes)."""
        overlap, shares, n = block.overlap, response.shares, len(block.overlap.listed)
        rows = sparse.csr_array((n, shares.shape[1]))
        normal = overlap.normal[:, axis]
        if not normal.any():
            return rows
        if overlap.one is surface:
            rows = shares[overlap.listed] * normal[:, None]
        if block.other is surface and block.feet is not None:
            point, sign = block.feet.point, np.ones(len(block.feet.point))
            if len(block.images.point):
                m = shares.shape[0]
                image = point >= m
                sign[image] = block.images.flip[point[image] - m, axis]
                point = np.where(image, block.images.point[np.maximum(point - m, 0)], point)
            scaled = block.feet.share * sign * np.repeat(normal, np.diff(block.feet.first))
            rows = rows - sparse.csr_array((scaled, point, block.feet.first), shape=(n, shares.shape[0])) @ shares
        return sparse.csr_array(rows)

    def _approach(self, block: Block) -> np.ndarray:
        """Return the velocities [m/s], shape (n,), at which the points of a block would approach the other surface at the
        end of the step without the normal forces of this system."""
        overlap = block.overlap
        along = self._velocity[id(overlap.one)][overlap.listed]
        if block.other is None or block.feet is None:
            along = along - (overlap.one.velocity[overlap.listed] - overlap.relative)
        else:
            along = along - block.feet.gather(self._velocity[id(block.other)], block.images)
        return np.asarray(-np.einsum("ij,ij->i", along, overlap.normal))

    def solve(self) -> list[Implicit]:
        """Solve the system; return for each block the normal forces on its points and the depths of its points at the end
        of the step."""
        ahead = np.concatenate([block.overlap.depth + self._dt * self._approach(block) for block in self._blocks])
        return solve_forces(
            self._factor, ahead, [block.stiffness for block in self._blocks], [block.given for block in self._blocks]
        )


def solve_forces(
    factor: sparse.csr_array,
    ahead: np.ndarray,
    stiffnesses: Sequence[np.ndarray],
    givens: Sequence[np.ndarray],
    exactly: bool = False,
) -> list[Implicit]:
    """Return the implicit normal forces of blocks of points, n points in all.

    Parameters
    ----------
    factor
        Matrix C; forces f reduce the depths at the end of the step by C Cᵀ f.
    ahead
        Depths at the end of the step without forces [m], shape (n,).
    stiffnesses, givens
        Stiffness k of each point [N/m] and normal force of the previous step, the initial guess [N]; one array per block.
    exactly
        True to solve to rounding error, for steady states.
    """
    stiffness, given = np.concatenate(stiffnesses), np.concatenate(givens)
    residual, times = (EXACTLY, TIMES) if exactly else (RESIDUAL, 1)
    stiff, force = stiffness > 0.0, given
    pressed = stiff & (ahead > 0.0)
    turned = sparse.csr_array(factor.T)
    for _ in range(times * ROUNDS):
        root = np.where(pressed, np.sqrt(stiffness), 0.0)
        first = np.where(pressed, force / np.maximum(root, TINY), 0.0)
        force = root * _solve_pressed(factor, root, root * ahead, first, residual, times * ITERATIONS)
        after = ahead - factor @ (turned @ force)
        # a tensile force would give its point a negative overlap
        before, pressed = pressed, stiff & np.where(pressed, force > 0.0, after > 0.0)
        if (before == pressed).all():
            break
    force = np.maximum(force, 0.0)
    found, ends = (force, ahead - factor @ (turned @ force), given), np.cumsum([len(of) for of in givens])[:-1]
    return [Implicit(*of) for of in zip(*(np.split(values, ends) for values in found), strict=True)]


def _solve_pressed(
    factor: sparse.csr_array, root: np.ndarray, wanted: np.ndarray, y: np.ndarray, tolerance: float, iterations: int
) -> np.ndarray:
    """Return the solution y of (1 + √k C Cᵀ √k) y = √k d* by conjugate gradients. The normal forces are √k y, for stiffnesses
    k, depths d* without forces, and the matrix C (`factor`) of `solve_forces`.

    root: √k, zero for excluded points. wanted: √k d*. y: initial guess. tolerance: relative residual. iterations: largest
    number of iterations.
    """
    scaled = sparse.csr_array(factor * root[:, None])
    turned = sparse.csr_array(scaled.T)
    residual = wanted - y - scaled @ (turned @ y)
    way, square = residual, float(np.sum(residual * residual))
    least = tolerance**2 * float(np.sum(wanted * wanted))
    for _ in range(iterations):
        if square <= least:
            break
        image = way + scaled @ (turned @ way)
        step = square / float(np.sum(way * image))
        y = y + step * way
        residual = residual - step * image
        before, square = square, float(np.sum(residual * residual))
        way = residual + (square / before) * way
    return y
