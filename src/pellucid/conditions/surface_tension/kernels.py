"""Kernels of surface tension: scatter point volumes to the nodes, and scatter the forces of a nodal potential.

Each kernel is written for a slab s, i.e. a set of points that one thread updates; the caller passes the number of slabs
and `mapped`, the bundle of a body's `MappedPoints`.
"""

from pellucid.grid.points import place_of
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour


@parallel_loop_by_colour(gives="target")
def scatter_volumes(s, mapped, target):
    """Add the volumes of the points of slab s, times the shape functions N, to the nodes: `target`, shape (nodes,) [m³].
    mapped: bundle (arrays as the compiled code receives them) of the fluid's `MappedPoints`."""
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about, V = stencil(functions, lattice, points.position, p), points.volume[p]
        wx, wy, wz = about.wx, about.wy, about.wz
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    target[node_at(about, lattice, a, b, c)] += wx[a] * wy[b] * wz[c] * V


@parallel_loop()
def gather_potential(s, mapped, potential, values, sums):
    """Interpolate a nodal potential [J/m³], shape (nodes,), and its gradient [N/m³] to the points of slab s, and store both
    in `values`, shape (points, 4). mapped: bundle of the fluid's `MappedPoints`.

    sums: for each slab the sum of volume times gradient over its points [N], shape (slabs, 3), set here.
    """
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    h, fx, fy, fz = lattice.inverse_cell, 0.0, 0.0, 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        here = x = y = z = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                line = slope = 0.0
                for c in range(len(wz)):
                    at_node = potential[node_at(about, lattice, a, b, c)]
                    line += wz[c] * at_node
                    slope += gz[c] * at_node
                here += wx[a] * wy[b] * line
                x += gx[a] * wy[b] * line
                y += wx[a] * gy[b] * line
                z += wx[a] * wy[b] * slope
        values[p, 0], values[p, 1], values[p, 2], values[p, 3] = here, h * x, h * y, h * z
        V = points.volume[p]
        fx += V * h * x
        fy += V * h * y
        fz += V * h * z
    sums[s, 0], sums[s, 1], sums[s, 2] = fx, fy, fz


@parallel_loop_by_colour(gives="target")
def scatter_forces(s, mapped, values, acceleration, target):
    """Add the forces -V (N ∇φ + φ ∇N) + N m a [N] of the points of slab s to the nodal forces `target`, shape (nodes, 3);
    V: volume and m: mass of a point, N: shape function of a node.

    mapped: bundle of the fluid's `MappedPoints`; values: potential φ [J/m³] and gradient ∇φ [N/m³] at the points, shape
    (points, 4); acceleration: a [m/s²], shape (3,).
    """
    functions, lattice, index, points, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.points, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about, V, m = stencil(functions, lattice, points.position, p), points.volume[p], points.mass[p]
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        slope = -V * lattice.inverse_cell * values[p, 0]
        x, y, z = (
            m * acceleration[0] - V * values[p, 1],
            m * acceleration[1] - V * values[p, 2],
            m * acceleration[2] - V * values[p, 3],
        )
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I, w = node_at(about, lattice, a, b, c), wx[a] * wy[b] * wz[c]
                    target[I, 0] += w * x + slope * gx[a] * wy[b] * wz[c]
                    target[I, 1] += w * y + slope * wx[a] * gy[b] * wz[c]
                    target[I, 2] += w * z + slope * wx[a] * wy[b] * gz[c]
