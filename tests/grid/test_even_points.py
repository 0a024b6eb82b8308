"""Even density and spacing of the points of a liquid: what the correction removes, what it conserves and where it acts."""

import numpy as np
import pytest
from small_cases import (
    GAS,
    SLIP,
    advance,
    assert_resumes,
    assert_same_arrays,
    box,
    case,
    copied_state,
    finished,
    past_a_disc,
    place,
    simulation,
)

from pellucid.errors import RunStopped
from pellucid.grid.even_points import FILLING, LEAST_SPACE, EvenPoints
from pellucid.grid.points import INVERTED
from pellucid.simulation.simulation import Simulation

N = 16
TAIT = {"kind": "tait", "sound_speed": 10.0, "carries_tension": True}
LIQUID = {"kind": "fluid", "density": 1.0, "viscosity": 0.01, "eos": TAIT, "even_points": True}
SKIN = {
    "kind": "membrane-elements",
    "name": "skin",
    "surface": {"sphere": {"centre": [0.5, 0.5, 0.5], "radius": 0.3, "divisions": 4}},
    "thickness": 0.01,
    "material": {"kind": "linear-membrane", "density": 1.0, "young_modulus": 1.0, "poisson_ratio": 0.3},
}
LID = [{"where": "y-upper", "velocity": (1, 0, 0)}, {"where": ["x-lower", "x-upper", "y-lower"]}]


def full_box(material=LIQUID, functions="trilinear", threads=1, **more):
    body = box((0, 0, 0), (1, 1, 1 / N), material, (2, 2, 1), "water", **more.pop("body", {}))
    table = {"counts": (N, N, 1), "cell": 1 / N, "functions": functions, "transfer": "apic", "support": SLIP[:4]}
    return Simulation(case(body, **table | more), threads=threads)


def part_of(sim):
    (found,) = sim.parts.of(EvenPoints)
    return found


def spread(sim):
    """Return the difference between the 1st and the 99th percentile of the densities over their median."""
    least, middle, most = np.percentile(sim.bodies[0].field("density"), [1, 50, 99])
    return (most - least) / middle


def test_densities_that_cells_cannot_represent_disappear():
    """Without motion the correction acts on densities alone: their noise falls, their sum and linear fields remain."""
    sim = full_box()
    water, generator = sim.bodies[0], np.random.default_rng(1)
    volume, x = water.arrays["volume"], water.arrays["position"]
    linear = volume[0] * (1.0 + 0.01 * x[:, 0] - 0.02 * x[:, 1])
    inside = np.all((x[:, :2] > 4 / N) & (x[:, :2] < 1 - 4 / N), axis=1)
    volume[:] = linear
    part_of(sim).begin(0.0, 0.01)
    assert volume[inside] == pytest.approx(linear[inside], rel=1e-12)
    noise = generator.uniform(-0.1, 0.1, len(volume)) * volume[0]
    volume[:] = linear + noise
    total = volume.sum()
    part_of(sim).begin(0.0, 0.01)
    assert np.std((volume - linear)[inside]) < 0.6 * np.std(noise[inside])
    assert volume.sum() == pytest.approx(total, rel=1e-13)


def test_crowded_points_spread_at_the_pace_of_the_flow():
    """A crowd one wave long: in the time in which the fastest point crosses a cell volumes approach the space of the points
    by FILLING, and the points move apart. Momentum and energy remain."""
    sim = full_box(body={"velocity": (0.3, 0.1, 0)})
    water = sim.bodies[0]
    x = water.arrays["position"]
    moved = np.stack((0.02 * np.sin(2 * np.pi * x[:, 0]), 0 * x[:, 0], 0 * x[:, 0]), axis=1)
    place(water, x - moved)
    sim = advance(sim, 1)
    part, dt = part_of(sim), 1e-3
    part._find_errors()
    before = part._cells.error[part._index].copy()
    energy, momentum = water.totals.kinetic + water.totals.stored, water.totals.momentum.copy()
    rate = dt * water.fastest() * N
    part.begin(0.0, dt)
    part._find_errors()
    after = part._cells.error[part._index]
    fitted = np.sum(after * before) / np.sum(before**2)
    assert np.std(before) > 0.05
    assert 1.0 - 1.3 * FILLING * rate < fitted < 1.0 - 0.95 * FILLING * rate
    assert water.totals.kinetic + water.totals.stored == pytest.approx(energy, rel=1e-14)
    assert water.totals.momentum == pytest.approx(momentum, abs=1e-15)


