"""Nodal forces of a pressure along the normals of a membrane."""

from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_vector, stencil
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.materials.damage import has_failed


@parallel_loop_by_colour(gives="load")
def press(s, mapped, surface, load, pressure):
    """Add the forces of a pressure [Pa] along the normals of a membrane's points in slab s (a layer of grid cells) to the
    nodal forces `load` [N].

    mapped: data of the points for transfers to the grid; surface: a `StrainedMembrane`. Points that have failed leave a hole,
    on which no pressure acts.
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    start, corners = surface.fans.start, surface.fans.corners
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if has_failed(surface.damage, surface.record, p):
            continue
        fx = fy = fz = 0.0
        for t in range(start[p], start[p + 1]):
            i, j = corners[t, 0], corners[t, 1]
            ax, ay, az = x[i, 0] - x[p, 0], x[i, 1] - x[p, 1], x[i, 2] - x[p, 2]
            bx, by, bz = x[j, 0] - x[p, 0], x[j, 1] - x[p, 1], x[j, 2] - x[p, 2]
            fx += ay * bz - az * by
            fy += az * bx - ax * bz
            fz += ax * by - ay * bx
        # a third of the vector area of each triangle: over a closed surface these sum to zero exactly
        force = (pressure / 6.0 * fx, pressure / 6.0 * fy, pressure / 6.0 * fz)
        add_vector(stencil(functions, lattice, x, p), lattice, load, force)
