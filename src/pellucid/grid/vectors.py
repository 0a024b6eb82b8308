"""Vectors between points and nodes: forces and other vectors that points have, to the nodes; nodal vectors to the points."""

from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.jit import kernel


@kernel()
def _scatter_vectors_slab(mapped, values, target, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c]
                    for d in range(3):
                        target[I, d] += w * values[p, d]


@kernel(parallel=True)
def scatter_vectors(n, mapped, values, target):
    """Add vectors that the points of n slabs have, shape (points, 3), to those of the nodes, shape (nodes, 3)."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _scatter_vectors_slab(mapped, values, target, 2 * half + colour)


@kernel()
def _gather_vectors_slab(mapped, nodal, target, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        vx = vy = vz = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c]
                    vx += w * nodal[I, 0]
                    vy += w * nodal[I, 1]
                    vz += w * nodal[I, 2]
        target[p, 0], target[p, 1], target[p, 2] = vx, vy, vz


@kernel(parallel=True)
def gather_vectors(n, mapped, nodal, target):
    """Nodal vectors, shape (nodes, 3), at the points of n slabs into `target`, shape (points, 3)."""
    for s in prange(n):
        _gather_vectors_slab(mapped, nodal, target, s)
