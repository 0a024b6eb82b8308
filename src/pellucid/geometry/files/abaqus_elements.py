"""Abaqus element types and face names (Abaqus Analysis User's Guide, element library)."""

import re

_SOLIDS = {4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron", 10: "tetra10", 13: "pyramid13", 15: "wedge15"}
_SOLIDS |= {20: "hexahedron20", 27: "hexahedron27"}
_FLAT = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
_LINES = {2: "line", 3: "line3"}
_TYPES: tuple[tuple[re.Pattern[str], dict[int, str]], ...] = tuple(
    (re.compile(pattern), kinds)
    for pattern, kinds in (
        (r"(?:D?C|AC|DCC|EMC|Q|GK|COH)3D(\d+)[A-Z]*\d?[A-Z]*", _SOLIDS),
        (r"SC(\d)[A-Z]*", _SOLIDS),
        (r"CSS(\d)[A-Z]*", _SOLIDS),
        (r"(?:SF)?M3D(\d)[A-Z]*", _FLAT),
        (r"[RF]3D([34])", _FLAT),
        (r"D?STRI(3)", _FLAT),
        (r"STRI(6)5", _FLAT),
        (r"D?S([34689])[A-Z]*\d?[A-Z]*", _FLAT),
        (r"(?:C|DC|AC|DCC|Q)(?:PS|PE|PEG|AX|GAX|AXA|2D)(\d+)[A-Z]*\d*", _FLAT),
        (r"(?:T|DC|AC|R)[123]D([23])[A-Z]*", _LINES),
        (r"B[23]([12])[A-Z]*\d*", {1: "line", 2: "line3"}),
        (r"(B)33H?", {2: "line"}),
    )
)
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
    "triangle": {f"{side}{k + 1}": (k, (k + 1) % 3) for side in "SE" for k in range(3)},
    "quad": {f"{side}{k + 1}": (k, (k + 1) % 4) for side in "SE" for k in range(4)},
}
"""Corners of the faces of solid elements, and of the edges of flat ones, by Abaqus' names (C3D4, C3D6, C3D8, S3, CPS4)."""


def kind_of(type_name: str) -> str | None:
    """Return the element kind of this package, such as "tetra10", for the name of an Abaqus element type; None for types
    that are not mesh elements, such as springs."""
    name = type_name.strip().upper()
    for pattern, kinds in _TYPES:
        if found := pattern.fullmatch(name):
            return kinds.get(2 if found[1] == "B" else int(found[1]))
    return None
