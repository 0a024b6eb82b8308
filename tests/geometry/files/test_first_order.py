"""Elements of higher order give their corners; hexahedra, wedges and pyramids are cut alike on both sides of a face."""

import numpy as np
import pytest

from pellucid.geometry.checks.solid_checks import solid_faults, upright
from pellucid.geometry.files.contents import Block, Contents, first_order, tetrahedra
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


def bricks(n, seed):
    """Hexahedra of a block of n³ cubes whose nodes have numbers in any order and lie a little aside."""
    random = np.random.default_rng(seed)
    i, j, k = np.meshgrid(*3 * [np.arange(n + 1)], indexing="ij")
    number = random.permutation((n + 1) ** 3).reshape(i.shape)
    nodes = np.empty(((n + 1) ** 3, 3))
    nodes[number.ravel()] = np.stack([i, j, k], axis=-1).reshape(-1, 3)
    inner = ((nodes > 0) & (nodes < n)).all(axis=1)
    nodes[inner] += random.uniform(-0.15, 0.15, (int(inner.sum()), 3))
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    hexahedra = np.stack([number[a : a + n, b : b + n, c : c + n].ravel() for a, b, c in corners], axis=1)
    return nodes, hexahedra


WEDGES = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
PYRAMIDS = [[0, 3, 2, 1, 8], [4, 5, 6, 7, 8], [0, 1, 5, 4, 8], [1, 2, 6, 5, 8], [2, 3, 7, 6, 8], [3, 0, 4, 7, 8]]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["hexahedron", "wedge", "pyramid", "mixed"])
def test_cut_elements_fit_together_and_keep_the_volume(kind, seed):
    nodes, hexahedra = bricks(3, seed)
    middles = nodes[hexahedra].mean(axis=1)
    centred = np.concatenate([hexahedra, len(nodes) + np.arange(len(hexahedra))[:, None]], axis=1)
    wedges = np.concatenate([hexahedra[:, corners] for corners in WEDGES])
    pyramids = np.concatenate([centred[:, corners] for corners in PYRAMIDS])
    if kind == "mixed":
        blocks = [Block("hexahedron", hexahedra[:9]), Block("pyramid", np.concatenate([centred[9:, c] for c in PYRAMIDS]))]
    else:
        blocks = [Block(kind, {"hexahedron": hexahedra, "wedge": wedges, "pyramid": pyramids}[kind])]
    cells, notes = tetrahedra(tuple(blocks))
    used, which = np.unique(cells, return_inverse=True)
    mesh, _ = upright(SimplexMesh(np.vstack([nodes, middles])[used], which.reshape(-1, 4)), 0)
    assert list(solid_faults(mesh)) == []
    assert mesh.volumes.sum() == pytest.approx(27.0, rel=1e-12)
    assert len(mesh.boundary) == 6 * 9 * 2, "no face within is left alone"
    assert all("divided into" in note for note in notes)


def test_elements_with_corners_drawn_together_are_cut_as_what_they_are():
    wedge_as_brick = np.array([[0, 1, 2, 2, 3, 4, 5, 5]])
    cells, _ = tetrahedra((Block("hexahedron", wedge_as_brick),))
    assert len(cells) == 3
    nodes = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)])
    assert np.abs(SimplexMesh(nodes, cells).volumes).sum() == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("kind", "corners", "more"),
    [
        ("tetra10", 4, 6),
        ("triangle6", 3, 3),
        ("triangle7", 3, 4),
        ("quad8", 4, 4),
        ("quad9", 4, 5),
        ("hexahedron20", 8, 12),
        ("hexahedron27", 8, 19),
        ("wedge15", 6, 9),
        ("pyramid13", 5, 8),
        ("line3", 2, 1),
        ("VTK_LAGRANGE_TETRAHEDRON", 4, 6),
    ],
)
def test_nodes_between_corners_go_and_sets_are_numbered_anew(kind, corners, more):
    n = corners + more + 1
    points = np.random.default_rng(3).uniform(size=(n, 3))
    order = np.random.default_rng(4).permutation(n)
    element, lone = order[: n - 1], order[n - 1]
    sets = {"all": np.arange(n), "between": np.sort(element[corners:]), "one": element[:1]}
    found = first_order(Contents("x", points, (Block(kind, element[None]),), node_sets=sets))
    [block] = found.blocks
    assert np.array_equal(found.points[block.nodes[0]], points[element[:corners]])
    assert len(found.points) == corners + 1, "a node of no element is no node between corners"
    assert np.array_equal(
        np.sort(found.points[found.node_sets["all"]], axis=0), np.sort(points[[*element[:corners], lone]], axis=0)
    )
    assert len(found.node_sets["between"]) == 0
    assert np.array_equal(found.points[found.node_sets["one"]], points[element[:1]])
    [note] = found.notes
    assert f"of higher order ({kind}) was reduced to the corners; {more} nodes between corners were removed" in note


def test_elements_of_first_order_are_left_as_they_are():
    contents = Contents("x", np.eye(4, 3), (Block("tetra", np.arange(4)[None]),))
    assert first_order(contents) is contents
