"""`fields/<body>.vtkhdf`: the fields of a body at each time, as temporal VTKHDF (opens in ParaView, VTK >= 9.4).

The file is laid out once for all frames that the run can produce, and gets its name only when the first frame is in it.
Every dataset has a fixed location in the file from the start; locations that are not yet written take no space on the disk.
A later frame overwrites bytes in place and then the number of frames, so the structure of the file never changes. After a
process is killed the file is complete, and a full disk leaves the previous frames intact.

`position` is another name of the dataset `Points`. VTK orders a symmetric tensor XX, YY, ZZ, XY, YZ, XZ; pellucid orders it
xx, yy, zz, yz, xz, xy. The file has VTK's order; the functions of this module accept and return pellucid's.
"""

import errno
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.results.storage import vtkhdf
from pellucid.results.storage.files import OutputError, replacing, sync
from pellucid.results.storage.vtkhdf import CONSTANT, Layout, counting, lay_out, layout, opened, put

TO_VTK = [0, 1, 2, 5, 3, 4]
FROM_VTK = [0, 1, 2, 4, 5, 3]
_TENSOR = 6

Frame = Mapping[str, np.ndarray]


class NoFrame(IndexError):
    """Error for a frame that a file does not have."""


def create(
    path: Path, capacity: int, time: float, frame: Frame, cells: Cells | None = None, constant: Collection[str] = CONSTANT
) -> bytes:
    """Lay out a file for `capacity` frames and write the first frame; return the digest (a checksum) of this frame.

    time: [s]. frame: fields by name, each of shape (n,), (n, 3), (n, 6) or similar. cells: cells of the body; default: one cell
    per point. constant: names of the fields that are the same in all frames. Raises OSError if the file cannot be written.
    """
    if cells is None:
        cells = Cells.of_points(len(frame["position"]))
    with replacing(path) as temporary:
        lay_out(temporary, capacity, frame, cells, constant)
        return _write(temporary, layout(temporary), 0, time, frame)


def append(path: Path, time: float, frame: Frame, constant: Collection[str] = CONSTANT) -> bytes:
    """Append a frame to a file and return its digest (a checksum of its bytes). A file without room is rewritten first with
    twice the capacity.

    time: [s]. frame: fields by name, with the shapes of the first frame. constant: names of the fields that are the same in
    all frames.
    """
    places = _layout(path)
    if places.frames == places.capacity:
        with replacing(path) as temporary:
            lay_out(temporary, 2 * places.capacity, frame, read_cells(path), constant)
            new = layout(temporary)
            for index, earlier in enumerate(times(path)):
                _write(temporary, new, index, earlier, read(path, index))
        places = new._replace(frames=places.frames)
    return _write(path, places, places.frames, time, frame)


def first(path: Path, count: int) -> list[bytes]:
    """Return the digests (checksums) of the first `count` frames, as `create` and `append` returned them."""
    places = _layout(path)
    if places.frames < count:
        raise OutputError(f"{path} was changed: it has fewer than the {count} frames of its checkpoint")
    with path.open("rb") as file:
        return [_digest(_read_part(file, *part) for part in _parts(places, index)) for index in range(count)]


def cut(path: Path, count: int) -> None:
    """Remove all but the first `count` frames of a file; the resumed run writes the later frames again."""
    if len(times(path)) < count:
        raise OutputError(f"{path} was changed: it has fewer than the {count} frames of its checkpoint")
    with counting(path, count):
        pass
    sync(path)


def times(path: Path) -> np.ndarray:
    """Return the times of the frames in a file [s], shape (frames,)."""
    with _whole(path), opened(_existing(path)) as file:
        return np.asarray(file["VTKHDF/Steps/Values"][:])


def names(path: Path) -> list[str]:
    """Return the names of the fields in a file, in the order of the file."""
    with _whole(path), opened(_existing(path)) as file:
        return list(file["VTKHDF/PointData"])


def read(path: Path, index: int, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
    """Return the fields of the frame with the number `index` by name, each of shape (n,), (n, 3) or (n, 6).

    names: fields to read; default: all. Raises IndexError if the file has no frame with this number.
    """
    with _whole(path), opened(_existing(path)) as file:
        root = file["VTKHDF"]
        n, count = int(root["NumberOfPoints"][0]), len(root["Steps/Values"])
        if not -count <= index < count:
            raise NoFrame(f"{path} has {count} frames; frame {index} does not exist")
        frame = {}
        data = root["PointData"]
        for name in data if names is None else [name for name in names if name in data]:
            dataset = data[name]
            start = int(root[f"Steps/PointDataOffsets/{name}"][index % count])
            values = np.asarray(dataset[start : start + n])
            frame[name] = values[:, FROM_VTK] if _is_tensor(values) else values
    return frame


def read_cells(path: Path) -> Cells:
    """Return the cells (points, elements or tetrahedra) of the body in a file, which are the same in all frames."""
    with _whole(path):
        return vtkhdf.read_cells(_existing(path))


def _write(path: Path, places: Layout, index: int, time: float, frame: Frame) -> bytes:
    parts = []
    for name, place in places.fields.items():
        if index == 0 or not place.once:
            values = frame[name][:, TO_VTK] if _is_tensor(frame[name]) else frame[name]
            parts.append(np.ascontiguousarray(values, place.dtype).tobytes())
    parts.append(np.float64(time).tobytes())
    with counting(path, index + 1) as file:  # a frame counts when all of it is there
        for (start, _), part in zip(_parts(places, index), parts, strict=True):
            put(file, start, part)
    return _digest(parts)


def _parts(places: Layout, index: int) -> list[tuple[int, int]]:
    """Return (offset, length) in bytes of each part of the file that holds a field of a frame or the time of the frame.
    places: locations of the data; index: number of the frame."""
    fields = [place for place in places.fields.values() if index == 0 or not place.once]
    return [*((place.offset + index * place.size, place.size) for place in fields), (places.values + 8 * index, 8)]


def _read_part(file: BinaryIO, start: int, size: int) -> bytes:
    file.seek(start)
    return file.read(size)


def _digest(parts: Iterable[bytes]) -> bytes:
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
    return found.digest()


def _is_tensor(values: np.ndarray) -> bool:
    return values.shape[1:] == (_TENSOR,)


def _layout(path: Path) -> Layout:
    with _whole(path):
        return layout(_existing(path))


@contextmanager
def _whole(path: Path) -> Iterator[None]:
    """Turn errors of HDF5 and of the operating system in the block into an `OutputError` that states why the file cannot be
    read."""
    try:
        yield
    except (KeyError, ValueError, TypeError, RuntimeError, AttributeError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None and error.errno not in (errno.EINVAL, errno.ENODATA):
            raise OutputError(f"cannot read {path}: {error.strerror}") from error
        reason = str(error).strip("'\"") or type(error).__name__
        raise OutputError(f"{path} is damaged: {reason}") from error


def _existing(path: Path) -> Path:
    if not path.is_file():
        raise OutputError(f"{path} does not exist")
    return path
