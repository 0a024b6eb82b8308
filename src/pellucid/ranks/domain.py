"""The rows of slabs of the grid that this process owns; the rows are adjacent. A slab is a block of cells
(`pellucid.grid.sorting`); a row contains all slabs in the same layers of cells along one axis.

Loops by colour add to nodes row by row. With several processes, the even rows of all processes are added first. At a cut
between two processes, the process whose adjacent row is even then sends the sums of the nodes that points on both sides of
the cut reach. The process whose adjacent row is odd adds to these sums and sends the complete sums back. All sums are
therefore formed in the order of a single process, whatever quantity is added. Nodes that points of a process reach have
complete sums in this process.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from pellucid.errors import PellucidError
from pellucid.jit.loops import joint_region, leaving_out
from pellucid.jit.region import EVEN_ROWS, ODD_ROWS
from pellucid.ranks.group import processes

EVERYWHERE, IN_FIRST, NOWHERE = "everywhere", "in the first process", "nowhere"


class OfListed(NamedTuple):
    """An array of values at a list of grid nodes, to which points add in parallel loops over slabs (blocks of grid cells);
    `Domain` exchanges these values between processes."""

    values: np.ndarray  # (n, ...) values of the listed nodes, or the same values flattened
    node: np.ndarray  # (n,) numbers of the listed grid nodes


Given = np.ndarray | OfListed


class Rows(NamedTuple):
    """Division of a grid into rows of slabs (blocks of cells), with the numbers from which `Domain` finds the nodes of a
    row."""

    edges: np.ndarray  # (rows + 1,) first layer of nodes of each row, and the end
    across: int  # slabs in a row
    stencil: int  # nodes that a point reaches along the axis of the rows
    layer: int  # nodes in a layer
    nodes: int  # number of nodes of the grid


def cuts_of(cost: np.ndarray, processes: int) -> np.ndarray:
    """Return the first row of slabs (blocks of grid cells) of each process, and the end, shape (processes + 1,).

    Each process has at least one row, if there are enough, and about the same total cost; cost: computing time of each row
    in any unit, shape (rows,).
    """
    until, cuts, n = np.concatenate([[0.0], np.cumsum(cost)]), [0], len(cost)
    busy = min(processes, n)
    for process in range(1, busy):
        nearest = int(np.argmin(np.abs(until - process * until[-1] / busy)))
        cuts.append(min(max(nearest, cuts[-1] + 1), n - (busy - process)))
    return np.array([*cuts, *[n] * (1 + processes - busy)])


class Domain:
    """Rows of slabs (blocks of grid cells) that this process owns, i.e. whose points this process computes, and exchange of
    sums between processes. A process owns all rows until `cut` distributes the rows."""

    def __init__(self) -> None:
        self.group = processes
        self.is_cut = False
        """True if the points are distributed over several processes."""
        self.joins = EVERYWHERE
        """Destination of gathered point data: EVERYWHERE; IN_FIRST, other processes get no rows; NOWHERE, each process
        keeps its own rows."""
        self.cuts_made = 0
        """Number of times that the rows were distributed, or returned to one process."""
        self.bytes_sent = 0
        """Number of bytes sent to neighbours so far."""

    def cut(self, rows: Rows, cost: np.ndarray) -> None:
        """Distribute the rows of slabs (blocks of grid cells) so that all processes have about the same total cost; cost:
        estimate for each row in any unit, shape (rows,). If there are more processes than rows, the last processes get no
        rows."""
        self._rows = rows
        self._take_rows(cuts_of(cost, self.group.size))
        self.is_cut = self.group.size > 1
        joint_region.by_parity = self.by_parity if self.is_cut else None

    def _take_rows(self, cuts: np.ndarray) -> None:
        self._cuts = cuts
        self.cuts_made += 1
        self.first, self.end = int(cuts[self.group.rank]), int(cuts[self.group.rank + 1])

    def would_pay(self, cost: np.ndarray) -> bool:
        """Return True if another distribution of rows would reduce the largest cost of a process by a tenth; cost: computing
        time of each row, shape (rows,)."""
        until = np.concatenate([[0.0], np.cumsum(cost)])
        before, after = (np.diff(until[cuts]).max() for cuts in (self._cuts, cuts_of(cost, self.group.size)))
        return bool(after < 0.9 * before)

    def cut_again(self, cost: np.ndarray) -> None:
        """Distribute the rows of slabs (blocks of grid cells) again according to their costs (computing times), shape
        (rows,)."""
        self._take_rows(cuts_of(cost, self.group.size))

    def leave(self) -> None:
        """End the distribution of rows of slabs (blocks of grid cells) at the end of the simulation: every process owns all
        rows again."""
        self.is_cut, joint_region.by_parity = False, None
        self.cuts_made += 1

    @contextmanager
    def together(self) -> Iterator[None]:
        """Context manager that ends all processes if one of them raises an error in the block; an error that every process
        raises does not end them but is raised in each."""
        try:
            yield
        except BaseException as error:
            self.leave()
            self.group.end(error)
            raise

    # loops by colour

    def by_parity(self, run: Callable[[], None], given: Sequence[Given]) -> None:
        """Execute loops over slabs, started by the function `run`, that add to the nodal arrays `given`: first for even and
        then for odd rows of slabs, with an exchange of sums between processes after each."""
        if not self.is_cut:
            run()
            return
        for parity, others in enumerate((ODD_ROWS, EVEN_ROWS)):
            with leaving_out(others):
                run()
            self._hand_on(parity, given)

    def _hand_on(self, parity: int, given: Sequence[Given]) -> None:
        """Exchange nodal sums at the cuts between processes: processes whose row at the cut has this parity (0 even, 1 odd)
        send the sums of the nodes that points on both sides of the cut reach, the other processes receive these sums.

        given: nodal arrays.
        """
        messages, taken = [], []
        for row, neighbour, own in ((self.first, -1, self.first), (self.end, 1, self.end - 1)):
            process = self.group.rank + neighbour
            if self.first == self.end or not 0 < row < len(self._rows.edges) - 1 or not given:
                continue
            parts = [self._part_about(row, one) for one in given]
            if sends := own % 2 == parity:
                message = np.concatenate([np.ascontiguousarray(part).reshape(-1).view(np.uint8) for part in parts])
                self.bytes_sent += message.nbytes
            else:
                message = np.empty(sum(part.nbytes for part in parts), np.uint8)
                taken.append((parts, message))
            messages.append((process, message, sends))
        self.group.pass_on(messages)
        for parts, message in taken:
            at = 0
            for part in parts:
                part[...] = message[at : at + part.nbytes].view(part.dtype).reshape(part.shape)
                at += part.nbytes

    def _part_about(self, row: int, given: Given) -> np.ndarray:
        """Return a view of nodal values for the nodes that points on both sides of the beginning of a row of slabs (blocks
        of grid cells) may reach (`pellucid.grid.sorting.slabs_of`); given: the values."""
        begin, stencil, layer = int(self._rows.edges[row]), self._rows.stencil, self._rows.layer
        ends = np.array([begin - 1, begin + stencil + (stencil == 3)]) * layer
        if isinstance(given, OfListed):
            n = len(given.node)
            return given.values.reshape(n, given.values.size // max(n, 1))[slice(*np.searchsorted(given.node, ends))]
        return given.reshape(self._rows.nodes, -1)[slice(*ends)]

    def spread(self, of_nodes: np.ndarray) -> None:
        """Complete nodal values, shape (nodes, ...), in place on every process: nodes that the points of a process do not
        reach get the values of other processes."""
        if self.is_cut:
            of_nodes[...] = self.of_nodes(of_nodes)

    # points and sums by slabs

    @property
    def slabs(self) -> slice:
        """The numbers of the slabs (blocks of grid cells) of this process, as a slice."""
        return slice(self.first * self._rows.across, self.end * self._rows.across)

    def has_layer(self, layer: np.ndarray) -> np.ndarray:
        """Return a mask of the points whose first nodes lie in the rows of slabs (blocks of grid cells) of this process;
        layer: grid layers of the first nodes, shape (n,)."""
        first, end = self._rows.edges[[self.first, self.end]]
        return (layer >= first) & (layer < end)

    def complete(self, of_slabs: np.ndarray) -> np.ndarray:
        """Fill an array with one entry per slab, shape (slabs, ...), in place with the entries that other processes
        computed, and return the array."""
        if self.is_cut:
            of_slabs[...] = self.group.joined(of_slabs[self.slabs], np.diff(self._cuts) * self._rows.across)
        return of_slabs

    def by_row(self, of_slabs: np.ndarray) -> np.ndarray:
        """Add up values per slab, shape (slabs,), over the slabs of each row, and return the sums, shape (rows,); a row
        consists of the slabs in the same layers of the grid."""
        return np.asarray(of_slabs, float).reshape(-1, self._rows.across).sum(axis=1)

    def near(self, of_row: np.ndarray) -> tuple[int, int]:
        """Return begin and end, in an array ordered by rows, of the data for the rows of slabs (blocks of grid cells) of
        this process and the two neighbouring rows, whose nodes points of this process can reach; of_row: begin of the data
        of each row, and the end, shape (rows + 1,)."""
        n = len(of_row) - 1
        rows = (max(self.first - 1, 0), min(self.end + 1, n)) if self.is_cut else (0, n)
        return int(of_row[rows[0]]), int(of_row[rows[1]])

    def of_chunks(self, sums: np.ndarray, of_row: np.ndarray, near: int | None = None) -> np.ndarray:
        """Gather sums of chunks of nodes from all processes, in the order of the chunks; `sums` has an entry per chunk
        along its first axis. of_row: the first chunk of each row of slabs, and the end of the last; near: index of the
        chunk whose sums are sums[0], if chunks divide all nodes of the grid; None if they divide a list of nodes of this
        process."""
        if not self.is_cut:
            return sums
        own = sums[of_row[self.first] - (near or 0) : of_row[self.end] - (near or 0)]
        return self.group.joined(own, None if near is None else np.diff(of_row[self._cuts]))

    def of_nodes(self, values: np.ndarray, node: np.ndarray | None = None) -> np.ndarray:
        """Gather nodal values, shape (n, ...), from all processes: the value of each node comes from the process that owns
        its row of slabs (blocks of grid cells).

        node: sorted indices of the nodes; None for all nodes.
        """
        if not self.is_cut:
            return values
        ends = np.append(self._rows.layer * self._rows.edges[:-1], self._rows.nodes)[[self.first, self.end]]
        return self.group.joined(values[slice(*(ends if node is None else np.searchsorted(node, ends)))])

    def whole(self, own: np.ndarray) -> np.ndarray:
        """Gather values of points, shape (n, ...), from all processes in the order of a run with one process; `joins` sets
        which processes receive them."""
        if not self.is_cut or self.joins == NOWHERE:
            return own
        return self.group.joined(own, to_first=self.joins == IN_FIRST)

    @contextmanager
    def joining(self, where: str) -> Iterator[None]:
        """Context manager within which values of points are gathered in the first process only (where = IN_FIRST) or not at all
        (NOWHERE), for output."""
        self.joins = where
        try:
            yield
        finally:
            self.joins = EVERYWHERE

    def any(self, flag: bool) -> bool:
        """Return True if the flag is set in any process."""
        return self.group.any(flag) if self.is_cut else flag

    def caught(self, signals: Sequence[int]) -> Sequence[int]:
        """Return the signals that were caught: all signals of this process, or, for several processes, only the largest one
        of all processes."""
        if not self.is_cut:
            return signals
        return [int(self.group.largest(max(signals, default=0)))] if self.any(len(signals) > 0) else []

    def largest(self, value: float) -> float:
        """Return the largest of the values that all processes pass."""
        return self.group.largest(value) if self.is_cut else value

    @contextmanager
    def told_by(self, slab: int) -> Iterator[bool]:
        """Context manager that yields True in the process that owns the slab (a block of grid cells) with the number
        `slab`, else False; a `PellucidError` raised in the block of the owner is raised in all processes."""
        process = int(np.searchsorted(self._cuts * self._rows.across, slab, side="right")) - 1 if self.is_cut else 0
        has_it, error = not self.is_cut or process == self.group.rank, None
        try:
            yield has_it
        except PellucidError as raised:
            error = raised
        if self.is_cut:
            error = self.group.told(error, by=process)
        if error is not None:
            raise error

    def migrate(self, arrays: Mapping[str, np.ndarray], first: np.ndarray) -> int:
        """Send points, sorted by slabs (blocks of grid cells), to the processes that own these slabs; return the new number
        of points of this process.

        arrays: arrays of the points, by name, changed in place, with room for all points; first: index of the first point
        of each slab, and the end. Received points are ordered by the sending process; sorting them again gives the order of
        a single process.
        """
        send = np.diff(first[self._cuts * self._rows.across])
        receive = self.group.numbers_from_each(send)
        there = int(receive.sum())
        if self.group.any(int(send.sum()) != send[self.group.rank]):
            for array in arrays.values():
                array[:there] = self.group.exchanged(array[: first[-1]], send, receive)
        return there


domain = Domain()
