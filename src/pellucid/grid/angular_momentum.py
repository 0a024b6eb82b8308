"""Angular momentum of points, with that of their affine velocity fields: what they give to the nodes of the grid."""

from math import sqrt

from pellucid.grid.affine import spread_along
from pellucid.grid.points import place_of
from pellucid.grid.stencil import stencil
from pellucid.jit.loops import parallel_loop


@parallel_loop()
def sum_angular_momentum(s, mapped, affine, about, sums):
    """Add up Σ m (x - a) × v of the points of n slabs about a place a [m], shape (3,), and the size Σ m |x - a| |v| [N m s].

    affine: fields of APIC, shape (points, 10), of which Σ m N r × C r over the nodes at r from the point counts too; no rows of
    points without. sums: (slabs, 4), filled.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, v, slabs = mapped.points.position, mapped.points.velocity, mapped.slabs
    hx = hy = hz = size = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        m = mapped.points.mass[p]
        rx, ry, rz = x[p, 0] - about[0], x[p, 1] - about[1], x[p, 2] - about[2]
        hx += m * (ry * v[p, 2] - rz * v[p, 1])
        hy += m * (rz * v[p, 0] - rx * v[p, 2])
        hz += m * (rx * v[p, 1] - ry * v[p, 0])
        vv = v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2]
        size += m * sqrt((rx * rx + ry * ry + rz * rz) * vv)
        if len(affine) > 0:
            near, C = stencil(functions, lattice, x, p), affine[p]
            m *= lattice.cell * lattice.cell
            # Σ N r r is diagonal, since Σ w r is zero along each axis
            dx, dy = m * spread_along(near.offset[0], near.wx), m * spread_along(near.offset[1], near.wy)
            dz = m * spread_along(near.offset[2], near.wz)
            hx += dy * C[7] - dz * C[5]
            hy += dz * C[2] - dx * C[6]
            hz += dx * C[3] - dy * C[1]
    sums[s, 0], sums[s, 1], sums[s, 2], sums[s, 3] = hx, hy, hz, size
