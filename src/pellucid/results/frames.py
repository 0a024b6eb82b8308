"""`fields/<body>.vtkhdf`: the fields of a body at each instant, as temporal VTKHDF (opens in ParaView, VTK >= 9.4).

The file is laid out once, for all frames that the run can produce, and gets its name only when the first frame is in
it. Every dataset has its place in the file from the start; places not yet written take no room on the disk. A later
frame overwrites bytes in place and then the number of frames, so the structure of the file never changes: a process
killed at any moment leaves a whole file, and a full disk leaves the frames before.

The cells of a membrane are its quadrilaterals and triangles, those of other bodies their points.

`position` is another name of the dataset `Points`. VTK orders a symmetric tensor XX, YY, ZZ, XY, YZ, XZ; pellucid
orders it xx, yy, zz, yz, xz, xy. The file holds VTK's order, everything that goes in or out here has ours.
"""

import errno
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.geometry.mesh import NO_QUADS, NO_TRIANGLES, cut_in_two
from pellucid.results.files import OutputError, replacing, sync
from pellucid.results.vtkhdf import CONSTANT, Layout, lay_out, layout, opened, put, set_count

TO_VTK = [0, 1, 2, 5, 3, 4]
FROM_VTK = [0, 1, 2, 4, 5, 3]
_TENSOR = 6

Frame = Mapping[str, np.ndarray]


def create(
    path: Path,
    capacity: int,
    time: float,
    frame: Frame,
    triangles: np.ndarray = NO_TRIANGLES,
    quads: np.ndarray = NO_QUADS,
) -> None:
    """Lay out a file for `capacity` frames and write the first. Arrays have shape (n,), (n, 3), (n, 6) or the like.

    `triangles`, shape (t, 3), and `quads`, shape (q, 4), number points in the order of the arrays.
    """
    room = 100_000 + 120 * capacity + 2 * sum(array.nbytes for array in frame.values()) + 40 * (len(triangles) + len(quads))
    if shutil.disk_usage(path.parent).free < room:  # HDF5 would not survive to say so
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with replacing(path) as temporary:
        lay_out(temporary, capacity, frame, quads, triangles)
        _write(temporary, layout(temporary), 0, time, frame)


def append(path: Path, time: float, frame: Frame) -> None:
    """Write one more frame; a file that is full is first laid out anew with twice the room."""
    places = _layout(path)
    if places.frames == places.capacity:
        with replacing(path) as temporary:
            lay_out(temporary, 2 * places.capacity, frame, *read_elements(path))
            new = layout(temporary)
            for index, earlier in enumerate(times(path)):
                _write(temporary, new, index, earlier, read(path, index))
        places = new._replace(frames=places.frames)
    _write(path, places, places.frames, time, frame)


def cut(path: Path, count: int) -> None:
    """Keep the first `count` frames; the resumed run writes the others again."""
    places = _layout(path)
    if places.frames < count:
        raise OutputError(f"{path} has fewer than the {count} frames that its checkpoint counts: it was changed")
    with _raw(path) as file:
        set_count(file, places, count)
    sync(path)


def times(path: Path) -> np.ndarray:
    """The instants of the frames [s], shape (frames,)."""
    with opened(_existing(path)) as file:
        return np.asarray(file["VTKHDF/Steps/Values"][:])


def read(path: Path, index: int) -> dict[str, np.ndarray]:
    """The fields of frame `index`, each of shape (n,), (n, 3) or (n, 6). Raises IndexError where there is none."""
    with opened(_existing(path)) as file:
        root = file["VTKHDF"]
        n, count = int(root["NumberOfPoints"][0]), len(root["Steps/Values"])
        if not -count <= index < count:
            raise IndexError(f"{path} has {count} frames; there is no frame {index}")
        frame = {}
        for name, dataset in root["PointData"].items():
            start = int(root[f"Steps/PointDataOffsets/{name}"][index % count])
            values = np.asarray(dataset[start : start + n])
            frame[name] = values[:, FROM_VTK] if _is_tensor(values) else values
    return frame


def read_elements(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The quadrilaterals, shape (q, 4), and triangles, shape (t, 3), of a membrane; none for other bodies."""
    with opened(_existing(path)) as file:
        corners = np.asarray(file["VTKHDF/Polygons/Connectivity"][:])
        sides = np.diff(file["VTKHDF/Polygons/Offsets"][:])
    of_quads = np.repeat(sides == 4, sides)
    return corners[of_quads].reshape(-1, 4), corners[~of_quads].reshape(-1, 3)


def read_triangles(path: Path) -> np.ndarray:
    """The elements of a membrane with every quadrilateral cut in two, shape (m, 3); none for other bodies."""
    quads, triangles = read_elements(path)
    return np.concatenate([cut_in_two(quads), triangles])


def _write(path: Path, places: Layout, index: int, time: float, frame: Frame) -> None:
    with _raw(path) as file:
        for name, place in places.fields.items():
            if name not in CONSTANT or index == 0:
                values = frame[name][:, TO_VTK] if _is_tensor(frame[name]) else frame[name]
                put(file, place.offset + index * place.size, np.ascontiguousarray(values, place.dtype).data)
        put(file, places.values + 8 * index, np.float64(time).tobytes())
        set_count(file, places, index + 1)  # last: a frame counts when all of it is there


def _is_tensor(values: np.ndarray) -> bool:
    return values.shape[1:] == (_TENSOR,)


def _raw(path: Path) -> Any:
    return path.open("r+b", buffering=0)


def _existing(path: Path) -> Path:
    if not path.is_file():
        raise OutputError(f"there are no fields at {path}")
    return path


def _layout(path: Path) -> Layout:
    return layout(_existing(path))
