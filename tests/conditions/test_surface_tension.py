"""Surface tension: pressure of Laplace, exact forces, momentum, contact angle, step, resuming, and what is refused."""

import numpy as np
import pytest

from pellucid.case import Case, loads
from pellucid.conditions.surface_tension.active import TenseSurface
from pellucid.conditions.surface_tension.planes import WettedPlane, find_open_space
from pellucid.contact.wall_plane import WallPlane
from pellucid.errors import CaseError
from pellucid.results.storage import history
from pellucid.running.launch import resume_case, run_case
from pellucid.running.step_number import of_case
from pellucid.simulation.simulation import Simulation

LIQUID = {
    "kind": "fluid",
    "density": 1.0,
    "pressure": 1.0,
    "viscosity": 0.05,
    "eos": {"kind": "tait", "sound_speed": 20.0, "carries_tension": True},
}
FLOOR = [{"where": "y-lower", "fix": "normal"}]


def case(radius=1.0, cell=0.2, centre=(0.03, 0.07, 0.0), end=0.4, grid=None, tension=None, body=None, **more):
    """A drop in a plane."""
    drop = {"name": "drop", "shape": {"cylinder": {"centre": centre, "radius": radius}}, "points_per_cell": [3, 3, 1]}
    table = {
        "schema": 1,
        "title": "a drop",
        "grid": {"lower": [-1.6, -1.6, 0], "upper": [1.6, 1.6, 0], "cell": cell, "functions": "quadratic-bspline"}
        | (grid or {}),
        "time": {"end": end, "transfer": "apic"} | more.pop("time", {}),
        "body": [drop | {"material": LIQUID} | (body or {})],
        "surface_tension": [{"body": "drop", "tension": 1.0} | (tension or {})],
    }
    return Case.model_validate(table | more)


def simulation(threads=1, **more):
    return Simulation(case(**more), threads=threads)


def surface_of(sim):
    return sim.parts.of(TenseSurface)[0]


def assert_exact(sim):
    """Forces are the derivative of the energy by places and volumes."""
    body, surface, chance = sim.bodies[0], surface_of(sim), np.random.default_rng(1)
    position, volume = body.arrays["position"], body.arrays["volume"]
    position[:, :2] += chance.uniform(0.0, 0.01, (len(position), 2))
    body.storage.sort()
    place, size = position.copy(), volume.copy()
    moves, grows = chance.normal(size=place.shape) * (1.0, 1.0, 0.0), size * chance.normal(size=size.shape)

    def energy(step):
        position[:], volume[:] = place + step * moves, size + step * grows
        surface.begin(0.0, 0.0)
        return surface.columns()["drop_surface_energy"]

    slope = (energy(1e-6) - energy(-1e-6)) / 2e-6
    energy(0.0)
    at_points = surface._values
    assert np.sum(size[:, None] * at_points[:, 1:] * moves) + np.sum(at_points[:, 0] * grows) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("angle", [90.0, 60.0, 130.0])
def test_forces_are_the_derivative_of_the_energy(angle):
    block = {"shape": {"box": {"lower": [-1.6, -1.6, 0], "upper": [0.05, 0.13, 0]}}}
    walls = [FLOOR[0] | {"contact_angle": angle}, {"where": "x-lower", "fix": "normal", "contact_angle": 0.9 * angle}]
    sim = simulation(body=block, support=walls)
    assert_exact(sim)


def test_a_drop_has_the_energy_of_its_surface_and_keeps_momentum():
    sim = simulation(cell=0.1, end=0.2)
    for _ in sim:
        pass
    assert surface_of(sim).columns()["drop_surface_energy"] == pytest.approx(2.0 * np.pi, rel=0.01)
    assert sim.budget.conservation()["momentum"] < 1e-12
    body = sim.bodies[0]
    assert np.abs(body.totals.momentum).max() < 1e-14


