"""The layout of a temporal VTKHDF file, and where in the file its parts lie.

HDF5 lays the file out and reads it; a later frame is written into its places without HDF5, which may end the whole
process when a write fails on a full disk. The format is HDF5's oldest, whose object headers carry no checksum: the
number of frames is a plain integer at a known place, in fact two, the attribute `NSteps` and the length of `Values`.
VTK wants them equal. They lie close together, so that one write sets both.
"""

import struct
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import h5py
import numpy as np

from pellucid.state import FIELDS

CONSTANT = ("id", "mass")
"""Fields that never change: stored once, and every frame refers to them."""

_DATASPACE, _ATTRIBUTE, _CONTINUATION = 0x0001, 0x000C, 0x0010  # messages of an object header


class Place(NamedTuple):
    """Where a field lies: offset in the file, bytes that a frame takes, and the file's type of number."""

    offset: int
    size: int
    dtype: np.dtype


class Layout(NamedTuple):
    """Where everything lies that a new frame changes."""

    frames: int
    capacity: int
    fields: dict[str, Place]
    values: int
    n_steps: int
    length: int


def opened(path: Path) -> AbstractContextManager[Any]:
    """The file, for reading. HDF5 never opens it for more, so readers and the run do not lock each other out."""
    return h5py.File(path, "r")


def lay_out(path: Path, capacity: int, frame: Mapping[str, np.ndarray], quads: np.ndarray, triangles: np.ndarray) -> None:
    """Make a file with places for `capacity` frames of fields of the shapes and types of `frame`; one counts.

    The cells are the `quads`, shape (q, 4), and the `triangles`, shape (t, 3), the same in every frame; without any every
    point is a cell.
    """
    n = len(frame["position"])
    vertices = np.arange(0 if len(quads) + len(triangles) else n).reshape(-1, 1)
    once, starts = np.zeros(capacity, np.int64), np.arange(capacity, dtype=np.int64) * n
    with h5py.File(path, "w", libver="earliest") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], np.int64)
        root.attrs["Type"] = np.bytes_("PolyData")
        steps = root.create_group("Steps")
        steps["PointOffsets"] = starts
        steps.attrs["NSteps"] = np.int64(1)
        _place(steps, "Values", (1,), np.dtype(np.float64), most=capacity)
        steps["NumberOfParts"] = once + 1
        steps["PartOffsets"] = once
        steps["CellOffsets"] = np.zeros((capacity, 4), np.int64)
        steps["ConnectivityIdOffsets"] = np.zeros((capacity, 4), np.int64)
        root["NumberOfPoints"] = np.array([n], np.int64)
        for name, kinds in (("Vertices", [vertices]), ("Lines", []), ("Polygons", [quads, triangles]), ("Strips", [])):
            group = root.create_group(name)
            corners = np.concatenate([np.zeros(0, np.int64), *(cells.ravel() for cells in kinds)])
            sides = np.concatenate([np.zeros(0, np.int64), *(np.full(len(cells), cells.shape[1]) for cells in kinds)])
            group["NumberOfCells"] = np.array([len(sides)], np.int64)
            group["NumberOfConnectivityIds"] = np.array([len(corners)], np.int64)
            group["Connectivity"] = corners.astype(np.int64)
            group["Offsets"] = np.concatenate([[0], np.cumsum(sides)]).astype(np.int64)
        data, offsets = root.create_group("PointData"), steps.create_group("PointDataOffsets")
        for name, array in frame.items():
            home, label = (root, "Points") if name == "position" else (data, name)
            frames = 1 if name in CONSTANT else capacity
            _place(home, label, (frames * n, *array.shape[1:]), array.dtype)
            home[label].attrs["unit"] = FIELDS[name].unit or "1"
            home[label].attrs["meaning"] = FIELDS[name].meaning
            offsets[name] = once if name in CONSTANT else starts
        data["position"] = root["Points"]


def layout(path: Path) -> Layout:
    """Find the places in a file made by `lay_out`."""
    with opened(path) as file, path.open("rb") as raw:
        root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        n = int(root["NumberOfPoints"][0])
        fields = {}
        for name, dataset in root["PointData"].items():
            size = n * int(np.prod(dataset.shape[1:], dtype=int)) * dataset.dtype.itemsize
            fields[name] = Place(dataset.id.get_offset(), size, dataset.dtype)
        values = steps["Values"]
        chunk = values.id.get_chunk_info_by_coord((0,))
        found = Layout(
            frames=len(values),
            capacity=len(steps["PointOffsets"]),
            fields=fields,
            values=chunk.byte_offset,
            n_steps=_attribute_value(raw, _message(raw, _address(steps), _ATTRIBUTE)),
            length=_message(raw, _address(values), _DATASPACE) + 8,
        )
        if _integer(raw, found.n_steps) != steps.attrs["NSteps"] or _integer(raw, found.length) != len(values):
            raise OSError(f"{path} is not laid out as pellucid does it")
    return found


def put(file: BinaryIO, offset: int, data: bytes | bytearray | memoryview) -> None:
    """Write all of `data` at `offset` of an unbuffered file."""
    file.seek(offset)
    rest = memoryview(data).cast("B")
    while rest:
        rest = rest[file.write(rest) :]


def set_count(file: BinaryIO, places: Layout, count: int) -> None:
    """Set the number of frames, at both its places with one write."""
    start = min(places.n_steps, places.length)
    file.seek(start)
    span = bytearray(file.read(max(places.n_steps, places.length) + 8 - start))
    for place in (places.n_steps, places.length):
        struct.pack_into("<q", span, place - start, count)
    put(file, start, span)


def _place(group: Any, name: str, shape: tuple[int, ...], dtype: np.dtype, most: int | None = None) -> None:
    """A dataset whose place in the file is fixed now and whose bytes are written later; a vector may grow to `most`."""
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if most:
        plan.set_chunk((most,))  # one chunk with room for all, so that growing changes its length and nothing else
    plan.set_obj_track_times(False)  # the same run gives the same bytes
    plan.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plan.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape, (most,) if most else shape)
    h5py.h5d.create(group.id, name.encode(), h5py.h5t.py_create(dtype), space, dcpl=plan)


def _address(thing: Any) -> int:
    return int(h5py.h5o.get_info(thing.id).addr)


def _integer(raw: BinaryIO, offset: int) -> int:
    raw.seek(offset)
    return int(struct.unpack("<q", raw.read(8))[0])


def _message(raw: BinaryIO, header: int, kind: int) -> int:
    """Offset of the first message of a kind in a version 1 object header (HDF5 file format specification, IV.A.1.a)."""
    raw.seek(header)
    version, size = struct.unpack("<B7xI4x", raw.read(16))
    blocks = [(header + 16, size)] if version == 1 else []
    while blocks:
        offset, size = blocks.pop()
        end = offset + size
        while offset < end:
            raw.seek(offset)
            found, length = struct.unpack("<HH4x", raw.read(8))
            if found == kind:
                return offset + 8
            if found == _CONTINUATION:
                blocks.append(struct.unpack("<QQ", raw.read(16)))
            offset += 8 + length
    raise OSError("an object header of HDF5 without the message that was looked for")


def _attribute_value(raw: BinaryIO, message: int) -> int:
    """Offset of the value of a version 1 attribute message (specification, IV.A.2.m): parts are padded to 8 bytes."""
    raw.seek(message)
    name, kind, space = struct.unpack("<xxHHH", raw.read(8))
    return message + 8 + sum(-(-part // 8) * 8 for part in (name, kind, space))
