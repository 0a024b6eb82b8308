"""Report on a mesh file: element counts, size, element quality, closedness, and faults."""

import re
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from pellucid.geometry.checks import Fault
from pellucid.geometry.checks.quality import dihedral_angles, quad_qualities, tetrahedron_qualities, triangle_qualities
from pellucid.geometry.checks.solid_checks import apart, solid_faults
from pellucid.geometry.checks.surface_checks import mesh_faults, rims
from pellucid.geometry.files.contents import Contents, counted, first_order
from pellucid.geometry.files.read import ANY, read_file
from pellucid.geometry.meshes.cells import outer_faces
from pellucid.geometry.meshes.crossing import self_crossing
from pellucid.geometry.meshes.enclosure import enclosed_volume
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import directed_edges, pieces
from pellucid.geometry.solid_meshes.file import SOLID, solid_of
from pellucid.geometry.surfaces.file import mended, surface_of

MOST_CROSSED = 300_000  # triangles: self-intersections of larger surfaces are not searched for, which would take over 30 s
METRES, MILLIMETRES = 3.0, 1000.0
"""Largest extents that are probably in metres and in millimetres: typical models are organs, cells and airbags."""
HEAD = 2000
"""Number of bytes at the start of a file in which a unit of length is searched."""
SAID = re.compile(rb"unit[s]?\s*[=:]?\s*\(?(mm|cm|dm|um|nm|m|inch|in)\b", re.IGNORECASE)


@dataclass(frozen=True)
class Survey:
    """Report on a mesh: the mesh in the unit of its file, rows of a table that describe it, notes for the user on changes by a
    repair, and the faults that remain."""

    mesh: Mesh | SimplexMesh
    rows: list[tuple[str, str]]  # name and value of each row of the table, as text
    notes: list[str]
    faults: list[Fault]  # text and remedy of each fault


def survey(path: str, repair: bool, close_holes: int, metres: float) -> Survey:
    """Return a report on a mesh file. A file with solid elements is treated as a solid, any other file as a surface.

    repair: True to repair the mesh first. close_holes: largest number of edges of a hole that the repair closes. metres:
    unit of length of the file [m]. Raises Refusal if the file cannot be read.
    """
    contents = read_file(path, "a mesh", ANY)
    raw, contents = contents, first_order(contents)
    sets = [f"`{name}` ({len(nodes)} nodes)" for name, nodes in contents.node_sets.items()]
    sets += [f"`{name}` ({sum(map(len, parts))} elements)" for name, parts in contents.cell_sets.items()]
    rows = [("format", contents.format), ("elements", _elements(raw)), ("sets", ", ".join(sets) or "none")]
    found: Mesh | SimplexMesh
    if any(block.kind in SOLID and len(block.nodes) for block in contents.blocks):
        found, notes = solid_of(path, contents, repair)
        in_metres = SimplexMesh(metres * found.nodes, found.cells, found.sets)
        nodes, corners = in_metres.nodes, [in_metres.cells]
        about, faults = _about_solid(in_metres), list(solid_faults(in_metres))
    else:
        found, _, notes = surface_of(path, contents)
        if repair:
            found, done = mended(path, found, close_holes)
            notes += done
        scaled = found._replace(vertices=metres * found.vertices)
        nodes, corners = scaled.vertices, [scaled.quads, scaled.triangles]
        about, faults = _about_surface(scaled)
    of_file = "" if len(nodes) == len(contents.points) else f", of {len(contents.points)} points of the file"
    rows += [("nodes", f"{len(nodes)}{of_file}"), *_size(path, nodes, metres), *_edges(nodes, corners), *about]
    return Survey(found, rows, [*contents.notes, *notes], faults)


def _elements(contents: Contents) -> str:
    found: dict[str, int] = {}
    for block in contents.blocks:
        found[block.kind] = found.get(block.kind, 0) + len(block.nodes)
    named = []
    for kind, n in found.items():
        base = next(block.base for block in contents.blocks if block.kind == kind)
        named.append(f"{n} of type {kind}" if base is None else counted(n, base) + (f" ({kind})" if kind != base else ""))
    return ", ".join(named) or "none"


def _size(path: str, nodes: np.ndarray, metres: float) -> list[tuple[str, str]]:
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    extent = " x ".join(f"{x:.5g}" for x in high - low)
    text = f"{extent} m, from {_at(low)} to {_at(high)} m"
    said = SAID.search(Path(path).read_bytes()[:HEAD])
    if metres != 1.0:
        return [("extent", text), ("unit", f"{metres:g} m (as given)")]
    if said:
        name = said[1].decode().lower()
        return [("extent", text), ("unit", f'the file defines {name}: set `unit = "{name}"` with its `path` in a case')]
    return [("extent", f"{text}, if the unit is a metre"), ("unit", _guess(float((high - low).max())))]


