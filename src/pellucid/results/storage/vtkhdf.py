"""The layout of a temporal VTKHDF file and the locations of its data.

HDF5 creates and reads the file and sets the number of frames, always through memory (`StagedFile`): HDF5 may abort the
process when a write fails on a full disk, and its changes are not atomic. The fields of a frame are written to their
locations without HDF5.

The number of frames is stored twice, as the attribute `NSteps` and as the length of `Values`, and VTK crashes if the two
differ. Both are created first, so that they lie close together and change with one write."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import h5py
import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.state import FIELDS

CONSTANT = ("id", "mass")
"""Fields that are usually constant: they are stored once, and every frame refers to them. In fluid films the mass of the
nodes changes."""

POLYGONS, GRID = b"PolyData", b"UnstructuredGrid"
GROUPS = {"Vertices": ("points",), "Lines": ("lines",), "Polygons": ("quadrilaterals", "triangles"), "Strips": ()}
"""Kinds of cells in each group of a `PolyData` file, in order."""

TYPES = {"points": 1, "lines": 3, "quadrilaterals": 9, "triangles": 5, "tetrahedra": 10}
"""VTK cell types of the kinds of cells in an unstructured grid, in order."""


class Place(NamedTuple):
    """Location of the values of a field in a VTKHDF file: byte offset of the first frame (`offset`), bytes per frame
    (`size`), and data type."""

    offset: int
    size: int
    dtype: np.dtype
    once: bool  # True if the field is stored once, for all frames


class Layout(NamedTuple):
    """Layout of a VTKHDF file: number of written frames (`frames`), number of frames that have space (`capacity`), and the
    locations of all data that are written without HDF5: the fields by name, and the byte offset of the times of the frames
    (`values`)."""

    frames: int
    capacity: int
    fields: dict[str, Place]
    values: int


def opened(path: Path) -> AbstractContextManager[Any]:
    """Open an HDF5 file for reading. HDF5 never opens the file for writing, so readers and the run do not lock each other
    out."""
    return h5py.File(path, "r")


def lay_out(
    path: Path, capacity: int, frame: Mapping[str, np.ndarray], cells: Cells, constant: Collection[str] = CONSTANT
) -> None:
    """Create a file with space for `capacity` frames; the number of frames is set to one.

    frame: a frame with the shapes and types of the fields. The cells and the fields named in `constant` are the same in
    every frame. Raises OSError if the file cannot be written.
    """
    n = len(frame["position"])
    once, starts = np.zeros(capacity, np.int64), np.arange(capacity, dtype=np.int64) * n
    with path.open("w+b", buffering=0) as raw:
        staged = StagedFile(raw)
        with h5py.File(staged, "w", libver="earliest") as file:
            root = file.create_group("VTKHDF")
            steps = root.create_group("Steps")
            steps.attrs["NSteps"] = np.int64(1)
            _place(steps, "Values", (1,), np.dtype(np.float64), most=capacity)
            root.attrs["Version"] = np.array([2, 0], np.int64)
            root.attrs["Type"] = np.bytes_(GRID if len(cells.tetrahedra) else POLYGONS)
            steps["PointOffsets"] = starts
            steps["NumberOfParts"] = once + 1
            steps["PartOffsets"] = once
            root["NumberOfPoints"] = np.array([n], np.int64)
            _put_cells(root, cells, capacity)
            data, offsets = root.create_group("PointData"), steps.create_group("PointDataOffsets")
            for name, array in frame.items():
                home, label = (root, "Points") if name == "position" else (data, name)
                stays = name in constant and not (name == "mass" and "areal_density" in frame)
                frames = 1 if stays else capacity
                _place(home, label, (frames * n, *array.shape[1:]), array.dtype)
                home[label].attrs["unit"] = FIELDS[name].unit or "1"
                home[label].attrs["meaning"] = FIELDS[name].meaning
                offsets[name] = once if stays else starts
            data["position"] = root["Points"]
        staged.commit()


def layout(path: Path) -> Layout:
    """Return the locations of the data in a file created by `lay_out`."""
    with opened(path) as file:
        root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
        n = int(root["NumberOfPoints"][0])
        fields = {}
        for name, dataset in root["PointData"].items():
            size = n * int(np.prod(dataset.shape[1:], dtype=int)) * dataset.dtype.itemsize
            fields[name] = Place(dataset.id.get_offset(), size, dataset.dtype, len(dataset) == n)
        values = steps["Values"]
        chunk = values.id.get_chunk_info_by_coord((0,))
        return Layout(len(values), len(steps["PointOffsets"]), fields, chunk.byte_offset)


def read_cells(path: Path) -> Cells:
    """Read the cells (points, elements or tetrahedra) of the body in a VTKHDF file."""
    with opened(path) as file:
        root = file["VTKHDF"]
        if root.attrs["Type"] == GRID:
            types = root["Types"][:]
            return Cells(**{kind: _read_cells(root, types == number, kind) for kind, number in TYPES.items()})
        found: dict[str, np.ndarray] = {}
        for name, kinds in GROUPS.items():
            sides = np.diff(root[name]["Offsets"][:])
            found |= {kind: _read_cells(root[name], sides == _corners(kind), kind) for kind in kinds}
        return Cells(**found)


@contextmanager
def counting(path: Path, count: int) -> Iterator[BinaryIO]:
    """Yield the open file, to which the caller writes a frame in place. If the block succeeds, set the number of frames to
    `count` in one write."""
    with path.open("r+b", buffering=0) as raw:
        staged = StagedFile(raw)
        with h5py.File(staged, "r+", libver="earliest") as file:
            file["VTKHDF/Steps"].attrs.modify("NSteps", np.int64(count))
            file["VTKHDF/Steps/Values"].resize((count,))
        yield raw
        staged.commit_at_once()


def _put_cells(root: Any, cells: Cells, capacity: int) -> None:
    steps = root["Steps"]
    if len(cells.tetrahedra):
        kinds = [getattr(cells, kind) for kind in TYPES]
        _put_group(root, kinds)
        root["Types"] = np.repeat(np.array(list(TYPES.values()), np.uint8), list(map(len, kinds)))
    else:
        for name, named in GROUPS.items():
            _put_group(root.create_group(name), [getattr(cells, kind) for kind in named])
    shape = (capacity,) if len(cells.tetrahedra) else (capacity, len(GROUPS))
    steps["CellOffsets"] = steps["ConnectivityIdOffsets"] = np.zeros(shape, np.int64)


def _put_group(group: Any, kinds: list[np.ndarray]) -> None:
    corners = np.concatenate([np.zeros(0, np.int64), *(cells.ravel() for cells in kinds)])
    sides = np.concatenate([np.zeros(0, np.int64), *(np.full(len(cells), cells.shape[1]) for cells in kinds)])
    group["NumberOfCells"] = np.array([len(sides)], np.int64)
    group["NumberOfConnectivityIds"] = np.array([len(corners)], np.int64)
    group["Connectivity"] = corners.astype(np.int64)
    group["Offsets"] = np.concatenate([[0], np.cumsum(sides)]).astype(np.int64)


def _read_cells(group: Any, which: np.ndarray, kind: str) -> np.ndarray:
    starts = group["Offsets"][:-1][which]
    corners = np.asarray(group["Connectivity"][:], np.int64)
    return corners[starts[:, None] + np.arange(_corners(kind))]


def _corners(kind: str) -> int:
    return int(Cells._field_defaults[kind].shape[1])


def _place(group: Any, name: str, shape: tuple[int, ...], dtype: np.dtype, most: int | None = None) -> None:
    """Create a dataset with a fixed location in an HDF5 group; its bytes are written later. most: number of entries up to
    which a vector may grow."""
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if most:
        plan.set_chunk((most,))  # one chunk with room for all, so that growing changes its length and nothing else
    plan.set_obj_track_times(False)  # the same run gives the same bytes
    plan.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plan.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape, (most,) if most else shape)
    h5py.h5d.create(group.id, name.encode(), h5py.h5t.py_create(dtype), space, dcpl=plan)


class StagedFile:
    """File object for HDF5 that reads from the unbuffered file `raw` and keeps all writes in memory until `commit`.

    HDF5 may abort the process when a write fails on a full disk; with this class HDF5 never meets a failed write.
    """

    def __init__(self, raw: BinaryIO) -> None:
        self._raw = raw
        self._changes: list[tuple[int, bytes]] = []
        self._size = raw.seek(0, 2)
        self._place = 0

    def commit(self) -> None:
        """Write the kept changes to the file one after the other. Raises OSError if a write fails."""
        self._raw.truncate(self._size)
        for start, data in self._changes:
            put(self._raw, start, data)

    def commit_at_once(self) -> None:
        """Write the whole range of bytes from the first to the last changed byte in a single call of the system, so that
        the file changes completely or not at all."""
        start = min(first for first, _ in self._changes)
        end = max(first + len(data) for first, data in self._changes)
        put(self._raw, start, self._read(start, end))

    # what HDF5 asks of a file

    def seek(self, offset: int, whence: int = 0) -> int:
        """Set the current position in the file and return it. whence: 0: offset from the start; 1: from the current
        position; 2: from the end."""
        self._place = offset + (0, self._place, self._size)[whence]
        return self._place

    def tell(self) -> int:
        """Return the current position in the file, in bytes from the start."""
        return self._place

    def read(self, size: int) -> bytes:
        """Read `size` bytes from the current position; bytes never written are zero."""
        data = self._read(self._place, self._place + size)
        self._place += size
        return data

    def write(self, data: memoryview) -> int:
        """Keep `data` in memory as a change of the file at the current position; return the number of bytes."""
        self._changes.append((self._place, bytes(data)))
        self._place += len(data)
        self._size = max(self._size, self._place)
        return len(data)

    def truncate(self, size: int) -> int:
        """Set the size of the file in bytes and return it."""
        self._size = size
        return size

    def flush(self) -> None:
        """Do nothing: data are written by `commit`."""

    def _read(self, start: int, end: int) -> bytes:
        self._raw.seek(start)
        found = bytearray(end - start)
        known = self._raw.read(end - start)
        found[: len(known)] = known
        for first, data in self._changes:
            low, high = max(start, first), min(end, first + len(data))
            if low < high:
                found[low - start : high - start] = data[low - first : high - first]
        return bytes(found)


def put(file: BinaryIO, offset: int, data: bytes | bytearray | memoryview) -> None:
    """Write all bytes of `data` at `offset` [bytes] of an unbuffered file, with several writes if required."""
    file.seek(offset)
    rest = memoryview(data).cast("B")
    while rest:
        rest = rest[file.write(rest) :]
