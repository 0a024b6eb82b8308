"""Strips and fans of triangles, as PLY and VTK files have them."""

from itertools import pairwise

RESTART = -1
"""Number that ends a strip and starts another one in the same list."""


def triangles_of_strip(strip: list[int]) -> list[list[int]]:
    """Return the triangles of a strip: every second one is turned, so that all face one side; those without area, by which
    programs join strips, are left out."""
    triangles: list[list[int]] = []
    for part in _parts(strip):
        corners = zip(part, part[1:], part[2:], strict=False)
        turned = ([a, b, c] if k % 2 == 0 else [b, a, c] for k, (a, b, c) in enumerate(corners))
        triangles += [triangle for triangle in turned if len(set(triangle)) == 3]
    return triangles


def triangles_of_fan(fan: list[int]) -> list[list[int]]:
    """Return the triangles of a fan, which all have its first vertex."""
    triangles = [[part[0], a, b] for part in _parts(fan) for a, b in pairwise(part[1:])]
    return [triangle for triangle in triangles if len(set(triangle)) == 3]


def _parts(corners: list[int]) -> list[list[int]]:
    parts: list[list[int]] = [[]]
    for corner in corners:
        if corner == RESTART:
            parts.append([])
        else:
            parts[-1].append(corner)
    return [part for part in parts if part]
