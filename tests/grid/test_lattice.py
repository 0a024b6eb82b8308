"""The memory of a grid."""

import numpy as np
import pytest

from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.nodal_fields import aligned_rows
from pellucid.jit.registry import LINE


@pytest.mark.parametrize("n", [1, 7, 1000])
def test_rows_of_nodes_lie_within_lines_of_the_cache(n):
    rows = aligned_rows(n)
    assert rows.shape == (n, 4)
    assert rows.ctypes.data % LINE == 0
    assert rows.flags.c_contiguous
    assert not rows.any()


@pytest.mark.parametrize("periodic", [(), ("x",), ("y", "z")])
@pytest.mark.parametrize("extent", [(0.4, 0.0, 0.0), (0.0, 0.5, 0.4), (0.4, 0.5, 0.0), (0.4, 0.5, 0.6)])
def test_positions_of_nodes_are_found_by_their_indices(extent, periodic):
    kept = [axis for axis, length in zip("xyz", extent, strict=True) if axis in periodic and length > 0.0]
    grid = Grid(GridCase(lower=(0.2, 0.0, 0.0), upper=(0.2 + extent[0], *extent[1:]), cell=0.1, periodic=kept))
    index, position = grid.where()
    np.testing.assert_array_equal(grid.find_positions(index), position)
