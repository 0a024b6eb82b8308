import numpy as np
import pytest

from pellucid.geometry.meshes.triangulation import rings
from pellucid.geometry.surfaces.triangles import Icosphere

MESH = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=1).mesh()


def test_rings_turn_with_the_triangles():
    found = rings(MESH.triangles, len(MESH.vertices))
    known = {tuple(np.roll(t, -k)[:3].tolist()) for t in MESH.triangles for k in range(3)}
    for half, node in enumerate(MESH.triangles.ravel()):
        ring = found.ring[half, : found.valence[node]].tolist()
        assert ring[0] == MESH.triangles[half // 3, (half + 1) % 3]
        for one, other in zip(ring, ring[1:] + ring[:1], strict=True):
            assert (node, one, other) in known


def test_every_edge_has_two_half_edges():
    found = rings(MESH.triangles, len(MESH.vertices))
    one, back = found.edges()
    assert len(one) == len(MESH.vertices) + len(MESH.triangles) - 2  # Euler, of a sphere
    assert np.array_equal(found.twin[back], one)
    assert np.array_equal(np.sort(np.concatenate([one, back])), np.arange(3 * len(MESH.triangles)))


def test_an_open_surface_has_none():
    with pytest.raises(ValueError, match="is not closed"):
        rings(MESH.triangles[1:], len(MESH.vertices))


def test_surfaces_that_touch_in_a_node_have_none():
    both = np.concatenate([MESH.triangles, np.where(MESH.triangles == 0, 0, MESH.triangles + len(MESH.vertices))])
    with pytest.raises(ValueError, match="more than one fan"):
        rings(both, 2 * len(MESH.vertices))
