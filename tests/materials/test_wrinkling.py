"""Tension fields of every membrane law: no compression, the derivative of the relaxed energy, the same in every frame."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import minimize, minimize_scalar

from pellucid.jit import kernel
from pellucid.materials.law import energy
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.membrane import (
    initial_shape,
    largest_strain,
    plane_response,
    plane_wave_speed,
    shape_of,
    smoothed,
    stretched,
)
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial

E, NU, RHO = 2.0, 0.3, 1.0
ELASTIC = {"density": RHO, "young_modulus": E, "poisson_ratio": NU}
MU = E / (2.0 * (1.0 + NU))
LAM = 2.0 * MU * NU / (1.0 - 2.0 * NU)
MATERIALS = {
    "linear": LinearMembraneMaterial(**ELASTIC, wrinkling=True),
    "neo-hookean": NeoHookeanMembraneMaterial(**ELASTIC, wrinkling=True),
    "auxetic": NeoHookeanMembraneMaterial(**ELASTIC | {"poisson_ratio": -0.3}, wrinkling=True),
    "nearly incompressible": NeoHookeanMembraneMaterial(**ELASTIC | {"poisson_ratio": 0.49}, wrinkling=True),
}
every_material = pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
LINEAR, NEO = MATERIALS["linear"].law(1.0), MATERIALS["neo-hookean"].law(1.0)

TAUT, WRINKLED, SLACK = (0.05, 0.02), (0.05, -0.04), (-0.01, -0.05)
STATES = {"taut": TAUT, "wrinkled": WRINKLED, "slack": SLACK}
every_state = pytest.mark.parametrize("principal", STATES.values(), ids=STATES)


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def in_plane(response):
    """The stress of a response as a matrix."""
    return np.array([[response[0], response[2]], [response[2], response[1]]])


def strained(law, principal, angle=0.0):
    """The shape with these principal logarithmic strains, turned by an angle."""
    if initial_shape(law) == (0.0, 0.0, 0.0, 0.0):
        e = turn(angle) @ np.diag(principal) @ turn(angle).T
        return (e[0, 0], e[1, 1], e[0, 1], 0.0)
    return tuple((turn(angle) @ np.diag(np.exp(principal)) @ turn(angle).T).ravel())


def strain_of(shape):
    return np.array([[shape[0], shape[2]], [shape[2], shape[1]]])


def natural_width(material, strain):
    """The natural width stretch of a strip at a logarithmic strain, by bisection on the lateral stress of the plain law."""
    law = material.elastic_law()
    low, high = -1.0, 1.0
    if material is MATERIALS["linear"]:
        return np.exp(-NU * strain)
    for _ in range(100):
        middle = 0.5 * (low + high)
        lateral = plane_response(law, (np.exp(strain), 0.0, 0.0, np.exp(middle)))[1]
        low, high = (low, middle) if lateral > 0.0 else (middle, high)
    return np.exp(middle)


@every_material
def test_what_bears_tension_alone_is_not_changed(material):
    shape = strained(material.law(1.0), TAUT, 0.4)
    assert plane_response(material.law(1.0), shape) == plane_response(material.elastic_law(), shape)
    assert plane_wave_speed(material.law(1.0), shape, RHO) == plane_wave_speed(material.elastic_law(), shape, RHO)


@every_material
@pytest.mark.parametrize("seed", range(30))
def test_there_is_never_compression_and_the_stress_is_turned_with_the_frame(material, seed):
    numbers = np.random.default_rng(seed)
    shape = strained(material.law(1.0), numbers.uniform(-0.3, 0.3, 2))
    angle = numbers.uniform(-np.pi, np.pi)
    found = plane_response(material.law(1.0), shape)
    # the natural width is found to 1e-14
    assert np.linalg.eigvalsh(in_plane(found)).min() > -1e-12 * E
    assert found[3] > 0.0
    if material is MATERIALS["linear"]:
        e = turn(angle) @ strain_of(shape) @ turn(angle).T
        seen = (e[0, 0], e[1, 1], e[0, 1], 0.0)
    else:
        seen = tuple((turn(angle) @ np.reshape(shape, (2, 2))).ravel())
    after = plane_response(material.law(1.0), seen)
    assert in_plane(after) == pytest.approx(turn(angle) @ in_plane(found) @ turn(angle).T, abs=1e-12 * E)
    assert after[3] == pytest.approx(found[3], rel=1e-12)


@every_material
def test_a_wrinkled_strip_is_under_uniaxial_tension(material):
    """The stress of a strip free to contract, whatever the width it is squeezed to."""
    free = plane_response(material.elastic_law(), strained(material.law(1.0), (0.05, np.log(natural_width(material, 0.05)))))
    narrow = plane_response(material.law(1.0), strained(material.law(1.0), (0.05, -0.6)))
    assert narrow[:3] == pytest.approx(free[:3], rel=1e-12, abs=1e-12 * E)
    # log strains and Cauchy stress of a neo-Hookean strip agree with Hooke's law to the order of the strain
    assert narrow[0] == pytest.approx(E * 0.05, rel=1e-12 if material is MATERIALS["linear"] else 0.1)
    assert narrow[1:3] == pytest.approx((0.0, 0.0), abs=1e-12 * E)


@every_material
def test_a_slack_membrane_has_no_stress_and_the_volume_it_began_with(material):
    found = plane_response(material.law(1.0), strained(material.law(1.0), SLACK, 0.7))
    assert found[:3] == (0.0, 0.0, 0.0)
    assert found[3] * np.exp(sum(SLACK)) == pytest.approx(1.0, rel=1e-13)


@every_material
@pytest.mark.parametrize(("major", "direction"), [(0.05, 1), (0.0, 0)], ids=["taut to wrinkled", "wrinkled to slack"])
def test_nothing_jumps_between_the_states(material, major, direction):
    """On either side of the boundary: stress and thickness differ by the order of the distance."""
    law, small = material.law(1.0), 1e-7
    natural = np.log(natural_width(material, major)) if direction else -0.02
    sides = []
    for side in (-small, small):
        principal = [major, natural]
        principal[direction] += side
        sides.append(np.array(plane_response(law, strained(law, principal, 0.3))))
    assert sides[0] == pytest.approx(sides[1], abs=20.0 * E * small)


def neo_hookean_energy(one, two):
    """Strain energy per initial volume of a taut membrane of two principal stretches, its thickness free."""

    def energy(log_thickness):
        third = np.exp(log_thickness)
        log_J = np.log(one * two * third)
        return 0.5 * MU * (one**2 + two**2 + third**2 - 3.0) - MU * log_J + 0.5 * LAM * log_J**2

    return minimize_scalar(energy, bracket=(-0.3, 0.3), tol=1e-12).fun


def relaxed(energy, one, two):
    """The least energy of all principal values at least as large: Pipkin's relaxed energy."""
    start = np.maximum((one, two), (1.0, 1.0) if energy is neo_hookean_energy else (0.0, 0.0)) + 0.01
    found = minimize(lambda p: energy(*p), start, bounds=[(one, None), (two, None)], options={"ftol": 1e-15, "gtol": 1e-10})
    return found.fun


