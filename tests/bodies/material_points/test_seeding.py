"""Seeding: where points stand, and that their volumes are the shape's."""

from itertools import pairwise

import numpy as np
import pytest
from small_cases import box, case, simulation

from pellucid.bodies.material_points import cutting
from pellucid.bodies.material_points.seeding import points_along_axes, seed
from pellucid.errors import CaseError
from pellucid.geometry.region import Shape
from pellucid.geometry.shapes.solids import Box, Cylinder, Pipe, Shell, Sphere
from pellucid.geometry.surfaces.surface import Inside
from pellucid.grid.model import GridCase

SHAPES = {
    "box": Box(lower=(0.5, 0.75, 1.0), upper=(3.5, 3.0, 2.0)),
    "ball": Sphere(centre=(2.0, 1.9, 2.1), radius=1.7),
    "disc": Cylinder(centre=(2.0, 2.0, 2.0), radius=1.5, height=2.0),
    "shell": Shell(centre=(2.0, 1.9, 2.1), outer_radius=1.7, inner_radius=0.8),
    "pipe": Pipe(centre=(2.0, 2.0, 2.0), outer_radius=1.6, inner_radius=0.7, height=2.0),
}
COUNTS = {"3-D": (4, 4, 4), "2-D": (4, 4, 1), "1-D": (4, 1, 1)}


def seeded(*arguments):
    """Positions and volumes."""
    seeds = seed(*arguments)
    return seeds.position, seeds.volume


def grid(counts, cell=1.0):
    return case(box((0, 0, 0), (cell, cell, cell)), counts=counts, cell=cell).grid


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("counts", COUNTS.values(), ids=COUNTS)
def test_volumes_sum_to_the_shape(shape, counts):
    active = tuple(n > 1 for n in counts)
    per_cell = tuple(3 if a else 1 for a in active)
    points, volumes = seeded(shape, grid(counts), per_cell)
    assert volumes.sum() == pytest.approx(shape.measure(active), rel=1e-13)  # thin axes are 1 m thick
    lattice = 3.0 ** -sum(active)
    assert np.all(volumes == volumes[0]) or (0.3 * lattice < volumes.min() and volumes.max() < 2.5 * lattice)
    assert shape.contains(points, active).all()
    for axis in range(3):
        if not active[axis]:
            assert np.all(points[:, axis] == 0.5), "in the middle of the thin cell"


@pytest.mark.parametrize("centre", [(3.0, 3.0, 3.0), (3.1, 2.9, 3.2), (2.95, 3.05, 3.12)], ids=["even", "odd", "odder"])
def test_points_stand_in_the_middle_of_what_they_stand_for(centre):
    """So the outline of a ball is where it should be, and its mass is centred; the points of the lattice miss both."""
    ball = Sphere(centre=centre, radius=2.0)
    points, volumes = seeded(ball, grid((6, 6, 6)), (3, 3, 3))
    x = points - centre
    reach = np.array([(sign * x + 0.5 * np.cbrt(volumes)[:, None]).max(axis=0) for sign in (1, -1)])
    assert np.abs(reach - 2.0).max() < 0.2 / 3  # of the spacing; equal volumes on the lattice miss by up to 0.4
    assert np.abs(volumes @ x / volumes.sum()).max() < 3e-4  # sampled; the lattice misses by 7e-3
    # each point has no width: the second moments lack spacing²/12
    second = volumes @ x**2 / volumes.sum() + 1.0 / 108.0
    assert second == pytest.approx(np.full(3, 2.0**2 / 5.0), rel=3e-3)


def test_a_symmetric_shape_has_symmetric_points():
    """Slivers that are as near to two points are shared."""
    points, volumes = seeded(Cylinder(centre=(3.0, 3.0, 0.5), radius=1.6), grid((6, 6, 1)), (4, 4, 1))
    x = points[:, :2] - 3.0
    order = np.lexsort(x.round(9).T)
    for image in (x[:, ::-1], -x, x * (-1.0, 1.0)):
        same = np.lexsort(image.round(9).T)
        assert image[same] == pytest.approx(x[order], abs=1e-13)
        assert volumes[same] == pytest.approx(volumes[order], rel=1e-12)


