"""Every registered surface law: its numbers, energy, tension, waves, moduli, width, and what a membrane of it has."""

import numpy as np
import pytest
from membranes import SURFACE_LAWS
from pydantic import ValidationError

from pellucid.jit import kernel
from pellucid.materials.damage import driving_strain
from pellucid.materials.law import energy
from pellucid.materials.membrane import plane_response, plane_wave_speed, shape_of, wave_in_shape
from pellucid.materials.membrane_material import MEMBRANE_MATERIALS
from pellucid.materials.surface_law import (
    by_search,
    natural_width,
    stretch_curvatures,
    stretch_slopes,
    surface_energy,
    surface_stiffness,
    surface_tension,
)
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial

RHO, THICKNESS = 1100.0, 2e-3
MODELS = MEMBRANE_MATERIALS.kinds_of(SurfaceMembraneMaterial)


def material(kind, **more):
    return MODELS[kind](density=RHO, **SURFACE_LAWS[kind] | more)


ISOTROPIC = [kind for kind in SURFACE_LAWS if material(kind).direction is None]
# their own samples beside the usual ones: a weak and a strong resistance to a change of area
SAMPLES = {kind: material(kind) for kind in SURFACE_LAWS} | {
    "red cell": material("skalak-membrane", area_coefficient=100.0),
    "widening": material("skalak-membrane", area_coefficient=-0.3),
    "vesicle": material("evans-skalak-membrane", shear_modulus=0.0),
    "short chains": material("arruda-boyce-membrane", links=3.0),
    "all ways": material("holzapfel-gasser-ogden-membrane", dispersion=1 / 3),
}
every_law = pytest.mark.parametrize("sample", SAMPLES.values(), ids=SAMPLES)
every_isotropic = pytest.mark.parametrize("kind", ISOTROPIC)
STATES = [(1.0, 1.0), (1.25, 1.25), (1.3, 0.9), (1.6, 1.2), (0.95, 0.9), (1.1, 1.1 - 1e-6)]


def test_every_law_has_a_sample():
    assert set(SURFACE_LAWS) == set(MODELS)


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def gradient(stretches, before=0.4, after=-0.9):
    return turn(after) @ np.diag(stretches) @ turn(before)


def tension(law, F):
    t11, t22, t12 = surface_tension(law, tuple(F.ravel()))
    return np.array([[t11, t12], [t12, t22]])


def nominal(law, F):
    """∂W/∂F."""
    return tension(law, F) @ np.linalg.inv(F).T


def differences(function, F, step=1e-5):
    """Derivative by F to the fourth order of the step, on the last axes."""
    result = np.zeros((*np.shape(function(F)), 2, 2))
    for k, K in np.ndindex(2, 2):
        dF = np.zeros((2, 2))
        dF[k, K] = step
        near, far = function(F + dF) - function(F - dF), function(F + 2 * dF) - function(F - 2 * dF)
        result[..., k, K] = (8.0 * near - far) / (12.0 * step)
    return result


# T₁ of strips whose sides are free at 1.25 and 1.5, and of equal stretches of 1.25: over G, of Arruda and Boyce's law over μ
NUMBERS = {
    "surface-neo-hookean-membrane": (0.68200, 1.29279, 0.73786),
    "skalak-membrane": (0.99114, 2.78730, 2.81470),
    "evans-skalak-membrane": (0.80406, 1.50216, 5.62500),
    "arruda-boyce-membrane": (0.74366, 1.42783, 0.81371),
}


@pytest.mark.parametrize("kind", NUMBERS)
def test_tensions_are_those_of_the_equations(kind):
    law = material(kind).elastic_law()
    found = [stretch_slopes(law, s, natural_width(law, s))[0] / natural_width(law, s) for s in (1.25, 1.5)]
    assert (*found, stretch_slopes(law, 1.25, 1.25)[0] / 1.25) == pytest.approx(NUMBERS[kind], abs=6e-6)


