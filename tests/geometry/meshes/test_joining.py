"""Vertices at one place are joined; layers that lie on each other stay apart."""

import warnings

import numpy as np
import pytest

from pellucid.geometry.checks.surface_checks import mesh_faults
from pellucid.geometry.files.writing import write_surface
from pellucid.geometry.mesh_survey import survey
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh, joined, layers_parted, place_of_each
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface
from pellucid.geometry.surfaces.surface import Surface


def disc(rings, quads=False):
    """Vertices on rings of 6, 12, ... about one in the middle, and triangles; a square of quadrilaterals instead."""
    if quads:
        i, j = np.meshgrid(np.arange(rings + 1), np.arange(rings + 1), indexing="ij")
        n = rings + 1
        places = np.column_stack([i.ravel(), j.ravel(), 0 * i.ravel()]) / rings
        corner = (np.arange(rings)[:, None] * n + np.arange(rings)).ravel()
        rim = (i.ravel() % rings == 0) | (j.ravel() % rings == 0)
        return places, np.stack([corner, corner + n, corner + n + 1, corner + 1], axis=1), rim
    from scipy.spatial import Delaunay

    angles = [2.0 * np.pi * np.arange(6 * k) / (6 * k) for k in range(1, rings + 1)]
    places = np.concatenate([[(0, 0)], *(k / rings * np.column_stack([np.cos(a), np.sin(a)]) for k, a in enumerate(angles, 1))])
    triangles = Delaunay(places).simplices
    a, b, c = (places[triangles[:, k]] for k in range(3))
    area = np.cross(np.pad(b - a, ((0, 0), (0, 1))), np.pad(c - a, ((0, 0), (0, 1))))[:, 2]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    triangles = triangles[np.abs(area) > 1e-9]
    rim = np.linalg.norm(places, axis=1) > 1.0 - 1e-9
    return np.pad(places, ((0, 0), (0, 1))), triangles, rim


def bag(rings=3, quads=False, shared_rim=True, tilt=None):
    """A flat bag of two layers: vertices, elements."""
    places, above, rim = disc(rings, quads)
    n = len(places)
    other = np.arange(n) + n
    if shared_rim:
        other = np.where(rim, np.arange(n), n + np.cumsum(~rim) - 1)
        places = np.concatenate([places, places[~rim]])
    else:
        places = np.concatenate([places, places])
    elements = np.concatenate([above, other[above][:, ::-1]])
    return places if tilt is None else places @ tilt, elements


def mesh_of(vertices, elements):
    return Mesh(vertices, elements, np.zeros((0, 3), int)) if elements.shape[1] == 4 else Mesh(vertices, NO_QUADS, elements)


@pytest.mark.parametrize("ending", [".obj", ".ply", ".msh", ".vtk"])
@pytest.mark.parametrize("quads", [False, True])
@pytest.mark.parametrize("shared_rim", [True, False])
def test_a_flat_bag_keeps_both_layers(ending, quads, shared_rim, tmp_path):
    if ending in (".msh", ".vtk"):
        pytest.importorskip("meshlane")
    vertices, elements = bag(3, quads, shared_rim)
    path = tmp_path / f"bag{ending}"
    write_surface(path, ending, *mesh_of(vertices, elements))
    inner = int((~disc(3, quads)[2]).sum())
    with pytest.warns(UserWarning, match=f"{inner} vertices coincide with another one but were not merged"):
        mesh = Surface(file={"path": str(path), "closed": True}).mesh()
    assert len(mesh.vertices) == len(bag(3, quads)[0])
    assert list(mesh_faults(mesh, closed=True)) == []
    found = survey(str(path), False, 0, 1.0)
    if shared_rim:
        assert found.faults == []
        assert dict(found.rows)["closed"] == "yes"
    else:
        [(text, remedy)] = found.faults
        assert "twice" in text
        assert "if these are the two layers of a flat bag, set `closed = true`" in remedy
    with pytest.warns(UserWarning, match="not merged"):
        repaired = Surface(file={"path": str(path), "closed": True, "repair": True}).mesh()
    assert len(repaired.vertices) == len(mesh.vertices), "a repair makes no single sheet of it"


