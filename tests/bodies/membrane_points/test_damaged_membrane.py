"""Damage of membrane points: the exact curve in uniaxial strain, failure, balance, the same bits everywhere."""

import numpy as np
import pytest
from membranes import body_of, drive, sheet
from small_cases import advance, simulation

from pellucid.energy import EnergyBudget
from pellucid.errors import RunStopped

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
    density, rate = body.frame()["density"], body.totals.rate
    before = body.arrays["position"].copy()
    drive(grid, body, np.diag([1.2, -3.0, 0.0]), 0.01, 100)  # torn wide open and pressed flat
    assert np.all(body.arrays["failed"] == 1.0)
    assert np.all(body.arrays["stress"] == 0.0)
    assert np.all(body.frame()["density"] == density)
    assert np.all(body.frame()["mass"] == mass)
    assert np.ptp(body.arrays["position"][:, 0]) > 3.0 * np.ptp(before[:, 0])
    assert np.ptp(body.arrays["position"][:, 1]) < 0.1 * np.ptp(before[:, 1])
    assert body.totals.rate == pytest.approx(rate, rel=1e-12), "its waves still bound the step"
    # all the work of the stress is dissipated
    assert body.totals.parts["dissipated"] == pytest.approx(body.totals.stored, rel=1e-12)


@pytest.mark.parametrize("more", [{}, {"radius": 0.25}], ids=["local", "nonlocal"])
def test_failed_points_keep_what_they_have_beside_points_that_go_on(more):
    """Points are strained some at a time: those that have failed among them change nothing for the others."""
    (grid, body), (whole_grid, whole) = body_of(damaged({**TOUGH, **more})), body_of(damaged({**TOUGH, **more}))
    uniaxial(grid, body, 0.01, steps=5)
    uniaxial(whole_grid, whole, 0.01, steps=5)
    failed = np.arange(body.n_points) % 3 == 0
    body.arrays["failed"][failed] = 1.0
    names = ("frame", "in_plane", "stress", "plane_stress", "volume", "strain_energy", "damage", "dissipated_energy")
    before = {name: body.arrays[name][failed].copy() for name in names}
    turn = np.array([(0.005, -0.3, 0.2), (0.3, 0.005, 0.0), (-0.2, 0.0, 0.0)])  # below the strain of any damage
    drive(grid, body, turn, 0.1, 5)
    drive(whole_grid, whole, turn, 0.1, 5)
    for name, kept in before.items():
        assert np.array_equal(body.arrays[name][failed], kept), name
        assert np.array_equal(body.arrays[name][~failed], whole.arrays[name][~failed]), name
    assert np.abs(body.arrays["plane_stress"][~failed, 0] - before["plane_stress"][0, 0]).min() > 0.0
    mass, energy = body.arrays["mass"], body.arrays["strain_energy"]
    assert body.totals.stored == pytest.approx(float(mass @ energy), rel=1e-13)


def torn(steps=400, damage=ZONA, threads=1):
    """A sheet with its left edge held that flies apart by its velocity."""
    table = damaged(damage, points=(41, 41))
    hold = {"where": {"box": {"lower": [-0.6, -0.6, -0.3], "upper": [-0.3, 0.6, 0.3]}}}
    sim = simulation(
        table, counts=(16, 10, 4), cell=0.125, lower=(-0.75, -0.6, -0.22), step=4e-4, end=10.0, support=[hold], threads=threads
    )
    body = sim.bodies[0]
    body.arrays["velocity"][:, 0] = 2.0 * np.maximum(body.arrays["position"][:, 0] + 0.3, 0.0)
    body.renew_totals()
    sim.budget = EnergyBudget(sim.bodies, sim.case.gravity)
    return advance(sim, steps)


def test_tearing_keeps_mass_momentum_and_the_balance():
    sim = torn()
    body = sim.bodies[0]
    assert 100 < body.arrays["failed"].sum() < 1400
    found = sim.budget.conservation()
    assert found["mass"] == 0.0
    assert found["momentum"] < 1e-12
    # of the method: the step, a thirtieth of the stable one, and what points hear of a tear within a cell
    assert abs(found["energy"]) < 0.002
    energies = sim.budget.energies()
    assert energies["dissipated"] > 0.0
    assert energies["strain"] > 0.0
    hurt = body.arrays["damage"] > 0.0
    assert np.all(body.arrays["dissipated_energy"][hurt] <= body.arrays["strain_energy"][hurt] * (1.0 + 1e-12))
    assert np.all(body.arrays["dissipated_energy"][~hurt] == 0.0)


