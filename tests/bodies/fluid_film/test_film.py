"""Fluid films against exact motions, and as parts of a case."""

import numpy as np
import pytest
from films import PRESSURE, case, ran

import pellucid
from pellucid.errors import CaseError, RunStopped
from pellucid.references.membranes import Growing, tether
from pellucid.running.launch import resume_case
from pellucid.simulation.simulation import Simulation

SPHEROID = "spheroid = { radius = 1, nodes = 21 }"
OCTAGON = [[1, 0], [0.7, 0.7], [0, 1], [-0.7, 0.7], [-1, 0], [-0.7, -0.7], [0, -1], [0.7, -0.7]]
TOO_MUCH = 'volume = { reduced = 1.2, over = 1 }\narea = "kept"'
CROSSED = [*OCTAGON[:3], OCTAGON[4], OCTAGON[3], *OCTAGON[5:]]


@pytest.mark.parametrize(
    ("pressure", "on", "shape", "end"),
    [
        (0.15, "present-area", "ellipse", 5.0),
        (0.25, "initial-area", "ellipse", 5.0),
        (0.15, "present-area", "spheroid", 5.0),
        (-0.05, "present-area", "ellipse", 2.0),
    ],
)
def test_a_circle_and_a_sphere_grow_as_they_must(pressure, on, shape, end):
    text = f"{shape} = {{ radius = 1, nodes = 20 }}"
    _, film = ran(case(text, end, loads_of=PRESSURE.format(value=pressure, on=on)))
    exact = Growing(shape == "spheroid", 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, pressure, on == "initial-area")
    radius = float(exact.radii(np.array([0.0, end]))[-1])
    assert film.field("distance") == pytest.approx(radius, rel=3e-4)  # the accuracy of its own steps
    assert film.field("areal_density") == pytest.approx(float(exact.densities(np.array(radius))), rel=1e-3)


def test_errors_fall_at_second_order_in_the_step():
    """Twice as fine an accuracy is √½ of the step, and half of the error."""
    errors = []
    for accuracy in (1.6e-2, 4e-3, 1e-3):
        _, film = ran(case(end=2.0, more=f"density = 2\naccuracy = {accuracy}", every=2.0))
        errors.append(abs(film.field("distance").mean() - (2.0 - np.exp(-2.0 / 3.0))))
    assert errors[0] > 2.5 * errors[1] > 6.0 * errors[2]


def test_a_load_that_rises_does_not_ask_how_often_results_are_kept():
    """The film takes loads at the instants of its own steps, not at those of the clock, which follow the output."""
    load = PRESSURE.format(value=0.1, on="present-area") + "rise = 2\n"
    radii = [ran(case(end=4.0, loads_of=load, every=every))[1].field("distance").mean() for every in (0.05, 4.0)]
    assert radii[0] > 1.05
    assert radii[1] == pytest.approx(radii[0], rel=1e-4)
    pressure = '\n[[pressure]]\nbody = "film"\nvalue = 0.1\nrise = 2\n'
    assert ran(case(end=4.0, loads_of=pressure, every=4.0))[1].field("distance").mean() == pytest.approx(radii[1], rel=1e-12)


HOLD = """
[[support]]
name = "hold"
where = { box = { lower = [-1.1, -1, -1.1], upper = [1.1, 1, 0] } }
fix = ["z"]
"""


def test_a_grip_holds_a_film_that_came_to_rest():
    """The impulse of the support goes on to be that of the load, however long nothing moves."""
    along = PRESSURE.format(value=0.1, on="present-area") + "along = [0, 0, 1]\n"
    loads_of = along + PRESSURE.format(value=0.3, on="present-area") + HOLD
    simulation, film = ran(case(SPHEROID, 300.0, 100.0, "", "drag = { normal = 0.1, tangential = 0.1 }", loads_of, 1.0))
    assert not film.arrays["velocity"].any()
    before = simulation.budget.reactions()["hold"][2]
    simulation.clock.case = simulation.clock.case.model_copy(update={"end": 303.0})
    for _ in range(3):
        simulation.step()
    o, wind = film.geometry.operators(film.arrays["x"]), simulation.case.load[0]
    load = film.balance.traction_force(o, film.arrays["part_mass"], lambda points, after: wind.traction(points, after), 0.0)
    gained = simulation.budget.reactions()["hold"][2] - before
    assert gained == pytest.approx(-3.0 * load[:, 1].sum(), rel=1e-7)  # forces are left that move nothing by rounding


@pytest.mark.parametrize("shape", ["ellipse", "spheroid"])
def test_a_film_at_rest_stays_there(shape):
    """Nothing acts; what rounding leaves of forces and works is no error of the energy."""
    simulation, film = ran(case(f"{shape} = {{ radius = 1, nodes = 21 }}", 20.0, every=0.05))
    assert film.field("distance") == pytest.approx(1.0, abs=1e-12)
    assert not film.arrays["velocity"].any()
    assert simulation.budget.conservation()["energy"] == 0.0


