"""Check of the precision of the coordinates of a file against the edge lengths of its mesh."""

import re

import numpy as np

from pellucid.geometry.files.contents import Contents
from pellucid.geometry.files.words import as_utf8
from pellucid.system.input_files import file_bytes

WORST = 0.01  # of the edge length: spacing of the coordinates above which the mesh is distorted
SHARE = 0.1  # quantile of the edge lengths that the spacing is compared with
FAR = 100.0  # distance from the origin in extents, above which the digits of a text file are counted
MOST_DIGITS = 7  # digits of single precision, which many programs write to text files
MOST_BYTES = 20_000_000  # number of bytes of a text file that are examined
NUMBER = re.compile(rb"(?<![\w.])[-+]?(\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")


def precision_notes(path: str, contents: Contents) -> tuple[str, ...]:
    """Return notes that warn if the coordinates in a file are too coarse for the edges of its mesh, e.g. in single
    precision far from the origin."""
    points = contents.points
    edges = [
        np.linalg.norm(points[nodes[:, k]] - points[nodes[:, k - 1]], axis=1)
        for base, nodes in ((block.base, block.nodes) for block in contents.blocks)
        if base not in (None, "vertex") and nodes.dtype.kind in "iu"
        for k in range(2 if base == "line" else 3)
    ]
    lengths = np.concatenate([np.zeros(0), *edges])
    lengths = lengths[lengths > 0.0]
    if not len(lengths):
        return ()
    spacing, reason = _spacing(path, points, contents.is_single)
    typical = float(np.quantile(lengths, SHARE, method="lower"))
    if not spacing > WORST * typical:
        return ()
    largest = float(np.abs(points).max())
    text = f"coordinates are only accurate to {spacing:.2g} ({reason} at {largest:.3g}), but edges are {typical:.2g} long"
    return (f"{text}, in the unit of the file; move the mesh to the origin before exporting it",)


def _spacing(path: str, points: np.ndarray, is_single: bool) -> tuple[float, str]:
    """Return the distance between neighbouring numbers that the file can store at the largest coordinate, in the unit of the
    file, and the reason in words. is_single: the file stores single precision.

    The distance is 0 if the file has more digits than single precision.
    """
    size = np.abs(points)
    largest = float(size.max())
    if not 0.0 < largest < float(np.finfo(np.float32).max):
        return 0.0, ""
    single = float(np.spacing(np.float32(largest)))
    coarse = points[size > 0.5 * largest]
    if is_single:
        return single, "single precision"
    if (points.astype(np.float32) == points).all() and (coarse / single % 2 == 1).any():
        return single, "numbers of single precision"
    if largest <= FAR * float(np.ptp(points, axis=0).max()):
        return 0.0, ""
    digits = _digits(path, largest)
    return (10.0 ** (np.floor(np.log10(largest)) + 1 - digits), f"{digits} digits") if 0 < digits <= MOST_DIGITS else (0.0, "")


def _digits(path: str, largest: float) -> int:
    """Return the largest number of digits, including trailing zeros, among the coordinates in a text file whose magnitude is
    at least half the largest; 0 for a binary file."""
    data = as_utf8(file_bytes(path)[:MOST_BYTES])
    if b"\0" in data:
        return 0
    found = 0
    for word in NUMBER.finditer(data):
        if 0.5 * largest <= abs(float(word[0])) <= largest * (1.0 + 1e-12):
            found = max(found, len(word[1].replace(b".", b"").lstrip(b"0")))
    return found
