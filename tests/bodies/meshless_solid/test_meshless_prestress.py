"""Initial stress of meshless solids: energy and objectivity, equilibria that stay, relaxation of a free body."""

from typing import ClassVar, Literal

import numpy as np
import pytest
from algebra import rotation
from meshes import irregular
from registries import forgotten_afterwards
from scipy.optimize import brentq
from solids import EDGE, Tissue, block, layer

from pellucid.bodies.initial import InitialField
from pellucid.bodies.meshless_solid.body import MeshlessSolid
from pellucid.grid.velocity_transfer import Flip
from pellucid.materials.law import first_piola_kirchhoff
from pellucid.parts.body import Placement
from pellucid.registry import register
from pellucid.simulation.simulation import Simulation

STRESS = (300.0, -200.0, 100.0, 50.0, -80.0, 120.0)
SOFT = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 3e3, "poisson_ratio": 0.3}
VISCOUS = {"kind": "kelvin-voigt", "density": 1000.0, "elastic": SOFT, "viscosity": 5.0}


class Stressed(Tissue):
    """A tissue with a stress that grows along x."""

    def initial_stress_at(self, position):
        return (1.0 + position[:, :1]) * np.array(STRESS)


def stressed(**settings):
    body = MeshlessSolid(Stressed(irregular(3, 3), **settings), Placement(None, None, Flip(), (0.0, 0.0, 0.0), 0))
    body.complete()
    return body


def found(body, displacement):
    """Energy and forces at displacements of the nodes."""
    force = np.zeros_like(displacement)
    body._forces.find(displacement, force, 0.0)
    return body._forces.stored(), force


@pytest.mark.parametrize("averaged", [False, True])
def test_forces_are_the_derivative_of_the_energy_which_turns_with_the_body(averaged):
    body, generator = stressed(averages_volume=averaged), np.random.default_rng(4)
    X = body.mesh.nodes
    u, along = generator.uniform(-0.02, 0.02, X.shape), generator.uniform(-1.0, 1.0, X.shape)
    energy, force = found(body, u)
    step = 1e-6
    work = (found(body, u + step * along)[0] - found(body, u - step * along)[0]) / (2.0 * step)
    assert -np.sum(force * along) == pytest.approx(work, rel=1e-7)
    R = rotation(7)
    turned, turned_force = found(body, (X + u) @ R.T - X)
    assert turned == pytest.approx(energy, rel=1e-9)
    assert np.abs(turned_force - force @ R.T).max() < 1e-9 * np.abs(force).max()
    assert abs(found(body, np.zeros_like(u))[0]) < 1e-12 * abs(energy)


@pytest.mark.parametrize("material", [SOFT, VISCOUS], ids=["elastic", "viscous"])
def test_results_show_it_at_the_start(material):
    sim = Simulation(block(material, body={"initial_stress": STRESS}), threads=1)
    assert sim.bodies[0].field("stress") == pytest.approx(np.tile(STRESS, (sim.bodies[0].n_points, 1)), rel=1e-9)
    assert np.abs(sim.bodies[0].field("strain_energy")).max() < 1e-12


# linear functions balance it exactly; the quadrature of the others is consistent for uniform stresses
@pytest.mark.parametrize(("approximant", "share"), [("linear-simplex", 1e-9), ("cell-based-maximum-entropy", 0.01)])
@forgotten_afterwards()
def test_a_column_with_the_stress_of_its_weight_stays_at_rest(approximant, share):
    """σ_zz = -ρ g (H - z) and nothing else, with free sides; without it, it sinks."""

    @register
    class Weight(InitialField):
        quantity: ClassVar[str] = "stress"
        kind: Literal["weight"] = "weight"

        def at(self, position):
            vertical = -1000.0 * 2.0 * (EDGE - position[:, 2])
            zero = np.zeros_like(vertical)
            return np.stack([zero, zero, vertical, zero, zero, zero], axis=1)

    more = {"support": [{"where": layer(0.0), "fix": ["x", "y", "z"]}], "gravity": (0.0, 0.0, -2.0), "time": {"end": 0.1}}
    moved = []
    for initial in ([{"kind": "weight"}], []):
        sim = Simulation(block(SOFT, body={"initial": initial, "approximant": {"kind": approximant}}, **more), threads=1)
        start = sim.bodies[0].places()
        while not sim.clock.finished(None):
            sim.step()
        moved.append(float(np.abs(sim.bodies[0].places() - start).max()))
    assert moved[0] < share * moved[1]


def test_a_free_body_relaxes_to_the_stretch_that_its_law_balances():
    """P(λ) + λ s = 0: all the same in every direction."""
    sim = Simulation(block(SOFT, body={"initial_stress": (400.0,) * 3 + (0.0,) * 3}, settle={"share": 1e-10}), threads=1)
    sim.settle()
    law = sim.case.body[0].law()

    def unbalanced(stretch):
        F = (stretch, 0.0, 0.0, 0.0, stretch, 0.0, 0.0, 0.0, stretch)
        return first_piola_kirchhoff(law, F)[0] + stretch * 400.0

    stretch = brentq(unbalanced, 0.5, 1.0)
    size = np.ptp(sim.bodies[0].places(), axis=0) / EDGE
    assert size == pytest.approx(np.full(3, stretch), rel=1e-4)
    assert stretch < 0.96, "it shrinks by several per cent"


def test_its_energy_balance_closes_while_it_swings():
    """To the error of central differences, which is of second order in the step."""
    errors = []
    for step in (1e-3, 5e-4):
        sim = Simulation(block(SOFT, body={"initial_stress": STRESS}, time={"end": 0.2, "step": step}), threads=1)
        largest = 0.0
        while not sim.clock.finished(None):
            sim.step()
            largest = max(largest, abs(sim.budget.energy_error()))
        errors.append(largest)
        assert sim.budget.conservation()["momentum"] < 1e-12
        assert sim.budget.kinetic > 0.01 * sim.budget.moved, "it swings"
    assert errors[0] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
