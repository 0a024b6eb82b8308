"""Triangulated surfaces: areas, closure, direction of the normals."""

import numpy as np
import pytest

from pellucid.bodies.membrane_points.surface import area_shares, fans_of, initial_frames
from pellucid.geometry.checks.surface_checks import mesh_faults
from pellucid.geometry.meshes.enclosure import enclosed_volume
from pellucid.geometry.meshes.surface_mesh import grid_quads
from pellucid.geometry.surfaces.quadrilaterals import (
    BoxSurface,
    CushionSurface,
    CylinderSurface,
    Lid,
    Rectangle,
    SphereSurface,
    Tube,
)
from pellucid.geometry.surfaces.surface import Surface
from pellucid.geometry.surfaces.triangles import Disc, Icosphere


def volume_inside(vertices, triangles):
    a, b, c = vertices[triangles.T]
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def test_a_rectangle_has_its_area_and_normal():
    rectangle = Rectangle(corner=(1, 2, 3), first_edge=(2, 0, 0), second_edge=(0, 0.5, 0.5), points=(5, 4))
    vertices, triangles = rectangle.triangulate()
    assert len(vertices) == 20
    assert len(triangles) == 2 * 4 * 3
    assert area_shares(vertices, triangles).sum() == pytest.approx(2 * np.sqrt(0.5), rel=1e-14)
    normals = initial_frames(vertices, triangles)[:, 6:]
    assert normals == pytest.approx(np.tile(np.cross((1, 0, 0), (0, 1, 1)) / np.sqrt(2.0), (20, 1)), abs=1e-14)


def test_the_papers_net_and_oocyte_have_its_counts():
    net = Rectangle(corner=(0, 0, 0), first_edge=(1, 0, 0), second_edge=(0, 0.2, 0), points=(1000, 40)).triangulate()
    assert (len(net.vertices), len(net.triangles)) == (40_000, 77_922)
    oocyte = Icosphere(centre=(0, 0, 0), radius=50e-6, refinements=6).triangulate()
    assert (len(oocyte.vertices), len(oocyte.triangles)) == (40_962, 81_920)


@pytest.mark.parametrize("refinements", [0, 2, 4])
def test_an_icosphere_is_closed_and_outward(refinements):
    vertices, triangles = Icosphere(centre=(1, 2, 3), radius=2.0, refinements=refinements).triangulate()
    assert len(vertices) == 10 * 4**refinements + 2
    assert np.linalg.norm(vertices - (1, 2, 3), axis=1) == pytest.approx(2.0, rel=1e-14)
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed), "each edge once in each direction"
    assert {tuple(edge) for edge in directed} == {tuple(edge[::-1]) for edge in directed}
    assert 0.0 < volume_inside(vertices - (1, 2, 3), triangles) < 4.0 / 3.0 * np.pi * 8.0
    normals = initial_frames(vertices, triangles)[:, 6:]
    # directions of points and normals agree the better the finer: by symmetry exactly at the twelve corners
    assert np.einsum("ij,ij->i", normals, (vertices - (1, 2, 3)) / 2.0).min() > 0.99


def test_a_tube_is_open_and_outward():
    vertices, triangles = Tube(start=(0, 0, 1), end=(0, 0, 3), radius=0.5, points=(64, 9)).triangulate()
    # a polygon of 64 sides
    assert area_shares(vertices, triangles).sum() == pytest.approx(64 * 2 * 0.5 * np.sin(np.pi / 64) * 2.0, rel=1e-12)
    normals = initial_frames(vertices, triangles)[:, 6:]
    outward = vertices * (1, 1, 0) / 0.5
    assert np.einsum("ij,ij->i", normals, outward).min() > 0.99


def test_fans_go_round_each_point():
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    fans = fans_of(triangles, 4)
    assert fans.start.tolist() == [0, 2, 3, 5, 6]
    assert fans.corners[:2].tolist() == [[1, 2], [2, 3]]
    assert fans.corners[2].tolist() == [2, 0]