def test_a_point_whose_middle_lies_outside_stays_on_the_lattice():
    shell = Shell(centre=(3.0, 3.0, 3.0), outer_radius=2.5, inner_radius=2.35)
    points, volumes = seeded(shell, grid((6, 6, 6)), (3, 3, 3))
    assert shell.contains(points, EVERYWHERE).all()
    assert volumes.sum() == pytest.approx(shell.measure(EVERYWHERE), rel=1e-13)


@pytest.mark.parametrize("counts", [(6, 6, 6), (6, 6, 1)], ids=["3-D", "2-D"])
def test_a_turned_box_has_its_exact_volume_and_points_inside(counts):
    active = tuple(n > 1 for n in counts)
    turns = [{"angle": 17}, {"axis": (1, 0, 0), "angle": 40}] if active[2] else {"angle": 17}
    shape = Shape(box={"lower": (1.4, 2.1, 2.0), "upper": (4.2, 3.7, 3.9)}, rotate=turns).geometry()
    points, volumes = seeded(shape, grid(counts), tuple(3 if a else 1 for a in active))
    assert volumes.sum() == pytest.approx(2.8 * 1.6 * (1.9 if active[2] else 1.0), rel=1e-13)
    assert shape.contains(points, active).all()
    keep = np.array(active)
    lattice = 3.0 ** -sum(active)
    assert 0.25 * lattice < volumes.min()
    assert volumes.max() < 2.5 * lattice
    x = (points - shape.centre())[:, keep] @ shape.turn.matrix[np.ix_(keep, keep)]
    assert np.abs(volumes @ x / volumes.sum()).max() < 2e-3
    # points have no width: of a lattice the second moments lack spacing²/12
    second = np.einsum("n,ni,nj->ij", volumes, x, x) / volumes.sum() + np.eye(sum(active)) / 108.0
    assert second == pytest.approx(np.diag(np.array([2.8, 1.6, 1.9])[keep] ** 2 / 12.0), abs=0.01)


def test_a_ball_left_out_of_a_turned_box_takes_its_exact_volume():
    shape = Shape(box={"lower": (1.0, 1.4, 1.4), "upper": (5.0, 4.6, 4.6)}, rotate={"angle": 25}).geometry()
    ball = Sphere(centre=(3.0, 3.0, 3.0), radius=1.0)
    _, volumes = seeded(shape, grid((6, 6, 6)), (3, 3, 3), (ball,))
    assert volumes.sum() == pytest.approx(4.0 * 3.2 * 3.2 - 4.0 / 3.0 * np.pi, rel=1e-13)


def test_a_turned_box_left_out_of_a_box_takes_its_exact_volume():
    shape = Shape(box={"lower": (2.0, 2.4, 2.0), "upper": (4.0, 3.6, 4.0)}, rotate={"angle": 25}).geometry()
    points, volumes = seeded(Box(lower=(1, 1, 1), upper=(5, 5, 5)), grid((6, 6, 6)), (3, 3, 3), (shape,))
    assert volumes.sum() == pytest.approx(64.0 - 2.0 * 1.2 * 2.0, rel=1e-13)
    assert not shape.contains(points, EVERYWHERE).any()


def test_planes_of_symmetry_cut_a_ball():
    """A quarter of it has just the points of the whole ball that lie there, and a quarter of its volume."""
    ball = Sphere(centre=(3.0, 3.0, 3.1), radius=2.0)
    whole, volumes = seeded(ball, grid((6, 6, 6)), (2, 2, 2))
    cells = GridCase(lower=(3, 3, 0), upper=(6, 6, 6), cell=1.0)
    quarter, shares = seeded(ball, cells, (2, 2, 2))
    assert shares.sum() == pytest.approx(0.25 * ball.measure(EVERYWHERE), rel=1e-3)  # sampled
    there = np.all(whole[:, :2] > 3.0, axis=1)
    assert quarter == pytest.approx(whole[there], abs=1e-12)
    assert shares == pytest.approx(volumes[there], rel=1e-3)


