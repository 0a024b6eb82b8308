"""Rows of four numbers, a vector and a scalar, at nodes beyond the ends of an axis, see `pellucid.grid.folding`.

They are SIMD vectors, so this module needs numba, which reading a case does not import.
"""

from typing import Any

from numpy import uintp

from pellucid.grid.folding import Mirrored, real_node
from pellucid.jit import default_function, generic, point_function
from pellucid.jit.vector import load, row, store


@generic
def row_at(folding: Any, rows: Any, number: Any) -> Any:
    """Return the row of four numbers, a vector and a scalar, at the node with this number in a stencil; rows: nodal rows, shape
    (4 nodes,); folding: `Walled`, `Folded` or `Mirrored`."""


@generic
def add_to_row(folding: Any, rows: Any, number: Any, value: Any) -> Any:
    """Add a row of four numbers, a vector and a scalar, to nodal rows, shape (4 nodes,), at the node with this number in a
    stencil; folding: `Walled`, `Folded` or `Mirrored`."""


@generic
def signs_at(folding: Any, number: Any) -> Any:
    """Return the factors of a vector along x, y, z and of a scalar at the node with this number in a stencil, a row of four
    numbers: -1 for the normal component at a node beyond a plane of symmetry, else 1; folding: `Walled`, `Folded` or
    `Mirrored`."""


@default_function(row_at)
def _row(folding, rows, number):
    return load(rows, 4 * real_node(folding, number))


@point_function(row_at, Mirrored)
def _row_of_image(folding, rows, number):
    q = uintp(number + folding.shift)
    return load(folding.sign, 4 * q) * load(rows, 4 * uintp(folding.real[q]))


@default_function(add_to_row)
def _add_to_row(folding, rows, number, value):
    I = 4 * real_node(folding, number)
    store(rows, I, load(rows, I) + value)


@point_function(add_to_row, Mirrored)
def _add_to_row_of_image(folding, rows, number, value):
    q = uintp(number + folding.shift)
    I = 4 * uintp(folding.real[q])
    if folding.beyond[q] == 0:
        store(rows, I, load(rows, I) + value)
        return
    store(rows, I, load(rows, I) + load(folding.sign, 4 * q) * value)
    x, y, z = row(2.0, 0.0, 0.0, 0.0), row(0.0, 2.0, 0.0, 0.0), row(0.0, 0.0, 2.0, 0.0)
    for axis, twice in ((0, x), (1, y), (2, z)):
        if folding.face[q, axis] >= 0:
            J = 4 * uintp(folding.face[q, axis])
            store(rows, J, load(rows, J) + twice * value)


@default_function(signs_at)
def _no_signs(folding, number):
    return row(1.0, 1.0, 1.0, 1.0)


@point_function(signs_at, Mirrored)
def _signs(folding, number):
    return load(folding.sign, 4 * uintp(number + folding.shift))
