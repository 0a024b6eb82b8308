"""What every law must do: energy from work, objectivity, honest wave speeds."""

import numpy as np
import pytest
from algebra import matrix, rotation, symmetric, tensor
from samples import MATERIALS, every_inviscid_fluid, every_material, every_solid, fluid, unsampled

from pellucid.materials.energy_update import pressure
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.law import (
    artificial_heating,
    diffusivity,
    dissipated_energy,
    point_pressure,
    signal_speed,
    stored_energy,
    update,
)
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.materials.neo_hookean import NeoHookeanMaterial
from pellucid.tensors import double_dot, symmetric_part

CELL = 0.01
STILL = (0.0,) * 9


def test_every_registered_law_is_tested():
    assert not unsampled(), "add a sample to tests/materials/samples.py"


def stretched(material, gradient, steps=1):
    """State and density after a velocity gradient has acted for unit time."""
    law, state, density = material.law(), material.initial_state(), material.density
    dt = 1.0 / steps
    for _ in range(steps):
        density /= 1.0 + dt * (gradient[0] + gradient[4] + gradient[8])
        state = update(law, state, density, gradient, dt, CELL)
    return state, density


def integrating(material):
    """The material, of which a fluid integrates its energy by itself and does not wait for the work of the grid."""
    return material.model_copy(update={"energy_update": "closed"}) if material.keeps_heat else material


def gradient(seed, size):
    return tensor(size * np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 3)))


def turned(state, Q):
    """The state of the same point seen after a superposed rotation."""
    turns = {
        1: lambda number: number,
        6: lambda s: symmetric(Q @ matrix(s) @ Q.T),
        9: lambda F: tensor(Q @ matrix(F)),  # the deformation gradient: one foot in the reference configuration
    }
    return type(state)(*(turns[np.size(value)](value) for value in state))


@every_material
def test_no_strain_changes_nothing(material):
    law, state = material.law(), material.initial_state()
    after = update(law, state, material.density, STILL, 1e-3, CELL)
    # relative to the largest numbers that cancel in the pressure: of a stiffened gas (Γ+1) P∞ = 1e9 Pa
    scale = material.density * signal_speed(law, state, material.density, STILL, CELL) ** 2
    assert after.stress == pytest.approx(state.stress, abs=1e-15 * scale)


@every_material
@pytest.mark.parametrize("seed", range(3))
def test_superposed_rotations(material, seed):
    Q, L = rotation(seed), gradient(seed, 0.02)
    state, density = stretched(material, gradient(seed + 10, 0.05))
    after = density / (1.0 + L[0] + L[4] + L[8])
    plain = update(material.law(), state, after, L, 1.0, CELL)
    seen = update(material.law(), turned(state, Q), after, tensor(Q @ matrix(L) @ Q.T), 1.0, CELL)
    expected = turned(plain, Q)
    # products of rotations; relative to a modulus, of which the stress may be a small part
    scale = density * signal_speed(material.law(), state, density, STILL, CELL) ** 2
    assert seen.stress == pytest.approx(expected.stress, abs=1e-13 * scale)
    energy = stored_energy(material.law(), plain, after)
    assert stored_energy(material.law(), seen, after) == pytest.approx(energy, rel=1e-11)


@every_material
def test_the_work_of_the_stress_is_stored_or_dissipated(material):
    """de = σ:D dt/ρ, summed with the mean stress of small steps; what is dissipated counts too."""
    material, L, steps = integrating(material), gradient(3, 0.02), 2000
    law, dt = material.law(), 1.0 / steps
    state, density = material.initial_state(), material.density
    start, work = stored_energy(law, state, density), 0.0
    for _ in range(steps):
        before, old = state.stress, density
        density /= 1.0 + dt * (L[0] + L[4] + L[8])
        state = update(law, state, density, L, dt, CELL)
        mean = [0.5 * (a / old + b / density) for a, b in zip(before, state.stress, strict=True)]
        work += dt * double_dot(tuple(mean), symmetric_part(L))
    found = stored_energy(law, state, density) + dissipated_energy(law, state, density) - start
    # the fluids' backward Euler is of first order: 1/2000 of the strain's own share
    assert found == pytest.approx(work, rel=1e-3)


@every_solid
def test_small_strain_is_hookes_law(material):
    E, nu, strain = material.young_modulus, material.poisson_ratio, 1e-6
    pulled = stretched(material, tensor(np.diag([strain, -nu * strain, -nu * strain])))[0].stress
    # first order in strain
    assert pulled == pytest.approx((E * strain, 0, 0, 0, 0, 0), abs=5e-5 * E * strain)
    shear = np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 0.5 * strain
    sheared = stretched(material, tensor(shear))[0].stress
    assert sheared == pytest.approx((0, 0, 0, 0, 0, E / (2 * (1 + nu)) * strain), abs=1e-5 * E * strain)


