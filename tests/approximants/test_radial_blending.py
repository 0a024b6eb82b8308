"""Radial functions blended over simplices, and windows on a line."""

import numpy as np
import pytest

from pellucid.approximants.radial import RADIAL_FUNCTIONS
from pellucid.approximants.radial.blending import Simplices, blended
from pellucid.approximants.radial.stencils import Stencils, along_curve, interpolants, on_surface
from pellucid.bodies.diffusing_field.weak_forms import windows_on_line
from pellucid.geometry.surfaces.triangles import Icosphere

RADIAL = RADIAL_FUNCTIONS.entries["polyharmonic"]()


def sphere(refinements=2):
    """A unit sphere whose vertices are moved by up to 0.2 of their distance."""
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).mesh().triangulated()
    spacing = np.sqrt(4.0 * np.pi / len(vertices))
    vertices = vertices + 0.2 * spacing * np.random.default_rng(2).uniform(-1.0, 1.0, vertices.shape)
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    return Simplices(vertices, triangles, vertices)


def stencils(simplices):
    near = on_surface(simplices.points, simplices.normals, RADIAL.stencil_size(2))
    return near, interpolants(near.coordinates, RADIAL)


def dense(rows, n):
    """Values (t, q, n) of all nodes."""
    whole = np.zeros((*rows.value.shape[:2], n))
    for k, nodes in enumerate(rows.nodes):
        for q in range(whole.shape[1]):
            np.add.at(whole[k, q], nodes, rows.value[k, q])
    return whole


def test_corners_have_their_own_node_alone_and_rows_add_up():
    simplices = sphere()
    near, found = stencils(simplices)
    shares = np.concatenate([np.eye(3), np.random.default_rng(1).dirichlet(np.ones(3), 4)])
    rows = blended(simplices, near, found, shares)
    assert rows.value.sum(axis=2) == pytest.approx(1.0, abs=1e-12)
    assert rows.first.sum(axis=3) == pytest.approx(0.0, abs=1e-12)
    values = dense(rows, len(simplices.points))[:, :3]
    exact = np.zeros_like(values)
    exact[np.arange(len(values))[:, None], np.arange(3), simplices.corners] = 1.0
    assert values == pytest.approx(exact, abs=1e-10)


def test_triangles_agree_on_their_common_edge():
    """A point of an edge has the same functions from either side: no jump, as there would be without blending."""
    simplices = sphere()
    (near, found), n = stencils(simplices), len(simplices.points)
    near_start, near_end = {}, {}
    for corner in range(3):
        following = (corner + 1) % 3
        for rows_of, share in ((near_start, 0.7), (near_end, 0.3)):
            shares = np.zeros((1, 3))
            shares[0, [corner, following]] = share, 1.0 - share
            values = dense(blended(simplices, near, found, shares), n)[:, 0]
            rows_of.update(zip(map(tuple, simplices.corners[:, [corner, following]]), values, strict=True))
    assert len(near_start) == 3 * len(simplices.corners)
    for (one, other), row in near_start.items():
        assert near_end[other, one] == pytest.approx(row, abs=1e-11)


def test_derivatives_are_those_of_the_values():
    simplices, step = sphere(), 1e-5
    near, found = stencils(simplices)
    shares = np.array([[0.3, 0.45, 0.25], [0.8, 0.1, 0.1]])
    first = blended(simplices, near, found, shares).first
    for axis, move in enumerate(([-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0])):
        after, before = (blended(simplices, near, found, shares + sign * step * np.array(move)).value for sign in (1.0, -1.0))
        assert (after - before) / (2.0 * step) == pytest.approx(first[:, :, axis], abs=1e-8)


def test_the_functions_span_the_sphere():
    """Distance from the centre at points of the triangles: of fourth order at least."""
    errors = []
    for refinements in (2, 3):
        simplices = sphere(refinements)
        near, found = stencils(simplices)
        places = blended(simplices, near, found, np.full((1, 3), 1.0 / 3.0)).at_points(simplices.points)
        errors.append(np.abs(np.linalg.norm(places, axis=2) - 1.0).max())
    assert errors[1] < 3e-5
    assert np.log2(errors[0] / errors[1]) > 4.0


