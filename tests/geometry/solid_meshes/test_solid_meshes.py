"""Meshes of tetrahedra: volumes, faces, faults."""

import re

import numpy as np
import pytest

from pellucid.geometry.checks.solid_checks import REPAIR, apart, solid_faults
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_meshes.box import BoxMesh, CylinderMesh, box_mesh
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh

LOWER, UPPER = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 3.0, 2.5])


@pytest.mark.parametrize("counts", [(1, 1, 1), (2, 3, 1), (4, 4, 4)])
def test_tetrahedra_fill_the_box_and_stand_upright(counts):
    mesh = box_mesh(LOWER, UPPER, counts)
    cube = np.prod(UPPER - LOWER) / np.prod(counts)
    assert mesh.volumes == pytest.approx(cube / 12.0, rel=1e-12), "twelve about each middle, or shared with a neighbour"
    assert mesh.volumes.sum() == pytest.approx(np.prod(UPPER - LOWER), rel=1e-12)
    assert (np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)) > 0).all(), "every node has a cell"


def test_its_outer_faces_are_those_of_the_box():
    mesh = box_mesh(LOWER, UPPER, (2, 3, 4))
    corners = mesh.nodes[mesh.faces[0][mesh.boundary]]
    on_a_face = np.zeros(len(corners), bool)
    for axis in range(3):
        for end in (LOWER, UPPER):
            on_a_face |= np.isclose(corners[:, :, axis], end[axis], atol=1e-12).all(axis=1)
    assert on_a_face.all()
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    x, y, z = UPPER - LOWER
    assert area.sum() == pytest.approx(2.0 * (x * y + y * z + x * z), rel=1e-12)