@every_law
@pytest.mark.parametrize("stretches", STATES)
def test_tension_is_the_derivative_of_the_energy(sample, stretches):
    law, F = sample.elastic_law(), gradient(stretches)
    if sample.direction is not None and stretches == (1.0, 1.0):
        F *= 1.0 - 3e-3  # fibres are taut or slack within the differences
    found = differences(lambda F: surface_energy(law, tuple(F.ravel())), F, 1e-3)
    size = sum(sample.surface_moduli())
    assert nominal(law, F) == pytest.approx(found, rel=1e-8, abs=1e-8 * size)


@every_law
@pytest.mark.parametrize("stretches", STATES)
def test_neither_frame_nor_turn_counts(sample, stretches):
    law, F, Q = sample.elastic_law(), gradient(stretches), turn(1.1)
    W, size = surface_energy(law, tuple(F.ravel())), sum(sample.surface_moduli())
    assert surface_energy(law, tuple((Q @ F).ravel())) == pytest.approx(W, rel=1e-13, abs=1e-14 * size)
    assert tension(law, Q @ F) == pytest.approx(Q @ tension(law, F) @ Q.T, rel=1e-12, abs=1e-13 * size)
    if sample.direction is None:
        assert tension(law, F @ Q) == pytest.approx(tension(law, F), rel=1e-12, abs=1e-13 * size)


@every_law
def test_moduli_at_rest(sample):
    law = sample.elastic_law()
    shear, area = sample.surface_moduli()
    assert surface_energy(law, (1.0, 0.0, 0.0, 1.0)) == 0.0
    # fibres are slack at a strain below 0, and the moduli are those of the matrix
    at_rest = np.eye(2) * (1.0 if sample.direction is None else 1.0 - 1e-7)
    found = differences(lambda F: nominal(law, F), at_rest, 1e-6 if sample.direction is None else 1e-8)
    error = 1e-6 if sample.direction is None else 1e-5
    assert 0.5 * (found[0, 0, 0, 0] + found[0, 0, 1, 1]) == pytest.approx(area, rel=error)
    assert 0.5 * (found[0, 1, 0, 1] + found[0, 1, 1, 0]) == pytest.approx(shear, rel=error, abs=error * area)


@pytest.mark.parametrize("kind", SURFACE_LAWS)
def test_moduli_are_the_parameters(kind):
    """All have the shear modulus 1 in these samples or one that their parameters give; rubber has K = 3G."""
    sample = material(kind)
    shear, area = sample.surface_moduli()
    known = {
        "ogden-membrane": lambda m: 0.5 * sum(mu * alpha for mu, alpha in zip(m.shear_moduli, m.exponents, strict=True)),
        "arruda-boyce-membrane": lambda m: m.rubber_modulus * {3.0: 1.2923, 8.0: 1.0851}[m.links],
    }
    error = 1e-4 if kind == "arruda-boyce-membrane" else 1e-14
    assert shear == pytest.approx(known.get(kind, lambda m: m.shear_modulus)(sample), rel=error)
    areas = {
        "skalak-membrane": lambda m: (1.0 + 2.0 * m.area_coefficient) * shear,
        "evans-skalak-membrane": lambda m: m.area_modulus,
    }
    assert area == pytest.approx(areas.get(kind, lambda m: 3.0 * shear)(sample), rel=1e-14)


@every_isotropic
@pytest.mark.parametrize("stretches", STATES)
def test_curvatures_are_the_derivatives_of_the_slopes(kind, stretches):
    law, (a, b), step = material(kind).elastic_law(), stretches, 1e-5
    one, two, mixed = stretch_curvatures(law, a, b)
    by_a = (np.array(stretch_slopes(law, a + step, b)) - stretch_slopes(law, a - step, b)) / (2.0 * step)
    by_b = (np.array(stretch_slopes(law, a, b + step)) - stretch_slopes(law, a, b - step)) / (2.0 * step)
    assert (*by_a, *by_b) == pytest.approx((one, mixed, mixed, two), rel=1e-8, abs=1e-8)