def stiffness(cells):
    """Second derivative of the energy by the stretch s of a drop (e^s along x, e^-s along y), over that of the perimeter."""
    sim = simulation(cell=1.0 / cells, centre=(0.0, 0.0, 0.0), grid={"lower": [-1.8, -1.8, 0], "upper": [1.8, 1.8, 0]})
    body, surface = sim.bodies[0], surface_of(sim)
    place, stretch = body.arrays["position"].copy(), np.linspace(-0.12, 0.12, 13)
    radius = np.sqrt(body.arrays["volume"].sum() / np.pi)
    angle, energies, lengths = (np.arange(400) + 0.5) * np.pi / 800, [], []
    for s in stretch:
        body.arrays["position"][:] = place * (np.exp(s), np.exp(-s), 1.0)
        surface.begin(0.0, 0.0)
        energies.append(surface.columns()["drop_surface_energy"])
        lengths.append(2.0 * np.pi * radius * np.mean(np.hypot(np.exp(s) * np.sin(angle), np.exp(-s) * np.cos(angle))))
    return np.polyfit(stretch, energies, 2)[0] / np.polyfit(stretch, lengths, 2)[0]


@pytest.mark.parametrize(("cells", "tolerance"), [(5, 0.06), (7.5, 0.025), (15, 0.015)])
def test_a_drop_resists_as_its_surface_does(cells, tolerance):
    """Without the second level of smoothing, curvature makes the drop softer by (4.5 h/R)²/6: 14, 6 and 1.5 %. What remains
    is of higher order, and the noise of the energy as the surface crosses cells: 1e-4 of it, 1 % of its change here."""
    assert stiffness(cells) == pytest.approx(1.0, abs=tolerance)


def test_a_face_that_nothing_holds_draws_no_drop():
    sim = simulation(centre=(-0.5, 0.0, 0.0), end=0.3)
    for _ in sim:
        pass
    assert np.abs(sim.bodies[0].totals.momentum).max() < 1e-14


def test_a_drop_rests_at_the_pressure_of_laplace():
    sim = simulation(cell=0.2, end=6.0, body={"material": LIQUID | {"viscosity": 0.3}})
    pressures = []
    for _ in sim:
        if sim.time > 2.0:
            stress, place = sim.bodies[0].field("stress"), sim.bodies[0].field("position")
            pressures.append(-stress[np.linalg.norm(place[:, :2], axis=1) < 0.6, :3].mean())
    assert np.mean(pressures) == pytest.approx(1.0, rel=0.03)
    assert 0.3 * sim.bodies[0].fastest() < 0.01  # the capillary number of what still moves


@pytest.mark.parametrize(("angle", "height"), [(60.0, 0.807), (120.0, 1.193)])
def test_a_drop_on_a_floor_has_the_height_of_its_contact_angle(angle, height):
    wide = 1.0 if angle < 90.0 else 0.8
    block = {
        "shape": {"box": {"lower": [-wide, 0, 0], "upper": [wide, 0.8 / wide, 0]}},
        "material": LIQUID | {"viscosity": 0.5, "pressure": 0.0, "eos": LIQUID["eos"] | {"sound_speed": 10.0}},
    }
    grid = {"lower": [-2.2, 0, 0], "upper": [2.2, 1.6, 0]}
    sim = simulation(cell=0.1, end=5.0, grid=grid, body=block, tension={"contact_angle": angle}, support=FLOOR)
    for _ in sim:
        pass
    assert sim.bodies[0].field("position")[:, 1].max() + 0.1 / 6.0 == pytest.approx(height, rel=0.03)


STILL = LIQUID | {"viscosity": 0.5, "pressure": 0.0, "eos": LIQUID["eos"] | {"sound_speed": 10.0}}
WALL, MIRROR = {"fix": "normal", "contact_angle": 60.0}, {"fix": "normal", "contact_angle": 90.0}