def test_rows_of_even_points_are_no_error_at_any_distance():
    """Points of a flow along a wall lie in rows, whose distances the flow changes. Functions that reach one cell find every
    other cell crowded by a tenth where 2.5 or 1.5 rows lie in a cell; the correction would turn this into velocities."""
    sim = full_box(support=[], periodic=["x", "y"])
    water, rows, columns = sim.bodies[0], 5 * N // 2, 3 * N // 2
    x, y = (np.arange(rows) + 0.25) / rows, (np.arange(columns) + 0.25) / columns
    position, volume = water.arrays["position"], water.arrays["volume"]
    even = rows * columns
    volume[even:], volume[:even] = 0.0, 1.0 / even
    position[:even, 0], position[:even, 1] = (at.ravel() for at in np.meshgrid(x, y, indexing="ij"))
    place(water, position.copy())
    part = part_of(sim)
    part._find_errors()
    assert np.abs(part._cells.error[part._index]).max() < 1e-12


def test_a_free_block_flies_as_without():
    """There is a surface near each of its cells that is not full: nothing pulls its points outwards."""
    body = box((0.2, 0.2, 0), (0.7, 0.7, 1 / N), LIQUID, (2, 2, 1), "water", velocity=(0.5, 0.25, 0))
    how = {"counts": (2 * N, N, 1), "cell": 1 / N, "functions": "quadratic-bspline", "transfer": "apic"}
    plain = body | {"material": LIQUID | {"even_points": False}}
    found, expected = (advance(simulation(one, **how), 100) for one in (body, plain))
    for name in ("position", "velocity", "density"):
        assert found.bodies[0].field(name) == pytest.approx(expected.bodies[0].field(name), abs=1e-10)


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_densities_below_a_moving_lid_stay_even(functions):
    """Lid-driven cavity, Re 100, until the lid has moved by some ten cells."""
    even = advance(full_box(support=LID, functions=functions), 450)
    plain = advance(full_box(LIQUID | {"even_points": False}, support=LID, functions=functions), 450)
    assert spread(even) < 0.06
    assert spread(plain) > 2.0 * spread(even)
    conservation = even.budget.conservation()
    assert abs(conservation["energy"]) < 1e-13
    assert conservation["momentum"] < 1e-13


def test_the_space_beside_a_wall_is_what_its_shape_leaves():
    """Cells that the edge of a disc cuts have 4 x 4 samples; others are all inside or all outside."""
    space, n = part_of(past_a_disc(1.0, even_points=True))._space[:, :, 0], 24
    assert space.sum() / n**2 == pytest.approx(1.0 - np.pi * 0.16**2, rel=2e-3)
    x, y = (np.indices(space.shape) + 0.5) / n
    distance = np.hypot(x - 0.5, y - 0.5)
    assert np.all(space[distance < 0.16 - 1.5 / n] == 0.0)
    assert np.all(space[distance > 0.16 + 1.5 / n] == 1.0)


def test_an_error_that_changes_its_sign_in_each_step_is_none():
    """With an implicit pressure, velocities of two steps alternate about their mean. Corrections of the present error alone
    grew in each step, and points between two walls left the grid."""
    sim = full_box(body={"velocity": (0.3, 0.1, 0)})
    water, part = sim.bodies[0], part_of(sim)
    x = water.arrays["position"]
    place(water, x - np.stack((0.02 * np.sin(2 * np.pi * x[:, 0]), 0 * x[:, 0], 0 * x[:, 0]), axis=1))
    part._find_errors()
    error = part._cells.error[part._index].copy()
    assert np.abs(error).max() > 0.05
    before = {name: water.arrays[name].copy() for name in ("position", "volume", "velocity")}
    part._error = -error
    part.begin(0.0, 1e-3)
    for name, values in before.items():
        assert water.arrays[name] == pytest.approx(values, rel=1e-12, abs=1e-18)