@every_law
@pytest.mark.parametrize("apart", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0])
def test_nearly_equal_stretches_cost_no_digits(sample, apart):
    """Beside the tension of equal ones, to first order in what they are apart."""
    law, a = sample.elastic_law(), 1.3
    F, equal = gradient((a, a - apart)), gradient((a, a))
    slope = differences(lambda F: tension(law, F), equal)
    expected = tension(law, equal) + np.einsum("ijkK,kK->ij", slope, F - equal)
    size = np.abs(slope).max()
    assert np.abs(tension(law, F) - expected).max() < (20.0 * apart**2 + 1e-9 * apart + 1e-14) * size


def fastest_stiffness(law, F):
    """λ² W₁₁ and the like: of small plane waves, those across the surface included, by differences [N/m]."""
    tangent = differences(lambda F: nominal(law, F), F)
    squares = []
    for angle in np.linspace(0.0, np.pi, 73):
        n = np.array((np.cos(angle), np.sin(angle)))
        N = F.T @ n
        squares += [*np.linalg.eigvals(np.einsum("iJkK,J,K->ik", tangent, N, N)).real, n @ tension(law, F) @ n]
    return max(squares)


@every_law
@pytest.mark.parametrize("stretches", STATES)
def test_no_wave_outruns_the_bound_and_the_bound_is_near(sample, stretches):
    law, F = sample.elastic_law(), gradient(stretches)
    bound = surface_stiffness(law, tuple(F.ravel())) + max(np.linalg.eigvalsh(tension(law, F)).max(), 0.0)
    fastest = fastest_stiffness(law, F)
    assert bound > fastest * (1.0 - 1e-6)
    # fibres that are slack count as taut, and their directions as one
    assert bound < fastest * (1.3 if sample.direction is None else 5.0) + 1e-6


@pytest.mark.parametrize(("stretch", "stiffness"), [(1.0, 4.0), (1.1, 8.14897)])
def test_a_skalak_membrane_stiffens_as_it_is_stretched(stretch, stiffness):
    """λ² W₁₁ = λ² (G (3λ² - 1) + GC λ² (3λ⁴ - 1)), and the wave √(λ² W₁₁/ρh) by the mass of initial area."""
    law = material("skalak-membrane").law(THICKNESS)
    shape = shape_of(law, (1.0, -1.0, 0.0), stretch, stretch)
    W11 = 3.0 * stretch**2 - 1.0 + stretch**2 * (3.0 * stretch**4 - 1.0)
    assert stretch**2 * W11 == pytest.approx(stiffness, rel=1e-4)
    assert wave_in_shape(law, shape, RHO) == pytest.approx(np.sqrt(stiffness / (RHO * THICKNESS)), rel=1e-4)


@every_law
def test_the_speeds_that_a_material_states_are_those_of_its_law(sample):
    law = sample.law(THICKNESS)
    speed, shear = sample.wave_speeds(THICKNESS)
    assert speed >= shear
    if sample.direction is None:
        assert plane_wave_speed(law, (1.0, 0.0, 0.0, 1.0), RHO) == pytest.approx(speed, rel=1e-12)


@every_law
@pytest.mark.parametrize("thickness", [1e-9, 1e-3, 0.5])
def test_the_thickness_serves_mass_alone(sample, thickness):
    law, F = sample.law(thickness), gradient((1.3, 1.1))
    s11, s22, s12, ratio = plane_response(law, tuple(F.ravel()))
    T = tension(sample.elastic_law(), F) / np.linalg.det(F)
    assert ratio == pytest.approx(1.0 / np.linalg.det(F), rel=1e-14)
    assert thickness * ratio * np.array([[s11, s12], [s12, s22]]) == pytest.approx(T, rel=1e-13, abs=1e-14)
    assert thickness * energy(law, tuple(F.ravel())) == pytest.approx(surface_energy(sample.elastic_law(), tuple(F.ravel())))