def rests(upper, box, end=5.0, **more):
    """Where the outermost points of a block of liquid are that came to rest, with half their distance."""
    fine = 3 if upper[2] == 0 else 2
    grid, shape = {"lower": [0, 0, 0], "upper": upper}, {"box": {"lower": [0, 0, 0], "upper": box}}
    body = {"shape": shape, "points_per_cell": [fine, fine, fine if upper[2] else 1], "material": STILL}
    sim = simulation(grid=grid, body=body, end=end, **more)
    for _ in sim:
        pass
    assert STILL["viscosity"] * sim.bodies[0].fastest() < 0.01
    return sim.bodies[0].field("position").max(axis=0) + 0.5 * sim.bodies[0].grid.lattice.cell / fine


def test_half_a_drop_beside_a_plane_of_symmetry():
    """The arc of 60 degrees over an area of 0.5."""
    x, y, _ = rests(
        [2, 1.4, 0], [0.7, 5 / 7, 0], cell=0.1, support=[WALL | {"where": "y-lower"}, MIRROR | {"where": "x-lower"}]
    )
    radius = np.sqrt(1.0 / (np.pi / 3 - np.sqrt(3) / 4))
    assert y == pytest.approx(0.5 * radius, rel=0.03)
    assert x == pytest.approx(np.sqrt(0.75) * radius, rel=0.03), "no foot creeps ahead"


def test_a_quarter_of_a_drop_in_space():
    """The cap of 60 degrees over a volume of 2.048 in all."""
    planes = [MIRROR | {"where": ["x-lower", "z-lower"]}, WALL | {"where": "y-lower"}]
    x, y, z = rests([1.8, 1.4, 1.8], [0.8, 0.8, 0.8], end=4.0, cell=0.2, support=planes)
    radius = np.cbrt(2.048 / (np.pi * 2.5 / 12))
    assert y == pytest.approx(0.5 * radius, rel=0.03)
    assert x == pytest.approx(z, rel=1e-9)
    assert x == pytest.approx(np.sqrt(0.75) * radius, rel=0.06)


def test_a_drop_between_two_walls_of_different_angles():
    """An arc in a corner: its centre lies -R cos θ before each wall."""
    walls = [{"where": "y-lower", "fix": "normal", "contact_angle": 60.0}]
    walls += [{"where": "x-lower", "fix": "normal", "contact_angle": 100.0}]
    x, y, _ = rests([2, 1.4, 0], [1.0, 0.6, 0], end=7.0, cell=0.1, support=walls)  # the grid holds the edge for a while
    a, b = -np.cos(np.radians([100.0, 60.0]))
    places = np.linspace(0.0, a + np.sqrt(1.0 - b * b), 200001)
    radius = np.sqrt(0.6 / np.trapezoid(np.maximum(b + np.sqrt(1.0 - (places - a) ** 2), 0.0), places))
    assert y == pytest.approx((b + 1.0) * radius, rel=0.03)
    assert x == pytest.approx((a + np.sqrt(1.0 - b * b)) * radius, rel=0.05)


def on_a_plane(tilt, angle, **more):
    """Height over a wall and half the width of a block of liquid with an area of 1.6 that came to rest there."""
    cos, sin = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    along, normal = [cos, sin, 0], [-sin, cos, 0]
    point = np.array([0.0, 0.05, 0.0])
    box = {"box": {"lower": [-0.9, 0.05, 0], "upper": [0.9, 0.05 + 8 / 9, 0]}}
    turned = {"rotate": [{"angle": tilt, "axis": [0, 0, 1], "centre": point.tolist()}]} if tilt else {}
    body = {"shape": box | turned, "material": STILL}
    wall = {"point": point.tolist(), "normal": normal, "contact_angle": angle} | more
    sim = simulation(cell=0.1, end=4.5, grid={"lower": [-2.2, -1, 0], "upper": [2.2, 2, 0]}, body=body, wall=[wall])
    for _ in sim:
        pass
    places = sim.bodies[0].field("position") - point
    return (places @ normal).max() + 0.1 / 6, 0.5 * np.ptp(places @ along) + 0.1 / 6


@pytest.mark.parametrize("tilt", [0.0, 20.0], ids=["level", "oblique"])
def test_a_drop_on_a_plane_that_cuts_cells(tilt):
    height, wide = on_a_plane(tilt, 60.0)
    assert height == pytest.approx(0.807, rel=0.03)
    assert wide == pytest.approx(1.398, rel=0.03)