def _guess(largest: float) -> str:
    """Return a text for the user on the probable unit of a mesh whose largest extent, in the unit of its file, is `largest`."""
    if largest < METRES:
        return f"the file does not define its unit; metres are assumed, as an extent below {METRES:g} is usually in metres"
    unit, other = ("mm", "um") if largest < MILLIMETRES else ("um", "mm")
    text = f"the file does not define its unit; an extent of {largest:.3g} is probably in {unit} or {other}, not in metres"
    return f'{text}: set `unit = "{unit}"` next to `path` in a case, or `--unit {unit}` for this command'


def _edges(nodes: np.ndarray, corners: list[np.ndarray]) -> list[tuple[str, str]]:
    """Return the row "edges" of the table: shortest, mean and longest edge length and the position of the shortest edge.
    corners: node numbers of the elements of each kind."""
    solid = len(corners) == 1
    pairs = [elements[:, pair] for elements in corners for pair in combinations(range(4), 2)] if solid else []
    edges = np.concatenate(pairs or [directed_edges(elements) for elements in corners])
    codes = np.unique(edges.min(axis=1) * len(nodes) + edges.max(axis=1))
    edges = np.stack([codes // len(nodes), codes % len(nodes)], axis=1)
    length = np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1)
    at = int(length.argmin())
    text = f"shortest {length[at]:.4g} m, near {_at(nodes[edges[at]].mean(axis=0))} m; mean {length.mean():.4g} m,"
    return [("edges", f"{text} longest {length.max():.4g} m")]


def _about_solid(mesh: SimplexMesh) -> list[tuple[str, str]]:
    quality, angles = tetrahedron_qualities(mesh.nodes, mesh.cells), dihedral_angles(mesh.nodes, mesh.cells)
    rows = [("quality", _worst(quality, mesh.nodes[mesh.cells].mean(axis=1), "tetrahedra"))]
    rows.append(("angles", f"{angles.min():.3g} to {angles.max():.3g} degrees between faces"))
    rows.append(("volume", f"{mesh.volumes.sum():.6g} m^3"))
    rows.append(("surface", f"{len(outer_faces(mesh.cells))} triangles"))
    return [*rows, ("pieces", apart(mesh) or "1")]


def _about_surface(mesh: Mesh) -> tuple[list[tuple[str, str]], list[Fault]]:
    quality = surface_qualities(mesh)
    rows = [("quality", _worst(quality, mesh.centres(), "elements"))]
    vertices, triangles = mesh.triangulated()
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    rows.append(("area", f"{0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum():.6g} m^2"))
    edges = np.concatenate([directed_edges(mesh.quads), directed_edges(mesh.triangles)])
    label = pieces(edges, len(vertices))[edges[:, 0]]
    rows.append(("pieces", str(len(np.unique(label)))))
    holes = rims(mesh)
    faults = list(mesh_faults(mesh, closed=not holes))
    if holes:
        sizes = sorted(map(len, holes))
        named = ", ".join(map(str, sizes[:8])) + (", ..." if len(sizes) > 8 else "")
        where = _at(vertices[min(holes, key=len)].mean(axis=0))
        many = "1 rim or hole" if len(holes) == 1 else f"{len(holes)} rims or holes"
        rows.append(("closed", f"no: {many} with {named} edges; the smallest is near {where} m"))
    elif faults:
        rows.append(("closed", "unknown until the faults are repaired"))
    else:
        rows += [("closed", "yes"), ("volume", f"{enclosed_volume(vertices, triangles):.6g} m^3")]
    if not faults:
        rows.append(("orientation", "consistent" + ("" if holes else ", normals outward")))
        if len(triangles) > MOST_CROSSED:
            rows.append(("crossings", f"not checked (more than {MOST_CROSSED} triangles)"))
            return rows, faults
        has_layers = len(np.unique(vertices, axis=0)) < len(vertices)
        if (crossed := self_crossing(mesh.triangulated(), in_plane=not has_layers)) is not None:
            faults.append(
                (
                    f"the surface intersects itself near {_at(crossed)} m",
                    "repair the surface at this point, or remove one of the overlapping pieces",
                )
            )
    return rows, faults


def surface_qualities(mesh: Mesh) -> np.ndarray:
    """Return the quality of the elements of a surface (see `pellucid.geometry.checks.quality`), from 0 (flat) to 1
    (regular), shape (q + t,): quadrilaterals, then triangles."""
    return np.concatenate([quad_qualities(mesh.vertices, mesh.quads), triangle_qualities(mesh.vertices, mesh.triangles)])


def _worst(quality: np.ndarray, centres: np.ndarray, what: str) -> str:
    at = int(quality.argmin())
    text = f"lowest {quality[at]:.3g}, near {_at(centres[at])} m; mean {quality.mean():.3g}"
    return f"{text}; {np.count_nonzero(quality < 0.1)} of {len(quality)} {what} below 0.1 (1: regular, 0: flat)"


def _at(place: np.ndarray) -> str:
    return f"({', '.join(f'{x:.4g}' for x in place)})"