@every_isotropic
@pytest.mark.parametrize("stretch", [1.0 + 1e-9, 1.01, 1.25, 1.5, 2.5])
def test_the_natural_width_leaves_no_tension_across(kind, stretch):
    """Closed forms, and the search that serves where there is none."""
    law = material(kind).elastic_law()
    width = natural_width(law, stretch)
    slopes = stretch_slopes(law, stretch, width)
    assert abs(slopes[1]) < 1e-13 * max(1.0, slopes[0])
    assert by_search(law, stretch) == pytest.approx(width, rel=1e-13)


@every_isotropic
def test_a_folded_membrane_bears_tension_along_its_folds_alone(kind):
    found = material(kind, wrinkling=True)
    law, plain = found.law(THICKNESS), found.elastic_law()
    width = natural_width(plain, 1.2)
    for narrow in (0.8, 0.5, 0.01):
        s11, s22, s12, ratio = plane_response(law, (1.2, 0.0, 0.0, narrow * width))
        assert s22 == pytest.approx(0.0, abs=1e-12 * s11)
        assert s12 == 0.0
        assert THICKNESS * s11 / (1.2 * width) == pytest.approx(stretch_slopes(plain, 1.2, width)[0] / width)
        assert ratio == pytest.approx(1.0 / (1.2 * narrow * width))
    assert plane_response(law, (0.9, 0.0, 0.0, 0.8))[:3] == (0.0, 0.0, 0.0)


def respond(law, F):
    return surface_energy(law, F), surface_tension(law, F), surface_stiffness(law, F)


compiled = kernel()(respond)


@pytest.mark.parametrize("kind", SURFACE_LAWS)
def test_compiled_laws_are_the_plain_ones(kind):
    law, F = material(kind).elastic_law(), tuple(gradient((1.3, 1.1)).ravel())
    plain, fast = respond(law, F), compiled(law, F)
    for one, other in zip(plain, fast, strict=True):
        assert other == pytest.approx(one, rel=1e-12)  # fused multiplications round differently


@every_law
def test_damage_follows_the_largest_logarithmic_strain(sample):
    zona = {"elastic_limit": 0.1, "stiffness_loss": 0.9, "rate": 1.0, "failure_strain": 0.5}
    damaged = type(sample)(**sample.model_dump() | {"damage": zona})
    shape = tuple(gradient((1.3, 0.8)).ravel())
    assert driving_strain(damaged.damage_law(), damaged.law(THICKNESS), shape) == pytest.approx(np.log(1.3), rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "keys", "told"),
    [
        ("skalak-membrane", {"area_coefficient": -0.5}, "area_coefficient\n.*greater than -0.5"),
        ("skalak-membrane", {"area_coefficient": -0.2, "wrinkling": True}, "area_coefficient = -0.2 is below 0"),
        ("holzapfel-gasser-ogden-membrane", {"dispersion": 0.4}, "dispersion\n.*less than or equal to 0.3"),
        ("holzapfel-gasser-ogden-membrane", {"fibre_direction": (0, 0, 0)}, "has no direction; give a vector"),
        ("holzapfel-gasser-ogden-membrane", {"wrinkling": True}, "wrinkling = true cannot be combined with fibres"),
        (
            "ogden-membrane",
            {"exponents": (1.0, -5.0, -2.0)},
            "exponents.1. = -5: their product must be positive",
        ),
        ("ogden-membrane", {"exponents": (1.0, 5.0)}, "shear_moduli has 3 numbers but exponents 2"),
        ("arruda-boyce-membrane", {"links": 0.5}, "links\n.*greater than or equal to 1"),
        ("yeoh-membrane", {"viscosity": 1e-7, "wrinkling": True}, "wrinkling = true cannot be combined with viscosity"),
    ],
)
def test_what_lies_outside_a_law_is_told(kind, keys, told):
    with pytest.raises(ValidationError, match=told):
        material(kind, **keys)
