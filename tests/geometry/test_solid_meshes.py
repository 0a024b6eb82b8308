"""Meshes of tetrahedra: volumes, faces, files, faults."""

import re

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid.geometry.box_mesh import box_mesh
from pellucid.geometry.cylinder_mesh import CylinderMesh
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.geometry.solid_checks import solid_faults
from pellucid.geometry.solid_file import SolidFile
from pellucid.geometry.solid_meshes import SolidMesh

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
    assert re.match(r"1 tetrahedron is inverted, the first is number 5 at \(", *fault(mesh.nodes, turned))
    assert re.match(
        r"1 tetrahedron is there twice, for example numbers 3 and 96", fault(mesh.nodes, [*mesh.cells, mesh.cells[3]])[0]
    )
    lonely = np.vstack([mesh.nodes, [9.0, 9.0, 9.0]])
    assert re.match(r"1 node belongs to no tetrahedron, the first is number 35 at \(9, 9, 9\) m", *fault(lonely, mesh.cells))
    lonely[35, 0] = np.nan
    assert fault(lonely, mesh.cells) == ["node 35 is at (nan, 9.0, 9.0), which is no place"]
    flat = mesh.nodes.copy()
    flat[mesh.cells[0, 3]] = flat[mesh.cells[0, :3]].mean(axis=0)
    assert any(
        re.match(r"\d+ tetrahedr\w+ (has|have) no volume, the first is number 0", text) for text in fault(flat, mesh.cells)
    )
    extra = np.vstack([mesh.nodes, mesh.nodes[mesh.cells[0]].mean(axis=0)])
    shared = mesh.faces[0][mesh.faces[1][:, 1] >= 0][0]
    over = [*mesh.cells, [*shared, len(mesh.nodes)]]
    assert any("more than two tetrahedra, for example that of nodes" in text for text in fault(extra, over))


@pytest.mark.parametrize("ending", ["msh", "vtk", "vtu", "inp", "bdf"])
def test_files_of_tetrahedra_are_read_back(tmp_path, ending):
    meshlane = pytest.importorskip("meshlane")
    mesh = box_mesh(LOWER, UPPER, (2, 1, 1))
    path = tmp_path / f"box.{ending}"
    meshlane.write(str(path), meshlane.Mesh(1000.0 * mesh.nodes, [("tetra", mesh.cells)]))
    read = SolidFile(path=str(path), scale=0.001).mesh()
    assert read.cells == pytest.approx(mesh.cells)
    assert read.nodes == pytest.approx(mesh.nodes, abs=1e-9 if ending != "bdf" else 1e-5)  # Nastran writes few digits


def test_named_sets_of_nodes_are_read(tmp_path):
    meshlane = pytest.importorskip("meshlane")
    mesh = box_mesh(LOWER, UPPER, (1, 1, 1))
    bottom = np.flatnonzero(mesh.nodes[:, 2] == LOWER[2])
    path = tmp_path / "box.inp"
    meshlane.write(str(path), meshlane.Mesh(mesh.nodes, [("tetra", mesh.cells)], point_sets={"bottom": bottom}))
    sets = SolidFile(path=str(path)).mesh().sets
    assert sets["bottom"].tolist() == bottom.tolist()


def test_a_mesh_is_made_once_while_its_file_does_not_change(tmp_path):
    meshlane = pytest.importorskip("meshlane")
    path = tmp_path / "box.vtk"
    for n in (1, 2):
        box = box_mesh(LOWER, UPPER, (n, n, n))
        meshlane.write(str(path), meshlane.Mesh(box.nodes, [("tetra", box.cells)]))
        source = SolidMesh(file={"path": str(path)})
        assert len(source.mesh().cells) == len(box.cells)
        assert source.mesh() is SolidMesh(file={"path": str(path)}).mesh()
    table = {"lower": LOWER.tolist(), "upper": UPPER.tolist(), "cells": (1, 2, 3)}
    assert SolidMesh(box=table).mesh() is SolidMesh(box=table).mesh()


def test_a_file_without_tetrahedra_is_refused(tmp_path):
    meshlane = pytest.importorskip("meshlane")
    path = tmp_path / "sheet.vtk"
    meshlane.write(str(path), meshlane.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))]))
    with pytest.raises(ValidationError, match="holds no tetrahedron"):
        SolidFile(path=str(path))
    with pytest.raises(ValidationError, match="there is no file"):
        SolidFile(path=str(tmp_path / "none.msh"))
