"""Curves and surfaces of revolution: rows of operators against differences and rigid motions, moving nodes."""

import numpy as np
import pytest

from pellucid.approximants.radial import PolyharmonicModel
from pellucid.bodies.fluid_film.assembly import NodalSums
from pellucid.bodies.fluid_film.curve import Curve
from pellucid.bodies.fluid_film.forces import Drag, FilmPhysics, Tension, bending_energies, dissipation, forms

RADIAL = PolyharmonicModel()


def wavy(n, around):
    """A smooth curve without symmetry but that about the axis."""
    if around:
        s = np.linspace(-0.5 * np.pi, 0.5 * np.pi, n)
        r = 1.0 + 0.2 * np.sin(2.0 * s) + 0.1 * np.cos(4.0 * s)
        x = np.stack([r * np.cos(s), r * np.sin(s)], axis=1)
        x[[0, -1], 0] = 0.0
        return x
    s = 2.0 * np.pi * np.arange(n) / n
    r = 1.0 + 0.2 * np.cos(2.0 * s) + 0.1 * np.sin(3.0 * s)
    return np.stack([r * np.cos(s), r * np.sin(s)], axis=1)


def rates(curve, x, v):
    """Strain rates, normal slopes and rate of curvature of nodal velocities."""
    o = curve.operators(x)
    own = v[curve.nodes]
    strain = np.einsum("eqsmd,emd->eqs", o.strain, own)
    slope = np.einsum("eqcmd,emd->eqc", o.slope, own)
    return o, strain, slope, np.einsum("eqmd,emd->eq", o.bending, own)


@pytest.mark.parametrize("around", [False, True])
def test_a_rigid_motion_strains_and_bends_nothing(around):
    curve, x = Curve(31, RADIAL, around), wavy(31, around)
    motions = [np.tile([0.0, 1.0], (31, 1))]
    if not around:
        motions += [np.tile([1.0, 0.0], (31, 1)), np.stack([-x[:, 1], x[:, 0]], axis=1)]
    for v in motions:
        _, strain, _, bending = rates(curve, x, v)
        assert np.abs(strain).max() < 1e-12
        assert np.abs(bending).max() < 1e-9  # second derivatives: rounding over the square of the spacing


@pytest.mark.parametrize("around", [False, True])
def test_rows_are_the_changes_of_area_and_curvature(around):
    curve, x = Curve(31, RADIAL, around), wavy(31, around)
    rng = np.random.default_rng(2)
    v = rng.normal(size=x.shape)
    v[curve.held] = 0.0
    o, strain, _, bending = rates(curve, x, v)
    h = 1e-6
    before, after = curve.operators(x - h * v), curve.operators(x + h * v)
    growth = (after.area - before.area) / (2.0 * h)
    assert np.allclose(growth, o.area * strain.sum(axis=2), atol=1e-7 * np.abs(growth).max())
    turning = (after.curvature - before.curvature) / (2.0 * h)
    assert np.allclose(turning, bending, atol=1e-6 * np.abs(turning).max())
    smooth = x * (1.0 + x[:, 1:] ** 2)  # the rate by the normal velocity is met by quadrature, for smooth motions
    before, after = curve.operators(x - h * smooth), curve.operators(x + h * smooth)
    volume = (after.volume() - before.volume()) / (2.0 * h)
    assert volume == pytest.approx(np.einsum("eqmd,emd->", o.volume_rate(), smooth[curve.nodes]), rel=1e-5)


