"""The memory of a grid."""

import pytest

from pellucid.grid.nodal_fields import aligned_rows
from pellucid.jit.kernels import LINE


@pytest.mark.parametrize("n", [1, 7, 1000])
def test_rows_of_nodes_lie_within_lines_of_the_cache(n):
    rows = aligned_rows(n)
    assert rows.shape == (n, 4)
    assert rows.ctypes.data % LINE == 0
    assert rows.flags.c_contiguous
    assert not rows.any()