def in_plane_derivative(function, F, step):
    """∂W/∂F by central differences."""
    P = np.zeros((2, 2))
    for i, j in np.ndindex(2, 2):
        dF = np.zeros((2, 2))
        dF[i, j] = step
        P[i, j] = (function(F + dF) - function(F - dF)) / (2.0 * step)
    return P


@every_state
@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_neo_hookean_stress_is_the_derivative_of_the_relaxed_energy(principal, angle):
    """P = ∂W/∂F by central differences, with the stress times the volume that the law gives."""
    F = turn(angle) @ np.diag(np.exp(principal)) @ turn(0.2) * 1.02
    P = in_plane_derivative(lambda F: relaxed(neo_hookean_energy, *np.linalg.svd(F, compute_uv=False)), F, 1e-4)
    response = plane_response(NEO, tuple(F.ravel()))
    volume = response[3] * np.linalg.det(F)
    # differences: the step squared; the minimum is found to 1e-11 or so, over the step
    assert volume * in_plane(response) @ np.linalg.inv(F).T == pytest.approx(P, abs=1e-6)


@every_state
def test_the_energy_of_the_law_is_the_relaxed_one(principal):
    """By a search of the least energy; taut, that of the plain law, which is least over the thickness alone."""
    F = turn(0.5) @ np.diag(np.exp(principal)) @ turn(0.2)
    stretches = np.linalg.svd(F, compute_uv=False)
    # the search ends at 1e-11 or so
    assert energy(NEO, tuple(F.ravel())) == pytest.approx(relaxed(neo_hookean_energy, *stretches), abs=1e-10)
    plain = MATERIALS["neo-hookean"].elastic_law()
    assert energy(plain, tuple(F.ravel())) == pytest.approx(neo_hookean_energy(*stretches), abs=1e-10)
    assert energy(NEO, tuple(F.ravel())) <= energy(plain, tuple(F.ravel()))


