"""Reader of VTK XML files with polygons (.vtp) or unstructured grids (.vtu): text, binary and appended, compressed or not."""

import base64
import binascii
import lzma
import re
import zlib
from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np

from pellucid.geometry.files.contents import Block, Contents, Damaged, flat_blocks, floats, integers, triangles_of_strip
from pellucid.geometry.files.vtk_legacy import UNREAD, grid_contents

_NONE = np.zeros(0, np.int64)
TYPES = {f"{kind}{bits}": f"{letter}{bits // 8}" for kind, letter in (("Int", "i"), ("UInt", "u")) for bits in (8, 16, 32, 64)}
TYPES |= {"Float32": "f4", "Float64": "f8"}


def lz4_block(data: bytes, most: int) -> bytes:
    """Return the decompressed bytes, at most `most`, of an LZ4 block (LZ4 block format description, Y. Collet). Raises
    Damaged if the block is invalid."""
    out, at = bytearray(), 0

    def length(first: int) -> int:
        nonlocal at
        if first == 15:
            while at < len(data):
                at += 1
                first += data[at - 1]
                if data[at - 1] != 255:
                    break
        return first

    while at < len(data) and len(out) <= most:
        token = data[at]
        at += 1
        literals = length(token >> 4)
        out += data[at : at + literals]
        at += literals
        if at >= len(data):
            break
        offset = int.from_bytes(data[at : at + 2], "little")
        at += 2
        count = length(token & 15) + 4
        if not 0 < offset <= len(out):
            raise Damaged("a packed table is damaged")
        part = bytes(out[len(out) - offset :])
        out += (part * (count // offset + 1))[:count]
    return bytes(out[:most])


PACKERS: dict[str, Callable[[bytes, int], bytes]] = {
    "vtkZLibDataCompressor": lambda data, most: zlib.decompressobj().decompress(data, most),
    "vtkLZMADataCompressor": lambda data, most: lzma.LZMADecompressor().decompress(data, most),
    "vtkLZ4DataCompressor": lz4_block,
}
APPENDED = re.compile(rb"<AppendedData[^>]*>\s*_")
PACKED = 1000
"""Largest ratio of decompressed to compressed length: VTK compresses blocks of 32 kB, and zlib achieves no higher ratio."""


def read_vtp(data: bytes) -> Contents:
    """Return the mesh in the bytes of a VTK XML file of polygons. Raises Damaged if they do not follow the format."""
    return _Reader(data, "PolyData").polygons()


def read_vtu(data: bytes) -> Contents:
    """Return the mesh in the bytes of a VTK XML file of an unstructured grid. Raises Damaged if they do not follow the
    format."""
    return _Reader(data, "UnstructuredGrid").grid()


class _Reader:
    """Reader of a VTK XML file, which consists of an XML tree and appended data; kind: type of data set, such as
    "PolyData"."""

    def __init__(self, data: bytes, kind: str) -> None:
        self._appended = b""
        found = APPENDED.search(data)
        if found:  # raw bytes are not valid XML
            end = data.rfind(b"</AppendedData>")
            self._appended = data[found.end() : end if end > found.end() else len(data)]
            data = data[: found.end() - 1] + b"</AppendedData></VTKFile>"
        if b"<!DOCTYPE" in data[:1000] or b"<!ENTITY" in data:
            raise Damaged("it declares XML entities, which are not allowed in VTK files")
        try:
            self._root = ElementTree.fromstring(data)
        except ElementTree.ParseError as error:
            raise Damaged(f"line {error.position[0]} is not valid XML") from None
        if self._root.tag != "VTKFile" or self._root.get("type") != kind:
            raise Damaged(f"it is not a VTKFile of type {kind}")
        if (packer := self._root.get("compressor", "")) and packer not in PACKERS:
            raise Damaged("its compression is not supported (supported: zlib, LZ4 and LZMA)")
        self._unpack = PACKERS.get(packer)
        self._order = ">" if self._root.get("byte_order") == "BigEndian" else "<"
        self._header = np.dtype(self._order + TYPES.get(self._root.get("header_type", "UInt32"), "u4"))
        encoding = self._root.find("AppendedData")
        self._raw = encoding is not None and encoding.get("encoding") == "raw"

    def grid(self) -> Contents:
        """Return the mesh of an unstructured grid: the points, cells and arrays of all pieces of the file, joined."""
        points, corners, ends, types = [np.zeros((0, 3))], [_NONE], [_NONE], [_NONE]
        arrays: tuple[dict[str, list[np.ndarray]], dict[str, list[np.ndarray]]] = ({}, {})
        pieces = self._root.findall("UnstructuredGrid/Piece")
        n, is_single, unread = 0, False, False
        for piece in pieces:
            here, single = self._points(piece)
            is_single = is_single or single
            cells = {table.get("Name"): table for table in piece.findall("Cells/DataArray")}
            if not {"connectivity", "offsets", "types"} <= cells.keys():
                raise Damaged("a piece has no cells with connectivity, offsets and types")
            own, own_ends, own_types = (
                self._values(cells[name]).astype(np.int64) for name in ("connectivity", "offsets", "types")
            )
            if own.size and not 0 <= own.min() <= own.max() < len(here):
                raise Damaged(f"a cell has a corner that is not one of the {len(here)} points of its piece")
            ends.append(own_ends + sum(map(len, corners)))
            corners.append(own + n)
            types.append(own_types)
            points.append(here)
            n += len(here)
            for found, name, count in zip(arrays, ("PointData", "CellData"), (len(here), len(own_types)), strict=True):
                for table in piece.findall(f"{name}/DataArray"):
                    try:
                        values = self._values(table) if table.get("NumberOfComponents", "1") == "1" else _NONE
                    except Damaged:
                        values, unread = _NONE, True
                    if len(values) == count:
                        found.setdefault(table.get("Name", ""), []).append(values)
        whole = tuple(
            {name: np.concatenate(parts) for name, parts in some.items() if len(parts) == len(pieces)} for some in arrays
        )
        all_points, connectivity = np.concatenate(points), np.concatenate(corners)
        tables = connectivity, np.concatenate(ends), np.concatenate(types)
        contents = grid_contents("VTK grid, XML", all_points, *tables, (whole[0], whole[1]), is_single)
        return replace(contents, notes=(UNREAD,)) if unread else contents

    def _points(self, piece: ElementTree.Element) -> tuple[np.ndarray, bool]:
        """Return the points of a piece, shape (n, 3), and True if they are binary single-precision numbers."""
        table = piece.find("Points/DataArray")
        if table is None:
            return np.zeros((0, 3)), False
        values = self._values(table).astype(float)
        if len(values) % 3:
            raise Damaged("its points do not have three coordinates each")
        return values.reshape(-1, 3), table.get("type") == "Float32" and table.get("format", "ascii") != "ascii"

    def polygons(self) -> Contents:
        """Return the mesh of a data set of polygons: the points and polygons of all pieces of the file, joined."""
        points, faces, n, is_single = [np.zeros((0, 3))], list[list[int]](), 0, False
        for piece in self._root.findall("PolyData/Piece"):
            here, single = self._points(piece)
            is_single = is_single or single
            for name in ("Polys", "Strips"):
                lists = self._lists(piece.find(name))
                lists = [t for strip in lists for t in triangles_of_strip(strip)] if name == "Strips" else lists
                faces += [[n + corner for corner in corners] for corners in lists]
            points.append(here)
            n += len(here)
        places = np.concatenate(points)
        blocks: tuple[Block, ...] = flat_blocks(places, faces, "polygon")
        return Contents("VTK polydata, XML", places, blocks, is_single=is_single)

    def _lists(self, group: ElementTree.Element | None) -> list[list[int]]:
        tables = {table.get("Name"): table for table in group.findall("DataArray")} if group is not None else {}
        if not {"connectivity", "offsets"} <= tables.keys():
            return []
        corners, ends = (self._values(tables[name]).astype(np.int64) for name in ("connectivity", "offsets"))
        if len(ends) and not ((np.diff(ends, prepend=0) >= 0).all() and ends[-1] == len(corners)):
            raise Damaged("the offsets of its lists are not ascending, or exceed the connectivity")
        return [part.tolist() for part in np.split(corners, ends[:-1])] if len(ends) else []

    def _values(self, table: ElementTree.Element) -> np.ndarray:
        kind = TYPES.get(table.get("type", ""))
        if kind is None:
            raise Damaged("a table has an unknown VTK data type")
        form = table.get("format", "ascii")
        if form == "ascii":
            words = (table.text or "").split()
            return floats(words, "its points") if kind[0] == "f" else integers(words, "its lists")
        if form == "appended":
            offset = table.get("offset", "")
            if not offset.isdecimal() or int(offset) >= len(self._appended):
                raise Damaged("a table starts after the end of the file")
            source = _Bytes(self._appended[int(offset) :], self._raw)
        else:
            source = _Bytes((table.text or "").strip().encode(), raw=False)
        data = self._unpacked(source) if self._unpack else source.take_behind_count(self._header)
        found = np.dtype(self._order + kind)
        if len(data) % found.itemsize:
            raise Damaged("a table ends within a number")
        return np.frombuffer(data, found).astype(found.newbyteorder("="))

    def _unpacked(self, source: "_Bytes") -> bytes:
        """Return the decompressed bytes of a table that is stored in compressed blocks, after their count, block size, size
        of the last block, and compressed size of each block."""
        head = np.frombuffer(source.take(3 * self._header.itemsize, peek=True), self._header)
        n = int(head[0])
        sizes = np.frombuffer(source.take((3 + n) * self._header.itemsize), self._header)[3:].astype(np.int64)
        packed = source.take(int(sizes.sum()))
        parts, at = [], 0
        for size in sizes.tolist():
            try:
                parts.append(self._unpack(packed[at : at + size], PACKED * max(size, 1)) if self._unpack else b"")
            except (zlib.error, lzma.LZMAError, EOFError):
                raise Damaged("a packed table is damaged") from None
            at += size
        return b"".join(parts)


class _Bytes:
    """Sequential reader of raw bytes, or of base 64 text whose parts are encoded separately."""

    def __init__(self, data: bytes, raw: bool) -> None:
        self._data, self._raw, self._at = data, raw, 0

    def take_behind_count(self, header: np.dtype) -> bytes:
        """Return the bytes of a table that follow the number of its bytes (of data type `header`); in base 64 both are
        encoded together."""
        count = int(np.frombuffer(self.take(header.itemsize, peek=True), header)[0])
        return self.take(header.itemsize + count)[header.itemsize :]

    def take(self, count: int, peek: bool = False) -> bytes:
        """Return the next `count` bytes; peek: leave the position unchanged. Raises Damaged if they are missing or invalid."""
        if count < 0:
            raise Damaged("a table has a negative length")
        length = count if self._raw else -(-count // 3) * 4
        part = self._data[self._at : self._at + length]
        try:
            found = part if self._raw else base64.b64decode(part[: len(part) // 4 * 4])[:count]
        except (binascii.Error, ValueError):
            raise Damaged("a table in base 64 is damaged") from None
        if len(found) != count:
            raise Damaged("a table is truncated")
        self._at += 0 if peek else length
        return found