def test_a_box_is_filled_evenly_though_it_fits_no_cells():
    shape = Box(lower=(0.1, 0.0, 0.0), upper=(3.45, 1.0, 1.0))
    points = seed(shape, grid((4, 1, 1)), (2, 1, 1)).position
    x = np.sort(points[:, 0])
    assert len(x) == 7  # 3.35 m in halves of a cell
    assert np.diff(x) == pytest.approx(np.full(6, 3.35 / 7))
    assert x[0] - 0.1 == pytest.approx(3.35 / 14)


def test_points_per_cell():
    box_of_cells = Box(lower=(0, 0, 0), upper=(2, 3, 4))
    points = seed(box_of_cells, grid((4, 4, 4)), (1, 2, 3)).position
    assert len(points) == 2 * 6 * 12
    # no two points in one place
    assert len(np.unique(points.round(9), axis=0)) == len(points)


def test_a_box_thinner_than_a_point_gets_one_layer():
    points, volumes = seeded(Box(lower=(1, 1, 1), upper=(1.01, 2, 2)), grid((4, 4, 4)), (2, 2, 2))
    assert len(points) == 4
    assert volumes.sum() == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("number", "thin", "along"),
    [
        (8, (False, False, False), (2, 2, 2)),
        (27, (False, False, False), (3, 3, 3)),
        (9, (False, True, False), (3, 1, 3)),
        (25, (False, True, True), (25, 1, 1)),
        ((2, 3, 4), (False, True, False), (2, 3, 4)),
        (1, (False, False, False), (1, 1, 1)),
        (1000000, (False, False, False), (100, 100, 100)),
    ],
)
def test_a_number_of_points_is_shared_among_the_axes(number, thin, along):
    assert points_along_axes(number, thin) == along


def test_a_number_that_cannot_be_shared_says_which_can():
    with pytest.raises(ValueError, match="use one of 1, 4, 9, 16, 25"):
        points_along_axes(8, (False, False, True))


def test_initial_velocities():
    """v + w × (x - centre) + a sin(k·x + φ)."""
    wave = {"amplitude": (0.1, 0.2, 0.3), "wave_vector": (1.0, 2.0, 0.0), "phase": 0.5}
    body = box((1, 1, 0), (3, 3, 1), velocity=(1, 2, 3), angular_velocity=(0.1, 0.2, 0.3), velocity_wave=wave)
    frame = simulation(body, counts=(4, 4, 4)).bodies[0].frame()
    x = frame["position"]
    expected = np.array((1.0, 2.0, 3.0)) + np.cross((0.1, 0.2, 0.3), x - (2.0, 2.0, 0.5))
    expected += np.sin(x @ (1.0, 2.0, 0.0) + 0.5)[:, None] * (0.1, 0.2, 0.3)
    assert frame["velocity"] == pytest.approx(expected, abs=1e-14)


EVERYWHERE = (True, True, True)
BALL = Sphere(centre=(5.1, 4.9, 5.0), radius=3.3)
PLATE = Box(lower=(0.3, 2.0, 2.0), upper=(1.4, 8.0, 8.0))
SURFACE = Inside(surface={"icosphere": {"centre": (5.1, 4.9, 5.0), "radius": 3.3, "refinements": 4}})
VESSEL = Box(lower=(0, 0, 0), upper=(10, 10, 10))


@pytest.mark.parametrize("per_cell", [(1, 1, 1), (2, 2, 2), (1, 2, 3)])
@pytest.mark.parametrize("left_out", [(BALL,), (SURFACE,), (BALL, PLATE)], ids=["ball", "surface", "ball and plate"])
def test_what_is_left_of_a_box_is_filled_to_its_exact_volume(left_out, per_cell):
    points, volumes = seeded(VESSEL, grid((10, 10, 10)), per_cell, left_out)
    exact = 1000.0 - sum(other.measure(EVERYWHERE) for other in left_out)
    assert volumes.sum() == pytest.approx(exact, rel=1e-13)
    cell = 1.0 / np.prod(per_cell)
    # the lattice points alone are right to some half a per cent; a point has at least half its cell or a corner less
    assert len(points) * cell == pytest.approx(exact, rel=0.01)
    assert volumes.min() > 0.3 * cell
    assert volumes.max() < 2.5 * cell
    away = np.ones(len(points), dtype=bool)
    for other in left_out:
        assert not other.contains(points, EVERYWHERE).any()
        lower, upper = other.bounds()
        away &= np.any((points < lower - 1.0) | (points > upper + 1.0), axis=1)
    # far from every border a point has its whole cell: the scale differs from one by what the sampling misses, 1e-4 of the ball
    # and a sixteenth of a lattice cell on the six by six cells of two faces of the plate, 3 of 813
    assert volumes[away] == pytest.approx(np.full(away.sum(), cell), rel=4e-3 if PLATE in left_out else 5e-4)


