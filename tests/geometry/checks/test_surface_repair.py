"""What is wrong with a surface and can be mended is mended, and told."""

from itertools import pairwise

import numpy as np
import pytest

from pellucid.findings import Refusal
from pellucid.geometry.checks.surface_checks import mesh_faults, rims
from pellucid.geometry.checks.surface_repair import repaired, turned_alike, without_holes
from pellucid.geometry.meshes.enclosure import signed_volume
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, NO_TRIANGLES, Mesh
from pellucid.geometry.surfaces.file import mended
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface, CylinderSurface, Rectangle
from pellucid.geometry.surfaces.triangles import Icosphere

BALL = Icosphere(centre=(1, 2, 3), radius=2.0, refinements=2).mesh()
DRUM = CylinderSurface(start=(0, 0, 0), end=(0, 0, 3), radius=1.0, rings=3, along=5).mesh()
SHEET = Rectangle(corner=(0, 0, 0), first_edge=(3, 0, 0), second_edge=(0, 3, 0), points=(6, 6)).mesh()


def volume(mesh):
    return signed_volume(*mesh.triangulated())


@pytest.mark.parametrize("mesh", [BALL, DRUM, SHEET, BoxSurface(lower=(0, 0, 0), upper=(1, 2, 3), points=(3, 4, 5)).mesh()])
def test_a_sound_surface_stays_as_it_is(mesh):
    after, notes = repaired(mesh, 20)
    notes = [note for note in notes if "a hole of" not in note]
    assert notes == []
    assert np.array_equal(after.vertices, mesh.vertices)
    assert np.array_equal(after.quads, mesh.quads)
    assert np.array_equal(after.triangles[: len(mesh.triangles)], mesh.triangles)


@pytest.mark.parametrize("mesh", [BALL, DRUM])
@pytest.mark.parametrize("seed", range(3))
def test_elements_turned_at_random_face_outward_again(mesh, seed):
    random = np.random.default_rng(seed)
    quads, triangles = mesh.quads.copy(), mesh.triangles.copy()
    of_quads, of_triangles = random.random(len(quads)) < 0.5, random.random(len(triangles)) < 0.5
    quads[of_quads], triangles[of_triangles] = quads[of_quads][:, [0, 3, 2, 1]], triangles[of_triangles][:, ::-1]
    after, notes = repaired(mesh._replace(quads=quads, triangles=triangles))
    assert list(mesh_faults(after, closed=True)) == []
    assert volume(after) == pytest.approx(volume(mesh), rel=1e-12)
    assert "reversed to match their neighbours, the first at (" in notes[0]


def test_the_fewer_elements_of_an_open_surface_are_turned():
    quads = SHEET.quads.copy()
    quads[[3, 7]] = quads[[3, 7]][:, ::-1]
    after, [note] = repaired(SHEET._replace(quads=quads))
    assert np.cross(*(after.vertices[after.quads[:, k]] - after.vertices[after.quads[:, 0]] for k in (1, 2)))[:, 2].min() > 0.0
    assert note.startswith("2 elements were reversed to match their neighbours")


def test_a_piece_in_another_one_is_a_hole():
    inner = BALL.vertices * 0.5 + np.array([0.5, 1, 1.5])
    n = len(BALL.vertices)
    both = Mesh(np.concatenate([BALL.vertices, inner]), NO_QUADS, np.concatenate([BALL.triangles[:, ::-1], BALL.triangles + n]))
    after, notes = repaired(both)
    assert volume(after) == pytest.approx(volume(BALL) * (1.0 - 0.125), rel=1e-12)
    assert ["outward" in note for note in notes] == [True, False]
    assert "inward, as it is a hole" in notes[1]


def test_a_strip_with_one_side_stays_as_it_is_and_is_told():
    n = 12
    angle = np.arange(n) * 2 * np.pi / n
    across = 0.3 * np.stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], axis=1)
    middle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    vertices = np.concatenate([middle - across, middle + across])
    quads = [(k, k + 1, n + k + 1, n + k) for k in range(n - 1)] + [(n - 1, n, 0, 2 * n - 1)]
    strip = Mesh(vertices, np.array(quads))
    after, [note] = turned_alike(strip)
    assert "is one-sided, like a Möbius strip" in note
    assert np.array_equal(after.quads, strip.quads)


