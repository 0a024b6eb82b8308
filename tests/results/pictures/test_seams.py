"""Pictures of periodic grids: bodies within the box."""

import numpy as np
import pytest

from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.results.pictures.surroundings import in_box, mirrors_at, places_unmoved, with_images

GRID = GridCase(lower=(-1, 0, 0), upper=(1, 1, 0), cell=0.25, periodic=["x"])
PLACE = np.array([(0.9, 0.5, 0.0), (1.2, 1.5, 0.0), (-5.3, 0.0, 0.0)])


def test_points_are_seen_in_the_box_each():
    found = in_box({"position": PLACE}, lambda: Cells.of_points(3), GRID)
    assert found["position"] == pytest.approx(np.array([(0.9, 0.5, 0.0), (-0.8, 1.5, 0.0), (0.7, 0.0, 0.0)]))
    assert places_unmoved(found) == pytest.approx(PLACE)


def test_a_mesh_stays_whole():
    cells = Cells(triangles=np.array([[0, 1, 2]]))
    moved = in_box({"position": np.add(PLACE, (7.0, 0.0, 0.0))}, lambda: cells, GRID)["position"]
    assert moved - PLACE == pytest.approx(np.tile([1.0, 0.0, 0.0], (3, 1)))
    assert -1.0 <= moved[:, 0].mean() < 1.0


def test_without_periodic_axes_nothing_changes():
    fields = {"position": PLACE}
    assert in_box(fields, Cells, GRID.model_copy(update={"periodic": ()})) is fields
    assert in_box(fields, Cells, None) is fields


def test_points_moved_into_the_box_have_mirror_images():
    found = with_images(in_box({"position": PLACE}, lambda: Cells.of_points(3), GRID), mirrors_at(("y-lower",), GRID))
    assert places_unmoved(found) == pytest.approx(np.concatenate([PLACE, PLACE * (1.0, -1.0, 1.0)]))