def test_a_graded_box_grows_by_a_constant_factor():
    even = {"lower": tuple(LOWER), "upper": tuple(UPPER), "cells": (5, 3, 1)}
    mesh = BoxMesh(**even, grading=(4.0, 0.25, 7.0)).mesh()
    assert (BoxMesh(**even).mesh().cells == mesh.cells).all()
    assert mesh.volumes.min() > 0.0
    assert mesh.volumes.sum() == pytest.approx(np.prod(UPPER - LOWER), rel=1e-12)
    corners = mesh.nodes[: 6 * 4 * 2].reshape(6, 4, 2, 3)
    widths = [np.diff(corners[:, 0, 0, 0]), np.diff(corners[0, :, 0, 1])]
    for width, last in zip(widths, (4.0, 0.25), strict=True):
        assert width[-1] / width[0] == pytest.approx(last, rel=1e-12)
        assert width[1:] / width[:-1] == pytest.approx(last ** (1.0 / (len(width) - 1)), rel=1e-12)
    assert corners[0, 0, :, 2] == pytest.approx([LOWER[2], UPPER[2]], abs=1e-15), "one cube has no other beside it"
    middle = mesh.nodes[6 * 4 * 2]
    assert middle == pytest.approx(0.5 * (corners[0, 0, 0] + corners[1, 1, 1]), rel=1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_cylinder_is_filled_up_to_its_polygon(axis):
    across, along = 6, 4
    cylinder = CylinderMesh(base=(1.0, 2.0, 3.0), radius=2.0, height=5.0, axis=axis, across=across, along=along)
    mesh = cylinder.mesh()
    assert mesh.volumes.min() > 0.0
    outside = np.roll(mesh.nodes - (1.0, 2.0, 3.0), -("xyz".index(axis) + 1), axis=1)
    assert np.linalg.norm(outside[:, :2], axis=1).max() == pytest.approx(2.0, rel=1e-12)
    assert [outside[:, 2].min(), outside[:, 2].max()] == pytest.approx([0.0, 5.0], abs=1e-12)
    # the sides of the polygon differ a little: its area errs like that of one with 4 across sides, 2π²/3 n² of the disc
    assert mesh.volumes.sum() == pytest.approx(np.pi * 20.0, rel=1.5 * 2.0 * np.pi**2 / 3.0 / (4 * across) ** 2)


def test_every_fault_of_a_mesh_is_told():
    mesh = box_mesh(LOWER, UPPER, (2, 2, 2))
    assert not list(solid_faults(mesh))

    def fault(nodes, cells):
        return [text for text, _ in solid_faults(SimplexMesh(nodes, cells))]

    turned = mesh.cells.copy()
    turned[5] = turned[5, [1, 0, 2, 3]]
    assert re.match(r"1 tetrahedron is inverted; the first is number 5 \(counted from 0\), at \(", *fault(mesh.nodes, turned))
    again = [*mesh.cells, mesh.cells[3][[1, 2, 0, 3]]]
    assert re.match(r"1 tetrahedron occurs twice, for example numbers 3 and 96", *fault(mesh.nodes, again))
    lonely = np.vstack([mesh.nodes, [9.0, 9.0, 9.0]])
    assert re.match(
        r"1 node belongs to no tetrahedron; the first is number 35 \(counted from 0\), at \(9, 9, 9\) m",
        *fault(lonely, mesh.cells),
    )
    lonely[35, 0] = np.nan
    assert fault(lonely, mesh.cells) == ["node 35 (counted from 0) has the position (nan, 9.0, 9.0), which is not finite"]
    flat = mesh.nodes.copy()
    flat[mesh.cells[0, 3]] = flat[mesh.cells[0, :3]].mean(axis=0)
    assert any(
        re.match(r"\d+ tetrahedr\w+ (has|have) no volume; the first is number 0", text) for text in fault(flat, mesh.cells)
    )
    named = SimplexMesh(mesh.nodes, mesh.cells, {"top": np.array([1]), "rim": np.zeros(0, int), "edge": np.zeros(0, int)})
    text, remedy = next(solid_faults(named))
    assert text == "2 sets have no nodes: `rim`, `edge`"
    assert remedy == f"list their nodes, or remove the sets from the file: {REPAIR}"
    extra = np.vstack([mesh.nodes, mesh.nodes[mesh.cells[0]].mean(axis=0)])
    shared = mesh.faces[0][mesh.faces[1][:, 1] >= 0][0]
    over = [*mesh.cells, [*shared, len(mesh.nodes)]]
    assert any("more than two tetrahedra, for example the face of nodes" in text for text in fault(extra, over))
    assert any("more than two tetrahedra" in text for text in fault(extra, [*over, mesh.cells[3]]))


def two_boxes(gap=0.0):
    """Two boxes one upon the other, each with nodes of its own, so far apart."""
    lower, upper = box_mesh(np.zeros(3), np.ones(3), (2, 2, 2)), box_mesh(np.zeros(3), np.ones(3), (2, 2, 1))
    n = len(lower.nodes)
    above = upper.nodes + np.array([0.0, 0.0, 1.0 + gap])
    return SimplexMesh(np.vstack([lower.nodes, above]), np.vstack([lower.cells, upper.cells + n]))


@pytest.mark.parametrize("gap", [0.0, 1e-8])
def test_nodes_at_one_place_that_tetrahedra_do_not_share_are_told(gap):
    mesh = two_boxes(gap)
    [(text, remedy)] = solid_faults(mesh)
    named = r"9 pairs of nodes have the same position, for example numbers (\d+) and (\d+) \(counted from 0\), at \((.*)\) m; "
    named += r"their distance is (\S+) m"
    one, other, place, distance = re.match(named, text).groups()
    assert mesh.nodes[int(one)] == pytest.approx(np.array(place.split(", "), float), abs=1e-6)
    assert mesh.nodes[int(other)] == pytest.approx(mesh.nodes[int(one)], abs=2e-8)
    assert float(distance) == pytest.approx(gap, abs=1e-15)
    limit = float(re.search(r"must be more than (\S+) m", text)[1])
    assert limit == pytest.approx(1e-6 * np.cbrt(2.0 / len(mesh.cells)), rel=1e-2)
    assert "merge these nodes" in remedy


def test_nodes_near_each_other_are_no_fault_and_pieces_are_told():
    mesh = two_boxes(1e-3)
    assert list(solid_faults(mesh)) == []
    larger, smaller = len(box_mesh(*np.eye(3)[:2], (2, 2, 2)).cells), len(box_mesh(*np.eye(3)[:2], (2, 2, 1)).cells)
    assert apart(mesh).startswith(
        f"the mesh consists of 2 pieces that share no node, of {larger} and {smaller} tetrahedra; no force acts"
    )
    one = np.array([[0, 1, 2, 3]])
    many = SimplexMesh(np.random.default_rng(0).uniform(size=(28, 3)), np.vstack([one + 4 * k for k in range(7)]))
    assert "consists of 7 pieces that share no node, of 1, 1, 1, 1, 1, ... tetrahedra" in apart(many)
    assert apart(box_mesh(LOWER, UPPER, (3, 2, 1))) is None


@pytest.mark.parametrize("cells", [(1, 1, 1), (1, 3, 2), (4, 3, 5)])
def test_a_pattern_needs_none_of_the_checks_that_it_is_spared(cells):
    pattern = BoxMesh(lower=(0, 0, 0), upper=(1, 2, 3), cells=cells, grading=(3.0, 1.0, 0.1))
    assert pattern.is_pattern
    assert not list(solid_faults(pattern.make()))
    assert apart(pattern.make()) is None


def test_a_pattern_that_rounding_makes_flat_is_told():
    flat = SolidMesh(box={"lower": (1e9, 0, 0), "upper": (1e9 + 1e-6, 1, 1), "cells": (40, 1, 1)})
    assert any("no volume" in text for text, _ in flat.faults())
