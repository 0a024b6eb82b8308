"""Named sets of meshes read by meshlane: sets of the file, element groups, and sets marked by arrays."""

from typing import Any

import numpy as np

GMSH = "gmsh:physical"
GROUPS = {GMSH, "nastran:ref", "medit:ref"}
"""Arrays with the group number of each cell: in Gmsh files, Nastran properties, Medit references; 0 means no group."""
OF_THE_READER = "gmsh:"
"""Prefix of names that meshlane adds and that are not sets."""


def sets_of_nodes(mesh: Any) -> dict[str, np.ndarray]:
    """Return the node numbers of each node set, by name, from a mesh object of meshlane."""
    sets = {name: np.unique(np.asarray(nodes, np.int64)) for name, nodes in (mesh.point_sets or {}).items()}
    for name, values in (mesh.point_data or {}).items():
        if (marked := marked_places(values)) is not None:
            sets.setdefault(name, marked)
    return sets


def sets_of_cells(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Return for each set its name and, for each block of elements, the indices of the elements of the block that belong to the
    set, from a mesh object of meshlane."""
    found = _groups(mesh)
    for name, parts in (mesh.cell_sets or {}).items():
        if not name.startswith(OF_THE_READER):
            found[name] = [np.asarray([] if part is None else part, np.int64) for part in parts]
    for name, blocks in (mesh.cell_data or {}).items():
        if name not in GROUPS and (marked := marked_places(np.concatenate(blocks))) is not None:
            ends = np.cumsum([len(block) for block in blocks])
            parts = np.split(marked, np.searchsorted(marked, ends[:-1]))
            found.setdefault(name, [part - start for part, start in zip(parts, [0, *ends[:-1]], strict=True)])
    return found


def _groups(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Return the numbered element groups by name, or else by number: for each block of elements, the indices of the elements of
    the block that belong to the group. mesh: mesh object of meshlane."""
    data = mesh.cell_data or {}
    named = (mesh.field_data or {}) if GMSH in data else {}
    names = {(int(number), int(dimension)): name for name, (number, dimension) in named.items()}
    none = [np.zeros(0, np.int64) for _ in mesh.cells]
    found = {name: list(none) for name in names.values()}
    for key in sorted(GROUPS & data.keys()):
        for place, (block, numbers) in enumerate(zip(mesh.cells, data[key], strict=True)):
            for number in np.unique(np.asarray(numbers, np.int64)):
                if number:
                    name = names.get((int(number), block.dim), str(number))
                    found.setdefault(name, list(none))[place] = np.flatnonzero(np.asarray(numbers) == number)
    return found


def marked_places(values: np.ndarray) -> np.ndarray | None:
    """Return the indices at which an integer array that marks a set by 0 and 1, or by -1 and 0, has the larger value; None
    for any other array."""
    values = np.asarray(values)
    if values.ndim != 1 or values.dtype.kind not in "biu":
        return None
    least, most = (int(values.min()), int(values.max())) if len(values) else (0, 0)
    return np.flatnonzero(values == most) if (least, most) in ((0, 1), (-1, 0)) else None
