"""The mean pressure of full cells: forces without errors of sums over points, and energy, volume and rest that follow."""

import numpy as np
import pytest
from scipy.integrate import quad
from small_cases import GAS, SLIP, SOLID, advance, box, case, place, simulation

from pellucid.approximants import GRID_FUNCTIONS, grid_functions
from pellucid.approximants.grid_functions import axis_weights
from pellucid.grid.full_cells import CellPressure, axis_integrals
from pellucid.grid.points import GROWTH, RATES, SHIFT, VOLUMES

every_function = pytest.mark.parametrize("functions", GRID_FUNCTIONS)
every_scheme = pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
PLANE = {"counts": (5, 6, 1), "cell": 0.2}
WALLS = SLIP[:4]


def gas(counts=(5, 6, 1), cell=0.2, per_cell=(3, 3, 1), **more):
    """That fills a plane grid."""
    upper = [n * cell for n in counts[:2]] + [0.0]
    return box((0, 0, 0), upper, GAS, per_cell, "gas", cell_pressure=True, **more)


def disordered(functions="quadratic-bspline", body=None, seed=1, **more):
    """Gas whose points have left their lattice by a third of their distance, with volumes and pressures of their own."""
    sim = simulation(body or gas(), **(PLANE | {"functions": functions, "support": WALLS} | more))
    fluid, generator = sim.bodies[0], np.random.default_rng(seed)
    shift = generator.uniform(-0.02, 0.02, (fluid.n_points, 3)) * [1, 1, 0]
    place(fluid, fluid.arrays["position"] + shift)
    fluid.arrays["volume"] *= generator.uniform(0.8, 1.2, fluid.n_points)
    return sim


def forces(sim):
    """Nodal forces of the points and of the mean pressures."""
    sim.stages.clear_nodes()
    sim.stages.before_forces()
    for body in sim.bodies:
        body.particle_to_grid(inertia=True, force=True)
    return sim.grid.nodes.force


@every_function
@pytest.mark.parametrize("n", [2, 3, 4, 12, 13])
def test_integrals_of_functions_over_cells(functions, n):
    """Beside adaptive quadrature of scipy."""
    function = grid_functions(functions, (2, 2, 2), (False, False, False))[0]
    table = axis_integrals(function, n)
    for cell in range(n):
        for node in range(n + 2):

            def of(u, k, node=node):
                first, *values = axis_weights(function, u, n)
                return values[k][node - first] if 0 <= node - first < len(values[k]) else 0.0

            at = node - table.first[cell]
            kinks = [cell + 0.25, cell + 0.5, cell + 0.75]
            for k, row in enumerate((table.value[cell], table.slope[cell])):
                found = row[at] if 0 <= at < len(row) else 0.0
                assert found == pytest.approx(quad(of, cell, cell + 1, args=(k,), points=kinks)[0], abs=1e-9)


@every_function
@pytest.mark.parametrize("n", [4, 5, 12])
def test_integrals_over_the_cells_of_a_period_are_alike(functions, n):
    """All are those of a cell far from walls, and a uniform pressure gives no force."""
    periodic = grid_functions(functions, (2, 2, 2), (False, False, False), (True, True, True))[0]
    walled = axis_integrals(periodic.function, 13)
    table = axis_integrals(periodic, n)
    force = np.zeros(n)
    for cell in range(n):
        assert table.value[cell] == pytest.approx(walled.value[6], abs=1e-15)
        assert (table.first[cell] - cell - walled.first[6] + 6) % n == 0
        np.add.at(force, (table.first[cell] + np.arange(table.slope.shape[1])) % n, table.slope[cell])
    assert force == pytest.approx(np.zeros(n), abs=1e-14)


@pytest.mark.parametrize("hole", [False, True])
def test_a_uniform_pressure_gives_no_force_across_seams(hole):
    """Nowhere, as there is no wall; a hole in the cells at a corner of the box belongs to those beside it."""
    sim = disordered(support=(), periodic=["x", "y"])
    fluid = sim.bodies[0]
    x = fluid.arrays["position"] + [0.6, -7.0, 0.0]
    if hole:
        x[((x[:, :2] - [1.0, -7.2]) % [1.0, 1.2] <= 0.2001).all(axis=1), 0] += 0.2
    place(fluid, x)
    fluid.arrays["stress"][:, :3] = -3.0
    force = forces(sim)
    assert np.count_nonzero(sim.parts.of(CellPressure)[0].cells.full) == 30 - hole
    assert np.abs(force).max() < 1e-14 * 3.0


