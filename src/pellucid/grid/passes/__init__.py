"""Passes over the points of a body, and the one loop that does them.

A pass is a NamedTuple of what stays the same from step to step, such as a law. It declares what it reads, gathers from the
nodes, keeps, and sums (`points_pass`); its functions are those of one point, in scalar code. The loop (`each_point`) owns the
rest: slabs, blocks, runs of points with the same nodes, vectors, prefetching, faults, and sums in order. `gifts` declares
likewise what points give to the nodes.
"""
