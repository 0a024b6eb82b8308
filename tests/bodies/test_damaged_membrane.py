"""Damage of membrane points: the exact curve in uniaxial strain, failure, books, the same bits everywhere."""

import numpy as np
import pytest
from membranes import body_of, drive, sheet
from scenes import advance, simulation

from pellucid.ledger import Ledger

E, NU = 17.9e3, 0.49
ZONA = {"elastic_limit": 0.05937, "stiffness_loss": 10.0, "rate": 10.0, "failure_strain": 0.06}
TOUGH = {"elastic_limit": 0.02, "stiffness_loss": 0.9, "rate": 1.0, "failure_strain": 0.08}
C = E / (1.0 - NU**2)


def damaged(damage=ZONA, law="linear-membrane", **more):
    material = {"kind": law, "density": 1100.0, "young_modulus": E, "poisson_ratio": NU, "damage": damage}
    return sheet(law, material=material, **more)


def uniaxial(grid, body, strain, steps=100):
    """Strain along x alone, in equal steps of the accumulated strain."""
    drive(grid, body, np.diag([strain, 0.0, 0.0]), 1.0 / steps, steps)


def test_uniaxial_strain_follows_the_curve_and_unloads_along_the_secant():
    grid, body = body_of(damaged(TOUGH))
    reached = 0.0
    for change in (0.015, 0.015, 0.01, -0.03, 0.03, 0.01):
        uniaxial(grid, body, change)
        strain = body.arrays["in_plane"][0, 0]
        reached = max(reached, strain)
        factor = 1.0 + 0.9 * (np.exp(-max(reached / 0.02 - 1.0, 0.0)) - 1.0)
        stress = body.frame()["stress"]
        assert stress[:, 0] == pytest.approx(factor * C * strain, rel=1e-9)
        assert stress[:, 1] == pytest.approx(factor * C * NU * strain, rel=1e-9)
    assert factor < 0.5


def test_a_neo_hookean_membrane_is_damaged_by_its_logarithmic_strain():
    grid, body = body_of(damaged(TOUGH, law="neo-hookean-membrane"))
    uniaxial(grid, body, 0.06)
    stretch = body.arrays["in_plane"][0, 0]
    assert body.arrays["damage"] == pytest.approx(np.log(stretch) / 0.02 - 1.0, rel=1e-9)


@pytest.mark.parametrize("law", ["linear-membrane", "neo-hookean-membrane"])
def test_failed_points_have_no_stress_and_keep_mass_volume_and_motion(law):
    grid, body = body_of(damaged(law=law))
    mass = body.frame()["mass"]
    uniaxial(grid, body, 0.07, steps=700)
    assert body.arrays["failed"].min() == 1.0
    assert np.all(body.arrays["stress"] == 0.0)
    density, rate = body.frame()["density"], body.sums["rate"]
    before = body.arrays["position"].copy()
    drive(grid, body, np.diag([1.2, -3.0, 0.0]), 0.01, 100)  # torn wide open and pressed flat
    assert np.all(body.arrays["failed"] == 1.0)
    assert np.all(body.arrays["stress"] == 0.0)
    assert np.all(body.frame()["density"] == density)
    assert np.all(body.frame()["mass"] == mass)
    assert np.ptp(body.arrays["position"][:, 0]) > 3.0 * np.ptp(before[:, 0])
    assert np.ptp(body.arrays["position"][:, 1]) < 0.1 * np.ptp(before[:, 1])
    assert body.sums["rate"] == pytest.approx(rate, rel=1e-12), "its waves still bound the step"
    # all the work of the stress is dissipated
    assert body.sums["dissipated"] == pytest.approx(body.sums["stored"], rel=1e-12)


def torn(steps=400):
    """A sheet with its left edge held that flies apart by its velocity."""
    table = damaged(points=(41, 41))
    hold = {"where": {"box": {"lower": [-0.6, -0.6, -0.3], "upper": [-0.3, 0.6, 0.3]}}}
    scene = simulation(table, counts=(16, 10, 4), cell=0.125, lower=(-0.75, -0.6, -0.22), step=4e-4, end=10.0, support=[hold])
    body = scene.bodies[0]
    body.arrays["velocity"][:, 0] = 2.0 * np.maximum(body.arrays["position"][:, 0] + 0.3, 0.0)
    body._measure()
    scene.ledger = Ledger(scene.bodies, scene.case.gravity)
    return advance(scene, steps)


def test_tearing_keeps_mass_momentum_and_the_books():
    scene = torn()
    body = scene.bodies[0]
    assert 100 < body.arrays["failed"].sum() < 1400
    found = scene.conservation()
    assert found["mass"] == 0.0
    assert found["momentum"] < 1e-12
    # of the method: the step, a thirtieth of the stable one, and what points hear of a tear within a cell
    assert abs(found["energy"]) < 0.002
    energies = scene.energies()
    assert energies["dissipated"] > 0.0
    assert energies["strain"] > 0.0
    hurt = body.arrays["damage"] > 0.0
    assert np.all(body.arrays["dissipated_energy"][hurt] <= body.arrays["strain_energy"][hurt] * (1.0 + 1e-12))
    assert np.all(body.arrays["dissipated_energy"][~hurt] == 0.0)


def test_probes_and_frames_show_the_damage():
    scene = torn(steps=1)
    assert {"damage", "failed", "dissipated_energy"} <= set(scene.bodies[0].frame())
    assert {"damage", "failed", "dissipated_energy"} <= set(scene.case.body[0].probed)
    assert "failed" not in simulation(sheet(), counts=(16, 16, 16), cell=0.25, lower=(-2, -2, -2)).case.body[0].probed
