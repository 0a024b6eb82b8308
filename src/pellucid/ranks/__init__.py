"""Parallel simulation: several processes share one simulation. Each process owns some rows of slabs of the grid. Results
agree bit for bit with those of one process."""
