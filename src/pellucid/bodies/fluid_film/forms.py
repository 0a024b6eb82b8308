"""The virtual power of a film, element by element: what resists its motion, and what drives it.

Of all velocities that of the film makes, for every other one δv,

    ∫ 2μ D:D(δv) + λ tr D tr D(δv) + ζ_t v_t·δv_t + ζ_n v_n δv_n = ∫ p tr D(δv) + b·δv - δE(δv)

with the bending energy E = ∫ (κ_c/2)(J - c₀)², whose change is exact: δE = ∫ κ_c (J - c₀) δJ + (κ_c/2)(J - c₀)² tr D(δv).
Pressure, tension and bending change as the film moves. What their change over a time τ resists stands beside the viscosity,
in the three parts of the `stiffness`: τ ρ p' of dilatation, τ times the tension of slopes, τ κ_c of changes of curvature.

Source: Benet 2015, eqs. 3.40-3.48 in their weak form, with the geometry taken implicitly; for the change of J, Capovilla &
Guven 2002, J. Phys. A 35, 6233.
"""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.fluid_film.operators import Operators


class Drag(NamedTuple):
    """What the fluid about it resists a film with [N s/m³]."""

    normal: float
    tangential: float


class FilmPhysics(NamedTuple):
    """What the film is made of."""

    viscosity: float  # μ [N s/m]
    dilatational_viscosity: float  # λ [N s/m]
    bending_rigidity: float  # κ_c [J]
    spontaneous_curvature: float  # c₀ [1/m]
    drag: Drag


class Tension(NamedTuple):
    """The state of the film at its quadrature points, shape (e, q)."""

    pressure: np.ndarray  # p [N/m]
    stiffness: np.ndarray  # ρ p' [N/m]


class ElementForms(NamedTuple):
    """Matrices and forces of the elements, over their m nodes with d components each."""

    resistance: np.ndarray  # (e, md, md) viscosity and drag [N s/m]
    stiffness: np.ndarray  # (e, md, md) what changes of pressure, tension and curvature resist [N s/m]
    force: np.ndarray  # (e, md) pressure within the film and bending [N]


def forms(o: Operators, physics: FilmPhysics, tension: Tension, ahead: float) -> ElementForms:
    """The forms of the elements; ahead: the time τ over which changes count [s]."""
    e, q = o.area.shape
    size = o.value.shape[2] * o.value.shape[3]
    w, mu, kappa = o.area, physics.viscosity, physics.bending_rigidity
    strain = o.strain.reshape(e, q, -1, size)
    dilatation = o.dilatation().reshape(e, q, size)
    grown = np.einsum("eq,eqa->ea", w, dilatation)  # rate of the element's area
    whole = w.sum(axis=1)
    parts = strain.shape[2]
    if parts == 1:  # along a curve one rate of a segment, as many as there are nodes: with more, none would move freely
        resistance = _outer(grown[:, None], ((2.0 * mu + physics.dilatational_viscosity) / whole)[:, None])
    else:
        factors = (2.0 * mu, 2.0 * mu, mu)[:parts]  # of D₁₁², D₂₂², (2 D₁₂)²
        resistance = _outer(dilatation, physics.dilatational_viscosity * w)
        for number, factor in enumerate(factors):
            resistance += _outer(strain[:, :, number], factor * w)
    resistance += _drag(o, physics.drag).reshape(e, size, size)

    mean_stiffness = np.einsum("eq,eq->e", w, tension.stiffness) / whole**2
    stiffness = _outer(grown[:, None], (ahead * mean_stiffness)[:, None])
    pull = np.maximum(-tension.pressure, 0.0)
    for number in range(o.slope.shape[2]):
        stiffness += _outer(o.slope[:, :, number].reshape(e, q, size), ahead * w * pull)
    force = np.einsum("eq,eqa->ea", w * tension.pressure, dilatation)
    if kappa > 0.0:
        bending, excess = o.bending.reshape(e, q, size), o.curvature - physics.spontaneous_curvature
        stiffness += _outer(bending, ahead * kappa * w)
        force -= np.einsum("eq,eqa->ea", kappa * w * excess, bending)
        force -= np.einsum("eq,eqa->ea", 0.5 * kappa * w * excess**2, dilatation)
    return ElementForms(resistance, stiffness, force)


def turning(o: Operators) -> np.ndarray:
    """∫ |∇v_n|², by which the film turns, of the elements, shape (e, md, md)."""
    e, q, c = o.slope.shape[:3]
    return sum((_outer(o.slope[:, :, number].reshape(e, q, -1), o.area) for number in range(c)), np.zeros(()))


def _outer(rows: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """Σ_q factor row ⊗ row, shape (e, md, md), of rows (e, q, md) and factors (e, q)."""
    return np.asarray(np.matmul((factor[..., None] * rows).transpose(0, 2, 1), rows))


def _drag(o: Operators, drag: Drag) -> np.ndarray:
    """ζ_t N_a·N_b + (ζ_n - ζ_t) (n·N_a)(n·N_b), shape (e, m, d, m, d)."""
    e, q, m, d = o.value.shape
    normal = (o.value * o.normal[:, :, None, :]).reshape(e, q, m * d)
    result = _outer(normal, (drag.normal - drag.tangential) * o.area).reshape(e, m, d, m, d)
    for i in range(d):
        result[:, :, i, :, i] += _outer(o.value[..., i], drag.tangential * o.area)
    return np.asarray(result)


def bending_energies(o: Operators, physics: FilmPhysics) -> np.ndarray:
    """Bending energy of each quadrature point [J], shape (e, q)."""
    return np.asarray(0.5 * physics.bending_rigidity * o.area * (o.curvature - physics.spontaneous_curvature) ** 2)


class Dissipation(NamedTuple):
    """What a motion of the film turns into heat [W]."""

    viscous: float
    drag: float


def dissipation(o: Operators, physics: FilmPhysics, velocity: np.ndarray) -> Dissipation:
    """By velocities of the nodes of each element [m/s], shape (e, m, d)."""
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