@pytest.mark.parametrize("rings", [1, 2, 7])
def test_a_disc_is_made_of_good_triangles_up_to_its_circle(rings):
    normal = np.array((1.0, -2.0, 2.0))
    vertices, triangles = Disc(centre=(1, 2, 3), normal=tuple(normal), radius=0.7, rings=rings).triangulate()
    assert len(vertices) == 1 + 3 * rings * (rings + 1)
    assert len(triangles) == 6 * rings**2
    distance = np.linalg.norm(vertices - (1, 2, 3), axis=1)
    assert distance[-6 * rings :] == pytest.approx(0.7, rel=1e-14)
    assert (vertices - (1, 2, 3)) @ normal == pytest.approx(0.0, abs=1e-14)
    # a polygon of 6 rings sides
    n = 6 * rings
    assert area_shares(vertices, triangles).sum() == pytest.approx(0.5 * n * np.sin(2 * np.pi / n) * 0.49, rel=1e-12)
    assert initial_frames(vertices, triangles)[:, 6:] == pytest.approx(np.tile(normal / 3.0, (len(vertices), 1)), abs=1e-14)
    corners = vertices[triangles]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2) * rings / 0.7
    assert edges.min() > 0.95
    assert edges.max() < 1.45  # a square of sides 1 and π/3 cut in two


@pytest.mark.parametrize("face", ["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"])
def test_a_lid_closes_its_face_outward(face):
    lower, upper = np.array((1.0, 2.0, 3.0)), np.array((1.5, 3.0, 5.0))
    vertices, triangles = Lid(box={"lower": lower, "upper": upper}, face=face, points=(4, 3)).triangulate()
    axis, outward = "xyz".index(face[0]), 1.0 if face.endswith("upper") else -1.0
    assert np.all(vertices[:, axis] == (upper if outward > 0 else lower)[axis])
    assert np.delete(vertices.min(axis=0), axis) == pytest.approx(np.delete(lower, axis))
    assert np.delete(vertices.max(axis=0), axis) == pytest.approx(np.delete(upper, axis))
    first = next(a for a in range(3) if a != axis)
    assert len(np.unique(vertices[:, first])) == 4, "points along the axes in the order x, y, z"
    assert initial_frames(vertices, triangles)[:, 6 + axis] == pytest.approx(outward)


def test_surfaces_without_a_direction_are_refused():
    with pytest.raises(ValueError, match="`normal` has zero length"):
        Disc(centre=(0, 0, 0), normal=(0, 0, 0), radius=1.0, rings=2)
    with pytest.raises(ValueError, match="`start` and `end` are the same point"):
        Tube(start=(0, 0, 0), end=(0, 0, 0), radius=1.0, points=(8, 2))


def test_a_triangulation_belongs_to_who_asked_for_it():
    surface = Surface(icosphere={"centre": (0, 0, 0), "radius": 1.0, "refinements": 1})
    surface.triangulate().vertices[:] = 7.0
    surface.mesh().triangles[:] = 7
    assert np.linalg.norm(surface.triangulate().vertices, axis=1) == pytest.approx(1.0)


BOX = {"lower": (1.0, 2.0, 3.0), "upper": (2.0, 4.0, 3.5), "points": (4, 6, 3)}


def test_a_box_is_closed_with_its_area_and_volume():
    box = BoxSurface(**BOX)
    mesh = box.mesh()
    assert box.closed
    assert len(mesh.triangles) == 0
    assert len(mesh.quads) == 2 * (3 * 5 + 3 * 2 + 5 * 2)
    assert len(mesh.vertices) == 4 * 6 * 3 - 2 * 4 * 1, "the lattice without its inner points"
    assert volume_inside(*mesh.triangulated()) == pytest.approx(1.0, rel=1e-14)
    assert area_shares(*mesh.triangulated()).sum() == pytest.approx(2 * (2 + 1 + 0.5), rel=1e-14)
    assert mesh.vertices.min(axis=0).tolist() == [1, 2, 3]
    assert mesh.vertices.max(axis=0).tolist() == [2, 4, 3.5]


def test_open_faces_of_a_box_are_left_out_with_their_points():
    """A quarter of a ring one element deep."""
    band = BoxSurface(**BOX | {"points": (4, 6, 2)}, open=("x-lower", "y-lower", "z-lower", "z-upper"))
    mesh = band.mesh()
    assert not band.closed
    assert len(mesh.quads) == 3 + 5
    assert len(mesh.vertices) == 2 * (4 + 6 - 1)
    assert np.all((mesh.vertices[:, 0] == 2.0) | (mesh.vertices[:, 1] == 4.0))
    normals = initial_frames(*mesh.triangulated())[:, 6:]
    assert normals[:, :2].min() > -1e-14
    assert np.abs(normals[:, 2]).max() < 1e-14
    only = BoxSurface(**BOX, open=tuple(f for f in ("x-lower", "y-lower", "y-upper", "z-lower", "z-upper")))
    assert np.all(only.mesh().vertices[:, 0] == 2.0)


