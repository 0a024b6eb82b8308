"""Mirror images of halves and quarters."""

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase
from pellucid.results.pictures.surroundings import cells_with_images, mirrors_at, with_images

GRID = GridCase(lower=(1.0, 0.0, 0.0), upper=(3.0, 2.0, 2.0), cell=0.5)


def test_places_vectors_and_tensors_are_mirrored_numbers_repeated():
    fields = {
        "position": np.array([[1.5, 0.5, 0.5]]),
        "velocity": np.array([[2.0, 3.0, 4.0]]),
        "stress": np.array([[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]),
        "mass": np.array([7.0]),
    }
    found = with_images(fields, mirrors_at(("x-lower", "y-upper"), GRID))
    assert found["position"].tolist() == [[1.5, 0.5, 0.5], [0.5, 0.5, 0.5], [1.5, 3.5, 0.5], [0.5, 3.5, 0.5]]
    assert found["velocity"][1].tolist() == [-2.0, 3.0, 4.0]
    assert found["velocity"][3].tolist() == [-2.0, -3.0, 4.0]
    assert found["stress"][1].tolist() == [1.0, 2.0, 3.0, 4.0, -5.0, -6.0], "yz stays; xz and xy turn round"
    assert found["mass"].tolist() == [7.0] * 4
    assert len(fields["position"]) == 1


def test_cells_number_the_points_of_the_images():
    cells = cells_with_images(Cells(triangles=np.array([[0, 1, 2]])), 3, mirrors_at(("z-lower",), GRID))
    assert cells.triangles.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert len(cells.points) == 0


def test_a_case_without_a_grid_has_no_mirrors():
    assert mirrors_at(("x-lower",), None) == ()
