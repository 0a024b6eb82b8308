import numpy as np
import pytest

from pellucid.geometry.checks.quality import dihedral_angles, quad_qualities, tetrahedron_qualities, triangle_qualities


def test_angles_of_known_tetrahedra():
    regular = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    nodes = np.concatenate([regular, corner])
    found = dihedral_angles(nodes, np.array([[0, 1, 2, 3], [4, 5, 6, 7], [5, 4, 6, 7]]))
    assert found[0] == pytest.approx(np.degrees(np.arccos(1.0 / 3.0)))
    slanted = np.degrees(np.arctan(np.sqrt(2.0)))
    assert np.sort(found[1]) == pytest.approx([slanted] * 3 + [90.0] * 3)
    assert np.sort(found[2]) == pytest.approx(np.sort(found[1])), "whichever way its corners turn"


def test_a_sliver_has_angles_near_0_and_180():
    sliver = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 1e-3], [0, -1, 1e-3]])
    found = np.sort(dihedral_angles(sliver, np.array([[0, 1, 2, 3]]))[0])
    assert found[:4].max() < 1.0
    assert found[4:].min() > 179.0


def test_regular_elements_have_quality_1_and_flat_ones_0():
    angle = np.arange(3) * 2 * np.pi / 3
    triangle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    square = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    regular = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    for found, corners in (
        (triangle_qualities, triangle),
        (quad_qualities, square),
        (tetrahedron_qualities, regular),
    ):
        elements = np.arange(len(corners))[None]
        for size in (1.0, 1e-6):
            assert found(size * corners, elements) == pytest.approx(1.0)
        flat = corners * (1, 0, 0)
        assert found(flat, elements) == pytest.approx(0.0)
    assert quad_qualities(square * (10, 1, 1), np.arange(4)[None]) == pytest.approx(10.0 / 50.5)
