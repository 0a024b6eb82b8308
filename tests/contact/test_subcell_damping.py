"""What contact takes of the velocities of membrane nodes against the mean about them."""

import numpy as np
import pytest
from elements import body_of, element_sheet, supported, wall

from pellucid.energy import CONTACT, SUPPORT

ALONG, ACROSS = np.array((0.0, 0.6, -0.8)), np.array(((1.0, 0.0, 0.0), (0.0, 0.8, 0.6)))


def pressed(body, velocity, push, dt=1e-9):
    """Velocities after a step in which contact changes those on the grid by `push` [m/s], shape (3,)."""
    body.arrays["velocity"][:] = velocity
    body.renew_totals()
    momentum, energy = body.totals.momentum, body.totals.kinetic
    body.grid.nodes.velocity_increment[:], body.velocity_field.pressed = push, True
    body.begin(dt)
    body.predict(dt)
    body.correct(remap=True)
    done = body.work()
    given = body.mass * push
    rounding = 1e-12 + 1e-15 * np.abs(given).max()  # of a sum over 49 nodes
    assert body.totals.momentum - momentum == pytest.approx(given + done.reactions.sum(axis=0), abs=rounding)
    assert body.totals.kinetic - energy == pytest.approx(done.works[CONTACT] + done.works[SUPPORT], rel=1e-12, abs=1e-12)
    return body.arrays["velocity"].copy()


def held_at_the_rim(body):
    body.add_supports([supported(np.arange(49) < 7, "xyz", (0.3, 0.2, -0.5))])
    return body


def test_along_the_impulse_nodes_near_the_mean_velocity_about_them_and_momentum_stays():
    """A push so hard that all strike; elements of 0.17 m in cells of 0.25 m, so what is left varies from cell to cell."""
    body, before = body_of(element_sheet()), np.random.default_rng(4).normal(size=(49, 3))
    after = pressed(body, before, 1000.0 * ALONG) - 1000.0 * ALONG
    assert np.abs((after - before) @ ACROSS.T).max() < 1e-12
    assert np.std(after @ ALONG) < 0.6 * np.std(before @ ALONG)


def test_nodes_that_are_held_keep_their_velocity_and_what_holds_them_takes_the_impulse():
    body, before = held_at_the_rim(body_of(element_sheet())), np.random.default_rng(4).normal(size=(49, 3))
    after = pressed(body, before, 0.5 * ALONG)
    assert np.array_equal(after[:7], np.tile((0.3, 0.2, -0.5), (7, 1)))
    change = after[7:] - before[7:] - 0.5 * ALONG
    assert np.abs(change @ ACROSS.T).max() < 1e-13
    assert np.abs(change @ ALONG).max() > 0.1


@pytest.mark.parametrize("speed", [0.0, -0.2])
def test_nodes_do_not_settle_through_a_wall(speed):
    """A sheet flies edge on into the lower x face of the grid, 1 nm away, which has a velocity or none; the others fly on."""
    body, before = body_of(element_sheet(), lower=(-0.49 - 1e-9, -2.0, -2.0)), np.tile((-1.0, 0.0, 0.0), (49, 1))
    body.add_supports([wall(body, 0, 0, (speed, 0.0, 0.0))])
    after = pressed(body, before, np.array((-0.5, 0.0, 0.0)), dt=1e-3)[:, 0]
    stopped = np.abs(after - max(speed, -1e-6)) < 1e-9
    assert stopped.sum() == 7
    assert after[~stopped].max() < -1.0
    assert not body.work().reactions[1:].any()


def test_uniform_motion_and_motion_without_contact_are_left_as_they_are():
    body, uniform = body_of(element_sheet()), np.tile((1.0, 2.0, 3.0), (49, 1))
    assert pressed(body, uniform, 5.0 * ALONG) == pytest.approx(uniform + 5.0 * ALONG, abs=1e-13)
    before = np.random.default_rng(4).normal(size=(49, 3))
    assert np.array_equal(pressed(body, before, 0.0 * ALONG), before)


def test_energy_is_never_given():
    body, generator = body_of(element_sheet()), np.random.default_rng(5)
    for push in 10.0 ** np.arange(-4.0, 4.0):
        before = generator.normal(size=(49, 3))
        after = pressed(body, before, push * ALONG) - push * ALONG
        assert np.sum(after**2) < np.sum(before**2)


@pytest.mark.parametrize("push", [1e-3, 0.5, 20.0])
def test_what_is_taken_is_the_energy_of_the_share_that_strikes(push):
    """All nodes lie at one node of the grid, whose other axes are thin: its mean is theirs."""
    body = body_of(element_sheet(), counts=(1, 1, 16), cell=1.5, lower=(-0.75, -0.75, -12.0))
    before = np.zeros((49, 3))
    before[:, 2] = np.random.default_rng(6).normal(size=49)
    mass = body.arrays["mass"]
    mean = np.average(before[:, 2], weights=mass)
    spread = np.average((before[:, 2] - mean) ** 2, weights=mass)
    after = pressed(body, before, np.array((0.0, 0.0, -push)))[:, 2] - (mean - push)
    assert np.average(after, weights=mass) == pytest.approx(0.0, abs=1e-14)
    strikes = push / (push + np.sqrt(spread))
    assert np.average(after**2, weights=mass) == pytest.approx((1.0 - strikes) * spread, rel=1e-12)
