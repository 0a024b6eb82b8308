"""How loads, pressures and gravity change in time: impulses of free bodies against the integral of the share."""

import films
import numpy as np
import pytest
from elements import element_sheet
from small_cases import RATE_SOLID, advance, box, case, simulation

from pellucid.conditions.signals.time_table import Amplitude
from pellucid.simulation.simulation import Simulation

PULSE = {"times": [0.1, 0.2, 0.4], "shares": [0.0, 2.0, -1.0]}
STEP, STEPS = 2e-3, 250  # to 0.5 s
IMPULSE = 0.5 * 0.1 * 2.0 + 0.5 * 0.2 * (2.0 - 1.0) - 0.1  # integral of the share until then [s]
FREE = {"counts": (6, 6, 6), "step": STEP}


def test_straight_lines_between_instants_constant_beyond():
    amplitude = Amplitude.model_validate(PULSE)
    found = [amplitude.at(time) for time in (0.0, 0.15, 0.2, 0.3, 0.4, 9.0)]
    assert found == pytest.approx([0.0, 1.0, 2.0, 0.5, -1.0, -1.0])


def test_a_file_is_the_same(tmp_path):
    (tmp_path / "pulse.csv").write_text("time,share\n0.1,0\n0.2,2\n0.4,-1\n")
    assert Amplitude(path=str(tmp_path / "pulse.csv")).at(0.3) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({}, "give either `times` and `shares`"),
        ({"times": [0, 1]}, "give either `times` and `shares`"),
        ({"times": [0, 1], "shares": [0, 1], "path": "x.csv"}, "give either `times` and `shares`"),
        ({"times": [0, 1], "shares": [0, 1, 2]}, "2 times and 3 shares"),
        ({"times": [0, 1, 1], "shares": [0, 1, 2]}, "time 1 s does not come after 1 s"),
        ({"path": "nowhere.csv"}, "cannot read the table"),
    ],
)
def test_what_is_no_function_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        Amplitude.model_validate(wrong)


def test_a_file_that_is_no_csv_is_refused_with_its_line(tmp_path):
    (tmp_path / "long.csv").write_text(f"0,1\n1,{'1' * 140_000}\n2,1\n")
    with pytest.raises(ValueError, match=r"line 2 of .*long\.csv cannot be read as CSV: field larger than"):
        Amplitude.model_validate({"path": str(tmp_path / "long.csv")})


def mean_velocity(sim):
    body = sim.bodies[0].arrays
    return body["mass"] @ body["velocity"] / body["mass"].sum()


@pytest.mark.parametrize("kind", ["body-force", "point-load"])
def test_a_load_gives_the_integral_of_its_share(kind):
    everywhere = {"box": {"lower": (2, 2, 2), "upper": (4, 4, 4)}}
    sizes = {"body-force": {"acceleration": (0.3, 0, 0)}, "point-load": {"force": (0.3 * 8000.0, 0, 0), "where": everywhere}}
    load = {"kind": kind, "body": "block", "amplitude": PULSE} | sizes[kind]
    sim = advance(simulation(box((2, 2, 2), (4, 4, 4), RATE_SOLID), load=[load], **FREE), STEPS)
    # a step takes the share at its beginning: wrong by half a step of the difference between the ends at most
    assert mean_velocity(sim)[0] == pytest.approx(0.3 * IMPULSE, abs=0.3 * STEP)
    assert abs(sim.budget.conservation()["momentum"]) < 1e-12


def gravity_case(body, **more):
    return case(body, gravity=(0.3, 0.0, 0.0), **(FREE | more))