def test_a_flat_bag_in_a_file_without_numbers_of_vertices_is_parted_where_it_is_closed(tmp_path):
    vertices, triangles = bag(3, tilt=np.linalg.qr(np.arange(9).reshape(3, 3) ** 2 - 4.0)[0])
    path = tmp_path / "bag.stl"
    write_surface(path, ".stl", vertices, NO_QUADS, triangles)
    [(text, remedy)] = survey(str(path), False, 0, 1.0).faults
    assert "triangles occur twice" in text
    assert "if these are the two layers of a flat bag, set `closed = true`" in remedy
    for repair in (False, True):
        with pytest.warns(UserWarning, match="two coincident layers were separated and stay joined at their rim"):
            mesh = Surface(file={"path": str(path), "closed": True, "repair": repair}).mesh()
        assert len(mesh.vertices) == len(vertices)
        assert len(mesh.triangles) == len(triangles)
        assert list(mesh_faults(mesh, closed=True)) == []
    with pytest.warns(UserWarning, match="duplicate elements were removed"):
        sheet = Surface(file={"path": str(path), "repair": True}).mesh()
    assert len(sheet.triangles) == len(triangles) // 2


@pytest.mark.parametrize("closed", [False, True])
def test_layers_whose_elements_differ_are_kept_apart(closed):
    """Squares cut along one diagonal above and along the other one below: no element is there twice, edges have four."""
    places, squares, rim = disc(4, quads=True)
    n = len(places)
    below = np.where(rim, np.arange(n), n + np.cumsum(~rim) - 1)[squares[:, ::-1]]
    triangles = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]], below[:, [0, 1, 2]], below[:, [0, 2, 3]]])
    place, apart = joined(np.concatenate([places, places[~rim]]), NO_QUADS, triangles, 0.0, closed)
    assert apart == np.count_nonzero(~rim)
    assert np.array_equal(place, np.arange(n + apart))


def test_surfaces_at_one_place_without_a_common_rim_are_not_kept_apart():
    """Of a cube that is there twice with vertices of its own, and of two cubes that touch, elements are there twice."""
    cube = BoxSurface(lower=(0, 0, 0), upper=(1, 1, 1), points=(2, 2, 2)).mesh()
    n = len(cube.vertices)
    for shift in (0.0, 1.0):
        points = np.concatenate([cube.vertices, cube.vertices + np.array([shift, 0.0, 0.0])])
        for closed in (False, True):
            assert joined(points, np.concatenate([cube.quads, n + cube.quads[:, ::-1]]), NO_QUADS[:, :3], 0.0, closed)[1] == 0


def test_a_closed_surface_that_a_file_has_twice_is_no_bag():
    cube = BoxSurface(lower=(0, 0, 0), upper=(1, 1, 1), points=(2, 2, 2)).mesh().triangulated()
    for again in (cube.triangles, cube.triangles[:, ::-1]):
        twice = Mesh(cube.vertices, NO_QUADS, np.concatenate([cube.triangles, again]))
        assert layers_parted(twice) is None
        [(text, remedy)] = mesh_faults(twice, closed=True)
        assert "12 triangles occur twice" in text
        assert remedy.startswith("remove the duplicates")


def test_a_sheet_that_is_attached_by_place_stays_attached():
    """A sheet on a ball shares places of its rim with the inside of another sheet: no layers, an edge of three elements."""
    places, triangles, _ = disc(2)
    flap = np.array([(0.0, 0, 0), (0.5, 0, 0), (0.25, 0, 1)])
    points = np.concatenate([places, flap])
    n = len(places)
    place, apart = joined(points, NO_QUADS, np.concatenate([triangles, [(n, n + 1, n + 2)]]), 0.0)
    assert apart == 0
    assert place[n] == 0


@pytest.mark.parametrize("noise", [3e-17, -1e-12, 1e-10])
def test_rounding_about_zero_joins(noise, tmp_path):
    """Exporters write 3e-17 for 0, with another sign at each element."""
    cube = BoxSurface(lower=(0, 0, 0), upper=(1, 1, 1), points=(3, 3, 3)).mesh().triangulated()
    places = cube.vertices[cube.triangles.ravel()]
    sign = np.random.default_rng(1).choice([-1.0, 0.0, 1.0], places.shape)
    places = np.where(places == 0.0, noise * sign, places)
    path = tmp_path / "cube.stl"
    write_surface(path, ".stl", places, NO_QUADS, np.arange(len(places)).reshape(-1, 3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = Surface(file={"path": str(path), "closed": True}).mesh()
    assert len(mesh.vertices) == len(cube.vertices)
    assert list(mesh_faults(mesh, closed=True)) == []


def test_places_take_the_first_number_and_chains_are_one():
    points = np.array([(5.0, 0, 0), (0, 0, 0), (5.0, 0, 0), (-0.0, 0, 0), (1e-9, 0, 0), (2e-9, 0, 0)])
    assert place_of_each(points, 0.0).tolist() == [0, 1, 0, 1, 4, 5]
    assert place_of_each(points, 1.5e-9).tolist() == [0, 1, 0, 1, 1, 1]