@every_solid
def test_simple_shear_and_its_transpose_turn_stress_alike(material):
    """A shear is a stretch and a turn: the symmetric and the turned one have the same invariants to the second order."""
    strain = 1e-4
    one = stretched(material, (0.0, strain, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))[0].stress
    other = stretched(material, (0.0, 0.0, 0.0, strain, 0.0, 0.0, 0.0, 0.0, 0.0))[0].stress
    assert one[5] == pytest.approx(other[5], rel=strain)
    assert one[0] == pytest.approx(other[1], abs=strain**3 * material.young_modulus)


def acoustic_speed(material, state, density, n):
    """The fastest plane wave along n, from differences of the first Piola stress about the current state."""
    law, step = material.law(), 1e-6

    def traction(m, e):
        L = np.outer(m, n)
        now = density / (1.0 + e * np.trace(L))
        stress = update(law, state, now, tensor(L), e, CELL).stress
        F = np.eye(3) + e * L
        return np.linalg.det(F) * matrix(stress) @ np.linalg.inv(F).T @ n

    columns = [(traction(m, step) - traction(m, -step)) / (2.0 * step) for m in np.eye(3)]
    return np.sqrt(np.linalg.eigvals(np.array(columns)).real.max() / density)


# not where a viscous stress depends on the step, or fibres make the stress change its slope at rest
SMOOTH = [
    name
    for name, material in MATERIALS.items()
    if not getattr(material, "viscosity", 0.0) and not hasattr(getattr(material, "elastic", material), "fibres")
]


@pytest.mark.parametrize("name", SMOOTH)
def test_signal_speed_at_rest_is_the_acoustic_one(name):
    material = integrating(MATERIALS[name])
    state = material.initial_state()
    speed = acoustic_speed(material, state, material.density, rotation(5)[0])
    # the step, 1e-6, times the curvature that jumps at the initial density of a Mie-Grüneisen liquid
    assert signal_speed(material.law(), state, material.density, STILL, CELL) == pytest.approx(speed, rel=1e-5)


@every_material
def test_the_pressure_that_results_show(material):
    """Of fluids P without viscous and artificial stress, of solids minus the mean stress."""
    law, state = material.law(), material.initial_state()
    squeeze = tensor(np.diag([-50.0, 0.0, 0.0]))
    assert point_pressure(law, state, material.density) == pytest.approx(getattr(material, "pressure", 0.0), abs=1e-6)
    density = material.density / 0.95
    after = update(law, state, density, squeeze, 1e-3, CELL)
    found, mean = point_pressure(law, after, density), -sum(after.stress[:3]) / 3.0
    if isinstance(material, FluidMaterial):
        assert found == pressure(law.eos, density, after.internal_energy)
        # the stress knows the work of the second half of the step too, which the energy of this update lacks
        ahead = after.internal_energy + (0.5e-3 * 50.0 * mean / density if material.keeps_heat else 0.0)
        of_stress = pressure(law.eos, density, ahead)
        assert mean == pytest.approx(of_stress, rel=1e-12) or material in (MATERIALS["viscous"], MATERIALS["shocked"])
        assert found > material.pressure
    else:
        assert found == mean > 0.0


@every_inviscid_fluid
@pytest.mark.parametrize("compression", [0.9, 1.001, 1.3])
def test_sound_speed_is_the_slope_of_the_isentrope(material, compression):
    """c² = dP/dρ at constant entropy, de = P/ρ² dρ."""
    law = material.law()
    density = material.density * compression
    energy = material.initial_state().internal_energy * 1.1
    step = 1e-5 * density
    P = pressure(law.eos, density, energy)
    slope = sum(
        sign * pressure(law.eos, density + sign * step, energy + sign * step * P / density**2) for sign in (1.0, -1.0)
    ) / (2.0 * step)
    state = material.initial_state()._replace(internal_energy=energy)
    # differences: the step squared, 1e-10, and rounding over the step, 1e-11 of numbers some ten times the slope
    assert signal_speed(law, state, density, STILL, CELL) ** 2 == pytest.approx(slope, rel=1e-7)