@pytest.mark.parametrize(
    ("shape", "speed"),
    [
        ("ellipse = { radius = 1, nodes = 40 }", 0.15 / 3.0),
        ("spheroid = { radius = 1, nodes = 21 }", 0.15 / 8.0),
        ("surface = { icosphere = { centre = [0, 0, 0], radius = 1, refinements = 2 } }", 0.15 / 8.0),
    ],
)
def test_the_first_frame_has_the_velocities_of_the_balance(shape, speed):
    """R' = P R/(2μ+λ) of a circle, P R/(4(μ+λ)) of a sphere; nodes at poles and with five neighbours are up to 1.4e-2 off."""
    simulation = Simulation(case(shape, loads_of=PRESSURE.format(value=0.15, on="present-area")))
    assert simulation.time == 0.0
    film = simulation.bodies[0]
    outward = film.arrays["position"] / np.linalg.norm(film.arrays["position"], axis=1)[:, None]
    assert film.arrays["velocity"] == pytest.approx(speed * outward, abs=2e-2 * speed)
    assert np.einsum("ni,ni->n", film.arrays["velocity"], outward).mean() == pytest.approx(speed, rel=1e-3)
    assert not film.arrays["v"].any()


def test_a_circle_without_drag_needs_a_load_that_holds_itself():
    driven = PRESSURE.format(value=0.1, on="present-area") + "along = [0, 1, 0]\n"
    with pytest.raises(RunStopped, match=r"motions without resistance.*add `drag`"):
        ran(case(loads_of=driven))


@pytest.mark.parametrize(
    ("shape", "balanced", "along"),
    [
        ("ellipse = { radius = 1, nodes = 40 }", 0.15, 0.002),
        ("surface = { icosphere = { centre = [0, 0, 0], radius = 1, refinements = 2 } }", 1.0, 0.05),
        ("spheroid = { radius = 1, nodes = 21 }", 1.0, 0.05),
    ],
)
def test_a_small_load_that_nothing_balances_is_found_beside_one_that_is(shape, balanced, along):
    """In a sphere p n·e n has the resultant 4π p/3 and a pressure P the size 4π P; the run stops in its first step."""
    loads_of = PRESSURE.format(value=balanced, on="present-area")
    loads_of += PRESSURE.format(value=along, on="present-area") + f"along = {[0, 1, 0] if balanced < 1.0 else [0, 0, 1]}\n"
    with pytest.raises(
        RunStopped, match=r"load\.1 of kind film-pressure: forces of .* N, .* % of the loads.*`drag`"
    ) as stopped:
        ran(case(shape, loads_of=loads_of))
    told = str(stopped.value)
    assert "step 1," in told
    if balanced == 1.0:
        assert "curve" not in told
        assert "resultant of 0.209 N" in told  # 4π 0.05/3
        assert "1.7 % of the loads" in told


def test_the_volume_may_balance_what_the_tension_does_not():
    """A pressure in an ellipse whose volume is kept does no work."""
    load = PRESSURE.format(value=0.1, on="present-area")
    _, film = ran(case("ellipse = { radius = 1, radius_y = 0.6, nodes = 40 }", 0.2, more="volume = {}", loads_of=load))
    assert np.abs(film.arrays["velocity"]).max() < 1e-9


def test_a_load_that_no_tension_holds_stops_the_run():
    with pytest.raises(RunStopped, match=r"stretched to 0\.0\d* of its rest density .*its tension cannot carry the loads"):
        ran(case(end=100.0, loads_of=PRESSURE.format(value=0.3, on="present-area"), every=1.0))


@pytest.mark.parametrize(("shape", "share", "axis"), [("ellipse", 2.0, 1), ("spheroid", 3.0, 2)])
def test_a_film_that_is_driven_moves_as_a_rigid_body(shape, share, axis):
    direction = [0, 0, 0]
    direction[axis] = 1
    taut = PRESSURE.format(value=0.2, on="present-area")
    load = taut + PRESSURE.format(value=0.1, on="present-area") + f"along = {direction}\n"
    more = "drag = { normal = 0.5, tangential = 0.5 }"
    simulation, film = ran(case(f"{shape} = {{ radius = 1, nodes = 21 }}", 40.0, 100.0, "", more, load, 2.0))
    velocity = film.arrays["velocity"]
    assert velocity[:, axis] == pytest.approx(0.1 / (share * 0.5), rel=1e-6)
    assert np.abs(np.delete(velocity, axis, axis=1)).max() < 1e-9
    assert abs(simulation.budget.conservation()["mass"]) < 1e-13
    assert abs(simulation.budget.conservation()["energy"]) < 1e-3


