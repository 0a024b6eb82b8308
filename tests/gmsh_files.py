"""Gmsh files of a cube of five tetrahedra with named faces, in several versions of the format."""

import struct

NODES = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
TETRAHEDRA = [(1, 2, 4, 5), (2, 3, 4, 7), (2, 5, 6, 7), (4, 5, 7, 8), (2, 4, 5, 7)]
ENTITIES = {(0, 1): [(1,)], (2, 1): [(1, 2, 4), (2, 3, 4)], (2, 2): [(5, 6, 7), (5, 7, 8)], (3, 1): TETRAHEDRA}
"""Elements of the entities of the geometry, by dimension and number."""
GROUPS = {(2, 1): [7], (3, 1): [3, 4]}
"""Numbers of the physical groups of entities: one face, and a body in two groups; others, as of `Mesh.SaveAll`, in none."""
NAMES = {(2, 7): "Fixed face", (3, 3): "body", (3, 4): "all of it", (1, 5): "no curve"}
KINDS = {1: 15, 3: 2, 4: 4}
NODE_DATA = b'$NodeData\n1\n"u"\n1\n0.0\n3\n0\n1\n2\n1 0.5\n2 0.5\n$EndNodeData\n'
TAGS = [10 * k + 3 for k in range(8)]


class Writer:
    """Writer that collects the bytes of a file, with numbers as text or binary."""

    def __init__(self, binary, order):
        self.binary, self.order, self.parts = binary, order, []

    def put(self, kind, *values, end="\n"):
        """Write integers ("i"), sizes ("Q") or floats ("d")."""
        if self.binary:
            self.parts.append(struct.pack(f"{self.order}{len(values)}{kind}", *values))
        else:
            self.parts.append((" ".join(map(repr, values)) + end).encode())

    def line(self, text):
        """Write a line of text."""
        self.parts.append(f"{text}\n".encode())

    def close(self, name):
        """Write the end of a section."""
        self.parts.append(b"\n" * self.binary + f"$End{name}\n".encode())


def gmsh_file(version, binary=False, order="<", parametric=False):
    """Return the bytes of a Gmsh file of version "2.2", "4.0" or "4.1"; order: byte order; parametric: True to write nodes
    with parametric coordinates."""
    w = Writer(binary, order)
    w.line(f"$MeshFormat\n{version} {int(binary)} 8")
    if binary:
        w.put("i", 1)
    w.close("MeshFormat")
    w.line(f"$PhysicalNames\n{len(NAMES)}")
    for (dimension, number), name in NAMES.items():
        w.line(f'{dimension} {number} "{name}"')
    w.line("$EndPhysicalNames")
    (_old if version == "2.2" else _new)(w, version, parametric)
    return b"".join(w.parts) + (b"" if binary else NODE_DATA)


def _old(w, version, parametric):
    name = "ParametricNodes" if parametric else "Nodes"
    w.line(f"${name}\n{len(NODES)}")
    for k, (tag, place) in enumerate(zip(TAGS, NODES, strict=True)):
        w.put("i", tag, end=" ")
        w.put("d", *map(float, place), end=" " if parametric else "\n")
        if parametric:
            w.put("i", k % 4, 1, end=" " if k % 4 in (1, 2) else "\n")
            if k % 4 in (1, 2):
                w.put("d", *[0.25] * (k % 4))
    w.close(name)
    rows = [
        (KINDS[len(nodes)], group, entity, nodes)
        for (dimension, entity), elements in ENTITIES.items()
        for group in GROUPS.get((dimension, entity), [0])
        for nodes in elements
    ]
    w.line(f"$Elements\n{len(rows)}")
    for number, (kind, group, entity, nodes) in enumerate(rows, 1):
        tags = [TAGS[node - 1] for node in nodes]
        if w.binary:
            w.put("i", kind, 1, 2, number, group, entity, *tags)
        else:
            w.put("i", number, kind, 2, group, entity, *tags)
    w.close("Elements")


def _new(w, version, parametric):
    is_41 = version == "4.1"
    w.line("$Entities")
    w.put("Q", *(sum(1 for place in ENTITIES if place[0] == dimension) for dimension in range(4)))
    for dimension, number in ENTITIES:
        groups = GROUPS.get((dimension, number), [])
        w.put("i", number, end=" ")
        w.put("d", *[0.0] * (3 if is_41 and dimension == 0 else 6), end=" ")
        w.put("Q", len(groups), end=" ")
        w.put("i", *groups, end=" ")
        if dimension:
            w.put("Q", 1)
            w.put("i", 1)
        else:
            w.line("") if not w.binary else None
    w.close("Entities")
    w.line("$Nodes")
    w.put("Q", *([2, 8, TAGS[0], TAGS[-1]] if is_41 else [2, 8]))
    for dimension, which in ((2, range(3)), (3, range(3, 8))):
        extra = [0.5] * (dimension if parametric else 0)
        w.put("i", *([dimension, 1] if is_41 else [1, dimension]), int(parametric), end=" ")
        w.put("Q", len(which))
        if is_41:
            w.put("Q", *(TAGS[k] for k in which))
        for k in which:
            if not is_41:
                w.put("i", TAGS[k], end=" ")
            w.put("d", *map(float, NODES[k]), *extra)
    w.close("Nodes")
    w.line("$Elements")
    n = sum(map(len, ENTITIES.values()))
    w.put("Q", *([len(ENTITIES), n, 1, n] if is_41 else [len(ENTITIES), n]))
    number = 0
    for (dimension, entity), elements in ENTITIES.items():
        w.put("i", *([dimension, entity] if is_41 else [entity, dimension]), KINDS[len(elements[0])], end=" ")
        w.put("Q", len(elements))
        for nodes in elements:
            number += 1
            w.put("Q" if is_41 else "i", number, *(TAGS[node - 1] for node in nodes))
    w.close("Elements")