def test_boxes_without_faces_or_extent_are_refused():
    every = ("x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper")
    with pytest.raises(ValueError, match="so no surface is left"):
        BoxSurface(**BOX, open=every)
    with pytest.raises(ValueError, match=r"`upper` must exceed `lower` along z: 3 m is not greater than 3 m"):
        BoxSurface(**BOX | {"upper": (2.0, 4.0, 3.0)})


@pytest.mark.parametrize("divisions", [1, 2, 5, 12])
def test_a_sphere_of_quadrilaterals(divisions):
    sphere = SphereSurface(centre=(1, 2, 3), radius=2.0, divisions=divisions)
    mesh = sphere.mesh()
    assert len(mesh.vertices) == 6 * divisions**2 + 2
    assert len(mesh.quads) == 6 * divisions**2
    assert np.linalg.norm(mesh.vertices - (1, 2, 3), axis=1) == pytest.approx(2.0, rel=1e-14)
    corners = mesh.vertices[mesh.quads]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    # lines at equal angles keep the sizes of the elements near each other; at equal distances on the cube it would be 2.1
    assert edges.max() / edges.min() < 1.5


def test_the_volume_of_a_sphere_of_quadrilaterals_converges():
    """Flat elements cut off a share that falls with the square of their size."""
    exact = 4.0 / 3.0 * np.pi * 8.0
    short = [
        1.0 - volume_inside(*SphereSurface(centre=(0, 0, 0), radius=2.0, divisions=k).triangulate()) / exact for k in (4, 8, 16)
    ]
    assert np.log2(np.array(short[:-1]) / short[1:]) == pytest.approx([2.0, 2.0], abs=0.1)


def test_a_part_of_a_sphere_is_a_cap():
    """A quarter of the cap below z = -0.8: lines of an even number of quadrilaterals lie on the planes of symmetry."""
    sphere = {"centre": (1, 2, 3), "radius": 2.0, "divisions": 32}
    cap = SphereSurface(**sphere, part={"lower": (1, 2, 1), "upper": (9, 9, 1.4)})
    mesh = cap.mesh()
    assert not cap.closed
    assert not list(mesh_faults(mesh, closed=False))
    assert mesh.vertices[:, :2].min(axis=0) == pytest.approx([1.0, 2.0], abs=1e-12)
    assert np.linalg.norm(mesh.vertices - (1, 2, 3), axis=1) == pytest.approx(2.0, rel=1e-14)
    vertices, triangles = mesh.triangulated()
    assert (initial_frames(vertices, triangles)[:, 8] < 0.0).all(), "outward as on the whole sphere"
    # the rim is a stair within an element of the circle at z = 1.4
    cut = 2.0 * np.pi * 2.0 * 0.4 / 4.0
    rim = 0.5 * np.pi * 1.2 * 2.0 * 2.0 * np.sin(np.pi / 4 / 32)
    assert cut - 1.5 * rim < area_shares(vertices, triangles).sum() < cut


def test_a_part_without_an_element_of_the_sphere_is_refused():
    with pytest.raises(ValueError, match=r"of the sphere has all corners in `part`; .* up to 0.39 m wide; enlarge the box"):
        SphereSurface(centre=(0, 0, 0), radius=1.0, divisions=4, part={"lower": (0, 0, 0.9), "upper": (0.1, 0.1, 1)})


CYLINDER = {"start": (0, 0, 1), "end": (0, 3, 5), "radius": 0.5, "rings": 4, "along": 6}


def test_a_cylinder_is_closed_by_lids_that_share_its_rims():
    mesh = CylinderSurface(**CYLINDER).mesh()
    assert CylinderSurface(**CYLINDER).closed
    assert len(mesh.quads) == 24 * 5
    assert len(mesh.triangles) == 2 * 6 * 4**2
    assert len(mesh.vertices) == 24 * 6 + 2 * (1 + 3 * 3 * 4)
    # a prism on a polygon of 24 sides
    base = 0.5 * 24 * np.sin(2 * np.pi / 24) * 0.25
    assert volume_inside(*mesh.triangulated()) == pytest.approx(5.0 * base, rel=1e-12)
    assert enclosed_volume(*mesh.triangulated()) == pytest.approx(5.0 * base, rel=1e-12)


