"""A cell that a pressure drives through the slit of `stokes.py`: slow flow and an elastic line, by the immersed-boundary method
of Peskin 2002 (Acta Numerica 11, 479), independently of the package. Lengths in micrometres, times in milliseconds, stresses
in pascal; the viscosity is 1 mPa s. Usage: python cell.py CELLS PRESSURE [TABLE]; CELLS: cells in 0.75 micrometres."""

import sys

import numpy as np
from scipy.sparse.linalg import splu
from stokes import END, START, Unknowns, equations

RADIUS, CENTRE = 2.7, 12.0
SHEAR, AREA = 4.0, 10.0  # shear modulus [µN/m]; coefficient of area changes
RISE = 0.1  # duration over which the pressure rises
EVERY = 0.02  # interval between rows of the table
AT_FACES = (np.array([0.0, 0.5]), np.array([0.5, 0.0]))  # places of the first velocities u and v, in cells


class Line:
    """The upper half of the membrane, from its front to its rear on the plane of symmetry."""

    def __init__(self, of: Unknowns) -> None:
        self.of = of
        angle = np.linspace(0.0, np.pi, round(1.5 * np.pi * RADIUS / of.h) + 1)
        self.x = np.stack([CENTRE + RADIUS * np.cos(angle), RADIUS * np.sin(angle)], axis=1)
        self.x[-1, 1] = 0.0
        self.rest = self.lengths()

    def lengths(self) -> np.ndarray:
        return np.linalg.norm(np.diff(self.x, axis=0), axis=1)

    def forces(self) -> np.ndarray:
        """Return the forces on the nodes by Skalak's law without strain across the plane: a tension G (1 + C) λ (λ² - 1)."""
        stretch = self.lengths() / self.rest
        tension = SHEAR * (1.0 + AREA) * stretch * (stretch**2 - 1.0)
        pull = (tension / self.lengths())[:, None] * np.diff(self.x, axis=0)
        force = np.zeros_like(self.x)
        force[:-1] += pull
        force[1:] -= pull
        force[[0, -1], 1] = 0.0
        return force

    def around(self, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the unknowns around each node along an axis, and their weights, shape (n, 16): cosines that reach two cells;
        0 in walls. Unknowns below the plane of symmetry are mirrored."""
        at = self.x / self.of.h - AT_FACES[axis]
        near = (np.floor(at).astype(int) - 1)[:, :, None] + np.arange(4)
        weight = 0.25 * (1.0 + np.cos(0.5 * np.pi * (near - at[:, :, None])))
        below = near[:, 1] < 0
        j = np.where(below, -near[:, 1] - (axis == 0), near[:, 1])
        across = np.where(below & (axis == 1), -weight[:, 1], weight[:, 1])
        number = (self.of.u, self.of.v)[axis][near[:, 0, :, None], j[:, None, :]].reshape(len(at), 16)
        product = (weight[:, 0, :, None] * across[:, None, :]).reshape(len(at), 16)
        return np.maximum(number, 0), np.where(number >= 0, product, 0.0)

    def area(self) -> float:
        x, y = self.x.T
        return float(abs(np.sum((y[1:] + y[:-1]) * np.diff(x))))


def passage(n: int, pressure: float) -> list[tuple[float, ...]]:
    """Return times, places of front and rear, largest half height in the slit, relative change of the area and largest stretch
    until the cell has passed. n: cells in 0.75; pressure: difference between the ends of the channel."""
    of = Unknowns(n)
    matrix, right = equations(of)
    solve = splu(matrix).solve
    driven, line, rows = solve(right), Line(of), []
    area, dt, t = line.area(), 0.15 * of.h / (SHEAR * (1.0 + AREA)), 0.0

    def velocity(time: float) -> np.ndarray:
        force, load, around = line.forces(), np.zeros(of.count), [line.around(axis) for axis in (0, 1)]
        for axis, (number, weight) in enumerate(around):
            np.subtract.at(load, number, weight * force[:, axis, None])
        flow = solve(load) + pressure * min(time / RISE, 1.0) * driven
        return np.stack([np.sum(flow[number] * weight, axis=1) for number, weight in around], axis=1)

    while line.x[-1, 0] < END + 1.0:
        if t >= EVERY * len(rows):
            x, y = line.x.T
            height = np.max(y, initial=0.0, where=(x > START) & (x < END))
            stretch = np.max(line.lengths() / line.rest)
            rows.append((t, x.max(), x.min(), height, line.area() / area - 1.0, stretch))
        before = line.x.copy()
        line.x = before + 0.5 * dt * velocity(t)
        line.x = before + dt * velocity(t + 0.5 * dt)
        line.x[[0, -1], 1] = 0.0
        t += dt
    return rows


if __name__ == "__main__":
    found = np.array(passage(int(sys.argv[1]), float(sys.argv[2])))
    for name, place, column in (
        ("front at the slit", START, 1),
        ("front", END, 1),
        ("rear at the slit", START, 2),
        ("rear", END, 2),
    ):
        print(f"{name}: {np.interp(place, found[:, column], found[:, 0]):.4f} ms")
    print(f"largest half height in the slit {found[:, 3].max():.3f}, area {100 * found[-1, 4]:+.2f} %")
    if len(sys.argv) > 3:
        head = "# Front and rear of a cell that a pressure drives through a slit: validation/slit/cell.py"
        header = f"{head}\ntime [ms],front [um],rear [um]"
        np.savetxt(sys.argv[3], found[:, :3], fmt="%.5g", delimiter=",", header=header, comments="")
