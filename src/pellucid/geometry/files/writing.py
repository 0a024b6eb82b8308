"""Writing of surfaces and solids to files: STL, OBJ and PLY directly, other formats through meshlane."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.system.extras import install_command

BY_MESHLANE = {".msh": "gmsh22", ".vtk": "vtk", ".vtu": "vtu", ".inp": "abaqus"}
"""meshlane's names of formats that can store tetrahedra with sets, and surfaces."""
SURFACE_ENDINGS = (".stl", ".obj", ".ply", *BY_MESHLANE)
SOLID_ENDINGS = tuple(BY_MESHLANE)


def check_ending(name: str, is_solid: bool) -> None:
    """Raise Refusal if the format that the ending of a file name selects cannot store a solid (if `is_solid`) or a surface
    (otherwise)."""
    endings = SOLID_ENDINGS if is_solid else SURFACE_ENDINGS
    if (ending := Path(name).suffix.lower()) not in endings:
        what = "a solid" if is_solid else "a surface"
        text = f"{what} cannot be written to a file with {f'the ending {ending}' if ending else 'no ending'}"
        raise Refusal(text, f"use one of {', '.join(endings)}")
    if ending in BY_MESHLANE and find_spec("meshlane") is None:
        remedy = install_command("mesh")
        text = f"the package meshlane, which is needed to write {ending} files, is not installed"
        raise Refusal(text, remedy if is_solid else f"{remedy}, or use .stl, .obj or .ply")


def write_surface(path: Path, ending: str, vertices: np.ndarray, quads: np.ndarray, triangles: np.ndarray) -> None:
    """Write a surface to a file in the format of an ending such as ".stl"; in the STL format, quadrilaterals are divided
    into triangles. vertices: shape (n, 3); quads, triangles: vertex numbers."""
    if ending in BY_MESHLANE:
        _through_meshlane(path, ending, vertices, [("quad", quads), ("triangle", triangles)], {})
        return
    elements = [*quads.tolist(), *triangles.tolist()]
    if ending == ".stl":
        places = vertices[np.concatenate([cut_in_two(quads), triangles])]
        normals = np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
        facets = zip(normals.tolist(), places.tolist(), strict=True)
        lines = ["solid mesh", *(_facet(normal, corners) for normal, corners in facets), "endsolid mesh"]
    elif ending == ".obj":
        lines = [f"v {_words(place)}" for place in vertices.tolist()]
        lines += ["f " + " ".join(str(corner + 1) for corner in corners) for corners in elements]
    else:
        lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property double {axis}" for axis in "xyz")]
        lines += [f"element face {len(elements)}", "property list uchar int vertex_indices", "end_header"]
        lines += [*map(_words, vertices.tolist()), *(" ".join(map(str, [len(corners), *corners])) for corners in elements)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def write_solid(path: Path, ending: str, nodes: np.ndarray, cells: np.ndarray, sets: Mapping[str, np.ndarray]) -> None:
    """Write tetrahedra (cells, shape (c, 4)) with their node sets to a file in the format of an ending such as ".msh". The
    sets become physical groups of points in Gmsh files, and arrays of 0 and 1 in VTK files.

    Names of arrays in VTK files have underscores instead of spaces.
    """
    _through_meshlane(path, ending, nodes, [("tetra", cells)], sets)


def _through_meshlane(
    path: Path, ending: str, points: np.ndarray, cells: list[tuple[str, np.ndarray]], sets: Mapping[str, np.ndarray]
) -> None:
    import meshlane

    blocks = [block for block in cells if len(block[1])]
    if ending == ".inp":
        meshlane.write(str(path), meshlane.Mesh(points, blocks, point_sets=dict(sets)), file_format=BY_MESHLANE[ending])
        return
    if ending != ".msh":
        marks = {"_".join(name.split()): np.isin(np.arange(len(points)), nodes).astype(int) for name, nodes in sets.items()}
        meshlane.write(str(path), meshlane.Mesh(points, blocks, point_data=marks), file_format=BY_MESHLANE[ending])
        return
    numbers = [np.zeros(len(block[1]), np.int64) for block in blocks]
    for number, nodes in enumerate(sets.values(), 1):
        blocks.append(("vertex", np.asarray(nodes).reshape(-1, 1)))
        numbers.append(np.full(len(nodes), number))
    names = {name: np.array([number, 0]) for number, name in enumerate(sets, 1)}
    groups = {"gmsh:physical": numbers, "gmsh:geometrical": [np.ones(len(group), np.int64) for group in numbers]}
    mesh = meshlane.Mesh(points, blocks, cell_data=groups, field_data=names)
    meshlane.write(str(path), mesh, file_format=BY_MESHLANE[ending], binary=False)


def _facet(normal: list[float], corners: list[list[float]]) -> str:
    places = "\n".join(f"  vertex {_words(place)}" for place in corners)
    return f" facet normal {_words(normal)}\n outer loop\n{places}\n endloop\n endfacet"


def _words(place: list[float]) -> str:
    return " ".join(map(repr, place))