def test_two_bodies_fill_each_region_of_the_box_without_overlap():
    """Mass is where it belongs: in each block of 2.5 cells the two bodies together have its volume."""
    medium, v_medium = seeded(VESSEL, grid((10, 10, 10)), (2, 2, 2), (BALL,))
    drop, v_drop = seeded(BALL, grid((10, 10, 10)), (4, 4, 4))
    assert v_medium.sum() + v_drop.sum() == pytest.approx(1000.0, rel=1e-12)
    points, volumes = np.concatenate([medium, drop]), np.concatenate([v_medium, v_drop])
    blocks = np.floor(points / 2.5).astype(int) @ (16, 4, 1)
    assert np.bincount(blocks, volumes, minlength=64) == pytest.approx(np.full(64, 2.5**3), rel=0.03)  # slivers at its faces


def test_bodies_left_out_twice_are_taken_off_once():
    other = Sphere(centre=(6.5, 5.0, 5.0), radius=2.0)
    _, volumes = seeded(VESSEL, grid((10, 10, 10)), (2, 2, 2), (BALL, other))
    # the lens of two balls of radii R, r at distance d
    R, r, d = 3.3, 2.0, float(np.linalg.norm(np.subtract(BALL.centre_, other.centre_)))
    lens = np.pi * (R + r - d) ** 2 * (d * d + 2 * d * (R + r) - 3 * (R - r) ** 2) / (12 * d)
    exact = 1000.0 - BALL.measure(EVERYWHERE) - other.measure(EVERYWHERE) + lens
    assert volumes.sum() == pytest.approx(exact, rel=1e-4)  # the lens is sampled


def test_a_body_that_is_no_box_is_cut_too():
    """A ball less its lower half, which a box twice as wide takes."""
    half = Box(lower=(0, 0, 0), upper=(10, 10, 5))
    points, volumes = seeded(BALL, grid((10, 10, 10)), (2, 2, 2), (half,))
    assert volumes.sum() == pytest.approx(0.5 * BALL.measure(EVERYWHERE), rel=2e-3)  # sampled, at 6.6 cells across
    assert points[:, 2].min() > 5.0


def test_a_disc_is_cut_out_of_a_plane():
    disc = Cylinder(centre=(2.0, 2.0, 0.0), radius=1.1)
    _, volumes = seeded(Box(lower=(0, 0, 0), upper=(4, 4, 0)), grid((4, 4, 1)), (2, 2, 1), (disc,))
    assert volumes.sum() == pytest.approx(16.0 - np.pi * 1.21, rel=1e-12)


def body_outside(shape, *names, per_cell=(1, 1, 1)):
    return box((0, 0, 0), (10, 10, 10), name="medium", per_cell=per_cell) | {"shape": shape, "outside": names}


def test_a_case_names_what_is_left_out():
    drop = {"sphere": {"centre": (5.1, 4.9, 5.0), "radius": 3.3}}
    bodies = [body_outside({"box": {"lower": (0, 0, 0), "upper": (10, 10, 10)}}, "drop")]
    bodies.append(box((0, 0, 0), (1, 1, 1), name="drop") | {"shape": drop})
    medium, _ = simulation(*bodies, counts=(10, 10, 10)).bodies
    assert medium.points.mass.sum() == pytest.approx(1000.0 * (1000.0 - BALL.measure(EVERYWHERE)), rel=1e-12)
    # density is exactly the material's, whatever a point's volume
    assert medium.field("density") == pytest.approx(np.full(medium.n_points, 1000.0), rel=1e-15)
    whole = case(*bodies, counts=(10, 10, 10))
    assert whole.body[0].with_others(whole.body).n_points(whole.grid) == pytest.approx(medium.n_points, rel=0.02)