@every_material
def test_compression_with_artificial_viscosity_only_raises_the_speed(material):
    squeeze = tensor(np.diag([-50.0, 0.0, 0.0]))
    law, state = material.law(), material.initial_state()
    still = signal_speed(law, state, material.density, STILL, CELL)
    fast = signal_speed(law, state, material.density, squeeze, CELL)
    if material is MATERIALS["shocked"]:
        a, Q = still, still + 2.0 * CELL * 50.0
        assert fast == pytest.approx(Q + np.sqrt(Q * Q + a * a))
    else:
        assert fast == still


@every_material
def test_diffusivity_and_heating_are_those_of_viscous_fluids_alone(material):
    law, state = material.law(), material.initial_state()
    mu = getattr(material, "viscosity", 0.0)
    assert diffusivity(law, material.density) == pytest.approx(4.0 / 3.0 * mu / material.density)
    swell = tensor(np.eye(3))
    assert artificial_heating(law, state, material.density, swell, CELL) == 0.0
    heat = artificial_heating(law, state, material.density, tensor(-np.eye(3)), CELL)
    assert heat > 0.0 if material is MATERIALS["shocked"] else heat == 0.0


@pytest.mark.parametrize("steps", [50, 500])
def test_a_quarter_turn_takes_the_stress_along(steps):
    """Stretch, then turn rigidly by 90 degrees in many steps."""
    material = LinearElasticMaterial(density=1.0, young_modulus=1.0, poisson_ratio=0.3)
    law = material.law()
    state = stretched(material, tensor(np.diag([0.01, 0.002, -0.003])))[0]
    energy = stored_energy(law, state, 1.0)
    expected = matrix(state.stress)[[1, 0, 2]][:, [1, 0, 2]]
    spin = (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(steps):
        state = update(law, state, 1.0, spin, 0.5 * np.pi / steps, CELL)
    # the angle of each step is 2 atan(dθ/2): short by dθ³/12, so by (π/2)³/12/steps² in all
    assert matrix(state.stress) == pytest.approx(expected, abs=0.33 / steps**2 * np.abs(expected).max() * 2.0)
    # each step is a rotation to rounding, and a rotation does no work
    assert np.linalg.eigvalsh(matrix(state.stress)) == pytest.approx(np.linalg.eigvalsh(expected), abs=1e-14)
    assert stored_energy(law, state, 1.0) == pytest.approx(energy, rel=1e-12)


def test_a_quarter_turn_of_a_hyperelastic_solid():
    """Steps (Q - I)/dt turn the deformation gradient exactly: its stress follows, its energy stays."""
    material = NeoHookeanMaterial(density=1.0, young_modulus=1.0, poisson_ratio=0.3)
    law = material.law()
    state, density = stretched(material, tensor(np.diag([0.3, 0.1, -0.2])))
    energy = stored_energy(law, state, density)
    expected = matrix(state.stress)[[1, 0, 2]][:, [1, 0, 2]]
    angle = 0.5 * np.pi / 200
    Q = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    for _ in range(200):
        state = update(law, state, density, tensor(Q - np.eye(3)), 1.0, CELL)
    # 200 products, each with its rounding
    assert matrix(state.stress) == pytest.approx(expected, abs=1e-13)
    assert stored_energy(law, state, density) == pytest.approx(energy, rel=1e-12)


def test_second_viscosity():
    shear = (0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    swell = tensor(2.0 * np.eye(3))
    dt = 1e-12  # so short that the pressure stays

    def extra(material, L):
        stress = update(material.law(), material.initial_state(), material.density, L, dt, CELL).stress
        return np.array(stress) + material.pressure * np.array([1, 1, 1, 0, 0, 0])

    stokes, given = fluid(viscosity=5.0), fluid(viscosity=5.0, second_viscosity=7.0)
    # relative to the pressure, 1e5 Pa, and its change within the step
    assert extra(stokes, shear) == pytest.approx([0, 0, 0, 0, 0, 15.0], abs=1e-5)
    assert extra(given, shear) == pytest.approx([0, 0, 0, 0, 0, 15.0], abs=1e-5)
    assert extra(stokes, swell) == pytest.approx([0] * 6, abs=1e-5), "Stokes: no bulk viscosity"
    assert extra(given, swell) == pytest.approx([2 * 5.0 * 2 + 7.0 * 6] * 3 + [0] * 3, abs=1e-5)


def test_a_second_viscosity_that_gives_energy_is_an_error():
    assert fluid(viscosity=3.0, second_viscosity=-2.0).second_viscosity == -2.0  # Stokes' own value may be written out
    with pytest.raises(ValueError, match="below -2/3 viscosity = -2"):
        fluid(viscosity=3.0, second_viscosity=-2.01)
