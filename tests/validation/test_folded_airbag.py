"""The mesh of a folded bag: two layers that meet at their rims alone, and cross nowhere."""

from math import pi
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "validation" / "lian2014-folded-airbag"
WIDTH, LENGTH, GAP, SIZE = 0.2, 0.06, 0.003, 0.01


def script(name: str) -> ModuleType:
    module = ModuleType(name)
    exec((FOLDER / f"{name}.py").read_text(encoding="utf-8"), module.__dict__)
    return module


@pytest.fixture(scope="module")
def mesh() -> ModuleType:
    return script("mesh")


@pytest.mark.parametrize("folds", [1, 2, 3])
@pytest.mark.parametrize("closed", [False, True])
def test_layers_lie_apart_and_cross_nowhere(mesh: ModuleType, folds: int, closed: bool) -> None:
    bag = mesh.folded_bag(folds, WIDTH, LENGTH, GAP, SIZE, closed)
    assert mesh.crossings(bag.vertices, bag.triangles) == 0
    assert mesh.nearest_sheets(bag, 8.0 * GAP) > 0.99 * GAP
    edges = np.sort(np.concatenate([bag.triangles[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0))]), axis=1)
    shared = np.unique(edges, axis=0, return_counts=True)[1]
    assert set(shared) == ({2} if closed else {1, 2})
    half = pi / (2.0 * mesh.PER_BEND)
    chords = 2.0 * folds * pi * 1.5 * GAP * (1.0 - np.sin(half) / half)  # bends are polygons
    assert bag.circumference == pytest.approx(2.0 * WIDTH - chords, rel=2e-3)  # the slope near the rims makes it 0.12 % longer
    # near the rims, over three gaps, the bag is half as thick
    flat = (WIDTH - 3.0 * GAP) * (LENGTH - 3.0 * GAP if closed else LENGTH) * GAP
    assert abs(mesh.volume(bag)) == pytest.approx(flat, rel=0.05)


def test_crossings_are_found(mesh: ModuleType) -> None:
    sheet = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.4, 1.0]])
    assert mesh.crossings(sheet, np.array([[0, 1, 2], [3, 4, 5]])) == 2
    assert mesh.crossings(sheet + np.repeat([[0, 0, 0], [0, 0, 5]], 3, axis=0), np.array([[0, 1, 2], [3, 4, 5]])) == 0


def test_a_bend_that_leaves_no_straight_part_is_refused(mesh: ModuleType) -> None:
    with pytest.raises(ValueError, match="too short for 9 folds"):
        mesh.folded_bag(9, WIDTH, LENGTH, GAP, SIZE, False)


def test_a_slice_that_hardly_stretches_is_a_circle() -> None:
    radius, volume, pressure = script("reference").blown_up(0.6, 1e9, 0.3, gas=100.0)
    assert radius == pytest.approx(0.6 / (2.0 * pi), rel=1e-5)
    assert volume == pytest.approx(0.36 / (4.0 * pi), rel=1e-5)
    assert pressure * volume == pytest.approx(100.0, rel=1e-12)


def test_a_slice_stretches_by_its_hoop_tension() -> None:
    radius, _, pressure = script("reference").blown_up(0.6, 1e5, 0.3, gas=100.0)
    hoop = (2.0 * pi * radius / 0.6 - 1.0) * 1e5 / (1.0 - 0.3**2)
    assert hoop == pytest.approx(pressure * radius, rel=1e-6)
