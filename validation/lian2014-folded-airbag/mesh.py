"""A flat bag of two layers, folded in two, three or more, as a slice between two planes or as a whole with closed ends.

    python mesh.py folded.obj [--folds 2] [--width 0.3] [--length 0.02] [--gap 0.003] [--ends open|closed]
    python mesh.py check

The middle line of the flat bag goes to and fro: straight parts of equal length, joined by half circles that turn to alternate
sides. Each layer lies half the gap to its side of that line. Both layers have the same length if the number of folds is even;
if it is odd, the outer layer is longer by pi times the gap. Near the rims the layers come together, over three gaps.
Neighbouring parts of the stack are two gaps apart, so that no two sheets are closer than the gap except at the rims, where
they are one. The gap must be larger than the thickness, for example 1.5 times the thickness.

The mesh is at rest as it is written. A slice with open ends lies between planes of symmetry: when inflated, its cross-section
is a circle with the circumference of both layers. Needs numpy.
"""

import argparse
import sys
from typing import NamedTuple

import numpy as np

from pellucid.gallery.lian2014.airbags import crossings

TAPER = 3.0  # gaps
PER_BEND = 4  # elements along a half circle: the shortest, on its inner side, are 0.77 gaps long and longer than the thickness


class Bag(NamedTuple):
    vertices: np.ndarray
    """(n, 3): x along the folded parts, y along the folds, z across the stack [m]."""
    triangles: np.ndarray
    circumference: float
    """Of both layers in a section across the folds [m]."""