@every_function
@pytest.mark.parametrize("hole", [False, True])
def test_a_uniform_pressure_gives_no_force_within(functions, hole):
    sim = disordered(functions)
    fluid = sim.bodies[0]
    if hole:
        x = fluid.arrays["position"]
        x[(np.abs(x[:, :2] - [0.5, 0.7]) <= 0.1001).all(axis=1), 0] += 0.2
        place(fluid, x)
        assert np.count_nonzero(sim.parts.of(CellPressure)[0].cells.full) == 0
    fluid.arrays["stress"][:, :3] = -3.0
    force = forces(sim)
    index, where = sim.grid.where()
    assert np.count_nonzero(sim.parts.of(CellPressure)[0].cells.full) == 30 - hole
    inner = ((where[:, :2] > 0.01) & (where[:, :2] < [0.99, 1.19])).all(axis=1)
    assert np.abs(force[index[inner]]).max() < 1e-14 * 3.0
    right = index[where[:, 0] > 0.99]
    assert force[right, 0].sum() == pytest.approx(3.0 * 1.2, rel=1e-13), "pressure times area"


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_uniform_pressure_gives_no_force_within_a_room(functions):
    body = box((0, 0, 0), (0.8, 1.0, 0.6), GAS, (2, 2, 2), "gas", cell_pressure=True)
    sim = simulation(body, counts=(4, 5, 3), cell=0.2, functions=functions, support=SLIP)
    fluid, generator = sim.bodies[0], np.random.default_rng(6)
    place(fluid, fluid.arrays["position"] + generator.uniform(-0.04, 0.04, (fluid.n_points, 3)))
    fluid.arrays["volume"] *= generator.uniform(0.8, 1.2, fluid.n_points)
    fluid.arrays["stress"][:, :3] = -3.0
    force = forces(sim)
    index, where = sim.grid.where()
    assert np.count_nonzero(sim.parts.of(CellPressure)[0].cells.full) == 60
    inner = ((where > 0.01) & (where < [0.79, 0.99, 0.59])).all(axis=1)
    assert np.abs(force[index[inner]]).max() < 1e-14 * 3.0
    assert force[index[where[:, 1] > 0.99], 1].sum() == pytest.approx(3.0 * 0.8 * 0.6, rel=1e-13)


def test_without_it_the_sums_over_points_give_one():
    body = gas()
    sim = disordered(body=body | {"cell_pressure": False})
    sim.bodies[0].arrays["stress"][:, :3] = -3.0
    index, where = sim.grid.where()
    inner = ((where[:, :2] > 0.01) & (where[:, :2] < [0.99, 1.19])).all(axis=1)
    assert np.abs(forces(sim)[index[inner]]).max() > 0.01 * 3.0 * 0.2


@every_function
def test_forces_keep_momentum_with_a_free_surface(functions):
    body = box((0.4, 0.4, 0), (1.5, 1.3, 0), GAS, (3, 3, 1), "gas", cell_pressure=True)
    sim = disordered(functions, body, counts=(10, 9, 1))
    generator = np.random.default_rng(2)
    sim.bodies[0].arrays["stress"][:] = generator.normal(size=(sim.bodies[0].n_points, 6)) * [1, 1, 1, 0, 0, 1]
    force = forces(sim)
    full = np.count_nonzero(sim.parts.of(CellPressure)[0].cells.full)
    assert 0 < full < 30
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * np.abs(force).sum()


@every_scheme
def test_energy_is_that_of_the_points_pressures(scheme):
    """Kinetic and internal energy together are constant to rounding: nodal forces do what the points' energies lose."""
    sim = disordered(scheme=scheme)
    fluid = sim.bodies[0]
    fluid.arrays["velocity"][:, 0] = 0.3 * np.sin(np.pi * fluid.arrays["position"][:, 0])
    fluid.renew_totals()
    sim.begin_balance()
    begun = sim.budget.energies()
    for _ in range(20):
        sim.step()
    ended = sim.budget.energies()
    assert abs(ended["kinetic"] - begun["kinetic"]) > 0.01 * begun["kinetic"]
    change = ended["kinetic"] + ended["internal"] - begun["kinetic"] - begun["internal"]
    assert abs(change) < 1e-13 * begun["internal"]