@pytest.mark.parametrize("level", [0.0, 0.025, 0.13])
def test_a_plane_on_or_near_a_face_that_nothing_holds(level):
    """The arc of 50 degrees over an area of 0.5, half of it; the face behind the wall is none that the fluid meets."""
    wall = {"point": [0, level, 0], "normal": [0, 1, 0], "contact_angle": 50.0}
    grid = {"lower": [0, 0, 0], "upper": [2, 1.4, 0]}
    body = {"shape": {"box": {"lower": [0, level, 0], "upper": [0.8, level + 0.625, 0]}}, "material": STILL}
    sim = simulation(cell=0.1, end=4.5, grid=grid, body=body, wall=[wall], support=[MIRROR | {"where": "x-lower"}])
    for _ in sim:
        pass
    angle = np.radians(50.0)
    radius = np.sqrt(1.0 / (angle - np.sin(angle) * np.cos(angle)))
    height = sim.bodies[0].field("position")[:, 1].max() + 0.1 / 6 - level
    assert height == pytest.approx((1.0 - np.cos(angle)) * radius, rel=0.04)


def test_a_plane_has_all_of_its_area_wherever_it_lies():
    """A floor of 2 m by the thickness of the slice, on a face, within cells and on nodes, and an oblique one."""
    grid = simulation(grid={"lower": [0, 0, 0], "upper": [2, 1, 0]}, centre=(1, 0.5, 0), radius=0.4).bodies[0]
    thickness = grid.grid.slice_thickness
    for level in (0.0, 0.004, 0.1, 0.17, 0.2, 1.0):
        plane = WettedPlane(WallPlane((0, level, 0), (0, 1, 0), (0, 0, 0)), 0.5)
        space = find_open_space(grid.grid, grid.functions, [plane])
        assert space.areas[0].sum() == pytest.approx(2.0 * thickness, rel=1e-12)
        assert np.all(space.faces[1][0] == 0.0), "the lower face lies on the plane or behind it"
        assert np.all(space.faces[1][1] == (0.0 if level == 1.0 else 1.0))
    oblique = WettedPlane(WallPlane((0, 0.1, 0), (-0.3, 1, 0), (0, 0, 0)), 0.5)
    space = find_open_space(grid.grid, grid.functions, [oblique])
    assert space.areas[0].sum() == pytest.approx(2.0 * np.hypot(1.0, 0.3) * thickness, rel=1e-12)
    assert space.faces[0][0].ravel() == pytest.approx([0.25, 0.875, 1, 1, 1, 1]), "of the left face, what lies above 0.1"


def test_forces_beside_planes_are_the_derivative_of_the_energy_too():
    block = {"shape": {"box": {"lower": [-1.2, -1.3, 0], "upper": [0.05, 0.13, 0]}}}
    walls = [{"point": [-1.2, -1.31, 0], "normal": [0.2, 1, 0], "contact_angle": 50.0, "name": "floor"}]
    walls += [{"point": [-1.22, 0, 0], "normal": [1, 0, 0], "contact_angle": 120.0}]
    assert_exact(simulation(body=block, wall=walls))


def angles_of(*supports, angle=60.0, **more):
    table = case(support=supports, tension={"contact_angle": angle}, **more)
    return next(dict(one.angles) for several in table.conditions().values() for one in several if hasattr(one, "angles"))


FLAT = {"point": [0, -1.5, 0], "normal": [0, 1, 0]}
SIDE = {"where": "x-lower", "fix": "normal"}


