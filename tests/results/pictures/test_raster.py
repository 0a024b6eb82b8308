import numpy as np
import pytest

from pellucid.results.pictures import drawables
from pellucid.results.pictures.drawables import DEPTHS, REACH, Canvas, ball_fragments, triangle_fragments

SHAPE = (40, 60)


def together(fragments):
    return [np.concatenate(parts) for parts in zip(*fragments, strict=True)]


def test_triangles_cover_the_pixels_within_them_at_their_depth():
    generator = np.random.default_rng(3)
    corners = generator.uniform(-10.0, 70.0, (50, 3, 3))
    x, y, depth, which = together(triangle_fragments(corners, SHAPE))
    found = set(zip(which, x, y, strict=True))
    assert len(found) == len(which), "each pixel once"
    columns, rows = np.meshgrid(np.arange(SHAPE[1]), np.arange(SHAPE[0]))
    for k, (a, b, c) in enumerate(corners):
        matrix = np.column_stack([(b - a)[:2], (c - a)[:2]])
        s, t = np.linalg.solve(matrix, np.stack([columns.ravel() - a[0], rows.ravel() - a[1]]))
        hit = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
        wanted = set(zip(columns.ravel()[hit], rows.ravel()[hit], strict=True))
        assert {(i, j) for n, i, j in found if n == k} == wanted
        mine = which == k
        plane = {(i, j): d for i, j, d in zip(x[mine], y[mine], depth[mine], strict=True)}
        for i, j, u, v in zip(columns.ravel()[hit], rows.ravel()[hit], s[hit], t[hit], strict=True):
            assert plane[i, j] == pytest.approx(a[2] + u * (b - a)[2] + v * (c - a)[2], abs=1e-9)


def test_many_triangles_are_looked_at_in_parts(monkeypatch):
    corners = np.random.default_rng(5).uniform(-10.0, 70.0, (50, 3, 3))
    whole = together(triangle_fragments(corners, SHAPE))
    monkeypatch.setattr(drawables, "MOST", 3000)
    parts = list(triangle_fragments(corners, SHAPE))
    assert len(parts) > 5
    for one, other in zip(whole, together(iter(parts)), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(
    "corners",
    [
        [[5.0, 5.0, 0.0], [20.0, 20.0, 3.0], [30.0, 30.0, 9.0]],
        [[5.0, 5.0, 0.0], [5.0, 5.0, 4.0], [9.0, 20.0, 0.0]],
        [[-9.0, 5.0, 0.0], [-2.0, 20.0, 3.0], [-5.0, 30.0, 9.0]],
        [[5.0, 60.0, 0.0], [9.0, 70.0, 4.0], [20.0, 80.0, 0.0]],
        [[5.0, np.nan, 0.0], [20.0, 20.0, 3.0], [5.0, 30.0, 9.0]],
        [[5.0, np.inf, 0.0], [20.0, 2.0, 3.0], [5.0, 3.0, 9.0]],
    ],
)
def test_triangles_edge_on_outside_or_nowhere_have_no_pixels(corners):
    beside = [[5.0, 5.0, 0.0], [20.0, 5.0, 0.0], [5.0, 20.0, 0.0]]
    *_, which = together(triangle_fragments(np.array([corners, beside]), SHAPE))
    assert set(which) == {1}


def test_no_triangles_have_no_pixels():
    assert not any(len(x) for x, *_ in triangle_fragments(np.zeros((0, 3, 3)), SHAPE))


def test_triangles_of_a_sheet_leave_no_gap():
    corners = np.random.default_rng(4).uniform(5.0, 30.0, (4, 3))
    corners[:, :2] = [[5.0, 5.0], [50.0, 8.0], [45.0, 33.0], [7.0, 30.0]]
    x, y, _, _ = together(triangle_fragments(corners[[[0, 1, 2], [0, 2, 3]]], SHAPE))
    for row in range(9, 30):
        covered = np.unique(x[y == row])
        assert np.array_equal(covered, np.arange(covered[0], covered[-1] + 1))
        assert len(covered) > 35


def test_balls_cover_discs_and_bulge():
    place = np.array([[20.3, 15.7, 4.0, 6.5], [1.0, 1.0, 0.0, 5.0], [40.0, 20.0, 0.0, 3.0]])
    x, y, depth, which = together(ball_fragments(place, np.array([0, 1]), SHAPE))
    assert set(which) == {0, 1}
    first = which == 0
    assert np.allclose((x[first] - 20.3) ** 2 + (y[first] - 15.7) ** 2 + (depth[first] - 4.0) ** 2, 6.5**2)
    assert abs(first.sum() - np.pi * 6.5**2) < 8  # a pixel's width along half of the rim
    assert min(x.min(), y.min()) == 0, "what lies outside the picture is left out"


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_canvas_keeps_the_nearest(order):
    canvas = Canvas((1, 3))
    things = [([0, 1], 5.0), ([1, 2], 7.0)]
    for k in order:
        columns, depth = things[k]
        canvas.begin_part(10)
        x = np.array(columns)
        canvas.add(x, np.zeros(2, int), np.full(2, depth), np.array([3, 4]))
    index, primitive = canvas.seen(order.index(1))
    assert index.tolist() == [1, 2]
    assert primitive.tolist() == [3, 4]
    assert canvas.seen(order.index(0))[0].tolist() == [0]
    assert canvas.depth()[0] == pytest.approx([5.0, 7.0, 7.0], abs=2 * REACH / DEPTHS)
