"""Nodal arrays set to zero before points and conditions give to them.

Rows are cleared by all threads: on a large grid with small bodies that is much of a step.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.listed import ALL, CHUNK, chunks_of, end_of, listed
from pellucid.grid.nodal_fields import ROW, Cleared, fields_of, views_of
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import splat, store


class ClearedRows(NamedTuple):
    """Rows of some fields, and their bits as integers, which tell a zero of either sign from what is to be cleared."""

    rows: tuple[np.ndarray, ...]
    bits: tuple[np.ndarray, ...]


@kernel(inner=True)
def _clear_chunk(chunk, cleared, width, node):
    zero = splat(0.0)
    for k in range(len(cleared.rows)):
        array, of_bits = cleared.rows[k], cleared.bits[k]
        for e in range(CHUNK * chunk, end_of(chunk, node, len(array) // ROW)):
            at = ROW * listed(node, e)
            # what is read alone need not go back to memory
            if of_bits[at] | of_bits[at + 1] | of_bits[at + 2] | of_bits[at + 3] == 0:
                continue
            if width == ROW:
                store(array, at, zero)
            else:
                for d in range(width):
                    array[at + d] = 0.0


@kernel()
def _clear(chunks, cleared, width, node):
    """Set the first numbers, as many as `width` says, of the rows of listed nodes to zero; cleared: a bundle."""
    parallel_for(_clear_chunk, chunks, cleared, width, node)


class Clearing:
    """Sets to zero what is cleared at one time of some sets of nodal arrays, as it is declared."""

    def __init__(self, cleared: Cleared, *sets: tuple[Any, ...]) -> None:
        self._others, rows, self._width = list[tuple[np.ndarray, Any]](), list[np.ndarray](), ROW
        for arrays in sets:
            for name, field in fields_of(type(arrays)).items():
                if field.cleared == cleared and field.in_rows:
                    rows.append(getattr(arrays, name))
                elif field.cleared == cleared and getattr(arrays, name).size:
                    self._others.append((getattr(arrays, name), field.start))
            for view in views_of(type(arrays)).values():
                if view.cleared == cleared and isinstance(view.part, slice):
                    rows, self._width = [getattr(arrays, view.of)], view.part.stop
        self._n = len(rows[0]) // ROW if rows else 0
        with_memory = tuple(array for array in rows if len(array))
        self._rows = Bundle(ClearedRows(with_memory, tuple(array.view(np.int64) for array in with_memory)))

    def __call__(self, node: np.ndarray | None = None) -> None:
        """Clear all nodes, or those of a list, shape (m,); fields that are not in rows at all nodes."""
        for array, start in self._others:
            array[...] = start
        if self._n:
            n = self._n if node is None else len(node)
            _clear(chunks_of(n), self._rows, self._width, ALL if node is None else node)
