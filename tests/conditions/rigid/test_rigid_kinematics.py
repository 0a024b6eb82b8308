"""What forces do to a rigid body at the places where they act, and how it turns by itself."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pellucid.conditions.rigid.kinematics import RigidState, inertia_of, inverse_inertia, rotation_by, turn_freely


def rod(turns=(0, 1, 2), free=(1.0, 1.0, 1.0)):
    """Of 3 kg and 2 m, along x: eleven points."""
    arm = np.stack([np.linspace(-1.0, 1.0, 11), np.zeros(11), np.zeros(11)], axis=1)
    mass = np.full((11, 1), 3.0 / 11)
    return RigidState(
        np.zeros(3), np.array([0, 0, 2.0]), np.array(free) / 3.0, inverse_inertia(inertia_of(mass, arm), list(turns))
    ), arm


@pytest.mark.parametrize(
    ("turns", "free", "answer"),
    [
        ((0, 1, 2), (1, 1, 1), 1.0 / 3.0 + 1.0 / 1.2),
        ((), (1, 1, 1), 1.0 / 3.0),
        ((2,), (1, 0, 1), 1.0 / 1.2),
        ((), (0, 0, 0), 0.0),
    ],
)
def test_a_force_at_the_end_of_a_rod(turns, free, answer):
    """1/m + r²/I, of what is free; its inertia is 3 kg times the mean square of the places of its points, 0.4 m²."""
    body, arm = rod(turns, free)
    assert body.mobility_along(arm[-1:], np.array([[0.0, 1.0, 0.0]])) == pytest.approx(answer)
    assert body.mobility_along(arm[-1:], np.array([[0.0, 2.0, 0.0]])) == pytest.approx(4.0 * answer)


def test_forces_shared_out_evenly_do_not_turn_it():
    body, arm = rod()
    assert body.mobility_along(arm, np.tile([0.0, 1.0 / 11, 0.0], (11, 1))) == pytest.approx(1.0 / 3.0)


def test_velocities_of_its_rotation():
    body, arm = rod()
    assert body.turning(arm[-1:]) == pytest.approx(np.array([[0.0, 2.0, 0.0]]))


def free_rotation(inertia, turn, times):
    """Angular velocities in space of a free body by Euler's equations, and where its axes are, at these times."""

    def rates(_, state):
        w, axes = state[:3], state[3:].reshape(3, 3)
        return np.concatenate([np.linalg.solve(inertia, np.cross(inertia @ w, w)), (axes @ np.cross(w, np.eye(3)).T).ravel()])

    start = np.concatenate([turn, np.eye(3).ravel()])
    states = solve_ivp(rates, (0.0, times[-1]), start, t_eval=times, rtol=1e-11, atol=1e-13).y.T
    axes = states[:, 3:].reshape(-1, 3, 3)
    return np.einsum("tij,tj->ti", axes, states[:, :3]), axes


@pytest.mark.parametrize("dt", [0.1, 0.02])
@pytest.mark.parametrize("turn", [(0.05, 3.0, 0.0), (0.3, 0.2, -2.0), (1.0, -1.0, 0.5)])
def test_a_free_body_turns_by_eulers_equations(turn, dt):
    """About its middle axis it turns over; the reference is integrated to 1e-11. Energy to some 1e-10 for each radian."""
    body, turn, rotation = np.diag([1.36, 1.04, 0.4]), np.array(turn), np.eye(3)
    spin = body @ turn
    exact, axes = free_rotation(body, turn, dt * np.arange(1, round(6.0 / dt) + 1))
    for at_time in exact:
        now = rotation @ body @ rotation.T
        turned = turn_freely(lambda more, now=now: np.linalg.solve(more @ now @ more.T, spin), dt)
        rotation = turned.rotation @ rotation
        assert turned.velocity == pytest.approx(at_time, abs=1e-6)
    assert rotation == pytest.approx(axes[-1], abs=1e-6)
    assert turned.velocity @ spin == pytest.approx(turn @ spin, rel=5e-9)


def test_a_constant_angular_velocity_turns_exactly():
    turned = turn_freely(lambda _: np.array([0.0, 0.6, 0.8]), 2.5)
    assert turned.rotation == pytest.approx(rotation_by(2.5 * np.array([0.0, 0.6, 0.8])), abs=1e-14)
    assert turned.angle == pytest.approx((0.0, 1.5, 2.0), abs=1e-14)
