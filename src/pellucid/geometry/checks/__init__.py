"""Mesh checks: faults, element quality, and repairs; phrases of their messages."""

import numpy as np

Fault = tuple[str, str]
"""Description of a fault, and its remedy."""

REPAIR = "for a mesh file, set `repair = true`, or run `pellucid mesh FILE --repair --out NEW`"
"""End of a remedy that the program can apply."""


def counted(n: int, one: str, many: str) -> str:
    """Return a number with its noun and verb: "1 element was" or "3 elements were"; one, many: noun and verb in the singular
    and the plural."""
    return f"{n} {one if n == 1 else many}"


def in_file(position: np.ndarray) -> str:
    """Return spatial coordinates read from a geometry file as text for messages, in the unit of the file."""
    return "at ({:.6g}, {:.6g}, {:.6g}), in the unit of the file".format(*position)
