"""Parallel simulation: several processes share one simulation. Each process owns some rows of slabs of the grid. Results
agree bit for bit with a run of one process."""
