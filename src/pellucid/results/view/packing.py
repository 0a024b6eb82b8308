"""Compression of arrays for an HTML page: quantized to few bits, stored as differences, bytes transposed, deflated
together.

The reader is viewer/src/data.js.
"""

import zlib

import numpy as np

LEVELS = 8191
"""Number of quantization steps of positions along each side of a body's box: about an eighth of a pixel if the box fills
the window."""
GONE = 65535
"""Value that replaces each coordinate of a point that has left the grid."""
SHADES = 254
"""Number of quantization steps between the limits of a field; the next value represents NaN."""


def places(position: np.ndarray, there: np.ndarray, low: np.ndarray, span: np.ndarray) -> np.ndarray:
    """Return quantized positions, shape (3, n): numbers of steps (integers) from the corner `low` of a box with the sides
    `span` [m], shape (3,) each.

    position: positions [m], shape (n, 3). there: mask of the points that exist, shape (n,); all other points get the value
    GONE.
    """
    sides = np.where(span > 0.0, span, 1.0)
    steps = np.where(there[:, None], (position - low) / sides, 0.0)
    found = np.rint(np.clip(steps, 0.0, 1.0) * LEVELS).astype(np.uint16)
    found[~there] = GONE
    return np.ascontiguousarray(found.T)


def shades(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return the values of a field, shape (n,), quantized to one byte each: 0 at the limit `low`, SHADES at the limit
    `high`; values beyond the limits are clipped. NaN becomes SHADES + 1."""
    known = np.isfinite(values)
    found = np.rint(np.clip((np.where(known, values, low) - low) / (high - low), 0.0, 1.0) * SHADES)
    found[~known] = SHADES + 1
    return found.astype(np.uint8)


class Pack:
    """Writer of a sequence of compressed arrays, for the interactive view. An array with a `key` is stored as the
    difference from the previous array with this key; an array without a key as differences between consecutive numbers."""

    def __init__(self) -> None:
        self._deflate = zlib.compressobj(6)
        self._parts: list[bytes] = []
        self._last: dict[object, np.ndarray] = {}

    def add(self, values: np.ndarray, key: object = None) -> None:
        """Append an array of unsigned integers of one, two or four bytes. key: name of a sequence of similar arrays to
        which the array belongs, such as positions at successive times."""
        flat = np.ascontiguousarray(values).ravel()
        before = self._last.get(key)
        if before is None:
            before = np.concatenate([np.zeros(1, flat.dtype), flat[:-1]]) if flat.size else flat
        if key is not None:
            self._last[key] = flat
        difference = (flat - before).view(flat.dtype.str.replace("u", "i"))  # round the end of the numbers: nothing is lost
        folded = ((difference << 1) ^ (difference >> (8 * flat.itemsize - 1))).view(flat.dtype)  # small ones, of either sign
        self._parts.append(self._deflate.compress(folded.view(np.uint8).reshape(-1, flat.itemsize).T.tobytes()))

    def forget(self) -> None:
        """Discard the previous array of every key, so that the next array with the key is stored in full."""
        self._last.clear()

    def close(self) -> bytes:
        """Finish the compression and return the data of all arrays in zlib's format."""
        return b"".join([*self._parts, self._deflate.flush()])
