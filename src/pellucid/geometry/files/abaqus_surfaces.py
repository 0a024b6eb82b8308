"""Surfaces that Abaqus' files name (*SURFACE), as sets of nodes; meshlane reads the sets that they refer to."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pellucid.geometry.files.contents import Block

FACES: dict[str, dict[str, tuple[int, ...]]] = {
    "tetra": {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)},
    "wedge": {"S1": (0, 1, 2), "S2": (3, 5, 4), "S3": (0, 3, 4, 1), "S4": (1, 4, 5, 2), "S5": (2, 5, 3, 0)},
    "hexahedron": {
        "S1": (0, 1, 2, 3),
        "S2": (4, 7, 6, 5),
        "S3": (0, 4, 5, 1),
        "S4": (1, 5, 6, 2),
        "S5": (2, 6, 7, 3),
        "S6": (3, 7, 4, 0),
    },
}
"""Corners of the faces of solid elements by Abaqus' names (Abaqus Analysis User's Guide, solid element library: C3D4, C3D6,
C3D8)."""
Lines = list[list[str]]


def abaqus_surfaces(
    path: str, blocks: Sequence[Block], cells: Mapping[str, Sequence[np.ndarray]], nodes: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Nodes of each surface of a file, by the names of their surfaces.

    cells: by name, the numbers of the elements of each block; nodes: those of each set of nodes. A surface with a line that
    refers to anything else, such as a number or a set unknown, is left out.
    """
    of_cells = {name.upper(): parts for name, parts in cells.items()}
    of_nodes = {name.upper(): np.asarray(numbers, np.int64) for name, numbers in nodes.items()}

    def nodes_of(line: list[str], is_of_nodes: bool) -> np.ndarray | None:
        """Those that a line of a surface names, None where it names none that are known."""
        what, face = line[0].upper(), (line[1].upper() if len(line) > 1 else "")
        if is_of_nodes:
            return of_nodes.get(what)
        if what not in of_cells or not any(face in faces for faces in FACES.values()):
            return None
        found = [np.zeros(0, np.int64)]
        for block, part in zip(blocks, of_cells[what], strict=True):
            if face in (faces := FACES.get(block.base or "", {})):
                found.append(block.nodes[part][:, faces[face]].ravel())
        return np.concatenate(found)

    surfaces = {}
    for name, is_of_nodes, lines in _surfaces(path):
        parts = [nodes_of(line, is_of_nodes) for line in lines]
        known = [part for part in parts if part is not None]
        if parts and len(known) == len(parts):
            surfaces[name] = np.unique(np.concatenate(known))
    return surfaces


def _surfaces(path: str) -> list[tuple[str, bool, Lines]]:
    """Name, whether of nodes, and the words of each line, of every surface of a file."""
    surfaces: list[tuple[str, bool, Lines]] = []
    inside = False
    for line in Path(path).read_text(encoding="utf-8", errors="replace").splitlines():
        words = [word.strip() for word in line.split(",")]
        if line.startswith("*") and not line.startswith("**"):
            keys = {key.strip().upper(): value.strip() for key, _, value in (word.partition("=") for word in words[1:])}
            inside = words[0].upper() == "*SURFACE" and "NAME" in keys
            if inside:
                surfaces.append((keys["NAME"], keys.get("TYPE", "ELEMENT").upper() == "NODE", []))
        elif inside and words[0] and not line.startswith("**"):
            surfaces[-1][2].append(words)
    return surfaces