def test_polynomials_in_a_plane_are_exact():
    """All corners see the same plane, where nothing is bowed: of degree 4, with derivatives."""
    rng = np.random.default_rng(4)
    u, v = np.meshgrid(np.arange(9.0), np.arange(9.0), indexing="ij")
    points = np.stack([u.ravel(), v.ravel()], axis=1) + rng.uniform(-0.2, 0.2, (81, 2))
    corners = np.array([[40, 49, 41], [40, 41, 32]])
    order = np.argsort(((points[:, None] - points) ** 2).sum(axis=2), axis=1)[:, :21]
    near = Stencils(order, np.broadcast_to(np.eye(2), (81, 2, 2)), points[order] - points[:, None])

    def field(x):
        return (x[..., :1] - 4.0) ** 4 - 2.0 * (x[..., :1] - 4.0) * (x[..., 1:] - 4.0) ** 3 + x[..., 1:]

    rows = blended(Simplices(points, corners, None), near, interpolants(near.coordinates, RADIAL), rng.dirichlet(np.ones(3), 5))
    assert rows.at_points(field(points)) == pytest.approx(field(rows.at_points(points)), abs=1e-10)


def nodes_on_line(n, uneven=0.0):
    x = np.linspace(0.0, 1.0, n)
    x[1:-1] += uneven / n * np.random.default_rng(n).uniform(-1.0, 1.0, n - 2)
    return x


@pytest.mark.parametrize("uneven", [0.0, 0.3])
def test_windows_of_half_the_spacing_meet(uneven):
    """Their contents are those of the line, and what leaves one enters the next."""
    x = nodes_on_line(30, uneven)
    content, outflow = windows_on_line(x, RADIAL)
    assert content.sum() == pytest.approx(1.0, abs=1e-14)
    assert content.sum(axis=0) @ x**3 == pytest.approx(0.25, abs=1e-13)
    assert abs(outflow.sum(axis=0)).max() < 1e-11 * abs(outflow).max()
    assert abs(outflow @ np.ones(30)).max() < 1e-11 * abs(outflow).max()


@pytest.mark.parametrize("half_width", [0.3, 0.5, 0.8, 1.4])
def test_balances_of_windows_are_exact_for_polynomials(half_width):
    """Of x⁴ in windows that do not reach an end: content and flow through the ends of a window."""
    n = 20
    x, inner = nodes_on_line(n), slice(2, -2)
    content, outflow = windows_on_line(x, RADIAL, half_width)
    low, high = x - half_width / (n - 1), x + half_width / (n - 1)
    assert (content @ x**4)[inner] == pytest.approx(((high**5 - low**5) / 5.0)[inner], abs=1e-13)
    assert (outflow @ x**4)[inner] == pytest.approx((4.0 * (low**3 - high**3))[inner], abs=1e-11)


def growth(half_width):
    """The fastest growth of ċ = c'' on 41 nodes between closed ends [1/s], over the fastest decay that they carry."""
    content, outflow = (part.toarray() for part in windows_on_line(nodes_on_line(41), RADIAL, half_width))
    return np.linalg.eigvals(np.linalg.solve(content, -outflow)).real.max() / (40.0 * np.pi) ** 2


@pytest.mark.parametrize("half_width", [0.25, 0.5, 0.75, 0.99])
def test_windows_narrower_than_the_spacing_are_stable(half_width):
    assert abs(growth(half_width)) < 1e-12


@pytest.mark.parametrize("half_width", [1.01, 1.1, 1.2, 1.3])
def test_wider_ones_are_not(half_width):
    """What the thesis puts down to more than two windows over a point (section 4.0.4)."""
    assert growth(half_width) > 1e-2


def test_stencils_at_the_ends_of_a_line_are_one_sided():
    near = along_curve(nodes_on_line(9)[:, None], 7, closed=False)
    assert near.nodes[0].tolist() == list(range(7))
    assert near.nodes[-1].tolist() == list(range(2, 9))