@pytest.mark.parametrize("ends", [("start",), ("end",), ("start", "end")])
def test_open_ends_of_a_cylinder_have_no_lid(ends):
    cylinder = CylinderSurface(**CYLINDER, open=ends)
    mesh = cylinder.mesh()
    assert not cylinder.closed
    assert len(mesh.triangles) == (2 - len(ends)) * 6 * 4**2
    lids = mesh.vertices[mesh.triangles].mean(axis=1) @ (0, 0.6, 0.8)
    assert np.all(lids > 4.0 if ends == ("start",) else lids < 1.0)


def test_a_cylinder_of_no_length_is_refused():
    with pytest.raises(ValueError, match="the same point"):
        CylinderSurface(**CYLINDER | {"end": (0, 0, 1)})


def test_a_surface_gives_quadrilaterals_or_triangles_alone():
    surface = Surface(cylinder=CYLINDER)
    mesh, cut = surface.mesh(), surface.mesh("triangles")
    assert len(mesh.quads) == 120
    assert len(cut.quads) == 0
    assert np.array_equal(cut.vertices, mesh.vertices)
    assert np.array_equal(cut.triangles, surface.triangulate().triangles)
    assert np.array_equal(cut.triangles[:2], mesh.quads[0][[[0, 1, 2], [0, 2, 3]]])
    assert np.array_equal(cut.triangles[240:], mesh.triangles)


def test_a_reversed_mesh_is_cut_alike():
    mesh = CylinderSurface(**CYLINDER).mesh()
    turned = mesh.reversed().triangulated().triangles

    def named(triangles):
        return {tuple(t) for t in np.sort(triangles, axis=1)}

    assert named(turned) == named(mesh.triangulated().triangles)
    assert volume_inside(mesh.vertices, turned) == pytest.approx(-volume_inside(*mesh.triangulated()))


def test_a_cushion_is_two_domed_sheets_with_common_edges():
    cushion = CushionSurface(centre=(1, 2, 3), sides=(2.0, 1.0), height=0.3, points=(41, 21))
    vertices, triangles = cushion.triangulate()
    assert len(vertices) == 2 * 41 * 21 - 2 * (41 + 21) + 4, "the points of the edges once"
    assert vertices.min(axis=0) == pytest.approx((0.0, 1.5, 2.85))
    assert vertices.max(axis=0) == pytest.approx((2.0, 2.5, 3.15))
    # the mean of (1 - ξ²)(1 - η²) is 4/9; the trapezoidal rule is 1/n² of it short along each axis with n squares to a half
    exact = 4.0 / 9.0 * 2.0 * 1.0 * 0.3
    assert enclosed_volume(vertices, triangles) == pytest.approx(exact, rel=0.01)
    assert volume_inside(vertices, triangles) > 0.0
    assert not list(mesh_faults(cushion.mesh(), closed=cushion.closed))


HALVINGS = [(), ("x",), ("y",), ("z",), ("x", "y"), ("x", "z"), ("y", "z"), ("x", "y", "z")]


@pytest.mark.parametrize("points", [(3, 3), (3, 6), (5, 4), (12, 9)])
@pytest.mark.parametrize("halved", HALVINGS)
@pytest.mark.parametrize("elements", ["quads", "triangles"])
def test_every_cushion_is_a_sound_mesh(halved, points, elements):
    cushion = CushionSurface(centre=(1, 2, 3), sides=(2.0, 1.0), height=0.1, points=points, halved=halved)
    mesh = Surface(cushion=cushion).mesh(elements)
    assert not list(mesh_faults(mesh, closed=cushion.closed))
    assert bool(len(mesh.quads)) == (elements == "quads")
    # no element lies in the plane of the edges, where it would have a twin in the other sheet
    for corners in (mesh.quads, mesh.triangles):
        assert np.all(np.abs(mesh.vertices[corners][:, :, 2] - 3.0).max(axis=1) > 0.0)


