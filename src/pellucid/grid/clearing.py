"""Nodal arrays set to zero before points and conditions give to them.

Rows are cleared by all threads: on a large grid with small bodies that is much of a step.
"""

from typing import Any

import numpy as np

from pellucid.grid.listed import ALL, CHUNK, chunks_of, end_of, listed
from pellucid.grid.nodal_fields import ROW, Cleared, fields_of, views_of
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for


@kernel(inner=True)
def _clear_chunk(chunk, rows, width, node):
    for k in range(len(rows)):
        array = rows[k]
        for e in range(CHUNK * chunk, end_of(chunk, node, len(array) // ROW)):
            at = ROW * listed(node, e)
            if array[at] | array[at + 1] | array[at + 2] | array[at + 3] != 0:  # what is read alone stays out of memory's way
                for d in range(width):
                    array[at + d] = 0


@kernel()
def _clear(chunks, rows, width, node):
    """Set the first numbers, as many as `width` says, of the rows of listed nodes to zero; rows: their bits, as integers."""
    parallel_for(_clear_chunk, chunks, rows, width, node)


class Clearing:
    """Sets to zero what is cleared at one time of some sets of nodal arrays, as it is declared."""

    def __init__(self, cleared: Cleared, *sets: tuple[Any, ...]) -> None:
        self._others, rows, self._width = list[tuple[np.ndarray, Any]](), list[np.ndarray](), ROW
        for arrays in sets:
            for name, field in fields_of(type(arrays)).items():
                if field.cleared == cleared and field.in_rows:
                    rows.append(getattr(arrays, name))
                elif field.cleared == cleared:
                    self._others.append((getattr(arrays, name), field.start))
            for view in views_of(type(arrays)).values():
                if view.cleared == cleared and isinstance(view.part, slice):
                    rows, self._width = [getattr(arrays, view.of)], view.part.stop
        self._rows = tuple(array.view(np.int64) for array in rows if len(array))

    def __call__(self, node: np.ndarray | None = None) -> None:
        """Clear all nodes, or those of a list, shape (m,); fields that are not in rows at all nodes."""
        for array, start in self._others:
            array[...] = start
        if self._rows and node is not None:
            _clear(chunks_of(len(node)), self._rows, self._width, node)
        elif self._rows:
            _clear(chunks_of(len(self._rows[0]) // ROW), self._rows, self._width, ALL)
