"""What is written to a file is read again as it was."""

import numpy as np
import pytest

from pellucid.findings import Refusal
from pellucid.geometry.files.writing import check_ending, write_solid, write_surface
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.solid_meshes.file import SolidFile
from pellucid.geometry.surfaces.file import SurfaceFile
from pellucid.geometry.surfaces.quadrilaterals import CylinderSurface

DRUM = CylinderSurface(start=(0, 0, 0), end=(0.1, 0, 1 / 3), radius=0.7, rings=2, along=3).mesh()
BOX = box_mesh(np.zeros(3), np.array([1 / 3, 1, 1]), (2, 1, 1))
SETS = {"bottom": np.flatnonzero(BOX.nodes[:, 2] == 0.0), "left wall": np.flatnonzero(BOX.nodes[:, 0] == 0.0)}


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".vtk", ".vtu", ".msh"])
def test_a_surface_comes_back_to_the_last_bit(tmp_path, ending):
    if ending not in (".stl", ".obj", ".ply"):
        pytest.importorskip("meshlane")
    path = tmp_path / f"drum{ending}"
    write_surface(path, ending, *DRUM)
    mesh = SurfaceFile(path=str(path)).mesh()
    if ending == ".stl":
        assert np.array_equal(mesh.vertices[mesh.triangles], DRUM.vertices[DRUM.triangulated().triangles])
    else:
        assert np.array_equal(mesh.vertices[mesh.quads], DRUM.vertices[DRUM.quads])
        assert np.array_equal(mesh.vertices[mesh.triangles], DRUM.vertices[DRUM.triangles])


@pytest.mark.parametrize("ending", [".msh", ".vtk", ".vtu", ".inp"])
def test_a_solid_comes_back_with_its_sets(tmp_path, ending):
    pytest.importorskip("meshlane")
    path = tmp_path / f"box{ending}"
    write_solid(path, ending, BOX.nodes, BOX.cells, SETS)
    mesh = SolidFile(path=str(path)).mesh()
    assert np.allclose(mesh.nodes, BOX.nodes, rtol=1e-15)
    assert np.array_equal(mesh.cells, BOX.cells)
    space = "_" if ending in (".vtk", ".vtu") else " "
    assert {name: nodes.tolist() for name, nodes in mesh.sets.items()} == {
        name.replace(" ", space): nodes.tolist() for name, nodes in SETS.items()
    }


def test_formats_that_cannot_hold_a_mesh_are_refused():
    with pytest.raises(Refusal, match=r"a solid cannot be written to a file with the ending \.stl; use one of \.msh"):
        check_ending("a.stl", is_solid=True)
    with pytest.raises(Refusal, match=r"a surface cannot be written to a file with no ending; use one of \.stl"):
        check_ending("a", is_solid=False)
