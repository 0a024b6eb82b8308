"""Reader of Abaqus input files (also CalculiX): nodes, elements, parts and instances, sets and surfaces.

Source: Abaqus Keywords Reference Guide; element types and faces: Abaqus Analysis User's Guide, element library."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pellucid.geometry.files.abaqus_keywords import Keyword, keywords
from pellucid.geometry.files.contents import Block, Contents, Damaged, floats, integers, nodes_of_kind, with_points

_SIDES = ("SPOS", "SNEG")
_GENERATORS = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYMMETRIC MODEL GENERATION", "SUBSTRUCTURE GENERATE"}
_NONE = np.zeros(0, np.int64)


class _Nodes(NamedTuple):
    """Nodes that one *NODE keyword defines: labels, shape (n,), coordinates, shape (n, 3), and the keyword itself."""

    labels: np.ndarray
    places: np.ndarray
    keyword: Keyword


@dataclass
class _Scope:
    """A scope with its own labels of nodes, elements and sets: the file, a part, or an instance of a part."""

    nodes: list[_Nodes] = field(default_factory=list)
    elements: list[tuple[str, np.ndarray]] = field(
        default_factory=list
    )  # kind of elements; for each element its label and the labels of its nodes
    sets: dict[tuple[str, str], list[tuple[str, str, list[list[str]], bool]]] = field(default_factory=dict)
    """Sets by ("N" or "E", name in capitals): name as written, instance, data lines, True if these are ranges."""
    surfaces: list[tuple[str, bool, list[list[str]]]] = field(default_factory=list)  # name, True if of nodes, data lines
    node_labels: np.ndarray = field(default_factory=lambda: _NONE)  # ascending, in the order of `node_numbers`
    node_numbers: np.ndarray = field(default_factory=lambda: _NONE)  # index in the whole mesh of each node
    element_labels: np.ndarray = field(default_factory=lambda: _NONE)  # ascending, in the order of `element_numbers`
    element_numbers: np.ndarray = field(default_factory=lambda: _NONE)  # index in the whole mesh of each element


def read_abaqus(path: str) -> Contents:
    """Return the mesh in an Abaqus input file and the files that it includes. Raises Damaged if they do not follow the
    format."""
    return _Model(keywords(path)).contents()


class _Model:
    """Collects the definitions of all keywords of an Abaqus file, and builds the mesh from them."""

    def __init__(self, found: list[Keyword]) -> None:
        self._file, self._parts, self._instances = _Scope(), dict[str, _Scope](), dict[str, _Scope]()
        self._left_out: dict[str, None] = {}  # types, in order
        self._notes: list[str] = []
        self._placed: set[str] = set()
        self._rotation, self._origin = np.eye(3), np.zeros(3)
        scope = self._file
        for keyword in found:
            name, parameters = keyword.name, keyword.parameters
            if name in _GENERATORS:
                raise Damaged(f"*{name} in {keyword.where} generates nodes or elements, which is not supported: list them all")
            if name == "PART":
                scope = self._parts.setdefault(parameters.get("NAME", "").upper(), _Scope())
            elif name == "INSTANCE":
                part = parameters.get("PART", "").upper()
                if part and part not in self._parts:
                    raise Damaged(f"*INSTANCE in {keyword.where} refers to a part that the file does not define")
                self._placed.add(part)
                scope = self._instances[parameters.get("NAME", "").upper()] = _moved(self._parts.get(part, _Scope()), keyword)
            elif name in ("END PART", "END INSTANCE", "ASSEMBLY", "END ASSEMBLY"):
                scope = self._file
            else:
                self._read(keyword, scope)

    def _read(self, keyword: Keyword, scope: _Scope) -> None:
        name, parameters = keyword.name, keyword.parameters
        if name == "SYSTEM":
            self._rotation, self._origin = _system(keyword)
        elif name == "NODE":
            labels, places = _nodes(keyword)
            scope.nodes.append(_Nodes(labels, places @ self._rotation + self._origin, keyword))
            self._define(scope, "N", parameters.get("NSET"), labels)
        elif name == "ELEMENT":
            self._read_elements(keyword, scope)
        elif name in ("NSET", "ELSET") and (set_name := parameters.get(name)):
            rows = [[word for word in words if word] for words in keyword.words()]
            if name == "NSET" and "ELSET" in parameters:
                rows = [[f"<{parameters['ELSET']}"]]
            entry = (set_name, parameters.get("INSTANCE", "").upper(), rows, "GENERATE" in parameters)
            scope.sets.setdefault((name[0], set_name.upper()), []).append(entry)
        elif name == "SURFACE" and "NAME" in parameters:
            rows = [words for words in keyword.words() if words[0]]
            scope.surfaces.append((parameters["NAME"], parameters.get("TYPE", "").upper() == "NODE", rows))

    def _read_elements(self, keyword: Keyword, scope: _Scope) -> None:
        kind = kind_of(keyword.parameters.get("TYPE", ""))
        if kind is None:
            self._left_out[keyword.parameters.get("TYPE", "no name")[:20]] = None
            return
        rows = _rows(keyword, 1 + nodes_of_kind(kind))
        scope.elements.append((kind, rows))
        self._define(scope, "E", keyword.parameters.get("ELSET"), rows[:, 0])

    @staticmethod
    def _define(scope: _Scope, what: str, name: str | None, labels: np.ndarray) -> None:
        if name:
            entry = (name, "", [list(map(str, labels.tolist()))], False)
            scope.sets.setdefault((what, name.upper()), []).append(entry)

    def contents(self) -> Contents:
        """Number nodes and elements of all parts and instances consecutively, resolve sets and surfaces, and return the
        mesh."""
        scopes = {"": self._file, **self._instances}
        scopes |= {part: scope for part, scope in self._parts.items() if part not in self._placed and part not in scopes}
        points, rows = [np.zeros((0, 3))], dict[str, list[np.ndarray]]()
        n = 0
        for scope in scopes.values():
            labels = np.concatenate([_NONE, *(some.labels for some in scope.nodes)])
            places = np.concatenate([np.zeros((0, 3)), *(some.places for some in scope.nodes)])
            first, which = np.unique(labels, return_index=True, return_inverse=True)[1:]
            moved = np.flatnonzero((places != places[first[which.reshape(-1)]]).any(axis=1))
            if len(moved):
                raise _defined_twice(scope, labels, int(moved[0]))
            first = np.sort(first)
            order = np.argsort(labels[first], kind="stable")
            scope.node_labels, scope.node_numbers = labels[first][order], n + order
            points.append(places[first])
            n += len(first)
        for scope in scopes.values():
            for kind, table in scope.elements:
                known = scope if len(scope.node_labels) else self._file
                rows.setdefault(kind, []).append(_numbers(known, table, kind))
        self._blocks = tuple(Block(kind, np.concatenate(parts)) for kind, parts in rows.items())
        self._starts = np.cumsum([0, *(len(block.nodes) for block in self._blocks)])
        filled = dict(zip(rows, self._starts.tolist(), strict=False))
        for scope in scopes.values():
            labels_of, numbers_of = [_NONE], [_NONE]
            for kind, table in scope.elements:
                labels_of.append(table[:, 0])
                numbers_of.append(filled[kind] + np.arange(len(table)))
                filled[kind] += len(table)
            order = np.argsort(labels := np.concatenate(labels_of), kind="stable")
            scope.element_labels, scope.element_numbers = labels[order], np.concatenate(numbers_of)[order]
        self._scopes = scopes
        node_sets, element_sets = self._named("N"), self._named("E")
        cell_sets = {name: self._by_block(numbers) for name, numbers in element_sets.items()}
        self._add_surfaces(node_sets)
        for name in node_sets.keys() & element_sets.keys():
            nodes = self._nodes_of(element_sets[name])
            if not np.array_equal(nodes, node_sets[name]):
                self._notes.append(f"the node set and the element set `{name}` differ: the node set was read")
        self._notes += [f"elements of type {kind} were not read: they are not mesh elements" for kind in self._left_out]
        skipped = tuple(self._left_out)
        contents = Contents("Abaqus", np.concatenate(points), self._blocks, node_sets, cell_sets, skipped_types=skipped)
        return replace(self._without_reference_points(contents), notes=tuple(self._notes))

    def _without_reference_points(self, contents: Contents) -> Contents:
        """Return the contents without nodes of the assembly that no element uses, such as reference points, and without sets
        that contain only these."""
        lone = np.zeros(len(contents.points), bool)
        lone[self._file.node_numbers] = bool(self._instances)
        for block in contents.blocks:
            lone[block.nodes] = False
        if not lone.any():
            return contents
        left = with_points(contents, ~lone)
        gone = [name for name, nodes in contents.node_sets.items() if len(nodes) and not len(left.node_sets[name])]
        named = f", with the sets {', '.join(f'`{name[:60]}`' for name in gone)}" if gone else ""
        self._notes.append(f"nodes of the assembly that no element uses, such as reference points, were removed{named}")
        return replace(left, node_sets={name: nodes for name, nodes in left.node_sets.items() if name not in gone})

    def _named(self, what: str) -> dict[str, np.ndarray]:
        """Return for each set of nodes (what = "N") or elements ("E") its name and the indices of its members.

        If several instances use a name, it selects the union of their sets; the set of each instance is also available as
        `INSTANCE.NAME`.
        """
        found: dict[str, np.ndarray] = {}
        written: dict[str, str] = {}
        owners: dict[str, list[str]] = {}
        for place, scope in self._scopes.items():
            for (kind, upper), entries in scope.sets.items():
                if kind == what:
                    name = written.setdefault(upper, entries[0][0])
                    owners.setdefault(name, []).append(place)
                    members = self._members(scope, what, upper, ())
                    found[name] = np.union1d(found.get(name, _NONE), members)
        for name, places in owners.items():
            if len(places) > 1:
                for place in filter(None, places):
                    found[f"{place}.{name}"] = self._members(self._scopes[place], what, name.upper(), ())
        return found

    def _members(self, scope: _Scope, what: str, name: str, within: tuple[str, ...]) -> np.ndarray:
        """Return the indices of the nodes (what = "N") or elements ("E") of a set, which may include other sets. name: in
        capitals; within: names of the sets that include this set, to detect a cycle."""
        if name in within:
            raise Damaged(f"the set {name[:60]} contains itself")
        found = [_NONE]
        for _, instance, rows, is_range in scope.sets[what, name]:
            inner = self._scopes.get(instance, self._file) if instance else scope
            if is_range:
                known = inner.node_labels if what == "N" else inner.element_labels
                found += [self._known(inner, what, _in_range(known, words, name)) for words in rows if words]
                continue
            plain = [word for words in rows for word in words if word.isdecimal()]
            if plain:
                found.append(self._known(inner, what, integers(plain, f"the members of the set {name[:60]}")))
            for word in (word for words in rows for word in words if not word.isdecimal()):
                found.append(self._named_in(inner, what, word, name, (*within, name)))
        return np.unique(np.concatenate(found))

    def _named_in(self, scope: _Scope, what: str, word: str, name: str, within: tuple[str, ...]) -> np.ndarray:
        """Return the members of `word`, which a set `name` includes: `SET`, `INSTANCE.SET`, `INSTANCE.7` (one label), or
        `<SET` for the nodes of an element set. what, within: as in `_members`."""
        if word.startswith("<"):
            return self._nodes_of(self._named_in(scope, "E", word[1:], name, within))
        upper = word.strip('"').upper()
        if (what, upper) in scope.sets:
            return self._members(scope, what, upper, within)
        owner, _, rest = upper.rpartition(".")
        if owner in self._instances and rest.isdecimal():
            return self._known(self._instances[owner], what, integers([rest], "the members of sets"))
        if owner in self._instances and (what, rest) in self._instances[owner].sets:
            return self._members(self._instances[owner], what, rest, ())
        self._notes.append(f"the set `{name[:60]}` contains `{word[:60]}`, which the file does not define")
        return _NONE

    def _known(self, scope: _Scope, what: str, labels: np.ndarray) -> np.ndarray:
        """Return the indices of the nodes (what = "N") or elements ("E") with given labels in a scope (file, part or instance);
        undefined labels are omitted."""
        if what == "N":
            known, numbers = scope.node_labels, scope.node_numbers
        else:
            known, numbers = scope.element_labels, scope.element_numbers
        low, high = np.searchsorted(known, labels), np.searchsorted(known, labels, side="right")
        if (high == low).any() and not self._left_out:
            missing = labels[high == low]
            what_kind = "node" if what == "N" else "element"
            self._notes.append(f"a set contains {what_kind} {missing[0]}, which the file does not define")
        return numbers[low[high > low]]

    def _by_block(self, numbers: np.ndarray) -> list[np.ndarray]:
        ends = np.searchsorted(numbers, self._starts)
        spans = zip(ends[:-1], ends[1:], self._starts[:-1], strict=True)
        return [numbers[low:high] - start for low, high, start in spans]

    def _nodes_of(self, numbers: np.ndarray, face: str = "") -> np.ndarray:
        """Return the indices of the nodes of the elements with the indices `numbers`, or only of the face `face` of each
        element, such as "S1"."""
        found = [_NONE]
        for block, part in zip(self._blocks, self._by_block(numbers), strict=True):
            if not face or (face in _SIDES and block.base in ("triangle", "quad")):
                found.append(block.nodes[part].ravel())
            elif corners := FACES.get(block.base or "", {}).get(face):
                found.append(block.nodes[part][:, corners].ravel())
        return np.unique(np.concatenate(found))

    def _add_surfaces(self, node_sets: dict[str, np.ndarray]) -> None:
        """Add to `node_sets` the nodes of each surface of the file under the name of the surface; add a note for each
        surface with an unreadable line."""
        for scope in self._scopes.values():
            for name, is_of_nodes, rows in scope.surfaces:
                parts: list[np.ndarray] = []
                for words in rows:
                    face = words[1].upper() if len(words) > 1 and not is_of_nodes else ""
                    labels = words[0].isdecimal()
                    what = "N" if is_of_nodes else "E"
                    if not is_of_nodes and face not in _SIDES and not any(face in faces for faces in FACES.values()):
                        break
                    if labels:
                        members = self._known(scope, what, integers([words[0]], "the members of surfaces"))
                    elif (what, words[0].strip('"').upper()) in scope.sets or "." in words[0]:
                        members = self._named_in(scope, what, words[0], name, ())
                    else:
                        break
                    parts.append(members if is_of_nodes else self._nodes_of(members, face))
                else:
                    if parts:
                        node_sets[name] = np.unique(np.concatenate(parts))
                        continue
                self._notes.append(f"the surface `{name[:60]}` was not read: it does not list sets or elements with faces")


def _nodes(keyword: Keyword) -> tuple[np.ndarray, np.ndarray]:
    """Return the labels, shape (n,), and Cartesian coordinates, shape (n, 3), of the nodes that a *NODE keyword lists;
    angles of cylindrical (C) and spherical (S) coordinates are in degrees."""
    words = [[*row[:4], "", "", ""][:4] for row in keyword.words()]
    where = f"the nodes after {keyword.where}"
    labels = integers([row[0] for row in words], where)
    flat = [word or "0" for row in words for word in row[1:]]
    try:
        places = floats(flat, where)
    except Damaged as error:
        try:
            places = floats([word.upper().replace("D", "E") for word in flat], where)
        except Damaged:
            raise error from None
    r, second, third = places.reshape(-1, 3).T
    system = keyword.parameters.get("SYSTEM", "R").upper()[:1]
    if system == "C":
        angle = np.radians(second)
        return labels, np.column_stack([r * np.cos(angle), r * np.sin(angle), third])
    if system == "S":
        longitude, latitude = np.radians(second), np.radians(third)
        flat_r = r * np.cos(latitude)
        return labels, np.column_stack([flat_r * np.cos(longitude), flat_r * np.sin(longitude), r * np.sin(latitude)])
    return labels, places.reshape(-1, 3)


def _rows(keyword: Keyword, width: int) -> np.ndarray:
    """Return the labels of the elements that a keyword lists, each followed by the labels of its nodes, shape (m, width); a
    data line that ends with a comma continues on the next line."""
    where = f"the elements after {keyword.where}"
    rows: list[list[str]] = []
    row: list[str] = []
    for line in keyword.lines:
        row += [word for word in (word.strip() for word in line.split(",")) if word]
        if len(row) >= width:  # further values, such as the direction of a beam, are ignored
            rows.append(row[:width])
            row = []
        elif not line.endswith(",") and width <= 15:
            raise Damaged(f"an element among {where} has {len(row) - 1} nodes, but its type has {width - 1}")
    if row:
        raise Damaged(f"the last line of {where} is incomplete")
    return integers([word for some in rows for word in some], where).reshape(-1, width)


def _defined_twice(scope: _Scope, labels: np.ndarray, row: int) -> Damaged:
    """Return the error for a node that an earlier line defines at another position; labels: labels of the nodes of the scope
    (file, part or instance) in the order of the file; row: index of the node among them."""
    lines = [(some.keyword, k) for some in scope.nodes for k in range(len(some.labels))]
    before, again = (keyword.line_of(k) for keyword, k in (lines[int(np.argmax(labels == labels[row]))], lines[row]))
    text = f"{again} defines node {labels[row]} again, at a different position than {before}"
    return Damaged(text, f"remove one of the two lines, or change the number of the node in {again}")


def _numbers(scope: _Scope, table: np.ndarray, kind: str) -> np.ndarray:
    """Return the node numbers of elements. table: the label of each element, followed by the labels of its nodes; kind:
    element kind for the message. Raises Damaged if a node is not defined."""
    known, labels = scope.node_labels, table[:, 1:]
    place = np.searchsorted(known, labels).clip(max=max(len(known) - 1, 0))
    if labels.size and (not len(known) or (known[place] != labels).any()):
        undefined = known[place] != labels if len(known) else np.ones(labels.shape, bool)
        wrong, element = labels[undefined][0], table[np.argmax(undefined.any(axis=1)), 0]
        text = f"node {wrong} of element {element} ({kind}) is not defined: the file defines {len(known)} nodes"
        raise Damaged(text, f"add node {wrong} to the lines after *NODE, or remove element {element}")
    return scope.node_numbers[place] if labels.size else np.zeros(labels.shape, np.int64)


def _in_range(known: np.ndarray, words: list[str], name: str) -> np.ndarray:
    """Return those of the known labels that lie in a range; words: first and last label, and optionally the step (default
    1); name: set name for the message."""
    values = integers(words[:3], f"the ranges of the set {name[:60]}").tolist()
    first, last, step = values[0], values[min(len(values), 2) - 1], values[2] if len(values) > 2 else 1
    if step < 1:
        raise Damaged(f"the set {name[:60]} has a range with a step of {step}, which must be at least 1")
    within = known[(known >= first) & (known <= last)]
    return within[(within - first) % step == 0]


def _numbers_of(lines: Iterable[list[str]], where: str) -> list[list[float]]:
    return [floats([word or "0" for word in words], where).tolist() for words in lines]


def _system(keyword: Keyword) -> tuple[np.ndarray, np.ndarray]:
    """Return the axes of the local coordinates that a *SYSTEM keyword sets, in rows, shape (3, 3), and their origin, shape
    (3,); the global ones if it has no data."""
    values = [x for row in _numbers_of(keyword.words(), f"the data of *SYSTEM in {keyword.where}") for x in row]
    if not values:
        return np.eye(3), np.zeros(3)
    origin, along, beside = (np.array([*values, *[0.0] * 9][k : k + 3]) for k in (0, 3, 6))
    if len(values) < 6:
        return np.eye(3), origin
    first = along - origin
    third = np.cross(first, (beside if len(values) > 6 else origin + np.cross([0.0, 0.0, 1.0], first)) - origin)
    second = np.cross(third, first)
    axes = np.array([first, second, third])
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    if not (lengths > 0.0).all():
        raise Damaged(f"*SYSTEM in {keyword.where} has collinear points, which define no axes")
    return axes / lengths, origin


def _moved(part: _Scope, keyword: Keyword) -> _Scope:
    """Return an instance of a part, translated by the first data line of the *INSTANCE keyword, then rotated about the axis
    of the second."""
    lines = _numbers_of(keyword.words(), f"the data of *INSTANCE in {keyword.where}")
    shift = np.array([*(lines[0] if lines else []), 0.0, 0.0, 0.0][:3])
    nodes = [some._replace(places=some.places + shift) for some in part.nodes]
    if len(lines) > 1:
        if len(lines[1]) < 7:
            raise Damaged(f"*INSTANCE in {keyword.where} needs 7 numbers for a rotation, two points and an angle")
        start, end, angle = np.array(lines[1][:3]), np.array(lines[1][3:6]), np.radians(lines[1][6])
        length = float(np.linalg.norm(end - start))
        if not length > 0.0:
            raise Damaged(f"*INSTANCE in {keyword.where} has a rotation axis between two equal points")
        k = (end - start) / length
        cross = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
        turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
        nodes = [some._replace(places=start + (some.places - start) @ turn.T) for some in nodes]
    return _Scope(nodes, list(part.elements), {key: list(some) for key, some in part.sets.items()}, list(part.surfaces))


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
