"""Forces of a pressure that follows a membrane."""

from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.jit import kernel


@kernel()
def _press_slab(mapped, fans, load, pressure, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    start, corners = fans.content[0]
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        fx = fy = fz = 0.0
        for t in range(start[p], start[p + 1]):
            q, r = corners[t, 0], corners[t, 1]
            ax, ay, az = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
            bx, by, bz = x[r, 0] - x[p, 0], x[r, 1] - x[p, 1], x[r, 2] - x[p, 2]
            fx += ay * bz - az * by
            fy += az * bx - ax * bz
            fz += ax * by - ay * bx
        # a third of the vector area of each triangle: over a closed surface these sum to zero exactly
        fx, fy, fz = pressure / 6.0 * fx, pressure / 6.0 * fy, pressure / 6.0 * fz
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c]
                    load[I, 0] += w * fx
                    load[I, 1] += w * fy
                    load[I, 2] += w * fz


@kernel(parallel=True)
def press(n, mapped, fans, load, pressure):
    """Forces of a pressure [Pa] along the normals of a membrane's points, added to the nodes' `load` [N]."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _press_slab(mapped, fans, load, pressure, 2 * half + colour)