@pytest.mark.parametrize(("mode", "rate"), [(2, 0.6241), (3, 2.5923)])
def test_modes_of_a_taut_curve_die_away_at_their_rate(mode, rate):
    """ω_n = S_n/(ζ (1 + 1/n²)), S_n = (n²-1)(P/R + κ (n²-1)/R⁴), of an inextensible curve."""
    n, tension, rigidity = 40, 0.2, 0.02
    angle = 2.0 * np.pi * np.arange(n) / n
    r = 1.0 + 1e-3 * np.cos(mode * angle)
    points = [[float(r_i * np.cos(a)), float(r_i * np.sin(a))] for r_i, a in zip(r, angle, strict=True)]
    stiffness = 1e4
    more = f"drag = {{ normal = 1, tangential = 1 }}\ndensity = {1.0 - tension / stiffness}\naccuracy = 1e-5"
    load = PRESSURE.format(value=tension, on="present-area")
    bending = f", bending_rigidity = {rigidity}"
    simulation = Simulation(case(f"curve = {{ points = {points} }}", 0.6, stiffness, bending, more, load))
    film, sizes = simulation.bodies[0], []
    while not simulation.clock.finished(None):
        simulation.step()
        radii = film.field("distance")
        sizes.append(2.0 * np.mean(radii * np.cos(mode * angle)) / radii.mean())
    found = -np.log(sizes[-1] / sizes[1]) / (simulation.time - 0.1)
    assert found == pytest.approx(rate, rel=0.01)


def test_a_vesicle_keeps_area_and_volume_and_comes_to_its_published_energy():
    more = 'volume = { reduced = 0.9, over = 0.5 }\narea = "kept"\ndrag = { normal = 0.1, tangential = 0.1 }'
    shape = "spheroid = { radius = 1, radius_z = 1.7, nodes = 31 }"
    of = case(shape, 4.0, 100.0, ", bending_rigidity = 1", more)
    simulation, film = ran(of)
    o = film.geometry.operators(film.arrays["x"])
    start = Simulation(of).bodies[0]
    assert o.area.sum() == pytest.approx(start.geometry.operators(start.arrays["x"]).area.sum(), rel=1e-5)
    assert 6.0 * np.sqrt(np.pi) * o.volume() / o.area.sum() ** 1.5 == pytest.approx(0.9, rel=1e-4)
    assert film.field("bending_energy").sum() / (8.0 * np.pi) == pytest.approx(1.18964, rel=1e-4)
    assert simulation.budget.energies()["support_work"] > 0.0, "it takes work to change the volume"
    assert abs(simulation.budget.conservation()["energy"]) < 2e-3  # of steps whose accuracy is 1e-3
    assert abs(simulation.budget.conservation()["mass"]) < 1e-13


def test_energy_never_grows_without_a_load():
    more = "drag = { normal = 1, tangential = 1 }\ndensity = 1.3"
    shape = "ellipse = { radius = 1, radius_y = 0.6, nodes = 24 }"
    simulation = Simulation(case(shape, 2.0, 1.0, ", bending_rigidity = 0.05", more))
    stored = [simulation.bodies[0].totals.stored]
    while not simulation.clock.finished(None):
        simulation.step()
        stored.append(simulation.bodies[0].totals.stored)
    assert np.all(np.diff(stored) <= 1e-12 * stored[0])


def test_a_support_holds_nodes_and_reports_its_force(tmp_path):
    pulled = """
[[support]]
name = "pull"
body = "film"
where = { box = { lower = [-1, -1, 0.99], upper = [1e-9, 1, 1.1] } }
fix = ["z"]
velocity = [0, 0, 0.1]

[[support]]
body = "film"
where = { box = { lower = [-1, -1, -1.1], upper = [1e-9, 1, -0.99] } }
fix = ["z"]

[[probe]]
name = "force"
quantity = "reaction"
condition = "pull"
component = "z"
"""
    of = case("spheroid = { radius = 1, nodes = 21 }", 0.5, 10.0, "", "", pulled)
    run = pellucid.run(of, out=tmp_path / "run", report=False)
    fields = run.fields("film")
    assert fields["position"][-1, 2] == pytest.approx(1.05)
    assert fields["position"][0, 2] == pytest.approx(-1.0)
    assert (run.history["force"][1:] > 0.0).all()
    assert np.abs(run.history["energy_error"]).max() < 1e-3
    assert run.history["support_work"][-1] > 0.0


