"""The Darcy drag of porous boxes: exact plug flow, energy, and mistakes."""

import numpy as np
import pytest
from small_cases import advance, box, case

from pellucid import CaseError
from pellucid.simulation.simulation import Simulation

FLUID = {
    "kind": "fluid",
    "density": 1000.0,
    "pressure": 1e3,
    "eos": {"kind": "stiffened-gas", "gruneisen": 6.0, "p_infinity": 1e4},
    "viscosity": 1e-3,
}
RATE, PULL, STEP = 20.0, 3.0, 1e-3
POROUS = {"body": "block", "lower": (0, 0, 0), "upper": (8, 4, 4), "permeability": 1e-3 / (1000.0 * RATE)}


def channel(porous=POROUS, body=None, **more):
    """A periodic channel full of fluid that gravity pulls along x."""
    body = body or box((0, 0, 0), (8, 4, 4), FLUID)
    sides = [{"where": f"{axis}-{end}", "fix": "normal"} for axis in "yz" for end in ("lower", "upper")]
    how = {"gravity": (PULL, 0, 0), "step": STEP, "end": 1.0, "porous": [porous]} | more
    return case(body, counts=(8, 4, 4), periodic=("x",), support=sides, **how)


def test_plug_flow_is_exact_at_any_step():
    """v' = g - βv from rest, in a box that fills the channel."""
    sim = advance(Simulation(channel()), 100)
    expected = PULL / RATE * -np.expm1(-RATE * 100 * STEP)
    velocity = sim.bodies[0].field("velocity")
    assert velocity[:, 0] == pytest.approx(np.full(len(velocity), expected), rel=1e-9)
    energies, mass = sim.budget.energies(), sim.bodies[0].mass
    lost = energies["gravity_work"] - 0.5 * mass * expected**2
    assert energies["porous_heat"] == pytest.approx(lost, rel=1e-6)
    assert abs(sim.budget.conservation()["energy"]) < 1e-9
    assert abs(sim.budget.conservation()["momentum"]) < 1e-12


def test_nodes_at_a_face_of_the_box_get_their_share():
    """The drag of uniform flow is that of the volume of the box, also where it cuts cells."""
    body = box((0, 0, 0), (8, 4, 4), FLUID) | {"velocity": (1.0, 0, 0)}
    porous = POROUS | {"lower": (2.3, 0, 0), "upper": (5.1, 4, 4)}
    sim = Simulation(channel(porous, body))
    before = sim.momentum()[0]
    advance(sim, 1)
    lost = before + PULL * STEP * sim.bodies[0].mass - sim.momentum()[0]
    volume = (5.1 - 2.3) * 16.0
    assert lost == pytest.approx(1000.0 * volume * RATE * STEP, rel=0.5 * RATE * STEP + 2 * PULL * STEP)


@pytest.mark.parametrize(
    ("porous", "body", "words"),
    [
        (POROUS | {"body": "blok"}, None, "porous.0.body: no body has this name"),
        (POROUS | {"lower": (9, 0, 0)}, None, "`lower` exceeds `upper`"),
        (POROUS, box((0, 0, 0), (8, 4, 4)), "is not a fluid of material points"),
        (
            POROUS,
            box((0, 0, 0), (8, 4, 4), FLUID | {"viscosity": 0.0}),
            "porous.0.viscosity: is missing, and the material of body block has none",
        ),
        (POROUS | {"permeability": -1.0}, None, "permeability"),
    ],
)
def test_mistakes_are_named(porous, body, words):
    with pytest.raises((CaseError, ValueError), match=words):
        channel(porous, body)
