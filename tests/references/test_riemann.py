"""The exact Riemann solver against published numbers and against the equations it solves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pellucid.references.gas_dynamics import GasState, VacuumError, solve

# Toro, Riemann Solvers and Numerical Methods for Fluid Dynamics, tables 4.1 and 4.2:
# left (rho, u, p), right (rho, u, p), p*, u*, rho*_L, rho*_R
TORO = [
    ((1.0, 0.0, 1.0), (0.125, 0.0, 0.1), 0.30313, 0.92745, 0.42632, 0.26557),
    ((1.0, -2.0, 0.4), (1.0, 2.0, 0.4), 0.00189, 0.00000, 0.02185, 0.02185),
    ((1.0, 0.0, 1000.0), (1.0, 0.0, 0.01), 460.894, 19.5975, 0.57506, 5.99924),
    ((1.0, 0.0, 0.01), (1.0, 0.0, 100.0), 46.0950, -6.19633, 5.99242, 0.57511),
    ((5.99924, 19.5975, 460.894), (5.99242, -6.19633, 46.0950), 1691.64, 8.68975, 14.2823, 31.0426),
]


@pytest.mark.parametrize(("left", "right", "pressure", "velocity", "rho_left", "rho_right"), TORO)
def test_toro_table(left, right, pressure, velocity, rho_left, rho_right):
    solution = solve(GasState(*left), GasState(*right))
    found = (solution.pressure, solution.velocity, solution.left_wave.density, solution.right_wave.density)
    # printed digits: half a unit of the last one (five decimals or six figures)
    for value, printed in zip(found, (pressure, velocity, rho_left, rho_right), strict=True):
        assert value == pytest.approx(printed, abs=max(5.1e-6, 1e-5 * abs(printed)))


def test_tube_of_gan2011():
    solution = solve(GasState(1.0, 0.0, 1.0), GasState(0.125, 0.0, 0.001))
    assert solution.pressure == pytest.approx(0.210858, abs=5e-7)
    assert solution.velocity == pytest.approx(1.179541, abs=5e-7)
    assert solution.left_wave.density == pytest.approx(0.328954, abs=5e-7)
    assert solution.right_wave.density == pytest.approx(0.729825, abs=5e-7)
    at = 0.143
    assert 0.5 + solution.right_wave.head * at == pytest.approx(0.70353, abs=5e-6)
    assert 0.5 + solution.velocity * at == pytest.approx(0.66867, abs=5e-6)
    head, tail = solution.left_wave[:2]
    assert (0.5 + head * at, 0.5 + tail * at) == pytest.approx((0.33080, 0.53321), abs=5e-6)
    mach = solution.right_wave.head / solution.right.sound_speed
    assert mach == pytest.approx(13.4, abs=0.1)  # "a Mach-13 shock"


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (GasState(1.0, -4.0, 0.4), GasState(1.0, 4.0, 0.4)),
        (GasState(1.0, 0.0, 1.0, gamma=5 / 3), GasState(1.0, 6.0, 0.1, gamma=1.1 + 2.0)),
    ],
)
def test_vacuum_is_an_error(left, right):
    with pytest.raises(VacuumError, match="vacuum"):
        solve(left, right)


def test_empty_state_and_bad_gamma_are_errors():
    with pytest.raises(VacuumError, match="positive"):
        GasState(0.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="gamma"):
        GasState(1.0, 0.0, 1.0, gamma=1.0)


states = st.builds(
    GasState,
    density=st.floats(1e-2, 1e2),
    velocity=st.floats(-2.0, 2.0),
    pressure=st.floats(1e-3, 1e3),
    gamma=st.floats(1.05, 3.0),
)


def jumps(state, behind, speed):
    """Relative residuals of the Rankine-Hugoniot conditions (mass, momentum, energy) across a front."""

    def fluxes(gas):
        w = gas.velocity - speed
        energy = gas.gamma / (gas.gamma - 1.0) * gas.pressure / gas.density + 0.5 * w**2
        return np.array([gas.density * w, gas.density * w**2 + gas.pressure, gas.density * w * energy])

    ahead = fluxes(state)
    return np.abs(fluxes(behind) - ahead) / np.abs(ahead)


@given(states, states)
def test_waves_satisfy_their_conditions(left, right):
    try:
        solution = solve(left, right)
    except VacuumError:
        return
    star = {
        "left": GasState(solution.left_wave.density, solution.velocity, solution.pressure, left.gamma),
        "right": GasState(solution.right_wave.density, solution.velocity, solution.pressure, right.gamma),
    }
    for side, gas, speeds, sign in (
        ("left", left, solution.left_wave[:2], 1.0),
        ("right", right, solution.right_wave[:2], -1.0),
    ):
        behind = star[side]
        if solution.pressure > gas.pressure * (1 + 1e-6):
            assert speeds[0] == speeds[1]
            assert np.all(jumps(gas, behind, speeds[0]) < 1e-8)
            assert behind.density > gas.density  # the second law: a shock compresses
        elif solution.pressure < gas.pressure:
            entropy = behind.pressure / behind.density**gas.gamma
            assert entropy == pytest.approx(gas.pressure / gas.density**gas.gamma, rel=1e-9)
            invariants = [g.velocity + sign * 2 * g.sound_speed / (g.gamma - 1) for g in (gas, behind)]
            scale = abs(gas.velocity) + 2 * gas.sound_speed / (gas.gamma - 1)
            assert invariants[0] == pytest.approx(invariants[1], abs=1e-9 * scale)


@given(states, states)
def test_mirror_image(left, right):
    try:
        solution = solve(left, right)
    except VacuumError:
        return
    image = solve(right.mirrored(), left.mirrored())
    speeds = np.linspace(-3.0, 3.0, 50)
    # keep off the contact, where the two sides of the sample belong to different gases
    speeds = speeds[np.abs(speeds - solution.velocity) > 1e-6]
    there, here = image.sample(-speeds), solution.sample(speeds)
    close = {"rtol": 1e-6, "atol": 1e-6}
    fronts = np.array([*solution.left_wave[:2], *solution.right_wave[:2]])
    away = np.min(np.abs(speeds[:, None] - fronts), axis=1) > 1e-6
    assert np.allclose(here["density"][away], there["density"][away], **close)
    assert np.allclose(here["velocity"][away], -there["velocity"][away], **close)


def test_sample_is_continuous_through_a_fan_and_keeps_the_shape():
    solution = solve(GasState(1.0, 0.0, 1.0), GasState(0.125, 0.0, 0.001))
    head, tail = solution.left_wave[:2]
    for edge in (head, tail):
        below, above = solution.sample([edge - 1e-9, edge + 1e-9])["density"]
        assert below == pytest.approx(above, abs=1e-7)
    assert solution.sample(np.zeros((3, 2)))["pressure"].shape == (3, 2)
    energy = solution.sample([-2.0, 2.0])["internal_energy"]
    assert energy == pytest.approx([2.5, 0.02])


def test_no_jump_gives_no_wave():
    gas = GasState(1.2, 3.0, 1e5)
    fields = solve(gas, gas).sample(np.linspace(-500, 500, 11))
    assert np.allclose(fields["density"], 1.2, rtol=1e-12)
    assert np.allclose(fields["velocity"], 3.0, rtol=1e-9)
