"""A file object that keeps all changes in memory until they are written together."""

from typing import BinaryIO


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