def test_probes_and_frames_show_the_damage():
    sim = torn(steps=1)
    assert {"damage", "failed", "dissipated_energy"} <= set(sim.bodies[0].frame())
    assert {"damage", "failed", "dissipated_energy"} <= set(sim.case.body[0].probed)
    assert "torn" not in torn(steps=1, damage={**ZONA, "radius": 0.13}).bodies[0].frame(), "only checkpoints contain it"
    assert "failed" not in simulation(sheet(), counts=(16, 16, 16), cell=0.25, lower=(-2, -2, -2)).case.body[0].probed


def test_uniform_strain_is_its_own_mean():
    """The nonlocal law follows the same curve where the strain is the same everywhere, at edges too."""
    grid, body = body_of(damaged({**TOUGH, "radius": 0.25}))
    uniaxial(grid, body, 0.05)
    factor = 1.0 + 0.9 * (np.exp(-1.5) - 1.0)
    assert body.frame()["stress"][:, 0] == pytest.approx(factor * C * 0.05, rel=1e-9)
    assert body.arrays["dissipated_energy"].min() > 0.0


def test_a_failed_point_counts_with_its_opening_only_where_it_tore_by_itself():
    grid, body = body_of(damaged({**ZONA, "radius": 0.25}))
    uniaxial(grid, body, 0.0601, steps=600)
    assert body.arrays["failed"].all()
    half = body.n_points // 2
    body.arrays["in_plane"][body.arrays["id"] < half] = 0.0  # as if these had failed for their neighbours' strain
    uniaxial(grid, body, 0.5)
    opened = body.arrays["torn"][np.argsort(body.arrays["id"]), 0]
    assert np.all(opened[:half] == 0.0)
    assert opened[half:] == pytest.approx(0.5, rel=1e-9)


def nonlocal_tear(threads=1, steps=300):
    return torn(steps, damage={**ZONA, "radius": 0.13}, threads=threads)


def test_nonlocal_damage_has_the_same_bits_on_any_number_of_threads():
    one, two = nonlocal_tear(1), nonlocal_tear(2)
    assert one.bodies[0].arrays["failed"].sum() > 100
    for name, array in one.state_arrays().items():
        assert np.array_equal(array, two.state_arrays()[name]), name


def test_a_restored_tear_goes_on_with_the_same_bits():
    straight, stopped = nonlocal_tear(steps=160), nonlocal_tear(steps=110)
    assert stopped.bodies[0].arrays["failed"].sum() > 0
    again = nonlocal_tear(steps=0)
    again.restore(stopped.state_arrays(), stopped.state_numbers())
    advance(again, 50)
    for name, array in straight.state_arrays().items():
        assert np.array_equal(array, again.state_arrays()[name]), name
    assert again.budget.energies() == straight.budget.energies()


@pytest.mark.parametrize("table", [damaged(), sheet()], ids=["damaged", "never"])
def test_a_surface_about_a_tear_has_triangles_that_turned_over(table):
    """Three to three, the normals of the six cancel; where points can fail, those that turned over do not count."""
    _, body = body_of(table)
    middle = int(np.argmin(np.linalg.norm(body.arrays["position"] - (0.01, 0.02, 0.03), axis=1)))
    body.arrays["position"][middle] += (0.13, -0.12, 0.0)  # among its neighbours' neighbours
    body.update_stress(0.0, move=False)
    if "damage" in table["material"]:
        body.check(0, 0.0)
        assert body.arrays["frame"][middle, 6:] == pytest.approx((0.0, 0.0, 1.0), abs=1e-15)
    else:
        with pytest.raises(RunStopped, match="not a finite number"):
            body.check(0, 0.0)


@pytest.mark.parametrize("table", [sheet(), damaged()], ids=["sheet", "damaged"])
def test_a_sheet_that_folds_in_one_step_stops_the_run(table):
    grid, body = body_of(table)
    index, position = grid.where()
    grid.nodes.velocity[index] = -2.0 * position[:, [0]] * (1.0, 0.0, 0.0)
    body.update_stress(1.0, move=True)  # x -> -x: every normal turns over
    with pytest.raises(RunStopped, match="folded onto itself"):
        body.check(1, 0.0)


def test_a_mean_over_less_than_a_cell_is_an_error_of_the_case():
    with pytest.raises(ValueError, match=r"damage.radius = 0.2 m is less than grid.cell = 0.25 m"):
        body_of(damaged({**ZONA, "radius": 0.2}))
