"""The virtual power of a film, element by element: resistance to its motion, and driving forces.

The film moves with the velocity v for which every virtual velocity δv satisfies

    ∫ 2μ D:D(δv) + λ tr D tr D(δv) + ζ_t v_t·δv_t + ζ_n v_n δv_n = ∫ p tr D(δv) + b·δv - δE(δv)

with the bending energy E = ∫ (κ_c/2)(J - c₀)², whose variation is exact: δE = ∫ κ_c (J - c₀) δJ + (κ_c/2)(J - c₀)² tr
D(δv). Here D is the rate of deformation in the surface, p the surface pressure, b the load per unit area, ζ the drag
coefficients, J the sum of the principal curvatures and c₀ its spontaneous value. Pressure, tension and bending change as the
film moves. Their changes over a time τ add a resistance to the viscosity, in the three parts of the `stiffness`: τ ρ p' for
dilatation (ρ: surface density), τ times the tension for slopes, τ κ_c for changes of curvature.

Source: Benet 2015, eqs. 3.40-3.48 in their weak form, with the geometry taken implicitly; for the change of J, Capovilla &
Guven 2002, J. Phys. A 35, 6233.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.assembly import ElementRows, NodalSums, SharedRows, rows
from pellucid.bodies.fluid_film.film_geometry import FilmGeometry, Operators
from pellucid.materials.lipid_film import LipidFilm
from pellucid.parts.capabilities import SurfacePoints, Traction
from pellucid.step.limit import StepLimit, bending_in_cells, spread_in_cells, tightest, waves_in_cells


class Drag(NamedTuple):
    """Drag coefficients of the surrounding fluid [N s/m³]."""

    normal: float  # ζ_n
    tangential: float  # ζ_t


class FilmPhysics(NamedTuple):
    """Physical properties of a film: viscosities, bending rigidity, spontaneous curvature and drag coefficients."""

    viscosity: float  # μ [N s/m]
    dilatational_viscosity: float  # λ [N s/m]
    bending_rigidity: float  # κ_c [J]
    spontaneous_curvature: float  # c₀ [1/m]
    drag: Drag


class Tension(NamedTuple):
    """Surface pressure of a film, and the stiffness of the film against dilatation, at the q quadrature points of each of e
    elements; shape (e, q) both."""

    pressure: np.ndarray  # p [N/m]
    stiffness: np.ndarray  # ρ p', with the surface density ρ [N/m]


class Forms(NamedTuple):
    """Resistance, stiffness and forces of a film, element by element, as weighted linear forms of the nodal velocities
    (`ElementRows`). The dissipated power is the sum of the weighted squares of the forms in `resistance`; the nodal forces
    are the weighted sums of the rows in `force`."""

    resistance: list[ElementRows | SharedRows]  # viscosity and drag [N s/m]
    stiffness: list[ElementRows]  # resistance by changes of pressure, tension and curvature [N s/m]
    force: list[ElementRows]  # forces of the surface pressure and of bending [N]


def forms(o: Operators, physics: FilmPhysics, tension: Tension, ahead: float) -> Forms:
    """Return resistance, stiffness and forces of the film's elements.

    o: geometry and strain operators at the present positions; physics: viscosities, drag and bending rigidity; tension:
    surface pressure and its stiffness; ahead: time τ over which changes of pressure, tension and bending add resistance [s].
    """
    w, mu, kappa = o.area, physics.viscosity, physics.bending_rigidity
    dilatation = o.dilatation()
    parts = o.strain.shape[2]
    if parts == 1:  # along a curve one rate of a segment, as many as there are nodes: with more, none would move freely
        whole = w.sum(axis=1, keepdims=True)
        grown = np.einsum("eq,eqmi->emi", w, dilatation)[:, None]  # rate of the element's area
        mean_stiffness = np.einsum("eq,eq->e", w, tension.stiffness)[:, None] / whole**2
        resistance: list[ElementRows | SharedRows] = [rows(grown, (2.0 * mu + physics.dilatational_viscosity) / whole)]
        stiffness = [rows(grown, ahead * mean_stiffness)]
    else:
        factors = mu * np.array((2.0, 2.0, 1.0)[:parts])  # of D₁₁², D₂₂², (2 D₁₂)²
        resistance = [rows(o.strain, w[..., None] * factors), rows(dilatation, physics.dilatational_viscosity * w)]
        stiffness = [rows(dilatation, ahead * (w * tension.stiffness))]
    resistance += _drag(o, physics.drag)
    pull = np.maximum(-tension.pressure, 0.0)
    stiffness.append(rows(o.slope, ahead * (w * pull)[..., None]))
    force = [rows(dilatation, w * tension.pressure)]
    if kappa > 0.0:
        excess = o.curvature - physics.spontaneous_curvature
        stiffness.append(rows(o.bending, ahead * kappa * w))
        force.append(rows(o.bending, -kappa * w * excess))
        force[0] = rows(dilatation, w * (tension.pressure - 0.5 * kappa * excess**2))
    return Forms(resistance, stiffness, force)


def turning(o: Operators) -> list[ElementRows]:
    """Return the linear forms of nodal velocities whose squares sum to ∫ |∇v_n|² dA, a measure of the rotation of the film; v_n
    is its normal velocity. o: geometry and strain operators of the film.
    """
    return [rows(o.slope, o.area[..., None])]


def _drag(o: Operators, drag: Drag) -> list[ElementRows | SharedRows]:
    """Return the linear forms of nodal velocities whose squares sum to the power of the drag on the film [W], ∫ ζ_t v_t·v_t +
    ζ_n v_n² dA, with the tangential velocity v_t and the normal velocity v_n.

    o: geometry of the film; drag: coefficients ζ_t and ζ_n. The tangential part is written as v·v - v_n² or computed
    separately, whichever avoids a negative factor.
    """
    if max(drag) == 0.0:
        return []
    normal = o.normal[:, :, None, :] * o.value
    d = o.normal.shape[2]
    if drag.normal >= drag.tangential:
        every = _of_each_component(o, drag.tangential * o.area)
        return [every, rows(normal, (drag.normal - drag.tangential) * o.area)]
    along = o.value[:, :, None] * (np.eye(d) - o.normal[..., None] * o.normal[:, :, None])[:, :, :, None, :]
    return [rows(along, drag.tangential * o.area[..., None]), rows(normal, drag.normal * o.area)]


def _of_each_component(o: Operators, factor: np.ndarray) -> ElementRows | SharedRows:
    """Return the linear forms of nodal velocities whose squares sum to Σ factor · v·v over the quadrature points, with the
    velocity v of the film at the point.

    o: shape functions of the film; factor: one number for each element and quadrature point, shape (e, q). The components
    of v have the same shape functions on surfaces of triangles, but not at the mirrored nodes of curves.
    """
    if o.strain.shape[2] == 3:
        return SharedRows(o.value[..., 0].copy(), factor)
    return rows(o.value[:, :, None] * np.eye(o.normal.shape[2])[:, None, :], factor[..., None])


def bending_energies(o: Operators, physics: FilmPhysics) -> np.ndarray:
    """Return the bending energy of the area of each quadrature point [J], shape (e, q). o: geometry at the present positions;
    physics: bending rigidity and spontaneous curvature.
    """
    return np.asarray(0.5 * physics.bending_rigidity * o.area * (o.curvature - physics.spontaneous_curvature) ** 2)


class Dissipation(NamedTuple):
    """Power dissipated by a motion of a film."""

    viscous: float  # by the viscosity of the film [W]
    drag: float  # by the drag of the surrounding fluid [W]


def dissipation(o: Operators, physics: FilmPhysics, velocity: np.ndarray) -> Dissipation:
    """Return the power dissipated by the viscosity of the film and by drag [W], for the velocities of each element's nodes
    [m/s], shape (e, m, d).

    o: geometry and strain operators at the present positions; physics: viscosities and drag coefficients.
    """
    rates = np.einsum("eqsmd,emd->eqs", o.strain, velocity)
    moved = np.einsum("eqmd,emd->eqd", o.value, velocity)
    across = np.einsum("eqd,eqd->eq", o.normal, moved)
    mu, both, w = physics.viscosity, rates[:, :, :2].sum(axis=2), o.area
    if rates.shape[2] == 1:
        mean = np.einsum("eq,eq->e", w, both) / w.sum(axis=1)
        viscous = np.sum(w.sum(axis=1) * (2.0 * mu + physics.dilatational_viscosity) * mean**2)
    else:
        squares = rates**2 * np.array([2.0, 2.0, 1.0])[: rates.shape[2]]
        viscous = np.sum(w * (mu * squares.sum(axis=2) + physics.dilatational_viscosity * both**2))
    normal, tangential = physics.drag
    drag = np.sum(w * (tangential * np.einsum("eqd,eqd->eq", moved, moved) + (normal - tangential) * across**2))
    return Dissipation(float(viscous), float(drag))


class FilmForces:
    """Computes the nodal forces of a film.

    geometry: interpolation between the nodes; material: equation of state of the film; physics: viscosities, bending rigidity
    and drag; initial_density: surface density at the start [kg/m²]. The mass of the film is given for its parts [kg], shape
    (parts,); a part is the piece of the film that belongs to a node or an element.
    """

    def __init__(self, geometry: FilmGeometry, material: LipidFilm, physics: FilmPhysics, initial_density: float) -> None:
        self.initial_density = initial_density
        self.geometry, self.material, self.physics = geometry, material, physics
        self._sums = NodalSums(geometry.nodes, *geometry.held.shape)

    def part_areas(self, o: Operators) -> np.ndarray:
        """Return the areas of the parts of the film [m²], shape (parts,). o: operators of the film at the present positions."""
        shares = self.geometry.shares
        areas = np.einsum("eq,qc->ec", o.area, shares.share)
        return np.bincount(shares.part.ravel(), areas.ravel())

    def densities(self, o: Operators, mass: np.ndarray) -> np.ndarray:
        """Return the surface densities of the parts of the film [kg/m²], shape (parts,).

        o: operators of the film at the present positions; mass: masses of the parts [kg], shape (parts,).
        """
        return np.asarray(mass / self.part_areas(o))

    def at_points(self, parts: np.ndarray) -> np.ndarray:
        """Interpolate values of the parts of the film, shape (parts,), to the quadrature points of its elements, shape (e,
        q).
        """
        shares = self.geometry.shares
        return np.asarray(parts[shares.part] @ shares.share.T)

    def stored_energy(self, o: Operators, mass: np.ndarray) -> float:
        """Return the energy of compression and bending of the film [J].

        o: operators of the film at the present positions; mass: masses of its parts [kg], shape (parts,).
        """
        compressed = float(np.sum(mass * self.material.stored_energy(self.densities(o, mass))))
        return compressed + float(bending_energies(o, self.physics).sum())

    def forms(self, o: Operators, mass: np.ndarray, ahead: float) -> Forms:
        """Return resistance, stiffness and forces of the film's elements (see `Forms`).

        o: operators of the film at the present positions; mass: masses of its parts [kg]; ahead: time over which pressure,
        tension and curvature are assumed to change with the motion [s]; the stiffness is the resistance due to these
        changes.
        """
        density = self.densities(o, mass)
        pressure, stiffness = self.material.pressure(density), density * self.material.pressure_slope(density)
        return forms(o, self.physics, Tension(self.at_points(pressure), self.at_points(stiffness)), ahead)

    def internal_force(self, o: Operators, mass: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return the internal force on the nodes [N], shape (n, d): viscous and elastic forces, and drag.

        o: operators of the film at the present positions; mass: masses of its parts [kg]; velocity: nodal velocities [m/s],
        shape (n, d).
        """
        parts = self.forms(o, mass, 0.0)
        return np.asarray(self._sums.gathered(parts.force) - self._sums.gathered(self._felt(parts.resistance, velocity)))

    def _felt(self, squares: Sequence[ElementRows | SharedRows], velocity: np.ndarray) -> list[ElementRows]:
        """Return the forces with which viscosity, drag or stiffness oppose nodal velocities [m/s], shape (n, d), as linear
        forms whose sums at the nodes are forces [N]. squares: the resistance or stiffness, written as a sum of squares of
        linear forms.
        """
        whole = (square.of_components(velocity.shape[1]) for square in squares)
        return [ElementRows(square.rows, square.factor * self._sums.rates(square, velocity)) for square in whole]

    def traction_force(self, o: Operators, mass: np.ndarray, traction: Traction, after: float) -> np.ndarray:
        """Return the nodal forces of a traction (force per unit area) [N], shape (n, d).

        o: operators of the film at the present positions; mass: masses of its parts [kg]; after: time since the start of the
        step of the run [s].
        """
        axes = list(self.geometry.axes)
        ratio = self.at_points(self.densities(o, mass)) / self.initial_density
        points = SurfacePoints(in_space(o.position, axes), in_space(o.normal, axes), ratio)
        on_area = o.area[..., None] * traction(points, after)[..., axes]
        return self._sums.summed(np.einsum("eqd,eqmd->emd", on_area, o.value))

    def vector_areas(self, o: Operators) -> np.ndarray:
        """Return ∫ N_I n dA around each node I [m²], shape (n, d), with its shape function N_I and the outward normal n of the
        film.

        o: operators of the film at the present positions.
        """
        return self._sums.summed(o.volume_rate().sum(axis=1))