@every_function
def test_the_shifted_volumes_of_a_cell_grow_as_it_does(functions):
    sim = disordered(functions)
    fluid, generator = sim.bodies[0], np.random.default_rng(4)
    fluid.arrays["velocity"][:, :2] = generator.normal(size=(fluid.n_points, 2))
    forces(sim)
    sim.stages.find_contact()
    sim.stages.advance_momentum(1e-3)
    sim.stages.stop_approach()
    sim.stages.after_momentum(1e-3)
    fluid.grid_to_particle(1e-3, remap=True)
    sim.stages.before_stress(1e-3)
    cells = sim.parts.of(CellPressure)[0].cells
    volumes, grown = cells.sums[:, VOLUMES], cells.sums[:, RATES] + cells.found[:, SHIFT] * cells.sums[:, VOLUMES]
    scale = np.abs(grown).sum()
    assert np.abs(grown - cells.found[:, GROWTH] * volumes).max() < 1e-14 * scale
    assert abs(grown.sum()) < 1e-13 * scale, "the walls stand"
    assert abs(cells.sums[:, RATES].sum()) > 1e-3 * scale


@pytest.mark.parametrize(
    ("cell_pressure", "functions"), [(True, "quadratic-bspline"), (True, "trilinear"), (False, "trilinear")]
)
def test_gas_in_slow_motion_stays_slow(cell_pressure, functions):
    """A vortex at a twentieth of the speed of sound in a closed box: sums over points tear the gas apart."""
    sim = simulation(
        gas((4, 4, 1)) | {"cell_pressure": cell_pressure}, counts=(4, 4, 1), cell=0.2, support=WALLS, functions=functions
    )
    fluid = sim.bodies[0]
    x, y = np.pi / 0.8 * fluid.arrays["position"][:, :2].T
    fluid.arrays["velocity"][:, :2] = 0.06 * np.stack((np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)), axis=1)
    fluid.renew_totals()
    sim.begin_balance()
    before = sim.kinetic_energy()
    for _ in range(1600):
        sim.step()
    grown = abs(fluid.arrays["volume"].sum() / 0.64 - 1.0)
    if cell_pressure:
        assert sim.kinetic_energy() < before
        assert grown < 1e-3
    else:
        assert sim.kinetic_energy() > 2.0 * before
        assert grown > 0.01


def test_bits_do_not_depend_on_threads():
    found = []
    for threads in (1, 2):
        sim = simulation(gas((24, 4, 1), 0.2), counts=(24, 4, 1), cell=0.2, support=WALLS, threads=threads)
        fluid = sim.bodies[0]
        fluid.arrays["velocity"][:, :2] = np.random.default_rng(5).normal(size=(fluid.n_points, 2))
        for _ in range(30):
            sim.step()
        found.append(fluid.frame())
    for name, field in found[0].items():
        assert np.array_equal(field, found[1][name]), name


@every_scheme
def test_a_restart_has_the_same_bits(scheme):
    sims = [simulation(gas(), **PLANE, support=WALLS, scheme=scheme) for _ in range(2)]
    fluid = sims[0].bodies[0]
    fluid.arrays["velocity"][:, :2] = np.random.default_rng(7).normal(size=(fluid.n_points, 2))
    advance(sims[0], 20)
    arrays = {name: array.copy() for name, array in sims[0].state_arrays().items()}
    sims[1].restore(arrays, sims[0].state_numbers())
    for sim in sims:
        advance(sim, 20)
    for name, field in fluid.frame().items():
        assert np.array_equal(field, sims[1].bodies[0].frame()[name]), name


def test_a_body_that_is_led_has_no_use_for_it():
    motion = [{"name": "hand", "body": "gas", "hold": ["x", "y", "z"]}]
    with pytest.raises(ValueError, match=r"body\.0\.cell_pressure.*prescribed motion: its pressure has no effect"):
        case(box((0, 0, 0), (1, 1, 0), GAS, name="gas", cell_pressure=True), counts=(4, 4, 1), motion=motion)


def test_a_solid_has_no_use_for_it():
    with pytest.raises(ValueError, match=r"body\.0\.cell_pressure.*has shear stresses"):
        case(box((0, 0, 0), (1, 1, 0), SOLID, cell_pressure=True), counts=(4, 4, 1))