@pytest.mark.parametrize("name", ["neo-hookean", "auxetic", "nearly incompressible"])
@pytest.mark.parametrize("relax", [False, True], ids=["plain", "tension field"])
@every_state
def test_stress_is_the_derivative_of_the_energy_of_the_law(name, relax, principal):
    """P = ∂W/∂F of membranes with a potential, and W(QF) = W(F)."""
    law = MATERIALS[name].law(1.0) if relax else MATERIALS[name].elastic_law()
    F = turn(0.3) @ np.diag(np.exp(principal)) @ turn(0.2)
    P = in_plane_derivative(lambda F: energy(law, tuple(F.ravel())), F, 1e-5)
    response = plane_response(law, tuple(F.ravel()))
    volume = response[3] * np.linalg.det(F)
    # differences: step² = 1e-10 times third derivatives, as large as λ = 50 E at ν = 0.49
    assert volume * in_plane(response) @ np.linalg.inv(F).T == pytest.approx(P, abs=1e-7 * E)
    assert energy(law, tuple((turn(1.0) @ F).ravel())) == pytest.approx(energy(law, tuple(F.ravel())), abs=1e-13 * E)


def linear_energy(one, two):
    return 0.5 * E / (1.0 - NU**2) * (one**2 + two**2 + 2.0 * NU * one * two)


@every_state
@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_linear_stress_is_the_derivative_of_the_relaxed_energy(principal, angle):
    e = turn(angle) @ np.diag(principal) @ turn(angle).T

    def least(e):
        return relaxed(linear_energy, *np.linalg.eigvalsh(e)[::-1])

    step, found = 1e-4, np.zeros((2, 2))
    for i, j in ((0, 0), (1, 1), (0, 1)):
        de = np.zeros((2, 2))
        de[i, j] = step
        de = 0.5 * (de + de.T)
        found[i, j] = found[j, i] = (least(e + de) - least(e - de)) / (2.0 * step)
    response = plane_response(LINEAR, (e[0, 0], e[1, 1], e[0, 1], 0.0))
    # quadratic pieces; the minimum is found to 1e-11 or so, over the step
    assert in_plane(response) == pytest.approx(found, abs=1e-6)


