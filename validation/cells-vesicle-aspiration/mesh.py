"""The vesicle of cells/vesicle-aspiration: a sphere with its pole below the mouth, in quadrilaterals that are cut in two there.

    python validation/cells-vesicle-aspiration/mesh.py > src/pellucid/gallery/cells/vesicle-aspiration.obj

Two rounded squares at the poles, rings between these. Rings that come to the mouth's edge lie close, the others far apart.
"""

import numpy as np

ACROSS = 4  # half the quadrilaterals along an edge of a square, an eighth of those round
POLE = 0.023  # height of the pole
NEAR, LAST, FAR = 0.16, 0.8, np.pi - 0.3  # angles of the first ring, of the last that passes the mouth, of the last
SPACING, MOUTH = 0.019, 0.25
CORNER, GROWTH, WIDEST = 0.8, 1.15, 0.13


def rings():
    """Angles from the pole."""
    found = [NEAR]
    while found[-1] < LAST:
        found.append(found[-1] + min(SPACING, 1.6 * SPACING * MOUTH / np.sin(found[-1])))
    step = found[-1] - found[-2]
    while found[-1] < FAR:
        step = min(GROWTH * step, WIDEST)
        found.append(found[-1] + step)
    return [*found[:-1], FAR]


def square(angle):
    """Places (x, y) in a rounded square of an angle from the pole, quadrilaterals, and its rim, leftwards from x on."""
    places, number = [], {}
    for i in range(-ACROSS, ACROSS + 1):
        for j in range(-ACROSS, ACROSS + 1):
            k = max(abs(i), abs(j))
            number[i, j] = len(places)
            if k == 0:
                places.append(np.zeros(2))
                continue
            if abs(i) == k:
                turn = 0.25 * np.pi * j / k if i > 0 else np.pi - 0.25 * np.pi * j / k
            else:
                turn = np.sign(j) * (0.5 * np.pi - 0.25 * np.pi * i / k)
            circle, straight = np.array([np.cos(turn), np.sin(turn)]), CORNER * np.array([i, j]) / k
            roundness = k / ACROSS
            places.append(angle * roundness * ((1 - roundness) * straight + roundness * circle))
    steps = range(-ACROSS, ACROSS)
    quads = [(number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i in steps for j in steps]
    m = ACROSS
    rim = [(m, j) for j in range(m)] + [(i, m) for i in range(m, -m, -1)] + [(-m, j) for j in range(m, -m, -1)]
    rim += [(i, -m) for i in range(-m, m)] + [(m, j) for j in range(-m, 0)]
    return places, quads, [number[place] for place in rim]


def on_sphere(angle, turn):
    return np.array([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)])


def main():
    places, quads, rim = square(NEAR)
    nodes = [on_sphere(np.hypot(x, y), np.arctan2(y, x)) for x, y in places]
    round_it = 2 * np.pi * np.arange(8 * ACROSS) / (8 * ACROSS)
    for angle in rings()[1:]:
        new = list(range(len(nodes), len(nodes) + len(rim)))
        nodes += [on_sphere(angle, turn) for turn in round_it]
        quads += [(rim[k - 1], new[k - 1], new[k], rim[k]) for k in range(len(rim))]
        rim = new
    places, inner, own_rim = square(np.pi - FAR)
    number = dict(zip(own_rim, rim, strict=True))
    for k, (x, y) in enumerate(places):
        if k not in number:
            number[k] = len(nodes)
            nodes.append(on_sphere(np.pi - np.hypot(x, y), np.arctan2(y, x)))
    quads += [tuple(number[k] for k in reversed(quad)) for quad in inner]
    for x, y, z in np.where(np.abs(nodes) < 1e-12, 0.0, nodes):
        print(f"v {x:.8g} {y:.8g} {z + POLE - 1:.8g}")
    for quad in quads:
        print("f", *(k + 1 for k in quad))


if __name__ == "__main__":
    main()
