"""Passes over the points of a body, and the loop that executes them.

A pass is a NamedTuple of data that stays constant from step to step, such as a law. It declares the arrays that it reads,
the values that it gathers from the nodes, its output and its sums (`points_pass`). Its functions compute one point, in
scalar code. The loop (`each_point`) handles slabs, blocks, sequences of points with the same nodes, vectors, prefetching,
faults and ordered sums. `gifts` declares the contributions of points to the nodes in the same way.
"""