def test_crowded_points_beside_a_wall_are_not_driven_into_it():
    """Cells with almost no space outside the wall were taken to be right, so that the error fell into the wall."""
    sim = past_a_disc(1.0, even_points=True)
    part, errors = part_of(sim), []
    for _ in range(2):
        part._find_errors()
        errors.append(part._cells.error[part._index].copy())
        sim.bodies[0].arrays["volume"] *= 1.05
    beside = (part._space < LEAST_SPACE) & part._near(part._space >= LEAST_SPACE, 1)
    assert np.any(beside)
    assert errors[1][beside] == pytest.approx(0.05 + 1.05 * errors[0][beside], rel=1e-9)


def test_flow_past_a_disc_stays_as_it_is():
    """Points leave gaps behind a disc: without a correction there, the flow grows by an eighth while the liquid passes five
    times. Reference: Sangani & Acrivos 1982, Int. J. Multiph. Flow 8, 193, square array of cylinders."""
    share = np.pi * 0.16**2
    drag = 4 * np.pi / (-0.5 * np.log(share) - 0.738 + share - 0.887 * share**2 + 2.039 * share**3)
    sim, found = past_a_disc(25.0, even_points=True), []
    for until in (3.0, 25.0):
        while sim.time < until:
            sim.step()
        found.append(sim.momentum()[0] / sim.bodies[0].mass)
    assert found[1] == pytest.approx(found[0], rel=0.02)
    assert found[1] == pytest.approx(4.0 / drag / (1.0 - share), rel=0.06)


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_same_bits_on_two_threads_and_after_a_stop(functions):
    one, two = (advance(full_box(support=LID, functions=functions, threads=n), 80) for n in (1, 2))
    assert_same_arrays(copied_state(one), copied_state(two))
    assert_resumes(one, full_box(support=LID, functions=functions), 0, 40)


def test_it_is_for_liquids_with_apic():
    with pytest.raises(ValueError, match=r"even_points = true, but .*depends on the energy; use a liquid"):
        full_box(GAS | {"even_points": True})
    with pytest.raises(ValueError, match=r"even_points = true, but energy_update = 'closed'"):
        full_box(LIQUID | {"energy_update": "closed"})
    with pytest.raises(
        ValueError, match=r"even_points: points that move need an affine velocity field, which the transfer \"flip\""
    ):
        full_box(transfer="flip")


def test_it_is_refused_beside_membranes():
    """It would move points of a liquid through the membrane of a drop: a cell in a slit lost the liquid around it."""
    grid = {"counts": (8, 8, 8), "cell": 0.125, "transfer": "apic"}
    water = box((0, 0, 0), (1, 1, 1), LIQUID, name="water")
    with pytest.raises(
        ValueError, match=r"moves points to where points are missing, also through skin in the same velocity field"
    ):
        case(water, SKIN, **grid)
    assert len(case(water, SKIN | {"field": "own"}, **grid).body) == 2


def test_implicit_pressure_passes_the_corners_of_a_lid():
    """Without the correction volumes of points at the corners of the lid become negative."""
    implicit = LIQUID | {"implicit_pressure": True}
    how = {"support": LID, "functions": "quadratic-bspline", "scheme": "usl", "end": 4.0, "output": {"history": 0.1}}
    even = finished(full_box(implicit, **how))
    assert spread(even) < 0.15
    assert abs(even.budget.conservation()["energy"]) < 1e-13
    advice = "set body.water.cell_pressure = true and body.water.material.even_points = true, or use"
    with pytest.raises(RunStopped, match=f"its volume would become zero or negative in this step; {advice}"):
        finished(full_box(implicit | {"even_points": False}, **how))


