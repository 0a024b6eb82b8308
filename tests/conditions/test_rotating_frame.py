"""Coriolis and centrifugal forces: a free body moves on a straight line as seen from outside of the frame."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, box, case

from pellucid import CaseError
from pellucid.simulation.simulation import Simulation

TURN, SPEED = 0.5, np.array([0.4, 0.1, 0.0])
STIFF = RATE_SOLID | {"young_modulus": 1e5}


def seen_from_the_frame(place, centre, time):
    """Return positions of the frame for positions outside of it."""
    c, s = np.cos(-TURN * time), np.sin(-TURN * time)
    return centre + np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ (place - centre)


def flight(step, counts=(24, 24, 1), cell=0.25, end=1.6):
    """Return the error of the centre of mass at the end [m], shape (3,), and the simulation."""
    frame = {"angular_velocity": (0, 0, TURN), "centre": (3.0, 3.0, 0.0)}
    start, centre = np.array([2.0, 3.5, 0.125]), np.array([3.0, 3.0, 0.125])
    drift = SPEED - TURN * np.cross([0, 0, 1], start - centre)  # at rest outside but for SPEED
    block = box((1.5, 3.0, 0), (2.5, 4.0, 0.25), STIFF) | {"velocity": tuple(drift), "angular_velocity": (0, 0, -TURN)}
    how = {"functions": "quadratic-bspline", "transfer": "apic", "step": step, "end": end}
    sim = Simulation(case(block, counts=counts, cell=cell, rotating_frame=[frame], **how))
    for _ in sim:
        pass
    body = sim.bodies[0]
    mass, place = body.field("mass"), body.field("position")
    found = np.sum(mass[:, None] * place, axis=0) / mass.sum()
    return found - seen_from_the_frame(start + SPEED * end, centre, end), sim


def test_a_free_body_moves_straight_ahead_and_the_energy_balance_closes():
    """Over 0.8 rad. Velocities are half a step behind the positions, so the initial velocity has an error of the first order
    in the step, which extrapolation from two steps removes."""
    coarse, _ = flight(8e-3)
    fine, sim = flight(4e-3)
    assert np.linalg.norm(fine) < 0.55 * np.linalg.norm(coarse)
    assert np.linalg.norm(2.0 * fine - coarse) < 0.02 * np.linalg.norm(fine)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3
    assert abs(sim.budget.energies()["rotating_frame_work"]) > 1e-3


def test_the_coriolis_force_does_no_work():
    """At the axis, where the centrifugal force is small, a body that moves keeps its energy for any angular velocity."""
    frame = {"angular_velocity": (0, 0, 50.0), "centre": (3.0, 3.0, 0.0)}
    block = box((2.75, 2.75, 0), (3.25, 3.25, 0.25), STIFF) | {"velocity": (1e-6, 0, 0)}
    sim = Simulation(case(block, counts=(24, 24, 1), cell=0.25, step=1e-4, end=1e-4, rotating_frame=[frame]))
    sim.step()
    work = sim.budget.energies()["rotating_frame_work"]
    assert abs(work - 0.0) < 0.5 * sim.bodies[0].mass * (50.0**2 * 0.25 * 1e-4) ** 2


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ([{"angular_velocity": (1.0, 0, 0)}], "rotates about x, but the grid is one cell thick along z"),
        ([{"angular_velocity": (0, 0, 1.0)}] * 2, "only one frame"),
        ([{"centre": (0, 0, 0)}], "angular_velocity"),
    ],
)
def test_mistakes_are_named(frame, words):
    block = box((1.5, 3.0, 0), (2.5, 4.0, 0.25))
    with pytest.raises((CaseError, ValueError), match=words):
        case(block, counts=(24, 24, 1), cell=0.25, rotating_frame=frame)
