"""Internal forces in the middle of the step: second order where viscosity dominates, none where inertia does, the same bits."""

import numpy as np
import pytest
from small_cases import advance, assert_resumes, assert_same_arrays, box, case, copied_state, finished

from pellucid.bodies.membrane_elements.forces_ahead import CRITICAL, ForcesAhead, forces_ahead, share_of_viscosity
from pellucid.simulation.simulation import Simulation

TAIT = {"kind": "tait", "sound_speed": 30.0, "carries_tension": True}
LIQUID = {"kind": "fluid", "density": 0.01, "viscosity": 1.0, "eos": TAIT, "implicit_pressure": True}
CAPSULE = {
    "name": "capsule",
    "kind": "membrane-elements",
    "elements": "triangles",
    "surface": {"icosphere": {"centre": [0, 0, 0], "radius": 0.5, "refinements": 2}},
    "thickness": 0.01,
    "initial": [{"kind": "velocity-gradient", "x": [0, 1, 0]}],
    "material": {"kind": "surface-neo-hookean-membrane", "density": 0.1, "shear_modulus": 1.0},
}
WALLS = [{"where": "y-lower", "velocity": (-1, 0, 0)}, {"where": "y-upper", "velocity": (1, 0, 0)}]


def capsule_in_shear(step=0.05, end=0.8, threads=1, capsule=CAPSULE, material=LIQUID, **more):
    body = box((-1, -1, -1), (1, 1, 1), material, (2, 2, 2), initial=CAPSULE["initial"])
    how = {"counts": (8, 8, 8), "lower": (-1, -1, -1), "cell": 0.25, "periodic": ["x", "z"], "support": WALLS}
    how |= {"functions": "quadratic-bspline", "scheme": "usl", "step": step, "end": end}
    return Simulation(case(body, capsule, **how | more), threads=threads)


def part_of(sim):
    (found,) = sim.parts.of(ForcesAhead)
    return found


@pytest.mark.slow
def test_the_motion_is_of_second_order_in_the_step():
    """Differences of the strain energy fall to a quarter or less if the step is halved; with forces at the start the error is
    ten times as large."""

    def energy(factor, step):
        surface = {"icosphere": {"centre": [0, 0, 0], "radius": 0.5, "refinements": 3}}
        sim = capsule_in_shear(step, end=0.5, capsule=CAPSULE | {"surface": surface}, counts=(16, 16, 16), cell=0.125)
        part_of(sim)._viscosity_share = factor
        return finished(sim).bodies[1].totals.stored

    ahead = [energy(1.0, step) for step in (0.05, 0.025, 0.0125)]
    first, second = np.abs(np.diff(ahead))
    assert second < 0.3 * first
    assert second < 0.15 * (energy(0.0, 0.025) - ahead[2])


def test_forces_at_the_start_act_where_inertia_dominates():
    assert share_of_viscosity(1.0, 1.0, 1e-6, 1.0) == pytest.approx(1.0)
    assert share_of_viscosity(CRITICAL, 1.0, 1.0, 1.0) == pytest.approx(0.5)
    assert share_of_viscosity(100.0 * CRITICAL, 1.0, 1.0, 1.0) < 1e-3
    inert = capsule_in_shear(0.001, material=LIQUID | {"density": 1000.0, "eos": TAIT | {"sound_speed": 1.0}})
    assert not inert.parts.of(ForcesAhead)
    explicit = LIQUID | {"implicit_pressure": False, "implicit_viscosity": True}
    assert not capsule_in_shear(0.0001, material=explicit).parts.of(ForcesAhead)
    assert forces_ahead(capsule_in_shear().bodies, []) == []


def test_forces_act_at_the_time_of_viscous_forces_in_stable_steps():
    sim = capsule_in_shear()
    part, limit = part_of(sim), sim.bodies[1].surface.step_of_waves()
    for courant, theta, share in ((0.1, 0.6, 0.1), (0.5, 1.0, 0.5), (0.8, 1.0, 0.125), (1.0, 1.0, 0.0), (2.0, 1.0, 0.0)):
        part._solver._theta = theta
        assert part._share_of(courant * limit) == pytest.approx(share, abs=1e-3)


@pytest.mark.parametrize(("courant", "ahead"), [(1.0, 0.0), (0.75, 1.0 / 6.0), (0.5, 0.5)])
def test_steps_up_to_the_limit_are_stable(courant, ahead):
    """The strain energy grows smoothly, as the capsule is stretched."""
    stiff = CAPSULE | {"material": CAPSULE["material"] | {"shear_modulus": 20.0}}
    how = {"courant": courant, "end": 4.0, "output": {"history": 0.5}}
    sim, stored = capsule_in_shear(None, capsule=stiff, **how), []
    for _ in range(40):
        sim.step()
        stored.append(sim.bodies[1].totals.stored)
    assert part_of(sim).share == pytest.approx(ahead, abs=0.05)
    growth = np.diff(stored)
    assert growth.min() > 0.0
    assert np.abs(np.diff(growth))[5:].max() < 0.1 * growth.max()


def test_the_error_of_the_energy_decreases_with_the_step():
    errors = [abs(finished(capsule_in_shear(step)).budget.conservation()["energy"]) for step in (0.05, 0.025)]
    assert errors[1] < 0.6 * errors[0] < 1e-3


def test_the_same_bits_on_two_threads_and_after_a_checkpoint():
    one, two = (advance(capsule_in_shear(threads=threads), 6) for threads in (1, 2))
    assert part_of(one).share > 0.2
    assert_same_arrays(copied_state(one), copied_state(two))
    assert_resumes(*(capsule_in_shear() for _ in range(2)), before=3, after=3)
