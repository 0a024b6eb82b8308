"""Words of messages about meshes: what is wrong with them, and what was mended."""

import numpy as np

Fault = tuple[str, str]
"""What is wrong, and a remedy."""

REPAIR = "of a file, `repair = true` does it, or `pellucid mesh FILE --repair --out NEW`"
"""How a remedy ends that a program can apply."""


def counted(n: int, one: str, many: str) -> str:
    """How many there are: "1 element was" or "3 elements were"."""
    return f"{n} {one if n == 1 else many}"


def in_file(position: np.ndarray) -> str:
    """Where something is that a reader finds in the file."""
    return "at ({:.6g}, {:.6g}, {:.6g}), in the unit of the file".format(*position)
