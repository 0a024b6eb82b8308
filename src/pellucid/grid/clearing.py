"""Reset of nodal arrays to zero before points and conditions add to them.

All threads share the work: on a large grid with small bodies, the reset takes much of the time of a step.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.chunks import ALL, ChunkedNodes, by_row, chunked, listed
from pellucid.grid.nodal_fields import ROW, Cleared, fields_of, views_of
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import splat, store
from pellucid.ranks.domain import domain


class ClearedRows(NamedTuple):
    """Input of the kernel that resets nodal arrays to zero: the arrays in two forms. With the integers the kernel finds
    rows (four numbers of a node) whose bits are all zero already, and does not write these rows."""

    rows: tuple[np.ndarray, ...]  # (4 nodes,) each: arrays with a row of four numbers per node
    bits: tuple[np.ndarray, ...]  # views of the memory of `rows` as 64-bit integers


@parallel_loop()
def _clear(chunk, cleared, width, chunks):
    """Set the first `width` numbers of each node's row to zero for the nodes of a chunk; cleared: a bundle of `ClearedRows`;
    chunks: the nodes (`ChunkedNodes`)."""
    zero = splat(0.0)
    for k in range(len(cleared.rows)):
        array, of_bits = cleared.rows[k], cleared.bits[k]
        for e in range(chunks.edges[chunk], chunks.edges[chunk + 1]):
            at = ROW * listed(chunks.node, e)
            # what is read alone need not go back to memory
            if of_bits[at] | of_bits[at + 1] | of_bits[at + 2] | of_bits[at + 3] == 0:
                continue
            if width == ROW:
                store(array, at, zero)
            else:
                for d in range(width):
                    array[at + d] = 0.0


class Clearing:
    """Resets nodal arrays to zero: of the given sets of nodal arrays (`sets`, named tuples), all fields that are declared
    to be reset at the time `cleared`, such as STEP (at the start of each step); see `NodalField.cleared`.

    rows: first node of each row of slabs (blocks of cells) of the grid, and the end of the last row, see
    `pellucid.grid.chunks.by_row`.
    """

    def __init__(self, cleared: Cleared, rows: np.ndarray, *sets: tuple[Any, ...]) -> None:
        self._of_grid, self._all, self._cut = rows, by_row(rows), -1
        self._others, in_rows, self._width = list[tuple[np.ndarray, Any]](), list[np.ndarray](), ROW
        for arrays in sets:
            for name, field in fields_of(type(arrays)).items():
                if field.cleared == cleared and field.in_rows:
                    in_rows.append(getattr(arrays, name))
                elif field.cleared == cleared and getattr(arrays, name).size:
                    self._others.append((getattr(arrays, name), field.start))
            for view in views_of(type(arrays)).values():
                if view.cleared == cleared and isinstance(view.part, slice):
                    in_rows, self._width = [getattr(arrays, view.of)], view.part.stop
        self._has_rows = bool(in_rows)
        with_memory = tuple(array for array in in_rows if len(array))
        self._rows = Bundle(ClearedRows(with_memory, tuple(array.view(np.int64) for array in with_memory)))
        self._own = self._whole = self._part(self._all.chunks.edges, slice(None))

    def __call__(self, node: np.ndarray | None = None) -> None:
        """Reset the fields to zero at all nodes, or at the nodes of a list, shape (m,). Fields that are not stored in rows of
        four numbers are always reset at all nodes, to their initial values; node: indices of the listed nodes."""
        if self._cut == domain.cuts_made:
            chunks, others = self._own
        else:  # rows may have something that are not those of this process any more
            chunks, others = self._whole
            first, end = domain.near(self._all.of_row)
            self._own = self._part(self._all.chunks.edges[first : end + 1], slice(*domain.near(self._of_grid)))
            self._cut = domain.cuts_made
        for array, start in others:
            array[...] = start
        if self._has_rows:
            if node is not None:
                chunks = chunked(node)
            _clear(chunks.n, self._rows, self._width, chunks)

    def _part(self, edges: np.ndarray, nodes: slice) -> tuple[ChunkedNodes, list[tuple[np.ndarray, Any]]]:
        """Return the data for resetting the nodal arrays of a range of nodes (`nodes`): its chunks (`ChunkedNodes`), and,
        for each array that is not stored in rows of four numbers, a view of the range with its initial value.

        edges: first node of each chunk, and the end of the last.
        """
        others = [((array if array.ndim > 1 else array[:, None])[..., nodes, :], start) for array, start in self._others]
        return ChunkedNodes(ALL, edges), others
