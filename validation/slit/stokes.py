"""Slow flow through a slit between two blocks in a channel, by finite differences on a staggered grid: prints, for some grids,
the flow as a share of the law of Poiseuille for the slit and the channel in series. Lengths in micrometres."""

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import spsolve

LENGTH, WIDTH, START, END, SLIT = 39.0, 10.5, 19.5, 24.0, 3.0  # of the channel; of the slit along the channel; its width


class Unknowns:
    """Numbers of the unknowns in half of the channel: velocities u, v at the faces of square cells, pressures at their centres;
    -1 where there is none. n: cells in 0.75."""

    def __init__(self, n: int) -> None:
        self.h = 0.75 / n
        nx, ny = round(LENGTH / self.h), round(0.5 * WIDTH / self.h)
        first, last, above = (round(at / self.h) for at in (START, END, 0.5 * SLIT))
        liquid = np.ones((nx, ny), bool)
        liquid[first:last, above:] = False
        beside = np.ones((nx + 2, ny), bool)
        beside[1:-1] = liquid
        masks = (beside[1:] & beside[:-1], np.pad(liquid[:, 1:] & liquid[:, :-1], ((0, 0), (1, 1))), liquid)
        self.count, numbers = 0, []
        for mask in masks:
            number = np.full(mask.shape, -1)
            number[mask] = self.count + np.arange(mask.sum())
            self.count += mask.sum()
            numbers.append(number)
        self.u, self.v, self.p = numbers


def equations(of: Unknowns) -> tuple[csc_array, np.ndarray]:
    """Return the matrix and the right-hand side of the equations of Stokes, times the square of the cell in rows of velocities.
    The pressure falls by 1 along the channel; the viscosity is 1."""
    u, v, p, h = of.u, of.v, of.p, of.h
    rows, columns, values, right = [], [], [], np.zeros(of.count)

    def add(row: int, column: int, value: float) -> None:
        rows.append(row)
        columns.append(column)
        values.append(value)

    def laplacian(number: np.ndarray, i: int, j: int, along: int) -> None:
        """Add the Laplacian of a velocity along an axis: a wall is half a cell away beside it, and a cell before it."""
        row, diagonal = number[i, j], 0.0
        for axis, step in ((0, -1), (0, 1), (1, -1), (1, 1)):
            to = (i + step, j) if axis == 0 else (i, j + step)
            inside = 0 <= to[0] < number.shape[0] and 0 <= to[1] < number.shape[1]
            if along == 0 and (to[1] < 0 or not 0 <= to[0] < number.shape[0]):
                continue  # a plane of symmetry; developed flow at the ends
            if inside and number[to] >= 0:
                add(row, number[to], 1.0)
                diagonal -= 1.0
            else:
                diagonal -= 1.0 if axis == along else 2.0
        add(row, row, diagonal)

    last = p.shape[0] - 1
    for i, j in np.argwhere(u >= 0):
        laplacian(u, i, j, 0)
        if i == 0:
            add(u[i, j], p[0, j], -2.0 * h)
            right[u[i, j]] = -2.0 * h
        elif i > last:
            add(u[i, j], p[last, j], 2.0 * h)
        else:
            add(u[i, j], p[i, j], -h)
            add(u[i, j], p[i - 1, j], h)
    for i, j in np.argwhere(v >= 0):
        laplacian(v, i, j, 1)
        add(v[i, j], p[i, j], -h)
        add(v[i, j], p[i, j - 1], h)
    for i, j in np.argwhere(p >= 0):
        for number, sign in ((u[i + 1, j], 1.0), (u[i, j], -1.0), (v[i, j + 1], 1.0), (v[i, j], -1.0)):
            if number >= 0:
                add(p[i, j], number, sign)
    return coo_array((values, (rows, columns)), shape=(of.count, of.count)).tocsc(), right


def flow_share(n: int) -> float:
    """Return the flow divided by that of the law of Poiseuille in series; n: cells in 0.75."""
    of = Unknowns(n)
    found = spsolve(*equations(of))
    flow = 2.0 * of.h * found[of.u[len(of.p) // 4]].sum()
    resistance = 12.0 * ((END - START) / SLIT**3 + (LENGTH - END + START) / WIDTH**3)
    return float(flow * resistance)


if __name__ == "__main__":
    for n in (2, 4, 8):
        print(f"{4 * n} cells across the slit: {flow_share(n):.4f}")