def test_vertices_that_rounding_parted_are_merged():
    corners = BALL.vertices[BALL.triangles].reshape(-1, 3)
    soup = corners + np.random.default_rng(1).uniform(-3e-7, 3e-7, corners.shape)
    after, [note] = repaired(Mesh(soup, NO_QUADS, np.arange(len(soup)).reshape(-1, 3)))
    assert len(after.vertices) == len(BALL.vertices)
    assert note.startswith(f"{len(soup) - len(BALL.vertices)} vertices were merged with a coincident one, the first")
    assert list(mesh_faults(after, closed=True)) == []


def test_doubles_and_lone_vertices_are_left_out():
    triangles = np.concatenate([BALL.triangles, BALL.triangles[4:6, [1, 0, 2]]])
    after, notes = repaired(Mesh(np.concatenate([BALL.vertices, [(9, 9, 9)]]), NO_QUADS, triangles))
    assert np.array_equal(after.triangles, BALL.triangles)
    assert len(after.vertices) == len(BALL.vertices)
    assert notes[0].startswith("2 duplicate elements were removed, the first at (")
    assert notes[1] == "1 unused vertex was removed, the first at (9, 9, 9), in the unit of the file"


def test_a_quadrilateral_with_a_corner_twice_becomes_a_triangle():
    mesh = Mesh(np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0)]), np.array([(0, 1, 2, 2)]))
    after, [note] = repaired(mesh)
    assert after.triangles.tolist() == [[0, 1, 2]]
    assert note == "1 quadrilateral was made a triangle, as one of its corners is repeated"


@pytest.mark.parametrize("kind", ["triangles", "quadrilaterals"])
def test_flat_triangles_go_and_leave_no_slit(kind):
    """A triangle with a corner on its longest edge, between two elements."""
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 1, 0), (0, 2, 0), (1, 2, 0)])
    flat = [(3, 4, 2)]
    above = [(3, 4, 5), (4, 6, 5), (4, 2, 6)]
    below = [(0, 1, 2), (0, 2, 3)] if kind == "triangles" else []
    quads = np.array([(0, 1, 2, 3)]) if kind == "quadrilaterals" else NO_QUADS
    after, [note] = repaired(Mesh(vertices, quads, np.array(below + above + flat)))
    assert note.startswith("1 triangle without area was removed")
    assert list(mesh_faults(after, closed=False)) == []
    assert len(rims(after)) == 1, "the rim outside alone"
    x = after.vertices[after.triangulated().triangles]
    assert 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() == pytest.approx(2.0)


def test_a_surface_of_nothing_but_flat_elements_is_refused():
    with pytest.raises(Refusal, match=r"removes all elements of a\.stl, as none of them has an area"):
        mended("a.stl", Mesh(np.zeros((3, 3)), NO_QUADS, np.array([(0, 1, 1)])), 0)


@pytest.mark.parametrize("mesh", [BALL, DRUM])
def test_holes_up_to_the_size_that_is_asked_are_closed(mesh):
    centre = mesh.vertices.mean(axis=0)
    near = np.argmax((mesh.vertices - centre) @ (0.2, 0.3, 1.0))
    kept = ~(mesh.triangles == near).any(axis=1)
    holed = mesh._replace(triangles=np.delete(mesh.triangles[kept], 0, axis=0))
    large, small = sorted((len(loop) for loop in rims(holed)), reverse=True)
    assert small == 3
    after, notes = repaired(holed, close_holes=3)
    assert sorted(note.split(",")[0] for note in notes[:2]) == [
        "a hole of 3 edges was closed",
        f"a hole of {large} edges was not closed",
    ]
    assert list(map(len, rims(after))) == [large]
    after, _ = repaired(holed, close_holes=large)
    assert list(mesh_faults(after, closed=True)) == []
    assert volume(after) == pytest.approx(volume(mesh), rel=0.05)


@pytest.mark.parametrize(("here", "there"), [((0.5,), ()), ((0.3, 0.6), ()), ((0.3,), (0.6,)), ((0.3, 0.6), (0.45,))])
def test_elements_that_meet_without_a_common_vertex_are_joined(here, there):
    """Vertices on an edge that the element across does not have, as programs for parts write them."""
    box = BoxSurface(lower=(0, 0, 0), upper=(1, 2, 3), points=(3, 4, 5)).mesh()
    one = box.quads[0]
    a, b = one[:2].tolist()
    other = next(quad for quad in box.quads[1:] if {a, b} <= set(quad.tolist()))
    start = next(k for k in range(4) if other[k] == b and other[(k + 1) % 4] == a)
    rings, vertices = [], [*box.vertices]
    for ring, shares in ((one.tolist(), here), (np.roll(other, -start).tolist(), [1.0 - share for share in there])):
        between = [len(vertices) + k for k in range(len(shares))]
        vertices += [box.vertices[ring[0]] + share * (box.vertices[ring[1]] - box.vertices[ring[0]]) for share in shares]
        rings.append([ring[0], *between, *ring[1:]])
    triangles = [(ring[-1], *pair) for ring in rings for pair in pairwise(ring[:-1])]
    rest = np.array([quad for quad in box.quads if {a, b} - set(quad.tolist())])
    torn = Mesh(np.array(vertices) + 1e-8 * np.random.default_rng(1).random((len(vertices), 3)), rest, np.array(triangles))
    assert [len(ring) for ring in rims(torn)] == [2 + len(here) + len(there)]
    after, notes = repaired(torn)
    assert f"a slit of {2 + len(here) + len(there)} edges was closed" in " ".join(notes)
    assert list(mesh_faults(after, closed=True)) == []
    assert volume(after) == pytest.approx(6.0, rel=1e-6)


