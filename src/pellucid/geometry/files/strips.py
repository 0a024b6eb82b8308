"""Triangle strips and fans, as in PLY and VTK files."""

from itertools import pairwise

RESTART = -1
"""Number that separates two strips in one list."""


def triangles_of_strip(strip: list[int]) -> list[list[int]]:
    """Return the triangles of a strip, in which every three consecutive vertices form a triangle. Every second triangle is
    reversed, so that all have the same orientation.

    Triangles without area, which programs insert to join strips, are omitted.
    """
    triangles: list[list[int]] = []
    for part in _parts(strip):
        corners = zip(part, part[1:], part[2:], strict=False)
        turned = ([a, b, c] if k % 2 == 0 else [b, a, c] for k, (a, b, c) in enumerate(corners))
        triangles += [triangle for triangle in turned if len(set(triangle)) == 3]
    return triangles


def triangles_of_fan(fan: list[int]) -> list[list[int]]:
    """Return the triangles of a fan: each has the first vertex of the fan and two consecutive vertices. Triangles with a
    repeated vertex are omitted."""
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