def test_a_closed_path_gives_its_work_back():
    """From rest through all three states and back: ∮ V σ:D dt = 0 for the relaxed energy of a neo-Hookean membrane."""
    law, dt, steps = NEO, 1e-4, 20_000
    time = dt * np.arange(steps + 1)
    one, two = 0.2 * np.sin(2.0 * np.pi * time / time[-1]), 0.15 * np.sin(4.0 * np.pi * time / time[-1])
    old = np.zeros(2)
    work, most, states = 0.0, 0.0, set()
    for k in range(1, steps + 1):
        response = plane_response(law, (np.exp(one[k]), 0.0, 0.0, np.exp(two[k])))
        new = np.array(response[:2]) * response[3] * np.exp(one[k] + two[k])
        work += 0.5 * (old + new) @ (one[k] - one[k - 1], two[k] - two[k - 1])
        most, old = max(most, work), new
        states.add(tuple(new > 0.0))
    assert states == {(True, True), (True, False), (False, True), (False, False)}
    # the trapezoidal rule over corners of the stress: the step squared
    assert abs(work) < 1e-6 * most


def wave_bound(material, principal):
    return plane_wave_speed(material.law(1.0), strained(material.law(1.0), principal), RHO)


@every_material
def test_waves_of_a_folded_membrane_are_those_of_its_material(material):
    """Folding to a twentieth of the width does not stiffen: as fast as the strip at its natural width."""
    natural = np.log(natural_width(material, 0.1))
    assert wave_bound(material, (0.1, -3.0)) == pytest.approx(wave_bound(material, (0.1, natural)), rel=1e-12)


@every_material
@every_state
def test_the_shape_of_two_stretches(material, principal):
    """Along the directions of a tensor whose own principal values do not count."""
    R = turn(0.4)
    axes = R @ np.diag((7.0, -2.0)) @ R.T
    for law in (material.law(1.0), material.elastic_law()):
        shape = shape_of(law, (axes[0, 0], axes[1, 1], axes[0, 1]), *np.exp(principal))
        assert shape == pytest.approx(strained(law, principal, 0.4), abs=1e-14)


@every_material
@pytest.mark.parametrize(("principal", "kept"), [(TAUT, 2), (WRINKLED, 1), (SLACK, 0)], ids=STATES)
def test_stretches_with_their_wrinkles_smoothed_out(material, principal, kept):
    """Taut they stay, wrinkled the width is the natural one, slack both are as at rest; without wrinkles both stay."""
    stretches, axes = tuple(np.exp(principal)), (1.0, -1.0, 0.0)
    smooth = stretches if kept == 2 else (stretches[0], natural_width(material, principal[0])) if kept else (1.0, 1.0)
    for law, expected in ((material.law(1.0), pytest.approx(smooth, rel=1e-12)), (material.elastic_law(), stretches)):
        assert smoothed(law, shape_of(law, axes, *stretches), *stretches) == expected


def test_the_largest_strain_does_not_depend_on_wrinkles():
    shape = strained(NEO, WRINKLED, 0.3)
    assert largest_strain(NEO, shape) == pytest.approx(0.05, rel=1e-12)


def respond(law, shape, D, dt):
    after, axes = stretched(law, shape, D, dt), (0.3, -0.1, 0.2)
    whole = shape_of(law, axes, 1.05, 0.9)
    return after, plane_response(law, after), plane_wave_speed(law, after, 1.0), largest_strain(law, after), whole


compiled = kernel()(respond)


@every_material
@every_state
def test_compiled_tension_fields_are_the_plain_ones(material, principal):
    arguments = material.law(1.0), strained(material.law(1.0), principal, 0.3), (0.1, -0.2, 0.05), 0.01
    plain, fast = respond(*arguments), compiled(*arguments)
    for one, other in zip(plain, fast, strict=True):
        # fused multiplications round differently
        assert other == pytest.approx(one, rel=1e-12, abs=1e-13)


def test_a_damaged_membrane_does_not_wrinkle():
    zona = {"elastic_limit": 0.05, "stiffness_loss": 10.0, "rate": 10.0, "failure_strain": 0.06}
    with pytest.raises(ValidationError, match="wrinkling = true cannot be combined with damage"):
        LinearMembraneMaterial(**ELASTIC, wrinkling=True, damage=zona)