@pytest.mark.parametrize(("around", "order"), [(False, 5.0), (True, 5.0)])
def test_circles_and_spheres_are_met_at_the_order_of_the_interpolation(around, order):
    errors = []
    for n in (20, 40):
        curve = Curve(n + 1 if around else n, RADIAL, around)
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, n + 1) if around else 2.0 * np.pi * np.arange(n) / n
        x = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if around:
            x[[0, -1], 0] = 0.0
        o = curve.operators(x)
        area, volume, sum_of_curvatures = (4.0 * np.pi, 4.0 / 3.0 * np.pi, 2.0) if around else (2.0 * np.pi, np.pi, 1.0)
        errors.append((abs(o.area.sum() / area - 1.0), abs(o.volume() / volume - 1.0)))
        assert np.abs(o.curvature - sum_of_curvatures).max() < 0.5 / n**2  # the error of second derivatives falls faster still
        assert np.all(np.einsum("eqd,eqd->eq", o.normal, o.position) > 0.0), "outward"
    falling = np.log2(np.array(errors[0]) / np.array(errors[1]))
    assert np.all(falling > order - 0.5)


@pytest.mark.parametrize("around", [False, True])
def test_the_forms_are_squares_and_dissipate_what_they_resist(around):
    curve, x = Curve(21, RADIAL, around), wavy(21, around)
    physics = FilmPhysics(1.3, 0.7, 0.4, 0.2, Drag(0.5, 0.2))
    o = curve.operators(x)
    flat = np.zeros_like(o.area)
    parts = forms(o, physics, Tension(flat - 0.3, flat + 2.0), 0.1)
    assert all((square.factor >= 0.0).all() for square in (*parts.resistance, *parts.stiffness))
    v = np.random.default_rng(3).normal(size=x.shape)
    sums = NodalSums(curve.nodes, *x.shape)
    power = sum(np.sum(square.factor * sums.rates(square, v) ** 2) for square in parts.resistance)
    assert power == pytest.approx(sum(dissipation(o, physics, v[curve.nodes])), rel=1e-12)


@pytest.mark.parametrize("around", [False, True])
def test_the_force_of_bending_is_the_derivative_of_its_energy(around):
    curve, x = Curve(21, RADIAL, around), wavy(21, around)
    physics = FilmPhysics(1.0, 0.0, 0.4, 0.8, Drag(0.0, 0.0))
    v = np.random.default_rng(4).normal(size=x.shape)
    v[curve.held] = 0.0
    o = curve.operators(x)
    flat = np.zeros_like(o.area)
    power = np.sum(NodalSums(curve.nodes, *x.shape).gathered(forms(o, physics, Tension(flat, flat), 0.0).force) * v)
    h = 1e-6
    change = (
        bending_energies(curve.operators(x + h * v), physics).sum()
        - bending_energies(curve.operators(x - h * v), physics).sum()
    )
    assert power == pytest.approx(-change / (2.0 * h), rel=1e-6)


@pytest.mark.parametrize("around", [False, True])
def test_nodes_spread_along_the_curve_and_keep_mass_shape_and_density(around):
    n = 61
    curve = Curve(n, RADIAL, around)
    s = np.linspace(-0.5 * np.pi, 0.5 * np.pi, n) if around else 2.0 * np.pi * np.arange(n) / n
    uneven = s + 0.1 * np.sin(2.0 * s)
    x = np.stack([np.cos(uneven), np.sin(uneven)], axis=1)
    if around:
        x[[0, -1], 0] = 0.0
    o = curve.operators(x)
    mass = np.einsum("eq,eq->e", o.area, 1.0 + 0.3 * o.position[..., 1])
    moved = curve.redistributed(x, mass, np.zeros_like(x))
    after = curve.operators(moved.x)
    lengths = np.linalg.norm(np.diff(moved.x, axis=0), axis=1)
    assert np.ptp(lengths) < 1e-3 * lengths.mean()
    assert moved.mass.sum() == pytest.approx(mass.sum(), rel=1e-14)
    assert np.abs(np.linalg.norm(moved.x, axis=1) - 1.0).max() < 1e-6
    height = np.einsum("eq,eq->e", after.area, after.position[..., 1]) / after.area.sum(axis=1)
    density = moved.mass / after.area.sum(axis=1)
    assert np.abs(density - 1.0 - 0.3 * height).max() < 2e-3  # monotone interpolation: second order at extremes
    again = curve.redistributed(moved.x, moved.mass, np.zeros_like(x))
    assert again.x is moved.x, "nodes that are spread evenly stay"
