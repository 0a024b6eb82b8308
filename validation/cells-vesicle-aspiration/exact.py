"""Reference curve of cells/vesicle-aspiration.

    python validation/cells-vesicle-aspiration/exact.py > src/pellucid/gallery/cells/vesicle-aspiration.csv
    python validation/cells-vesicle-aspiration/exact.py table

A vesicle of radius 1 keeps its volume, and its tension is the same all over: T = K ΔA/A with K = 1. So it is made of two
spheres, a cylinder in the mouth, and what lies on the mouth's rounded edge, an arc in the meridian; spheres and cylinder touch
that arc or each other with the same tangent. The suction is 2T (1/R_cap - 1/R_v). Lengths count from LEVEL of the edge's radius
within, since as much membrane goes round it as into a sharp mouth there. Needs scipy.
"""

import sys

import numpy as np
from scipy.optimize import brentq

MOUTH, EDGE, LEVEL = 0.25, 0.05, 0.415
END, LARGEST = 140.0, 0.37  # s and Pa of the case, in which the suction grows with the square of the time
VOLUME, AREA = 4 / 3 * np.pi, 4 * np.pi
MIDDLE = MOUTH + EDGE  # radius of the middle of the edge's arc, which is EDGE above the face


def cap(radius, angle):
    """Area and volume of a cap of a sphere, by the angle at its centre."""
    low = 1 - np.cos(angle)
    return np.array([2 * np.pi * radius**2 * low, np.pi * radius**3 * low**2 * (2 + np.cos(angle)) / 3])


def round_the_edge(first, last):
    """Area of the arc between two angles, and volume within, by Gauss' rule."""
    x, w = np.polynomial.legendre.leggauss(40)
    angle, w = first + (last - first) * (x + 1) / 2, w * (last - first) / 2
    radius = MIDDLE - EDGE * np.cos(angle)
    return np.array([w @ (2 * np.pi * radius * EDGE), w @ (np.pi * radius**2 * EDGE * np.cos(angle))])


def meets(radius, centre):
    """The angle on the arc at which a sphere about a height touches it, and the sphere's own from the axis to there."""
    return np.arctan2(centre - EDGE, MIDDLE), np.arcsin(MIDDLE / (radius + EDGE))


def shape(height, radius):
    """Area and volume with the pole at a height over the face, and a sphere of a radius outside; radius of the cap."""
    if height >= MOUTH + EDGE:
        inside, top, curved = cap(MOUTH, np.pi / 2), 0.0, MOUTH
        long = height - MOUTH - EDGE
        inside = inside + np.array([2 * np.pi * MOUTH * long, np.pi * MOUTH**2 * long])
    else:
        curved = brentq(lambda R: np.hypot(MIDDLE, height - R - EDGE) - R - EDGE, MOUTH, 100.0)
        top, angle = meets(curved, height - curved)
        inside = cap(curved, angle)
    centre = EDGE - np.sqrt((radius + EDGE) ** 2 - MIDDLE**2)
    bottom, angle = meets(radius, centre)
    outside = np.array([4 * np.pi * radius**2, 4 / 3 * np.pi * radius**3]) - cap(radius, angle)
    return *(inside + round_the_edge(bottom, top) + outside), curved


def state(length):
    """Share by which the area is larger, and suction."""
    height = length + LEVEL * EDGE
    radius = brentq(lambda R: shape(height, R)[1] - VOLUME, 0.8, 1.2)
    area, _, curved = shape(height, radius)
    more = area / AREA - 1
    return more, 2 * more * (1 / curved - 1 / radius)


def main():
    if sys.argv[1:] == ["table"]:
        for times in (1, 2, 3):
            more, suction = state(times * MOUTH)
            print(f"{times}: area {more:.5f}, suction {suction:.5f}, at {END * np.sqrt(suction / LARGEST):.3f} s")
        return
    print("# Length of a vesicle in the mouth of a pipette: spheres, a cylinder and a rounded edge under one tension")
    print("# validation/cells-vesicle-aspiration/exact.py")
    print("time [s],length [m],suction [Pa],area_excess")
    for length in np.arange(0.175, 0.801, 0.025):
        more, suction = state(length)
        print(f"{END * np.sqrt(suction / LARGEST):.4f},{length:.3f},{suction:.6f},{more:.6f}")


if __name__ == "__main__":
    main()
