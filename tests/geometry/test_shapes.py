"""Shapes: what they contain agrees with their measure and bounds, also with thin axes."""

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.geometry.region import Shape
from pellucid.geometry.shapes.solids import Box, Cushion, Cylinder, Pipe, Shell, Sphere
from pellucid.geometry.surfaces.surface import Inside

SHAPES = {
    "box": Box(lower=(-0.2, 0.1, -0.5), upper=(0.6, 0.4, 0.7)),
    "sphere": Sphere(centre=(0.1, 0.0, -0.2), radius=0.6),
    "cylinder-x": Cylinder(centre=(0.1, 0.0, -0.2), radius=0.4, axis="x", height=0.9),
    "cylinder-z": Cylinder(centre=(0.1, 0.0, -0.2), radius=0.4, axis="z", height=0.9),
    "shell": Shell(centre=(0.1, 0.0, -0.2), outer_radius=0.6, inner_radius=0.3),
    "pipe-y": Pipe(centre=(0.1, 0.0, -0.2), outer_radius=0.4, inner_radius=0.2, axis="y", height=0.9),
    "cushion": Cushion(centre=(0.1, 0.0, -0.2), sides=(0.9, 1.2), height=0.4),
    "eighth of a cushion": Cushion(centre=(0.1, 0.0, -0.2), sides=(0.9, 1.2), height=0.4, halved=("x", "y", "z")),
    "inside": Inside(surface={"icosphere": {"centre": (0.1, 0.0, -0.2), "radius": 0.6, "refinements": 2}}),
}
HOLLOW = (Shell, Pipe)
ACTIVE = [(x, y, z) for x in (True, False) for y in (True, False) for z in (True, False) if x or y or z]
every_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


def test_every_shape_of_a_case_is_tested():
    assert {type(shape) for shape in SHAPES.values()} == {
        annotation
        for name in Shape.alternatives()
        for annotation in Shape.model_fields[name].annotation.__args__
        if annotation is not type(None)
    }


@every_shape
@pytest.mark.parametrize("active", ACTIVE)
def test_measure_agrees_with_what_is_inside(shape, active):
    if isinstance(shape, Inside) and not all(active):
        return  # a surface has an inside in space alone; a case with a thin grid is refused
    keep = np.array(active)
    lower, upper = shape.bounds()
    n = 40
    axes = [a + (np.arange(n) + 0.5) * (b - a) / n for a, b in zip(lower[keep], upper[keep], strict=True)]
    # a lattice over the bounds; a thin axis is filled with nonsense, which must not count
    lattice = np.full((n ** keep.sum(), 3), 99.0)
    lattice[:, keep] = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, keep.sum())
    share = shape.contains(lattice, active).mean()
    # cells of a fortieth that a curved surface cuts: surface over volume, six per cent at worst; much of it cancels
    assert share * np.prod((upper - lower)[keep]) == pytest.approx(shape.measure(active), rel=0.02)


@every_shape
def test_bounds_and_centre(shape):
    lower, upper = shape.bounds()
    assert shape.centre() == pytest.approx(0.5 * (lower + upper))
    everything = (True, True, True)
    points = np.random.default_rng(0).uniform(-2.0, 2.0, (5000, 3))
    inside = points[shape.contains(points, everything)]
    assert np.all((inside >= lower) & (inside <= upper))
    assert shape.contains(shape.centre()[None], everything).all() != isinstance(shape, HOLLOW)


def test_faces_belong_to_a_box():
    corners = np.array([(x, y, z) for x in (-0.2, 0.6) for y in (0.1, 0.4) for z in (-0.5, 0.7)])
    assert SHAPES["box"].contains(corners, (True, True, True)).all()


@pytest.mark.parametrize(
    "table", [{}, {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1)}, "sphere": {"centre": (0, 0, 0), "radius": 1}}]
)
def test_a_shape_has_exactly_one_key(table):
    with pytest.raises(ValueError, match="exactly one of the keys box, sphere, cylinder"):
        Shape.model_validate(table)


def test_the_shape_that_is_named_is_found():
    assert isinstance(Shape(sphere=SHAPES["sphere"]).geometry(), Sphere)


@pytest.mark.parametrize("axis", "xyz")
def test_a_pipe_is_filled_ring_by_ring(axis):
    pipe = Pipe(centre=(1, 2, 3), outer_radius=0.5, inner_radius=0.4, axis=axis, height=1.5, points=(3, 60, 30))
    points, volumes = pipe.own_points()
    assert len(points) == pipe.n_own_points() == 5400
    assert pipe.contains(points, (True, True, True)).all()
    assert len(np.unique(points.round(9), axis=0)) == 5400
    assert volumes.sum() == pytest.approx(pipe.measure((True, True, True)), rel=1e-13)
    # each ring by itself
    along = "xyz".index(axis)
    r = np.linalg.norm(np.delete(points - (1, 2, 3), along, axis=1), axis=1)
    for k in range(3):
        low, high = 0.4 + 0.1 / 3 * k, 0.4 + 0.1 / 3 * (k + 1)
        ring = (r > low) & (r < high)
        assert volumes[ring].sum() == pytest.approx(np.pi * (high**2 - low**2) * 1.5, rel=1e-12)
    assert points.mean(axis=0) == pytest.approx((1, 2, 3), abs=1e-12)


@pytest.mark.parametrize("shape", [Shell, Pipe])
def test_a_hollow_shape_has_a_wall(shape):
    with pytest.raises(ValueError, match="must be smaller than"):
        shape(centre=(0, 0, 0), outer_radius=0.5, inner_radius=0.5)


def test_a_cushion_is_halved_along_an_axis_once():
    with pytest.raises(ValidationError, match="names an axis twice"):
        Cushion(centre=(0, 0, 0), sides=(1, 1), height=1, halved=("x", "x"))
