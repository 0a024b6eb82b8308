"""What is wrong with a surface is found, counted and placed, and nothing else is reported."""

import numpy as np
import pytest

from pellucid.geometry.checks.surface_checks import MOST_EDGES, REPAIR, faults, mesh_faults
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface, CylinderSurface, Lid, Rectangle, SphereSurface, Tube
from pellucid.geometry.surfaces.triangles import Disc, Icosphere

BALL = Icosphere(centre=(1, 2, 3), radius=2.0, refinements=2)
SOUND = {
    "rectangle": Rectangle(corner=(0, 0, 0), first_edge=(1, 0, 0), second_edge=(0, 1, 0), points=(4, 3)),
    "icosphere": BALL,
    "tube": Tube(start=(0, 0, 0), end=(0, 1, 1), radius=0.3, points=(12, 5)),
    "disc": Disc(centre=(0, 0, 0), normal=(0, 0, 1), radius=1.0, rings=4),
    "lid": Lid(box={"lower": (0, 0, 0), "upper": (1, 1, 1)}, face="y-lower", points=(3, 5)),
    "box": BoxSurface(lower=(0, 0, 0), upper=(1, 2, 3), points=(2, 4, 3)),
    "band": BoxSurface(lower=(0, 0, 0), upper=(1, 2, 3), points=(2, 4, 3), open=("z-lower", "z-upper")),
    "cylinder": CylinderSurface(start=(0, 0, 0), end=(1, 1, 1), radius=0.2, rings=3, along=5),
    "cup": CylinderSurface(start=(0, 0, 0), end=(1, 1, 1), radius=0.2, rings=3, along=5, open=("end",)),
    "cube": SphereSurface(centre=(0, 0, 0), radius=1.0, divisions=1),
    "coarse sphere": SphereSurface(centre=(0, 0, 0), radius=1.0, divisions=2),
    "sphere": SphereSurface(centre=(0, 0, 0), radius=1.0, divisions=9),
}


def found(vertices, triangles, closed=True, **keys):
    return list(faults(vertices, triangles, closed, **keys))


@pytest.mark.parametrize("surface", SOUND.values(), ids=SOUND)
def test_sound_surfaces_have_no_faults(surface):
    assert found(*surface.triangulate(), surface.closed) == []
    assert list(mesh_faults(surface.mesh(), surface.closed)) == []


def test_two_pieces_apart_are_sound():
    vertices, triangles = BALL.triangulate()
    assert found(np.concatenate([vertices, vertices + 10.0]), np.concatenate([triangles, triangles + len(vertices)])) == []


def test_a_flipped_triangle():
    vertices, triangles = BALL.triangulate()
    triangles[5] = triangles[5, ::-1]
    ((text, remedy),) = found(vertices, triangles)
    assert "have opposite normals at 3 edges" in text
    assert " 5 " in f"{text.split('numbers')[1].split(',')[0]} "
    assert "consistently" in remedy
    assert len(found(vertices, triangles, closed=False)) == 1, "of an open surface too"


def test_the_example_is_of_the_two_triangles_at_the_edge():
    """Whichever way the edge runs."""
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    for triangles in ([(0, 1, 2), (0, 3, 2), (3, 0, 1)][:2], [(2, 1, 0), (2, 3, 0)]):
        ((text, _),) = found(vertices, np.array(triangles), closed=False)
        assert "at 1 edge, for example numbers 0 and 1, near (0.5, 0.5, 0) m" in text


def test_all_inward():
    vertices, triangles = BALL.triangulate()
    ((text, remedy),) = found(vertices, triangles[:, ::-1])
    assert "point inward: the triangles enclose -" in text
    assert "`repair = true` or `reverse = true`" in remedy
    assert found(vertices, triangles[:, ::-1], closed=False) == []


@pytest.mark.parametrize("turn", [slice(None), slice(None, None, -1)], ids=["same way", "other way"])
def test_repeated_triangles(turn):
    vertices, triangles = BALL.triangulate()
    again = np.concatenate([triangles, np.roll(triangles[7:9], 1, axis=1)[:, turn]])
    ((text, _),) = found(vertices, again)
    assert "2 triangles occur twice, for example numbers" in text, "what follows from them is not reported"
    over = np.concatenate([again, [(*triangles[0, :2], len(vertices))]])
    texts = [text for text, _ in found(np.vstack([vertices, [9.0, 9.0, 9.0]]), over)]
    assert len(texts) == 2
    assert "1 edge has more than two triangles" in texts[1], "what has another cause is"


def test_empty_triangles():
    vertices, triangles = BALL.triangulate()
    a, b, _ = triangles[0]
    ((text, _),) = found(vertices, np.concatenate([triangles, [(a, a, b)]]))
    assert f"1 triangle has no area; the first is number {len(triangles)}" in text
    flat = np.array([(0.0, 0, 0), (1, 0, 0), (2, 0, 0)])
    assert "no area" in found(flat, np.array([(0, 1, 2)]), closed=False)[0][0]


def test_edges_with_more_than_two_triangles():
    vertices = np.array([(0.0, 0, 0), (0, 0, 2), (1, 0, 0), (0, 1, 0), (-1, 0, 0)])
    ((text, remedy),) = found(vertices, np.array([(0, 1, 2), (0, 1, 3), (0, 1, 4)]), closed=False)
    assert text == "1 edge has more than two triangles, for example between vertices 0 and 1, near (0, 0, 1) m"
    assert "a separate body" in remedy


