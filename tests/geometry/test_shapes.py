"""Shapes: what they contain agrees with their measure and bounds, also with thin axes."""

import numpy as np
import pytest

from pellucid.geometry.shapes import Box, Cylinder, Shape, Sphere

SHAPES = {
    "box": Box(lower=(-0.2, 0.1, -0.5), upper=(0.6, 0.4, 0.7)),
    "sphere": Sphere(centre=(0.1, 0.0, -0.2), radius=0.6),
    "cylinder-x": Cylinder(centre=(0.1, 0.0, -0.2), radius=0.4, axis="x", height=0.9),
    "cylinder-z": Cylinder(centre=(0.1, 0.0, -0.2), radius=0.4, axis="z", height=0.9),
}
ACTIVE = [(x, y, z) for x in (True, False) for y in (True, False) for z in (True, False) if x or y or z]
every_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


def test_every_shape_of_a_case_is_tested():
    assert {type(shape) for shape in SHAPES.values()} == {
        annotation
        for field in Shape.model_fields.values()
        for annotation in field.annotation.__args__
        if annotation is not type(None)
    }


@every_shape
@pytest.mark.parametrize("active", ACTIVE)
def test_measure_agrees_with_what_is_inside(shape, active):
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
    assert shape.contains(shape.centre()[None], everything).all()


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
