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

from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, SharedRows, rows
from pellucid.bodies.fluid_film.surfaces.operators import Operators


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