@pytest.mark.filterwarnings("ignore:.*contain no points")
def test_vortices_in_a_box_keep_their_cells_filled():
    """At the walls between vortices a liquid is stretched by ten times in a second, and points gather in rows. If functions
    that reach one cell measured the errors, points would leave the places around these rows, and the run would stop."""
    body = box((0, 0, 0), (1, 1, 1 / 32), LIQUID | {"implicit_pressure": True}, (2, 2, 1), "water", cell_pressure=True)
    how = {"counts": (32, 32, 1), "cell": 1 / 32, "functions": "quadratic-bspline", "transfer": "apic", "scheme": "usl"}
    sim = Simulation(case(body, **how, support=SLIP[:4], end=1.0))
    water, k = sim.bodies[0], np.pi
    (sx, sy), (cx, cy) = (f(k * water.arrays["position"][:, :2].T) for f in (np.sin, np.cos))
    water.arrays["velocity"][:, :2] = np.stack((sx * cy, -cx * sy), axis=1)
    water.arrays["affine"][:, [0, 1, 3, 4]] = k * np.stack((cx * cy, -sx * sy, sx * sy, -cx * cy), axis=1)
    part, least = part_of(sim), 0.0
    while sim.time < 0.8:
        sim.step()
        least = min(least, part._cells.error[part._index].min())
    assert least > -0.5


OPEN = {"inflow": [{"body": "water", "where": "x-lower", "velocity": 0.1}], "outflow": [{"where": ["x-upper"]}]}
IMPLICIT = {"scheme": "usl", "functions": "quadratic-bspline"}


@pytest.mark.parametrize(
    ("material", "body", "more", "settings"),
    [
        ({}, {}, {}, ["even_points"]),
        ({"even_points": True}, {}, {}, []),
        ({"implicit_pressure": True}, {}, IMPLICIT, ["even_points", "cell_pressure"]),
        ({"implicit_pressure": True, "even_points": True}, {}, IMPLICIT, ["cell_pressure"]),
        ({"implicit_pressure": True, "even_points": True}, {"cell_pressure": True}, IMPLICIT, []),
        ({"implicit_pressure": True, "second_viscosity": 0.01}, {}, IMPLICIT, ["even_points"]),
        ({"implicit_pressure": True}, {}, IMPLICIT | OPEN | {"support": SLIP[2:4]}, ["even_points"]),
    ],
)
def test_the_advice_about_densities_can_be_followed(material, body, more, settings):
    """All settings that the case accepts and lacks are named, and no others: `cell_pressure` closes open faces and needs
    Stokes' second viscosity."""
    found = full_box(LIQUID | {"even_points": False} | material, body=dict(body), **more)
    water = found.bodies[0]
    water.arrays["volume"][::50] *= 1.2
    advice, remedy = water.state_warning().rsplit("; ", 1)[1], water.fault(INVERTED, 0).remedy
    assert advice.startswith("for confined flow set " if settings else "use a smaller grid.cell")
    for name in ("even_points", "cell_pressure"):
        assert (f"{name} = true" in advice) == (name in settings)
        assert (f"{name} = true" in remedy) == (name in settings and "implicit_pressure" in material)
    assert ("artificial viscosity" in remedy) == ("implicit_pressure" not in material)
    followed = LIQUID | {"even_points": False} | material | ({"even_points": True} if "even_points" in settings else {})
    full_box(followed, body=body | ({"cell_pressure": True} if "cell_pressure" in settings else {}), **more)


def test_beside_a_membrane_only_smaller_cells_are_advised():
    water = box((0, 0, 0), (1, 1, 1), LIQUID | {"even_points": False, "implicit_pressure": True}, name="water")
    sim = simulation(water, SKIN, counts=(8, 8, 8), cell=0.125, transfer="apic", **IMPLICIT)
    sim.bodies[0].arrays["volume"][::50] *= 1.2
    assert sim.bodies[0].state_warning().endswith("wrong; use a smaller grid.cell")
    assert sim.bodies[0].fault(INVERTED, 0).remedy == "use a smaller time.step or time.courant, or a finer grid.cell"


def test_a_run_names_densities_that_drift():
    sim = full_box(LIQUID | {"even_points": False})
    water = sim.bodies[0]
    water.arrays["volume"][::50] *= 1.2
    assert "the densities of 2" in water.state_warning()
    assert "set body.water.material.even_points = true" in water.state_warning()
    water.arrays["volume"][::50] /= 1.2
    assert water.state_warning() is None
