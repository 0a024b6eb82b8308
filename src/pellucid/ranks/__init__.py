"""Parallel simulation: several processes share one simulation. A slab is a block of cells, a few layers thick; each process
owns some rows of slabs of the grid. Results agree bit for bit with a run of one process."""
