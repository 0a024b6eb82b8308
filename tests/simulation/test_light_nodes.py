"""Nodes with little mass must not throw the points that reach them."""

import pytest
from small_cases import SOLID, advance, box, simulation

from pellucid.errors import RunStopped
from pellucid.simulation import light_nodes as module

STEPS = 600


def stretched(per_cell, counts):
    """A block whose faces lie on planes of nodes, which it passes by little as it vibrates and moves on slowly."""
    size = (5.0, 4.0, 4.0 if counts[2] > 1 else 1.0)
    wave = {"amplitude": (0.05, 0.02, 0), "wave_vector": (0.8, 0.4, 0)}
    body = box((2, 2, 2 if counts[2] > 1 else 0), size, SOLID, per_cell, velocity_wave=wave)
    energy = {"warn": 10.0, "stop": 100.0}
    return simulation(body, counts=counts, end=1e3, courant=0.4, transfer="apic", energy=energy)


@pytest.mark.parametrize(("per_cell", "counts"), [((3, 3, 1), (8, 6, 1)), ((2, 2, 2), (8, 6, 6)), ((4, 4, 1), (8, 6, 1))])
def test_points_that_pass_a_plane_of_nodes_stay_together(per_cell, counts, monkeypatch):
    """With APIC and linear functions; without the bound they fall apart."""
    start = stretched(per_cell, counts)
    first = start.kinetic_energy()
    advance(start, STEPS)
    assert start.kinetic_energy() < 1.05 * first
    monkeypatch.setattr(module, "small_mass_of_affine", lambda *_: 0.0)
    try:
        won = advance(stretched(per_cell, counts), STEPS).kinetic_energy()
    except RunStopped:
        return
    assert won > 2.0 * first