def test_crooked_quadrilaterals_are_cut_along_the_better_diagonal():
    dart = np.array([(0.0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)])
    roof = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0.9), (0, 1, 0)])
    for vertices in (dart, np.roll(dart, 1, axis=0), roof):
        after, [note] = repaired(Mesh(vertices, np.array([(0, 1, 2, 3)])))
        assert note.startswith("1 quadrilateral was not convex or far from flat and was divided")
        assert list(mesh_faults(after, closed=False)) == []
        x = after.vertices[after.triangles]
        assert np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2].min() > 0.0
    crossed = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    after, _ = repaired(Mesh(crossed, np.array([(0, 1, 2, 3)])))
    assert len(after.quads) == 1, "which way round its corners should go is not known"


def test_a_flat_hole_of_many_edges_is_filled_flat():
    inner = ((SHEET.vertices > 0.5) & (SHEET.vertices < 2.5))[:, :2].all(axis=1)
    holed = SHEET._replace(quads=SHEET.quads[~inner[SHEET.quads].all(axis=1)])
    hole = min(rims(holed), key=len)
    after, notes = without_holes(holed, len(hole))
    x = after.vertices[after.triangles]
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    assert len(after.triangles) == len(hole) - 2
    assert normals[:, 2].min() > 0.0, "turned as the elements around, none of them flat"
    assert 0.5 * normals[:, 2].sum() == pytest.approx(1.8**2)
    assert "20 edges was not closed" in " ".join(notes)


def test_holes_that_touch_at_a_vertex_are_two():
    vertex = BALL.triangles[0, 0]
    around = np.flatnonzero((BALL.triangles == vertex).any(axis=1))
    first = around[0]
    across = next(k for k in around if len(set(BALL.triangles[k]) & set(BALL.triangles[first])) == 1)
    holed = BALL._replace(triangles=np.delete(BALL.triangles, [first, across], axis=0))
    assert sorted(map(len, rims(holed))) == [3, 3]
    after, _ = repaired(holed, 3)
    assert list(mesh_faults(after, closed=True)) == []


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("mesh", [BALL, DRUM])
def test_surfaces_with_every_fault_at_once_are_mended(mesh, seed):
    random = np.random.default_rng(seed)
    elements = [corners for corners in [*mesh.quads.tolist(), *mesh.triangles.tolist()] if random.random() > 0.04]
    elements += [elements[k] for k in random.integers(0, len(elements), 3)]
    elements = [corners[::-1] if random.random() < 0.3 else corners for corners in elements]
    vertices, soup = [(9.0, 9.0, 9.0)], []
    for corners in elements:
        soup.append(list(range(len(vertices), len(vertices) + len(corners))))
        vertices += list(mesh.vertices[corners] + random.uniform(-1e-8, 1e-8, (len(corners), 3)))
    quads, triangles = (np.array([c for c in soup if len(c) == n], int).reshape(-1, n) for n in (4, 3))
    after, _ = repaired(Mesh(np.array(vertices), quads, triangles), 40)
    assert list(mesh_faults(after, closed=True)) == []
    assert volume(after) == pytest.approx(volume(mesh), rel=0.03), "holes are closed by flat triangles"


def test_no_repair_of_nothing():
    assert rims(Mesh(np.zeros((0, 3)), NO_QUADS, NO_TRIANGLES)) == []


def test_an_edge_from_a_vertex_to_itself_is_no_rim():
    """Where two fans of elements meet at that vertex."""
    places = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0], [0, 1, 1]], float)
    mesh = Mesh(places, NO_QUADS, np.array([[0, 1, 2], [0, 3, 4], [0, 0, 5]]))
    assert rims(mesh) == [[1, 0, 4, 3, 0, 2]]