def in_space(vectors: np.ndarray, axes: Sequence[int]) -> np.ndarray:
    """Return vectors with d components along `axes` as vectors in space, shape (..., 3); the other components are 0."""
    result = np.zeros((*vectors.shape[:-1], 3))
    result[..., list(axes)] = vectors
    return result


class Signals:
    """The wave speed [m/s], momentum diffusivity [m²/s] and bending coefficient [m⁴/s²] of a film with inertia.

    physics: viscosities and bending rigidity; material: equation of state of the film; density: surface density at its nodes
    or elements [kg/m²].
    """

    def __init__(self, physics: FilmPhysics, material: LipidFilm, density: np.ndarray) -> None:
        tension, least = -material.pressure(density), float(density.min())
        self.wave = sqrt(float(np.max((density * material.pressure_slope(density) + np.maximum(tension, 0.0)) / density)))
        self.spread = (2.0 * physics.viscosity + physics.dilatational_viscosity) / least
        self.bending = physics.bending_rigidity / least

    def rate(self, h: float) -> float:
        """Return the reciprocal of the largest stable time step by waves, viscosity and bending [1/s]. h: reciprocal of the
        size of the grid cells [1/m].
        """
        return max(h * self.wave, 2.0 * h * h * self.spread, 2.0 * h * h * sqrt(self.bending))

    def limit(self, cell: float, speed: float) -> StepLimit:
        """Return the largest stable time step and its cause, for grid cells of size `cell` [m] and a film that moves at a
        speed [m/s].
        """
        waves, spread = waves_in_cells(cell, self.wave, cause="membrane"), spread_in_cells(cell, self.spread)
        tight = tightest([waves, spread, bending_in_cells(cell, self.bending)])
        return tight._replace(step=1.0 / (1.0 / tight.step + speed / cell))
