"""What forces do to a rigid body at the places where they act."""

import numpy as np
import pytest

from pellucid.conditions.rigid.kinematics import RigidState, inverse_inertia


def rod(turns=(0, 1, 2), free=(1.0, 1.0, 1.0)):
    """Of 3 kg and 2 m, along x: eleven points."""
    arm = np.stack([np.linspace(-1.0, 1.0, 11), np.zeros(11), np.zeros(11)], axis=1)
    mass = np.full((11, 1), 3.0 / 11)
    return RigidState(np.zeros(3), np.array([0, 0, 2.0]), np.array(free) / 3.0, inverse_inertia(mass, arm, list(turns))), arm


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
