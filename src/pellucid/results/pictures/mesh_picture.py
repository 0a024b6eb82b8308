"""The picture of a mesh: elements and edges, coloured by element quality, with faults marked."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.checks.quality import tetrahedron_qualities
from pellucid.geometry.checks.surface_checks import rims
from pellucid.geometry.mesh_survey import surface_qualities
from pellucid.geometry.meshes.cells import cut_in_two, outer_faces_of_cells
from pellucid.geometry.meshes.enclosure import spread
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.surface_mesh import Mesh as SurfaceMesh
from pellucid.geometry.meshes.triangulation import directed_edges
from pellucid.results.pictures.camera import Camera, View, camera_for, coloured, corner_words, scale_bar, show
from pellucid.results.pictures.drawables import Balls, Drawable, Mesh
from pellucid.results.pictures.render import render
from pellucid.results.pictures.style import SEQUENTIAL, Figure, colour_bar, house_style, new_figure

FRONT, BELOW = View(-50.0, 22.0), View(130.0, -22.0)
MOST_PIXELS = 1000  # of a view, along and across
PANEL, LOWEST = 4.6, 2.6  # width of a view and the most of its height, the least of its height [inch]
INK, RIM, BACK = (0.13, 0.13, 0.2), (0.84, 0.1, 0.1), (0.93, 0.55, 0.35)
FINEST = 5.0  # pixels of a mean side: of smaller elements no sides are drawn
AHEAD = 2e-3  # of the width of the picture, by which sides lie before their elements
STEP = 0.8  # pixels between the dots that make a side


def mesh_picture(mesh: SurfaceMesh | SimplexMesh, metres: float, title: str) -> Figure:
    """Return a figure with two views of a mesh: a surface from both sides; a solid as a whole, and with the half towards the
    viewer removed.

    metres: size of the mesh's length unit [m]. Elements are coloured by their quality (1 regular, 0 degenerate). Edges of a
    surface with only one element are red. Elements of a surface that are seen from the side opposite to their normals are
    orange.
    """
    is_solid = isinstance(mesh, SimplexMesh)
    views = [_whole(mesh), _opened(mesh)] if isinstance(mesh, SimplexMesh) else [_surface(mesh)] * 2
    words = ("from the front", "cut open") if is_solid else ("from the front and above", "from behind and below")
    places = metres * views[0].vertices
    cameras = [_camera(view, places) for view in ((FRONT, FRONT) if is_solid else (FRONT, BELOW))]
    tallest = max(camera.shape[0] / camera.shape[1] for camera in cameras)
    with house_style():
        height = max(PANEL * min(tallest, 1.4), LOWEST)
        figure = new_figure(2.0 * PANEL + 1.0, height + 0.4, layout="compressed")
        for axes, camera, shown, word in zip(figure.subplots(1, 2), cameras, views, words, strict=True):
            drawn = _drawables(shown._replace(vertices=places), camera, both_sides=not is_solid)
            show(axes, render(drawn, camera), camera)
            scale_bar(axes, camera)
            corner_words(axes, "", word)
        colour_bar(figure, "element quality (1 regular, 0 degenerate)", (0.0, 1.0, "neither"), SEQUENTIAL)
        marks = [] if is_solid else ["orange: inner side"]
        figure.suptitle(" · ".join([title, *["red: boundary edges (one element)"] * bool(len(views[0].rim)), *marks]))
    return figure


class _Shown(NamedTuple):
    """The part of a mesh that one view of `mesh_picture` draws."""

    vertices: np.ndarray  # (n, 3) positions
    triangles: np.ndarray  # (m, 3) vertex numbers
    quality: np.ndarray  # (m,) quality of the element of each triangle, from 0 (degenerate) to 1 (regular)
    sides: np.ndarray  # (k, 2) vertex numbers of the element edges
    rim: np.ndarray  # (r, 2) vertex numbers of the boundary edges


def _surface(mesh: SurfaceMesh) -> _Shown:
    quality, n = surface_qualities(mesh), len(mesh.quads)
    rim = [pair for ring in rims(mesh) for pair in zip(ring, ring[1:] + ring[:1], strict=True)]
    return _Shown(
        mesh.vertices,
        np.concatenate([cut_in_two(mesh.quads), mesh.triangles]),
        np.concatenate([np.repeat(quality[:n], 2), quality[n:]]),
        np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)]),
        np.array(rim, int).reshape(-1, 2),
    )


def _whole(mesh: SimplexMesh) -> _Shown:
    triangles, owner = outer_faces_of_cells(mesh.cells)
    quality = tetrahedron_qualities(mesh.nodes, mesh.cells[owner])
    return _Shown(mesh.nodes, triangles, quality, directed_edges(triangles), np.zeros((0, 2), int))


def _opened(mesh: SimplexMesh) -> _Shown:
    """Return the half of a mesh of tetrahedra that is far from the viewer, i.e. the tetrahedra whose centroid has a y
    coordinate in the upper half of the mesh."""
    depth = mesh.nodes[mesh.cells].mean(axis=1)[:, 1]
    behind = depth >= 0.5 * (mesh.nodes[:, 1].min() + mesh.nodes[:, 1].max())
    return _whole(SimplexMesh(mesh.nodes, mesh.cells[behind]))


def _camera(view: View, places: np.ndarray) -> Camera:
    rows, columns = camera_for(view, places, MOST_PIXELS, margin=0.06).shape
    return camera_for(view, places, max(int(MOST_PIXELS * min(columns / rows, 1.0)), 1), margin=0.06)


def _drawables(shown: _Shown, camera: Camera, both_sides: bool) -> list[Drawable]:
    vertices, triangles, quality, sides, rim = shown
    eye = camera.axes[2]
    places = vertices[triangles]
    away = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]) @ eye < 0.0
    colours = coloured(quality, (0.0, 1.0), SEQUENTIAL)
    colours = 0.25 + 0.75 * colours  # paler, so that sides stand out
    if both_sides:
        colours[away] = BACK
    flat = np.arange(triangles.size).reshape(-1, 3)  # corners of their own: plane elements, each of one colour
    drawn: list[Drawable] = [Mesh(places.reshape(-1, 3), flat, np.repeat(colours, 3, axis=0), np.zeros(triangles.size, bool))]
    ahead = AHEAD * float((camera.high - camera.low)[0]) * eye
    sides = np.unique(np.sort(sides, axis=1), axis=0)
    lengths = np.linalg.norm(vertices[sides[:, 0]] - vertices[sides[:, 1]], axis=1) * camera.scale
    if len(lengths) and lengths.mean() >= FINEST:
        drawn.append(_dots(vertices + ahead, sides, camera, INK, 0.75))
    if len(rim):
        drawn.append(_dots(vertices + 2.0 * ahead, rim, camera, RIM, 2.0))
    return drawn


def _dots(vertices: np.ndarray, sides: np.ndarray, camera: Camera, colour: tuple[float, float, float], radius: float) -> Balls:
    """Build lines along edges as rows of small balls. vertices: [m], shape (n, 3). sides: pairs of vertices, shape (k, 2).
    radius: radius of the balls in pixels."""
    start, end = vertices[sides[:, 0]], vertices[sides[:, 1]]
    counts = np.maximum((np.linalg.norm(end - start, axis=1) * camera.scale / STEP).astype(int), 1) + 1
    which, step = spread(counts)
    share = step / (counts[which] - 1)
    centres = start[which] + share[:, None] * (end - start)[which]
    return Balls(centres, np.full(len(centres), radius / camera.scale), np.tile(colour, (len(centres), 1)), lit=False)
