"""How far a volume reaches about the numbered nodes along the normals of a membrane there, which may point either way."""

from numpy import uintp

from pellucid.contact.normals import CENTRE, VOLUME, NumberedNodes, reach_of_point
from pellucid.contact.shared import list_within
from pellucid.grid.folding import seen_from
from pellucid.grid.lattice import LARGEST_STENCIL
from pellucid.grid.nodal_fields import fields_of
from pellucid.grid.passes.blocks import about_lanes, fetch, find_functions, functions_like, run_end
from pellucid.grid.points import ByIndex
from pellucid.grid.stencil import node_at
from pellucid.jit import kernel, pointwise
from pellucid.jit.columns import BLOCK, WIDTH, put, size, take, take_lanes
from pellucid.jit.local import indices, numbers
from pellucid.jit.loops import parallel_loop_by_colour
from pellucid.jit.vector import LANES, larger, load, row, splat, store, total, where_positive
from pellucid.tensors import ZERO_VECTOR

AHEAD, BEHIND, PLACES, VOLUMES, COLUMNS = range(5)
"""Columns of extents: how far points reach along the normal and against it [m]; Σ N_I V x·n [m⁴], Σ N_I V [m³]."""
POINT = ZERO_VECTOR, 0.0, 0.0  # what a block has of a point: place, volume, how far the body reaches beyond it
VOLUME_OF_POINT, REACH = 3, 4  # columns of a block
NOWHERE = tuple(fields_of(NumberedNodes)["extents"].start)


@pointwise
def _nothing_yet(found, number):
    """Let the vectors of a node of the stencil hold nothing."""
    for column in range(COLUMNS):
        store(found, (COLUMNS * number + column) * LANES, splat(NOWHERE[column]))


@pointwise
def _first_lanes(n):
    """Ones in the first n lanes, zeros in the others."""
    return row(1.0, 1.0 if n > 1 else 0.0, 1.0 if n > 2 else 0.0, 1.0 if n > 3 else 0.0)


@pointwise
def _add_lanes(about, lattice, slot, normal, point, present, found):
    """Let the vectors of each node hold these points too; present: 1 in the lanes of points, 0 in others."""
    place, V, r = point
    number = 0
    for a in range(len(about.wx)):
        for b in range(len(about.wy)):
            line = about.wx[a] * about.wy[b] * present
            for c in range(len(about.wz)):
                e, at = slot[node_at(about, lattice, a, b, c)], COLUMNS * LANES * number
                number += 1
                if e >= 0:
                    x, y, z = seen_from(lattice.folding, lattice, about, place, a, b, c)
                    w, along = line * about.wz[c], x * normal[e, 0] + y * normal[e, 1] + z * normal[e, 2]
                    for column, reach in enumerate((r + along, r - along)):
                        before = load(found, at + column * LANES)
                        store(found, at + column * LANES, where_positive(w, larger(reach, before), before))
                    # what lies in lanes of no points may be no number
                    share = where_positive(w, w * V, splat(0.0))
                    moment = where_positive(w, share * along, splat(0.0))
                    store(found, at + PLACES * LANES, load(found, at + PLACES * LANES) + moment)
                    store(found, at + VOLUMES * LANES, load(found, at + VOLUMES * LANES) + share)


@pointwise
def _keep_run(about, lattice, slot, found, extents):
    """Add what the vectors hold to the extents of their nodes; they hold nothing then."""
    number = 0
    for a in range(len(about.wx)):
        for b in range(len(about.wy)):
            for c in range(len(about.wz)):
                e, at = slot[node_at(about, lattice, a, b, c)], COLUMNS * LANES * number
                if e >= 0:
                    for lane in range(LANES):
                        extents[e, AHEAD] = max(extents[e, AHEAD], found[uintp(at + lane)])
                        extents[e, BEHIND] = max(extents[e, BEHIND], found[uintp(at + LANES + lane)])
                    extents[e, PLACES] += total(load(found, at + PLACES * LANES))
                    extents[e, VOLUMES] += total(load(found, at + VOLUMES * LANES))
                    _nothing_yet(found, number)
                number += 1


@parallel_loop_by_colour(gives="extents")
def extents_along(s, mapped, where, normal, radius, extents):
    """Extents of the points of n slabs about each numbered node, an `OfListed` of shape (nodes, COLUMNS), along its normal;
    `NOWHERE` before."""
    functions, lattice, points, slabs = mapped.functions, mapped.lattice, mapped.points, mapped.slabs
    if slabs.first[s] == slabs.first[s + 1]:
        return
    functions_found, first_node = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK)
    listed, c, found = indices(BLOCK), numbers(WIDTH * size(POINT)), numbers(COLUMNS * LANES * LARGEST_STENCIL**3)
    for number in range(functions[0].stencil * functions[1].stencil * functions[2].stencil):
        _nothing_yet(found, number)
    q = slabs.first[s]
    while q < slabs.first[s + 1]:
        n, q = list_within(where, mapped.index, points.position, q, slabs.first[s + 1], listed)
        fetch(ByIndex(listed), (ZERO_VECTOR, 0.0), (points.position, points.volume), 0, n, c, 0)
        find_functions(functions, lattice, n, c, 0, functions_found, first_node)
        for k in range(n):
            put(c, k + REACH * WIDTH, reach_of_point(radius, take(0.0, c, k + VOLUME_OF_POINT * WIDTH)))
        a = 0
        while a < n:
            end = run_end(first_node, a, n)
            if where.near[first_node[a]]:
                for k in range(a, end, LANES):
                    about = about_lanes(functions, functions_found, first_node, k)
                    _add_lanes(about, lattice, where.slot, normal, take_lanes(POINT, c, k), _first_lanes(end - k), found)
                _keep_run(about_lanes(functions, functions_found, first_node, a), lattice, where.slot, found, extents.values)
            a = end


@kernel()
def orient_membrane_normals(surface, volume, sign, normal, foremost):
    """Turn the normals of a membrane from the first side to the second, as `orient` does, for a volume of this sign.

    surface: moments of the membrane; volume: extents of the volume; foremost, (n,): of what it reaches along the normals and
    against them that towards the membrane.
    """
    for e in range(len(normal)):
        a, b, c = normal[e, 0], normal[e, 1], normal[e, 2]
        m = surface[e, VOLUME]
        place = (a * surface[e, CENTRE] + b * surface[e, CENTRE + 1] + c * surface[e, CENTRE + 2]) / m
        ahead = volume[e, PLACES] / volume[e, VOLUMES] >= place
        foremost[e] = volume[e, BEHIND] if ahead else volume[e, AHEAD]
        if ahead == (sign > 0.0):
            normal[e, 0], normal[e, 1], normal[e, 2] = -a, -b, -c
