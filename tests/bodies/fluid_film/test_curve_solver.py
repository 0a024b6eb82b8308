"""Velocities of curves beside dense systems that are put together element by element."""

import numpy as np
import pytest

from pellucid.bodies.fluid_film.assembly import ElementRows
from pellucid.bodies.fluid_film.solvers import Border, CurveSolver, System

N, D = 8, 2
NODES = (np.arange(N)[:, None] + np.arange(4)) % N  # each element has four nodes of the ring


def squares(random):
    return [ElementRows(random.normal(size=(N, 3, 4 * D)), random.uniform(0.5, 2.0, (N, 3))) for _ in range(2)]


def dense(rows):
    whole = np.zeros((N * D, N * D))
    for square in rows:
        for nodes, factors, of_element in zip(NODES, square.factor, square.rows, strict=True):
            for factor, row in zip(factors, of_element, strict=True):
                spread = np.zeros((N, D))
                spread[nodes] = row.reshape(-1, D)
                whole += factor * np.outer(spread.ravel(), spread.ravel())
    return whole


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("bordered", [0, 2])
def test_velocities_and_border_forces_are_those_of_the_dense_system(bordered, turns):
    random = np.random.default_rng(3)
    resistance, stiffness = squares(random), squares(random)[:1]
    held, known = np.zeros((N, D), bool), np.zeros((N, D), bool)
    held[0, 0], known[3] = True, True
    force, guess, velocity = (random.normal(size=(N, D)) for _ in range(3))
    turning = squares(random) if turns else None  # all motions meet a resistance: it changes nothing
    system = System(None, None, resistance, stiffness, force, force, guess, known, velocity, turning, 1e-11)
    borders = [Border(random.normal(size=(N, D)), rate) for rate in (0.3, -0.7)[:bordered]]
    found = CurveSolver(NODES, held).solve(system, borders)

    whole, prescribed = dense(resistance) + dense(stiffness), (held | known).ravel()
    rows = np.array([border.row.ravel() for border in borders]).reshape(bordered, N * D)
    rest = (found.velocity - guess).ravel()
    left = force.ravel() - dense(resistance) @ found.velocity.ravel() - dense(stiffness) @ rest
    pushed = rows.T @ np.array(found.border_forces)
    assert (left + pushed)[~prescribed] == pytest.approx(0.0, abs=1e-11 * np.abs(whole).max())
    assert rows @ found.velocity.ravel() == pytest.approx([border.rate for border in borders], abs=1e-12)
    assert np.array_equal(found.velocity[3], velocity[3])
    assert found.velocity[0, 0] == 0.0
