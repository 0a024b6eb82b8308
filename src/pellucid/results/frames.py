"""`fields/<body>.vtkhdf`: the fields of a body at each instant, as temporal VTKHDF (opens in ParaView, VTK >= 9.4).

The file is laid out once, for all frames that the run can produce, and gets its name only when the first frame is in
it. Every dataset has its place in the file from the start; places not yet written take no room on the disk. A later
frame overwrites bytes in place and then the number of frames, so the structure of the file never changes and a process
killed at any moment leaves a whole file. For the same reason the format is HDF5's oldest: its object headers carry no
checksum that half a write could break. The number of frames stands twice, as `NSteps` and as the length of `Values`;
VTK wants them equal and overruns its memory where `Values` is longer, so that is the one that grows last.

`position` is another name of the dataset `Points`. VTK orders a symmetric tensor XX, YY, ZZ, XY, YZ, XZ; pellucid
orders it xx, yy, zz, yz, xz, xy. The file holds VTK's order, everything that goes in or out here has ours.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pellucid.results.files import OutputError, replacing, sync
from pellucid.state import FIELDS

CONSTANT = ("id", "mass")
"""Fields that never change: stored once, and every frame refers to them."""

TO_VTK = [0, 1, 2, 5, 3, 4]
FROM_VTK = [0, 1, 2, 4, 5, 3]
_TENSOR = 6

Frame = Mapping[str, np.ndarray]


def create(path: Path, capacity: int, time: float, frame: Frame) -> None:
    """Lay out a file for `capacity` frames and write the first. Arrays have shape (n,), (n, 3) or (n, 6)."""
    with replacing(path) as temporary, _new(temporary) as file:
        _lay_out(file.create_group("VTKHDF"), capacity, frame)
        _write(file["VTKHDF"], 0, frame)
        _count(file["VTKHDF"], 1, time)


def append(path: Path, time: float, frame: Frame) -> None:
    """Write one more frame; a file that is full is first laid out anew with twice the room."""
    with _opened(path, "r+") as root:
        steps = root["Steps"]
        count, capacity = len(steps["Values"]), len(steps["PointOffsets"])
        if count < capacity:
            _write(root, count, frame)
            root.file.flush()  # the frame is in the file before it counts
            _count(root, count + 1, time)
    if count == capacity:
        _grow(path, 2 * capacity)
        append(path, time, frame)


def cut(path: Path, count: int) -> None:
    """Keep the first `count` frames; the resumed run writes the others again."""
    with _opened(path, "r+") as root:
        if len(root["Steps/Values"]) < count:
            raise OutputError(f"{path} has fewer than the {count} frames that its checkpoint counts: it was changed")
        _count(root, count)
    sync(path)


def times(path: Path) -> np.ndarray:
    """The instants of the frames [s], shape (frames,)."""
    with _opened(path, "r") as root:
        return np.asarray(root["Steps/Values"][:])


def read(path: Path, index: int) -> dict[str, np.ndarray]:
    """The fields of frame `index`, each of shape (n,), (n, 3) or (n, 6)."""
    with _opened(path, "r") as root:
        count = len(root["Steps/Values"])
        if not -count <= index < count:
            raise IndexError(f"{path} has {count} frames; there is no frame {index}")
        return _read(root, index % count)


def _new(path: Path) -> Any:
    return h5py.File(path, "w", libver="earliest")


@contextmanager
def _opened(path: Path, mode: str) -> Iterator[Any]:
    if not path.is_file():
        raise OutputError(f"there are no fields at {path}")
    # Without a lock a viewer can read the file while the run goes on, and cannot stop the run.
    with h5py.File(path, mode, locking=False) as file:
        yield file["VTKHDF"]


def _lay_out(root: Any, capacity: int, frame: Frame) -> None:
    n = len(frame["position"])
    root.attrs["Version"] = np.array([2, 0], np.int64)
    root.attrs["Type"] = np.bytes_("PolyData")
    once = np.zeros(capacity, np.int64)
    root["NumberOfPoints"] = np.array([n], np.int64)
    for cells, connectivity in (("Vertices", n), ("Lines", 0), ("Polygons", 0), ("Strips", 0)):
        group = root.create_group(cells)
        group["NumberOfCells"] = np.array([connectivity], np.int64)
        group["NumberOfConnectivityIds"] = np.array([connectivity], np.int64)
        group["Connectivity"] = np.arange(connectivity, dtype=np.int64)
        group["Offsets"] = np.arange(connectivity + 1, dtype=np.int64)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(0)
    _place(steps, "Values", (1,), np.dtype(float), most=capacity)
    starts = np.arange(capacity, dtype=np.int64) * n
    steps["PointOffsets"] = starts
    steps["NumberOfParts"] = once + 1
    steps["PartOffsets"] = once
    steps["CellOffsets"] = np.zeros((capacity, 4), np.int64)
    steps["ConnectivityIdOffsets"] = np.zeros((capacity, 4), np.int64)
    data, offsets = root.create_group("PointData"), steps.create_group("PointDataOffsets")
    for name, array in frame.items():
        constant = name in CONSTANT
        home, label = (root, "Points") if name == "position" else (data, name)
        _place(home, label, ((1 if constant else capacity) * n, *array.shape[1:]), array.dtype)
        home[label].attrs["unit"] = FIELDS[name].unit or "1"
        home[label].attrs["meaning"] = FIELDS[name].meaning
        offsets[name] = once if constant else starts
    data["position"] = root["Points"]


def _place(group: Any, name: str, shape: tuple[int, ...], dtype: np.dtype, most: int | None = None) -> None:
    """A dataset whose place in the file is fixed now and whose bytes are written later; a vector may grow to `most`."""
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if most:
        plan.set_chunk((most,))  # one chunk with room for all: growing changes a number in the file and moves nothing
    plan.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    plan.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    space = h5py.h5s.create_simple(shape, (most,) if most else shape)
    h5py.h5d.create(group.id, name.encode(), h5py.h5t.py_create(dtype), space, dcpl=plan)


def _count(root: Any, count: int, time: float | None = None) -> None:
    """Set the number of frames and, where given, the instant of the last."""
    steps = root["Steps"]
    values = steps["Values"]
    if count < len(values):
        values.resize((count,))
        root.file.flush()
    steps.attrs.modify("NSteps", count)
    root.file.flush()
    values.resize((count,))
    if time is not None:
        values[count - 1] = time


def _write(root: Any, index: int, frame: Frame) -> None:
    n = len(frame["position"])
    for name, array in frame.items():
        if name not in CONSTANT:
            values = array[:, TO_VTK] if array.shape[1:] == (_TENSOR,) else array
            root[f"PointData/{name}"][index * n : (index + 1) * n] = values
        elif index == 0:
            root[f"PointData/{name}"][:] = array


def _read(root: Any, index: int) -> dict[str, np.ndarray]:
    n = int(root["NumberOfPoints"][0])
    frame = {}
    for name, dataset in root["PointData"].items():
        start = int(root[f"Steps/PointDataOffsets/{name}"][index])
        values = np.asarray(dataset[start : start + n])
        frame[name] = values[:, FROM_VTK] if values.shape[1:] == (_TENSOR,) else values
    return frame


def _grow(path: Path, capacity: int) -> None:
    with _opened(path, "r") as old, replacing(path) as temporary, _new(temporary) as file:
        root = file.create_group("VTKHDF")
        _lay_out(root, capacity, _read(old, 0))
        for index, time in enumerate(old["Steps/Values"][:]):
            _write(root, index, _read(old, index))
            _count(root, index + 1, time)