@pytest.mark.parametrize(
    ("supports", "angles"),
    [
        ([*FLOOR], {"y-lower": 60.0}),
        ([FLOOR[0] | {"contact_angle": 50.0}, SIDE | {"contact_angle": 90.0}], {"y-lower": 50.0, "x-lower": 90.0}),
        ([{"where": "y-lower"}, SIDE | {"contact_angle": 90.0}], {"y-lower": 60.0, "x-lower": 90.0}),
        ([FLOOR[0] | {"friction": 0.1}, SIDE | {"contact_angle": "1.5 rad"}], {"y-lower": 60.0, "x-lower": np.degrees(1.5)}),
        ([{"where": ["x-upper", "y-lower"]}], {"x-upper": 60.0, "y-lower": 60.0}),
    ],
)
def test_the_role_of_a_face(supports, angles):
    assert angles_of(*supports) == pytest.approx(angles)
    assert angles_of(*supports[::-1]) == pytest.approx(angles)


def test_a_face_at_which_a_body_is_cut_is_a_plane_of_symmetry():
    half = {"shape": {"cylinder": {"centre": [-1.6, 0, 0], "radius": 1}}, "cut_at": ["x-lower"]}
    assert angles_of(*FLOOR, SIDE, body=half) == {"x-lower": 90.0, "y-lower": 60.0}


def test_a_wall_has_the_angle_of_the_fluid_or_its_own():
    walls = [FLAT, FLAT | {"point": [0, -1.4, 0], "contact_angle": 30.0}, FLAT | {"velocity": [0, -1, 0]}]
    table = case(tension={"contact_angle": 60.0}, wall=walls)
    (tension,) = (one for several in table.conditions().values() for one in several if hasattr(one, "angles"))
    assert [angle for _, angle in tension.walls] == [60.0, 30.0], "none where a wall moves along its normal"
    with pytest.raises(ValueError, match="is a wall"):
        case(tension={"contact_angle": 60.0}, wall=[FLAT], support=[SIDE])


def test_faces_without_an_angle_are_neutral_where_the_fluid_has_none():
    assert angles_of(*FLOOR, SIDE, angle=90.0) == {"x-lower": 90.0, "y-lower": 90.0}


@pytest.mark.parametrize("floor", [FLOOR[0], {"where": "y-lower"}, FLOOR[0] | {"contact_angle": 60.0}])
def test_a_face_that_may_be_a_wall_or_a_plane_of_symmetry_is_told(floor):
    with pytest.raises(ValueError, match=r"x-lower.* unknown whether this is a wall with the contact angle 60 degrees, or"):
        angles_of(floor, SIDE)


EITHER = "contact_angle = 60 if it is a wall, contact_angle = 90 if it is a plane of symmetry"


@pytest.mark.parametrize(
    ("supports", "told"),
    [
        (
            ['where = "x-lower"\ncontact_angle = 45', 'where = "y-lower"'],
            {"support.1.where": f'add to the support of "y-lower" {EITHER}'},
        ),
        (
            ['where = ["x-lower", "y-lower"]', 'where = "x-upper"'],
            {
                "support.0.where": 'such as where = "y-lower", fix = "normal", contact_angle = 60 for a wall, and '
                'where = "x-lower", fix = "normal", contact_angle = 90 for a plane',
                "support.1.where": 'add to the support of "x-upper" contact_angle = 60 if',
            },
        ),
        (
            ['where = ["x-lower", "y-lower"]', 'where = "x-lower"\ncontact_angle = 60'],
            {"support.0.where": f'from this list, and add a [[support]] with where = "y-lower", fix = "normal" and {EITHER}'},
        ),
    ],
    ids=["one", "several", "one-of-a-list"],
)
def test_each_support_of_an_unknown_face_is_told_what_to_add(supports, told):
    text = """schema = 1
title = "half a drop"
grid = { lower = [0, 0, 0], upper = [2, 2, 0], cell = 0.2, functions = "quadratic-bspline" }
time = { end = 1, transfer = "apic" }
surface_tension = [{ body = "drop", tension = 1, contact_angle = 60 }]
[[body]]
name = "drop"
shape = { box = { lower = [0, 0, 0], upper = [1, 1, 0] } }
points_per_cell = [3, 3, 1]
material = { kind = "fluid", density = 1, viscosity = 1, eos = { kind = "tait", sound_speed = 20, carries_tension = true } }
"""
    with pytest.raises(CaseError) as caught:
        loads(text + "".join(f'[[support]]\nfix = "normal"\n{support}\n' for support in supports))
    remedies = {problem.key: problem.remedy for problem in caught.value.problems}
    assert remedies.keys() == told.keys()
    for key, words in told.items():
        assert words in remedies[key]


