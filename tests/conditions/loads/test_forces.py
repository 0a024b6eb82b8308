"""A force that points share: its sum, its even distribution, and that sorted points keep their shares."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, advance, box, simulation
from solids import block_of

from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

TISSUE = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3}
BLOCK = block_of(TISSUE, (2, 2, 2))
FORCE = (0.3, 0.0, -0.6)
PUSH = {"kind": "point-load", "body": "block", "where": {"normal": (0, 0, 1)}, "force": FORCE}


def solid(**load):
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0, "step": 1e-3}, "body": [BLOCK], "load": [PUSH | load]}
    return Simulation(Case.model_validate(table), threads=1)


@pytest.mark.parametrize(("rise", "share"), [(0.0, 1.0), (0.5, 0.5)])
def test_nodes_of_a_solid_share_the_force(rise, share):
    sim = solid(rise=rise)
    (body,) = sim.bodies
    body.begin(1e-3)
    sim.stages.begin(0.25, 1e-3)
    force, top = body.motion.loads.sum(axis=0), np.isclose(body.mesh.nodes[:, 2], 0.1)
    assert top.sum() == 9
    assert force[top] == pytest.approx(np.tile(share * np.array(FORCE) / 9.0, (9, 1)), rel=1e-14)
    assert not force[~top].any()


def test_the_momentum_of_a_solid_is_the_impulse_of_the_force():
    sim = advance(solid(), 20)
    assert sim.momentum() == pytest.approx(sim.time * np.array(FORCE), rel=1e-12)
    assert sim.budget.conservation()["momentum"] < 1e-12
    energies = sim.budget.energies()
    assert energies["load_work"] > 0.0
    assert abs(energies["transfer_error"]) < 1e-14 * energies["load_work"]


def test_material_points_keep_their_shares_when_they_are_sorted():
    """A spinning block whose corner is pulled: the pull goes round with the points that were there at the start."""
    body = box((2, 2, 0), (4, 4, 1), RATE_SOLID, (4, 4, 1), angular_velocity=(0.0, 0.0, 4.0))
    corner = {"box": {"lower": (3.5, 3.5, 0), "upper": (4, 4, 1)}}
    load = {"kind": "point-load", "body": "block", "where": corner, "force": (0.0, 1.0, 0.0)}
    sim = simulation(body, counts=(6, 6, 1), load=[load], end=10.0, step=5e-3)
    (block,), given = sim.bodies, []
    at_start = np.sort(block.arrays["id"][(block.arrays["position"][:, :2] > 3.5).all(axis=1)])
    order = block.arrays["id"].copy()
    block.add_external_force = lambda force, column: given.append(force.copy())
    advance(sim, 60)
    block.storage.sort()
    assert not np.array_equal(order, block.arrays["id"]), "points were sorted anew"
    assert len(at_start) == 4
    sim.stages.begin(1.0, 5e-3)
    assert np.array_equal(np.sort(block.arrays["id"][given[-1][:, 1] > 0.0]), at_start)
    assert given[-1].sum(axis=0) == pytest.approx([0.0, 1.0, 0.0], rel=1e-14)


@pytest.mark.parametrize(
    ("where", "words"),
    [({"set": "top"}, "no named sets"), ({"sphere": {"centre": (9, 9, 9), "radius": 1}}, "no node of body block lies in it")],
)
def test_points_that_are_not_there(where, words):
    with pytest.raises(ValueError, match=words):
        solid(where=where)


def test_no_material_point_there_is_an_error_of_the_load():
    nowhere = {"kind": "point-load", "body": "block", "where": {"sphere": {"centre": (9, 9, 9), "radius": 1}}, "force": FORCE}
    with pytest.raises(CaseError, match=r"load\.0\.where(.|\n)*no point of body block"):
        simulation(box((1, 1, 1), (3, 3, 3)), load=[nowhere])