def test_lone_vertices():
    vertices, triangles = BALL.triangulate()
    ((text, remedy),) = found(np.concatenate([vertices, [(7, 8, 9)]]), triangles)
    assert text.startswith(f"1 vertex belongs to no triangle; the first is number {len(vertices)}, near (7, 8, 9) m")
    assert remedy == f"remove them: {REPAIR}"


def test_holes_are_counted():
    vertices, triangles = BALL.triangulate()
    middle = vertices[triangles].mean(axis=1) - (1, 2, 3)
    apart = [np.argmax(middle @ side) for side in ((1, 2, 3), (-1, 2, 0), (0, 1, -2))]
    assert len(np.unique(triangles[apart])) == 9, "holes without a common corner"
    ((text, remedy),) = found(vertices, np.delete(triangles, apart, axis=0))
    assert text.startswith(
        "the surface is declared closed but has 3 holes with 9 edges in total, one of which is between vertices"
    )
    assert "`close_holes = 3`" in remedy
    assert "closed = false" not in remedy
    ((_, remedy),) = found(vertices, np.delete(triangles, apart, axis=0), may_be_open=True)
    assert remedy.endswith("; or declare it open with `closed = false`")
    assert found(vertices, np.delete(triangles, apart, axis=0), closed=False) == []


def test_a_hole_that_repair_cannot_close_is_for_a_mesh_program():
    tube = Tube(start=(0, 0, 0), end=(0, 0, 1), radius=1.0, points=(MOST_EDGES + 1, 2))
    ((_, remedy),) = found(*tube.triangulate())
    assert remedy == "close it in a mesh program: a hole has 201 edges, and `close_holes` closes at most 200"


SQUARES = Rectangle(corner=(0, 0, 0), first_edge=(3, 0, 0), second_edge=(0, 3, 0), points=(4, 4)).mesh()
DRUM = CylinderSurface(start=(0, 0, 0), end=(0, 0, 1), radius=1.0, rings=2, along=3).mesh()


def of(mesh, closed=False, **changes):
    return list(mesh_faults(mesh._replace(**changes), closed))


def test_a_flipped_quadrilateral():
    quads = SQUARES.quads.copy()
    quads[4] = quads[4, ::-1]
    ((text, remedy),) = of(SQUARES, quads=quads)
    assert text.startswith("neighbouring quadrilaterals have opposite normals at 4 edges, for example numbers ")
    assert " 4" in text.split("numbers")[1].split(",")[0]
    assert remedy == f"order the corners of all quadrilaterals consistently: {REPAIR}"


def test_a_flipped_triangle_beside_quadrilaterals_is_counted_through():
    rim = int(np.flatnonzero(np.isin(DRUM.triangles, DRUM.quads).sum(axis=1) == 2)[0])
    triangles = DRUM.triangles.copy()
    triangles[rim] = triangles[rim, ::-1]
    ((text, _),) = of(DRUM, closed=True, triangles=triangles)
    assert "neighbouring elements have opposite normals at 3 edges" in text
    assert str(len(DRUM.quads) + rim) in text.split("numbers")[1].split(", near")[0]


def test_a_mesh_that_is_all_inward():
    ((text, remedy),) = of(DRUM.reversed(), closed=True)
    assert text.startswith("the normals point inward: the elements enclose -")
    assert "`repair = true` or `reverse = true`" in remedy


def test_holes_of_a_mesh():
    ((text, _),) = of(DRUM, closed=True, quads=np.delete(DRUM.quads, 0, axis=0))
    assert text.startswith("the surface is declared closed but has 1 hole with 4 edges in total")


@pytest.mark.parametrize("turn", [[2, 3, 0, 1], [1, 0, 3, 2]], ids=["same way", "other way"])
def test_repeated_quadrilaterals(turn):
    ((text, _),) = of(SQUARES, quads=np.concatenate([SQUARES.quads, SQUARES.quads[[4]][:, turn]]))
    assert text.startswith("1 quadrilateral occurs twice, for example numbers 4 and 9, near (")


def test_a_quadrilateral_without_area():
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)])
    ((text, _),) = of(Mesh(vertices, np.array([(0, 1, 2, 3)])))
    assert text.startswith("1 quadrilateral has no area; the first is number 0, near (0, 0, 0) m")


def test_a_quadrilateral_with_one_vertex_twice():
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)])
    ((text, remedy),) = of(Mesh(vertices, np.array([(0, 1, 2, 2)])))
    assert text.startswith("1 quadrilateral has the same vertex at two corners; the first is number 0")
    assert remedy == f"replace them by triangles: {REPAIR}"


@pytest.mark.parametrize(
    "moved", [(0.4, 0.4, 0.0), (0.5, 0.5, 0.0), (-1.0, 0.5, 0.0)], ids=["dented", "a triangle", "edges cross"]
)
def test_a_quadrilateral_that_is_not_convex(moved):
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), moved, (0, 1, 0)])
    ((text, remedy),) = of(Mesh(vertices, np.array([(0, 1, 2, 3)])))
    assert text.startswith("1 quadrilateral is not convex; the first is number 0, near (0, 0, 0) m, which has a corner of 180")
    assert "order the corners" in remedy


@pytest.mark.parametrize(("height", "count"), [(0.62, 0), (0.68, 1)])
def test_a_quadrilateral_far_from_flat(height, count):
    """A corner of a unit square lifted by h folds it by acos(1/(1 + h²)) about the diagonal through it: 44 and 47 degrees."""
    vertices = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, height), (0, 1, 0)])
    found = of(Mesh(vertices, np.array([(0, 1, 2, 3)])))
    assert len(found) == count
    if found:
        assert "1 quadrilateral is far from flat; number 0 is folded by 47 degrees about a diagonal" in found[0][0]
        assert "at most 45" in found[0][0]