def test_threads_and_going_on_change_no_bit(tmp_path):
    more = {"time": {"step": 3e-3}, "end": 0.15, "tension": {"contact_angle": 70.0}, "support": FLOOR}
    more["output"] = {"history": 0.03}
    run_case(case(**more), tmp_path / "whole", threads=2)
    run_case(case(**more), tmp_path / "part", until=0.06, threads=1)
    stopped, going_on = Simulation(case(**more), threads=1), Simulation(case(**more), threads=1)
    stopped.step()
    stopped.step()
    going_on.restore(stopped.state_arrays(), stopped.state_numbers())
    assert going_on.parts.columns() == stopped.parts.columns(), "before the next step too"
    resume_case(tmp_path / "part", threads=1)
    whole, part = (history.read(tmp_path / name / "history.csv") for name in ("whole", "part"))
    for name, values in whole.items():
        assert np.array_equal(values, part[name]), name


def test_capillary_waves_bound_the_step_where_they_are_faster_than_sound():
    slow = {"material": LIQUID | {"pressure": 0.0, "eos": LIQUID["eos"] | {"sound_speed": 3.0}}}
    small = case(cell=0.1, body=slow)
    found = of_case(small)
    assert "capillary" in found.why
    sim = Simulation(small, threads=1)
    capillary = np.sqrt(0.1**3 / (4.0 * np.pi))
    assert sim.step_limit()[0].cause == "capillary"
    assert sim.step_limit()[0].step == pytest.approx(1.0 / np.hypot(1.0 / capillary, 30.0), rel=0.01)
    assert found.step == pytest.approx(0.4 * sim.step_limit()[0].step, rel=0.01)


SOLID = {"kind": "neo-hookean", "density": 1.0, "young_modulus": 10.0, "poisson_ratio": 0.3}
TORN = LIQUID | {"pressure": 0.0, "eos": {"kind": "tait", "sound_speed": 20.0}}


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"body": {"material": SOLID}}, "is not a fluid of material points"),
        ({"body": {"material": TORN}}, "cannot have surface tension"),
        ({"tension": {"body": "drip"}}, "no body has this name"),
        ({"tension": {"tension": -1.0}}, "tension"),
        ({"tension": {"contact_angle": 200.0}}, "contact_angle"),
        ({"tension": {"contact_angle": 60.0}}, "no support constrains a face"),
        ({"grid": {"functions": "trilinear"}}, "needs quadratic B-splines"),
        ({"grid": {"periodic": ["x"]}}, "periodic"),
        ({"time": {"scheme": "usf"}}, "usf"),
        ({"outflow": [{"where": "x-upper"}]}, "crosses a face"),
        (
            {"support": [{"where": "y-lower", "fix": ["x"], "contact_angle": 60.0}]},
            "constrained along its normal for all bodies",
        ),
        ({"support": [FLOOR[0] | {"contact_angle": a} for a in (60.0, 70.0)]}, "sets the contact angle 60 on the face y-lower"),
        ({"surface_tension": [], "wall": [FLAT | {"contact_angle": 60.0}]}, "no fluid in this case has surface tension"),
        ({"wall": [FLAT | {"contact_angle": 60.0, "velocity": [0, 0.1, 0]}]}, "moves along its normal"),
        ({"surface_tension": [], "support": [FLOOR[0] | {"contact_angle": 60.0}]}, "no fluid in this case has surface tension"),
    ],
)
def test_what_has_no_such_surface_is_refused(more, text):
    with pytest.raises((CaseError, ValueError), match=text):
        case(**more)


def test_two_tensions_of_one_fluid_are_refused():
    twice = [{"body": "drop", "tension": 1.0}, {"body": "drop", "tension": 2.0}]
    with pytest.raises((CaseError, ValueError), match="already"):
        case(surface_tension=twice)