@pytest.mark.parametrize("own_nodes", [False, True])
def test_gravity_gives_the_integral_of_its_share(own_nodes):
    body = element_sheet(points=(4, 4)) if own_nodes else box((2, 2, 2), (4, 4, 4), RATE_SOLID)
    found = gravity_case(body, **({"step": 2e-4, "lower": (-3, -3, -3)} if own_nodes else {}))
    changing = type(found).model_validate(found.to_data() | {"gravity_amplitude": PULSE})
    sim = Simulation(changing, threads=1)
    steps = round(0.5 / found.time.step)
    advance(sim, steps)
    assert mean_velocity(sim)[0] == pytest.approx(0.3 * IMPULSE, abs=0.3 * found.time.step)
    assert abs(sim.budget.conservation()["momentum"]) < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-9


def test_gravity_on_a_film_moves_it_by_the_integral_of_its_share():
    """A film without inertia falls against a drag ζ at ρ g/ζ, as a whole."""
    more = "drag = { normal = 2.0, tangential = 2.0 }"
    found = films.case("ellipse = { radius = 1, nodes = 20 }", end=0.5, every=STEP, more=more)
    changing = found.to_data() | {"gravity": (0.3, 0.0, 0.0), "gravity_amplitude": PULSE}
    sim = Simulation(type(found).model_validate(changing))
    start = sim.bodies[0].arrays["x"].mean(axis=0)
    while not sim.clock.finished(None):
        sim.step()
    moved = sim.bodies[0].arrays["x"].mean(axis=0) - start
    assert moved[0] == pytest.approx(0.3 / 2.0 * IMPULSE, abs=0.3 / 2.0 * STEP)
    assert abs(sim.budget.conservation()["energy"]) < 1e-6


def test_the_largest_share_of_gravity_bounds_the_step():
    """By the time in which a body falls through a cell."""
    slow = {"functions": "trilinear", "counts": (6, 6, 6)}
    found = case(box((2, 2, 2), (4, 4, 4), RATE_SOLID | {"young_modulus": 1e-6}), gravity=(8.0, 0.0, 0.0), **slow)
    changing = type(found).model_validate(found.to_data() | {"gravity_amplitude": {"times": [0, 1], "shares": [0, -4]}})
    steps = [Simulation(of, threads=1).clock.longest for of in (found, changing)]
    assert steps == pytest.approx([0.5, 0.25])


def test_rise_and_amplitude_exclude_each_other():
    load = {"kind": "body-force", "body": "block", "acceleration": (1, 0, 0), "rise": 1.0, "amplitude": PULSE}
    with pytest.raises(ValueError, match="cannot be combined"):
        case(box((2, 2, 2), (4, 4, 4)), load=[load])


def test_gravity_that_is_not_there_cannot_change():
    data = case(box((2, 2, 2), (4, 4, 4))).to_data()
    with pytest.raises(ValueError, match="the case has no gravity"):
        type(case(box((2, 2, 2), (4, 4, 4)))).model_validate(data | {"gravity_amplitude": PULSE})


def test_a_fluid_at_rest_needs_the_whole_of_gravity_at_the_start():
    water = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 50.0}}
    body = box((0, 0, 0), (4, 3, 4), water) | {"hydrostatic": {"level": 3.0}}
    data = case(body, gravity=(0, -1, 0)).to_data()
    with pytest.raises(ValueError, match="under full gravity, but its amplitude at time 0 is 0"):
        type(case(box((2, 2, 2), (4, 4, 4)))).model_validate(data | {"gravity_amplitude": {"times": [0, 1], "shares": [0, 1]}})


def test_pressure_on_a_membrane_changes_too():
    pressure = {"body": "sheet", "value": 2.0, "amplitude": PULSE}
    sheet = element_sheet(points=(4, 4))
    sim = simulation(sheet, pressure=[pressure | {"body": sheet["name"]}], **(FREE | {"step": 2e-4, "lower": (-3, -3, -3)}))
    advance(sim, round(0.5 / 2e-4))
    area = float(np.linalg.norm(sim.bodies[0].vector_areas().sum(axis=0)))
    given = float(np.linalg.norm(sim.momentum()))
    assert given == pytest.approx(2.0 * area * IMPULSE, rel=0.02)
