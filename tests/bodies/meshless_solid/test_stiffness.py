"""The stiffness of meshless solids and its factors: differences of the forces, for every law and approximant."""

import numpy as np
import pytest
from materials.samples import every_hyperelastic
from solids import EDGE, block_of, layer

from pellucid.approximants.nodal import NODAL_APPROXIMANTS
from pellucid.bodies.meshless_solid.stiffness import SolidStiffness
from pellucid.case import Case
from pellucid.simulation.simulation import Simulation

SMALL = 1e-6  # displacement of the differences over the edge: error 1e-8, of a second derivative and of rounding


CLAMPED = [{"where": layer(0.0)}]
ENCLOSED = [
    {
        "where": {
            "box": {
                "lower": [x - 1e-6 if k == axis else -1.0 for k in range(3)],
                "upper": [x + 1e-6 if k == axis else 1.0 for k in range(3)],
            }
        }
    }
    for axis in range(3)
    for x in (0.0, EDGE)
]


def body_of(support=CLAMPED, **settings):
    """A block of 3 × 3 × 3 cells in a random state of two per cent of strain, and its displacements."""
    table = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "body": [block_of(cells=(3, 3, 3)) | settings]}
    case = Case.model_validate(table | {"support": support})
    body = Simulation(case, threads=1).bodies[0]
    rng = np.random.default_rng(3)
    strain = rng.uniform(-0.02, 0.02, (3, 3))
    strain -= np.eye(3) * (np.trace(strain) / 3.0 - 1e-3)  # slightly stretched: stable
    return body, body.mesh.nodes @ strain + 1e-4 * EDGE * rng.standard_normal(body.mesh.nodes.shape)


def forces(body, displacement):
    force = np.empty_like(displacement)
    body._forces.find(displacement, force, 0.0)
    return force


def error_of(body, displacement):
    """Relative error of displacements that are recovered from the change of forces that they cause."""
    moved = np.random.default_rng(4).standard_normal(displacement.shape) * body.motion.free
    step = SMALL * EDGE * moved
    change = (forces(body, displacement - step) - forces(body, displacement + step)) / (2.0 * SMALL * EDGE)
    stiffness = SolidStiffness(body._forces.solid, body.mesh.nodes)
    forces(body, displacement)
    stiffness.renew(body.motion.free, body.mesh.nodes + displacement, single=False)
    assert stiffness.shift == 0.0
    return abs(stiffness.solve(change) - moved).max() / abs(moved).max()


@every_hyperelastic
@pytest.mark.parametrize("averaged", [False, True])
def test_displacements_follow_from_forces(material, averaged, monkeypatch):
    body, displacement = body_of(volume_averaging=averaged)
    kinks = material.kind == "holzapfel-gasser-ogden"  # at points where fibres begin to carry, the stiffness jumps
    law = material.law()
    solid = body._forces.solid._replace(law=law, points=body._forces.solid.points._replace(law=law))
    monkeypatch.setattr(body, "_forces", type(body._forces)(solid))
    assert error_of(body, displacement) < (1e-2 if kinks else 2e-5)


@pytest.mark.parametrize("kind", NODAL_APPROXIMANTS.entries)
@pytest.mark.parametrize("points", [1, 4, 8])
def test_for_every_approximant_and_number_of_points(kind, points):
    settings = {"approximant": {"kind": kind}, "points_per_cell": points, "initial_stress": [30.0, 0, 0, 0, 20.0, 0]}
    body, displacement = body_of(**settings)
    assert error_of(body, displacement) < 2e-5


def test_prescribed_displacements_are_followed():
    """A linear displacement of all faces is followed by the nodes inside, and the resisting forces are the change of the
    forces."""
    body, _ = body_of(ENCLOSED)
    places, free = body.mesh.nodes, body.motion.free
    stiffness = SolidStiffness(body._forces.solid, places)
    before = forces(body, np.zeros_like(places))
    stiffness.renew(free, body.mesh.nodes, single=True)
    prescribed = 1e-5 * places @ np.random.default_rng(5).standard_normal((3, 3))
    found, resisted = stiffness.follow(np.zeros_like(places), np.where(free, 0.0, prescribed))
    assert found == pytest.approx(prescribed, abs=1e-9 * EDGE)
    assert abs(resisted + forces(body, found) - before).max() < 1e-3 * abs(resisted).max(), "differences of second order"


def test_instability_is_found():
    """A block without support under a compression along one axis is unstable: it would turn."""
    body, _ = body_of()
    places = body.mesh.nodes
    forces(body, places * [0.1, 0.1, -0.2])
    stiffness = SolidStiffness(body._forces.solid, places)
    stiffness.renew(np.ones(places.shape, bool), body.arrays["position"], single=True)
    assert stiffness.shift > 0.0