def middle_line(folds: int, width: float, gap: float, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, unit normals and arc lengths along the folded middle line, whose length is the width."""
    radius = 1.5 * gap
    straight = (width - folds * np.pi * radius) / (folds + 1)
    if straight < 2 * TAPER * gap:
        raise ValueError(f"straight parts of {straight:g} m are too short for {folds} folds: use fewer, or a smaller gap")
    n = max(4, int(np.ceil(straight / size)))
    points, angles, lengths = [], [], []
    x, z, direction, done = 0.0, 0.0, 1.0, 0.0
    for part in range(folds + 1):
        for s in np.linspace(0.0, 1.0, n + 1)[(1 if part else 0) :]:
            points.append((x + direction * straight * s, z))
            angles.append(0.0 if direction > 0 else np.pi)
            lengths.append(done + straight * s)
        x, done = x + direction * straight, done + straight
        if part < folds:
            for s in np.linspace(0.0, 1.0, PER_BEND + 1)[1:]:
                turn = np.pi * s
                points.append((x + direction * radius * np.sin(turn), z + radius * (1 - np.cos(turn))))
                angles.append(turn if direction > 0 else np.pi - turn)
                lengths.append(done + radius * turn)
            z, done, direction = z + 2 * radius, done + np.pi * radius, -direction
    angle = np.array(angles)
    return np.array(points), np.stack([-np.sin(angle), np.cos(angle)], axis=1), np.array(lengths)


def folded_bag(folds: int, width: float, length: float, gap: float, size: float, closed: bool) -> Bag:
    """A bag of a width across the folds and a length along them; elements of about a size."""
    line, normals, s = middle_line(folds, width, gap, size)
    rows = max(2, int(np.ceil(length / size))) + 1
    y = np.linspace(0.0, length, rows)
    to_rim = np.broadcast_to(np.minimum(s, width - s)[:, None], (len(s), rows)).copy()
    if closed:
        to_rim = np.minimum(to_rim, np.minimum(y, length - y)[None, :])
    half = 0.5 * gap * np.clip(to_rim / (TAPER * gap), 0.0, 1.0)
    sides = []
    for side in (1.0, -1.0):
        across = line[:, None, :] + side * half[:, :, None] * normals[:, None, :]
        sides.append(np.stack([across[..., 0], np.broadcast_to(y, half.shape), across[..., 1]], axis=-1))
    number = np.arange(half.size).reshape(half.shape)
    other = number.copy()
    inner = to_rim > 1e-12 * width
    other[inner] = half.size + np.arange(np.count_nonzero(inner))
    vertices = np.concatenate([sides[0].reshape(-1, 3), sides[1][inner]])
    triangles = []
    for numbers, outward in ((number, 1), (other, -1)):
        a, b, c, d = numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]
        flip = (np.add.outer(np.arange(a.shape[0]), np.arange(a.shape[1])) % 2 == 0)[..., None]
        flip[[0, -1], [0, -1]], flip[[0, -1], [-1, 0]] = True, False  # diagonals from the corners of the bag inwards
        one = np.where(flip, np.stack([a, b, c], -1), np.stack([a, b, d], -1)).reshape(-1, 3)
        two = np.where(flip, np.stack([a, c, d], -1), np.stack([b, c, d], -1)).reshape(-1, 3)
        both = np.concatenate([one, two])
        triangles.append(both if outward > 0 else both[:, ::-1])
    loop = np.concatenate([sides[0][:, rows // 2], sides[1][::-1, rows // 2]])
    around = float(np.linalg.norm(np.diff(loop, axis=0), axis=1).sum())
    return Bag(vertices, distinct(np.concatenate(triangles)), around)


def distinct(triangles: np.ndarray) -> np.ndarray:
    """Without triangles whose corners both layers share at a corner of the bag."""
    key = np.sort(triangles, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    if np.any(count > 1):
        raise ValueError("a triangle belongs to both layers: use smaller elements")
    return triangles[np.sort(first)]


def volume(bag: Bag) -> float:
    """Volume between the layers, open ends included: half the flux of (x, 0, z), which does not pass planes across y."""
    a, b, c = (bag.vertices[corner] for corner in bag.triangles.T)
    areas, middles = 0.5 * np.cross(b - a, c - a), (a + b + c) / 3.0
    return 0.5 * float(np.sum((areas * middles)[:, [0, 2]]))


def nearest_sheets(bag: Bag, beyond: float) -> float:
    """Least distance of vertices whose ways along the mesh are longer than a length: how far the sheets are apart."""
    import heapq

    neighbours: list[set[int]] = [set() for _ in bag.vertices]
    for triangle in bag.triangles:
        for i, j in ((0, 1), (1, 2), (2, 0)):
            neighbours[triangle[i]].add(int(triangle[j]))
            neighbours[triangle[j]].add(int(triangle[i]))
    least = np.inf
    for start in range(0, len(bag.vertices), 7):
        ways, heap = {start: 0.0}, [(0.0, start)]
        while heap:
            way, at = heapq.heappop(heap)
            if way > ways[at]:
                continue
            for to in neighbours[at]:
                new = way + float(np.linalg.norm(bag.vertices[to] - bag.vertices[at]))
                if new < beyond and new < ways.get(to, np.inf):
                    ways[to] = new
                    heapq.heappush(heap, (new, to))
        far = np.setdiff1d(np.arange(len(bag.vertices)), list(ways))
        if len(far):
            least = min(least, float(np.linalg.norm(bag.vertices[far] - bag.vertices[start], axis=1).min()))
    return least


def write(bag: Bag, path: str) -> None:
    """As an OBJ file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in bag.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in bag.triangles + 1]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def check() -> None:
    print("folds, ends, vertices, triangles, crossings, distance of sheets/gap, circumference/(2 width), volume")
    for folds in (1, 2, 3):
        for closed in (False, True):
            bag = folded_bag(folds, 0.3, 0.15 if closed else 0.02, 0.003, 0.008, closed)
            edges = np.sort(np.concatenate([bag.triangles[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0))]), axis=1)
            count = np.unique(np.unique(edges, axis=0, return_counts=True)[1])
            near = nearest_sheets(bag, 8 * 0.003)
            print(folds, "closed" if closed else "open", len(bag.vertices), len(bag.triangles), crossings(*bag[:2]), end=" ")
            print(f"{near / 0.003:.3f} {bag.circumference / 0.6:.5f} {volume(bag):.4g} edges of {count} triangles", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("path")
    parser.add_argument("--folds", type=int, default=2)
    parser.add_argument("--width", type=float, default=0.3)
    parser.add_argument("--length", type=float, default=0.02)
    parser.add_argument("--gap", type=float, default=0.003)
    parser.add_argument("--size", type=float, default=0.008)
    parser.add_argument("--ends", choices=("open", "closed"), default="open")
    chosen = parser.parse_args()
    bag = folded_bag(chosen.folds, chosen.width, chosen.length, chosen.gap, chosen.size, chosen.ends == "closed")
    write(bag, chosen.path)


if __name__ == "__main__":
    check() if sys.argv[1:] == ["check"] else main()