def test_a_body_that_does_not_know_what_is_left_out_is_not_filled_wholly():
    body = case(
        body_outside({"box": {"lower": (0, 0, 0), "upper": (9, 9, 9)}}, "b"),
        box((0, 0, 0), (1, 1, 1), name="b"),
        counts=(9, 9, 9),
    )
    with pytest.raises(RuntimeError, match=r"body\.with_others"):
        _ = body.body[0].excluded


def test_gaps_thinner_than_the_points_are_an_error():
    """A slab of a whole cell with all but a fifth of a cell taken away by two others."""
    slab = {"box": {"lower": (0, 0, 4), "upper": (10, 10, 6)}}
    low, high = (box((0, 0, a), (10, 10, b), name=name) for name, a, b in (("low", 2, 4.6), ("high", 5.4, 8)))
    with pytest.raises(CaseError, match="thinner than the distance between points") as caught:
        simulation(body_outside(slab, "low", "high"), low, high, counts=(10, 10, 10))
    assert caught.value.problems[0].key == "body.medium.outside"
    assert "more points_per_cell" in caught.value.problems[0].remedy


def test_a_pipe_with_points_has_just_these():
    shape = {
        "pipe": {"centre": (5, 5, 5), "axis": "x", "outer_radius": 2, "inner_radius": 1.6, "height": 3, "points": (2, 40, 12)}
    }
    (pipe,) = simulation(box((0, 0, 0), (1, 1, 1)) | {"shape": shape}, counts=(10, 10, 10)).bodies
    assert pipe.n_points == 960
    assert pipe.arrays["volume"].sum() == pytest.approx(np.pi * (4.0 - 1.6**2) * 3.0, rel=1e-13)


def test_the_papers_oocyte_has_its_counts():
    """Gan et al. 2011, section 3.4: 175 522 points in all, of which 40 962 are the membrane's and 5 400 the pipette's."""
    um = 1e-6
    space = {"lower": (-75 * um, -65 * um, -65 * um), "upper": (75 * um, 65 * um, 65 * um)}
    cells = GridCase(**space, cell=5 * um)
    oocyte = Sphere(centre=(0, 0, 0), radius=50 * um)
    plate = Box(lower=(-65 * um, -35 * um, -35 * um), upper=(-50 * um, 35 * um, 35 * um))
    radii = {"outer_radius": 5 * um, "inner_radius": 4 * um}
    pipette = Pipe(centre=(57.5 * um, 0, 0), axis="x", height=15 * um, points=(3, 60, 30), **radii)
    filled = [
        seeded(oocyte, cells, (3, 3, 3)),
        seeded(plate, cells, (1, 1, 1)),
        seeded(pipette, cells, (1, 1, 1)),
        seeded(Box(**space), cells, (1, 1, 1), (oocyte, plate, pipette)),
    ]
    assert [len(points) for points, _ in filled] == [113_104, 588, 5_400, 15_468]
    assert sum(len(points) for points, _ in filled) + 40_962 == 175_522
    assert sum(volumes.sum() for _, volumes in filled) == pytest.approx(150 * 130 * 130 * um**3, rel=1e-12)


@pytest.mark.parametrize("left_out", [(), (BALL, PLATE)], ids=["ball", "what two bodies leave of a box"])
def test_layers_at_a_time_give_the_same_points(monkeypatch, left_out):
    """Each of three processes keeps what lies in its part, of two layers of the lattice at a time."""
    shape = VESSEL if left_out else BALL
    whole = seed(shape, grid((10, 10, 10)), (2, 2, 2), left_out)
    monkeypatch.setattr(cutting, "FEWEST_LAYERS", 2)
    monkeypatch.setattr(cutting, "CELLS_AT_ONCE", 1)
    ends = [0.0, 4.3, 5.7, 10.0]
    parts = [
        seed(shape, grid((10, 10, 10)), (2, 2, 2), left_out, lambda x, a=a, b=b: np.flatnonzero((x[:, 1] >= a) & (x[:, 1] < b)))
        for a, b in pairwise(ends)
    ]
    number = np.concatenate([part.number for part in parts])
    order = np.argsort(number)
    assert np.array_equal(number[order], np.arange(whole.n))
    for name in ("position", "volume"):
        assert np.array_equal(np.concatenate([getattr(part, name) for part in parts])[order], getattr(whole, name))
