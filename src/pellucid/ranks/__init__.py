"""Several processes that share one simulation, each with some rows of slabs of the grid, and with the bits of one process."""
