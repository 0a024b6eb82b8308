"""Surfaces that Abaqus' files name (*SURFACE), as sets of nodes; meshlane reads the sets that they refer to."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

FACES = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}
"""Corners of the faces of a tetrahedron by Abaqus' names (Abaqus Analysis User's Guide, solid element library, C3D4)."""
Lines = list[list[str]]


def abaqus_surfaces(
    path: str, cells: Mapping[str, np.ndarray], nodes: Mapping[str, Sequence[int] | np.ndarray]
) -> dict[str, np.ndarray]:
    """Nodes of each surface of a file, by the names of their surfaces.

    cells: corners of the tetrahedra of each set of elements, shape (k, 4); nodes: those of each set of nodes. A surface with a
    line that refers to anything else, such as a number or a set unknown, is left out.
    """
    of_cells = {name.upper(): corners for name, corners in cells.items()}
    of_nodes = {name.upper(): np.asarray(numbers, np.int64) for name, numbers in nodes.items()}
    found = {}
    for name, is_of_nodes, lines in _surfaces(path):
        parts = [_nodes_of(line, is_of_nodes, of_cells, of_nodes) for line in lines]
        known = [part for part in parts if part is not None]
        if parts and len(known) == len(parts):
            found[name] = np.unique(np.concatenate(known))
    return found


def _nodes_of(
    line: list[str], is_of_nodes: bool, cells: Mapping[str, np.ndarray], nodes: Mapping[str, np.ndarray]
) -> np.ndarray | None:
    """The nodes that a line of a surface names, None where it names none that are known."""
    what, face = line[0].upper(), (line[1].upper() if len(line) > 1 else "")
    if is_of_nodes:
        return nodes.get(what)
    return cells[what][:, FACES[face]].ravel() if what in cells and face in FACES else None


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