@pytest.mark.parametrize("points", [(3, 3), (3, 6), (12, 9)])
def test_the_two_sheets_of_a_cushion_mirror_each_other(points):
    """Cut in two as well: elements that do not would push the bag to one side."""
    cushion = CushionSurface(centre=(0, 0, 0), sides=(2.0, 1.0), height=0.1, points=points)
    vertices, triangles = cushion.triangulate()
    upper = vertices[triangles][:, :, 2].max(axis=1) > 0.0
    assert 2 * np.count_nonzero(upper) == len(triangles)

    def places(of, sign):
        return {frozenset(map(tuple, np.round(corners * (1, 1, sign), 12) + 0.0)) for corners in vertices[of]}

    assert places(triangles[upper], 1.0) == places(triangles[~upper], -1.0)
    normals = initial_frames(vertices, triangles)[:, 6:]
    on_edge = vertices[:, 2] == 0.0
    assert normals[on_edge, 2] == pytest.approx(0.0, abs=1e-14), "halfway between those of the sheets"
    assert np.einsum("ij,ij->i", normals[on_edge], vertices[on_edge]).min() > 0.0, "outward"


def test_a_halved_cushion_keeps_the_order_of_its_corners():
    cushion = CushionSurface(centre=(0, 0, 0), sides=(1, 1), height=0.1, points=(4, 4), halved=("x", "y", "z"))
    assert np.array_equal(cushion.mesh().quads, grid_quads(4, 4, wrapped=False))


@pytest.mark.parametrize(("points", "axis"), [((2, 5), "x"), ((5, 2), "y")])
def test_sheets_that_would_coincide_are_refused(points, axis):
    settings = {"centre": (0, 0, 0), "sides": (1.0, 1.0), "height": 0.2, "points": points}
    with pytest.raises(ValueError, match=f"2 points along {axis} all points lie on the common edges.* use at least 3"):
        CushionSurface(**settings)
    for halved in (axis, "z"):
        assert not list(mesh_faults(CushionSurface(**settings, halved=(halved,)).mesh(), closed=False))


@pytest.mark.parametrize(("halved", "share"), [(("x",), 0.5), (("y", "z"), 0.25), (("x", "y", "z"), 0.125)])
def test_a_halved_cushion_is_the_upper_part_of_the_whole(halved, share):
    settings = {"centre": (0, 0, 0), "sides": (1.0, 1.0), "height": 0.2}
    whole = CushionSurface(**settings, points=(9, 9))
    part = CushionSurface(**settings, points=tuple(5 if axis in halved else 9 for axis in "xy"), halved=halved)
    assert whole.closed
    assert not part.closed
    assert not list(mesh_faults(part.mesh(), closed=False))
    assert {tuple(x) for x in np.round(part.mesh().vertices, 12)} <= {tuple(x) for x in np.round(whole.mesh().vertices, 12)}
    area, all_of_it = (area_shares(*cushion.triangulate()).sum() for cushion in (part, whole))
    assert area == pytest.approx(share * all_of_it, rel=1e-3)  # quadrilaterals are cut along other diagonals


def test_a_red_cell_has_its_size():
    """Volume 94.10 µm³, area 134.09 µm², thickest 2.566 µm: integrals of the meridian of a radius of 3.91 µm."""
    vertices, triangles = Surface(biconcave={"radius": 3.91, "refinements": 5}).triangulate()
    a, b, c = vertices[triangles.T]
    normals = np.cross(b - a, c - a)
    assert np.einsum("ti,ti->", a, normals) / 6.0 == pytest.approx(94.10, rel=1e-3)
    assert 0.5 * np.linalg.norm(normals, axis=1).sum() == pytest.approx(134.09, rel=1e-3)
    assert np.ptp(vertices[:, 2]) == pytest.approx(2.566, rel=1e-3)


def test_a_part_of_a_tube_ends_in_the_planes_of_its_box():
    """A vault of 40 degrees: its crown and its ends lie in planes to the last bit, rounding of the angles does not count."""
    part = {"lower": [0, 0, 19.151], "upper": [20, 25, 30]}
    keys = {"start": [0, 0, 0], "end": [0, 25, 0], "radius": 25, "points": [72, 6]}
    mesh = Surface(tube=keys | {"part": part}).mesh()
    assert len(mesh.quads) == 8 * 5
    assert np.count_nonzero(mesh.vertices[:, 0] == 0.0) == 6
    assert np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 2]) == pytest.approx(25.0, rel=1e-9)
    with pytest.raises(ValueError, match=r"no quadrilateral of the tube has all corners in `part`"):
        Surface(tube=keys | {"part": {"lower": [0, 0, 0], "upper": [1, 1, 1]}})