def test_a_run_goes_on_from_its_checkpoint_bit_for_bit(tmp_path):
    shape = "spheroid = { radius = 1, radius_z = 1.5, nodes = 21 }"
    of = case(shape, 1.0, 10.0, ", bending_rigidity = 0.1", 'volume = {}\narea = "kept"')
    whole = pellucid.run(of, out=tmp_path / "whole", report=False)
    pellucid.run(of, out=tmp_path / "part", until=0.4, report=False)
    resumed = resume_case(tmp_path / "part", report=False)
    for name in ("position", "areal_density"):
        assert np.array_equal(whole.fields("film")[name], resumed.fields("film")[name])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shape": f"curve = {{ points = {[[float(i), 0.1 * (i > 5)] for i in range(8)]} }}"}, "the curve is open"),
        ({"shape": f"curve = {{ points = {[*OCTAGON[:3], OCTAGON[2], *OCTAGON[3:]]} }}"}, "coincide"),
        ({"shape": f"curve = {{ points = {[*OCTAGON, OCTAGON[0]]} }}"}, "a closed curve does not repeat its first point"),
        (
            {"shape": f"curve = {{ points = {[*OCTAGON[:5], OCTAGON[0], *OCTAGON[5:]]} }}"},
            r"points 0 and 5 coincide at \(.*\) m, but are not neighbours: a film must not touch itself",
        ),
        ({"shape": "ellipse = { radius = 1, radius_y = 1e-7, nodes = 40 }"}, "has two nodes at one position"),
        (
            {"shape": "surface = { ellipsoid = { centre = [0, 0, 0], radii = [1, 1, 1e-7], refinements = 2 } }"},
            "has two nodes at one position",
        ),
        ({"shape": f"curve = {{ points = {OCTAGON[:5]} }}"}, r"must have at least 8 items \(x and y of the nodes"),
        ({"shape": f"curve = {{ points = {OCTAGON[::-1]} }}"}, "clockwise"),
        ({"shape": f"meridian = {{ points = {[[0, -1], *OCTAGON]} }}"}, "open"),
        ({"bending": ", bending_rigidity = -1"}, "bending_rigidity"),
        ({"bending": ", bending_rigidity = 1"}, "a curve with bending needs drag"),
        ({"more": TOO_MUCH}, "encloses more than a circle of the same length"),
        (
            {"shape": SPHEROID, "more": 'volume = { reduced = 1.2, over = 1 }\narea = "kept"'},
            "no surface encloses more than a sphere of the same area",
        ),
        (
            {"shape": SPHEROID, "more": 'volume = { reduced = 1.0, over = 1 }\narea = "kept"'},
            "(?s)1 is above 0.999: a sphere, which has 1, cannot move at constant volume and area.*use at most 0.999",
        ),
        ({"more": TOO_MUCH.replace("1.2", "1.0")}, "1 is above 0.999: a circle"),
        (
            {"shape": SPHEROID, "more": 'volume = { reduced = 0.05, over = 1 }\narea = "kept"'},
            "(?s)0.05 would leave 0.033 m between the sides .* apart.*use a value of at least .* times as many nodes",
        ),
        (
            {"shape": "ellipse = { radius = 1, nodes = 40 }", "more": 'volume = { reduced = 0.05, over = 1 }\narea = "kept"'},
            r"(?s)0\.05 would leave .*use a value of at least 0\.158",
        ),
        ({"more": 'volume = { reduced = 0.9 }\narea = "kept"'}, "add `over = "),
        ({"more": "volume = { reduced = 0.9, over = 1 }"}, 'add area = "kept"'),
        ({"more": "volume = { over = 1 }"}, "applies to a changing volume"),
        ({"more": "density = 0.01"}, "too thin for a film"),
        (
            {"shape": f"curve = {{ points = {[*OCTAGON[:3], OCTAGON[4], OCTAGON[3], *OCTAGON[5:]]} }}"},
            "crosses the segment from point",
        ),
        ({"stiffness": 0.0}, "stiffness"),
        ({"more": "velocity = [1, 0, 0]"}, "follows from their loads"),
    ],
)
def test_what_cannot_be_is_refused(change, message):
    with pytest.raises(CaseError, match=message):
        case(**change)


def test_the_tube_of_a_tether_is_balanced():
    tube = tether(1.0, 0.005, 2.0)
    thin = tether(1.0, 0.005)
    assert thin.force == pytest.approx(2.0 * np.pi * np.sqrt(2.0 * 0.005))
    assert thin.radius == pytest.approx(np.sqrt(0.0025))
    h = 1e-6  # F is least where the tube is balanced across

    def energy(r):
        return np.pi * 0.005 / r + 2.0 * np.pi * r - np.pi * r * r * 2.0

    assert (energy(tube.radius + h) - energy(tube.radius - h)) / (2.0 * h) == pytest.approx(0.0, abs=1e-6)
    assert tube.force == pytest.approx(energy(tube.radius))
