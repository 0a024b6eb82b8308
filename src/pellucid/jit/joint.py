"""Joint parallel region for the loops of several bodies.

Loops that start with `joint_for` or `joint_by_colour` in a block `with joint_region:` are deferred to the end of the block.
Then one thread runs the first chunk of all loops, one loop after another; another thread runs the second, and so on; loops
by colour run one colour after the other. Bodies that add to the same nodes do not conflict, since their chunks are the same
layers of the grid, and all contributions are added in the same order for any number of threads. A loop may use the results
of an earlier loop of its kind in the same chunk.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numba

from pellucid.jit.region import COUNT, LEFT_OUT, MOST, OPEN, ROOM, USED, make_known, waiting

OF_A_BODY, BYTES_EACH = 8, 256
"""Largest number of loops that a body starts in a region, and largest size of the arguments of a loop [bytes]."""


@contextmanager
def leaving_out(rows: int) -> Iterator[None]:
    """Make parallel loops skip the even or odd rows of slabs within the block; rows: EVEN_ROWS or ODD_ROWS of
    `pellucid.jit.region`."""
    waiting[LEFT_OUT] = rows
    try:
        yield
    finally:
        waiting[LEFT_OUT] = 0


class JointRegion:
    """Context manager that defers joint loops (parallel loops started with `joint_for` or `joint_by_colour`) and runs them
    together at the end of its block, unless an error ends the block.

    The arguments of the loops must exist until the end of the block; their results are available after it. Regions cannot
    be nested.
    """

    by_parity: Callable[[Callable[[], None], Sequence[Any]], None] | None = None
    """Function that runs loops that add to nodal arrays, separately for even and odd rows of slabs; set if several
    processes share the rows, else None."""

    def __init__(self) -> None:
        self._given: list[Any] = []

    def give(self, begin: Callable[[], None], given: Callable[[], Sequence[Any]]) -> None:
        """Start joint loops by colour (loops over slabs in which neighbouring slabs never run at the same time).

        begin: function that starts the loops; given: function that returns the arrays, of all nodes or of lists of nodes,
        to which the loops add. `given` is called only if several processes share the rows of slabs.
        """
        if self.by_parity is not None and waiting[OPEN]:
            self._given += [array for array in given() if not any(array is known for known in self._given)]
            begin()
        else:
            self.give_at_once(begin, given)

    def give_at_once(self, do: Callable[[], None], given: Callable[[], Sequence[Any]]) -> None:
        """Run joint loops (see the class) at once instead of at the end of the block.

        do: function that starts the loops; given: function that returns the arrays to which the loops add. It is called only
        if several processes share the rows of slabs, which then exchange the contributions to these arrays.
        """
        if self.by_parity is None:
            do()
        else:
            self.by_parity(do, given())

    def __enter__(self) -> None:
        if not numba.config.DISABLE_JIT:
            waiting[OPEN] = 1

    def make_room(self) -> None:
        """Run the deferred loops now if the memory for deferred loops might not suffice for the loops of one more body.
        Called before a body starts its loops.

        A loop without memory would run at once, before deferred loops whose results it may use.
        """
        if waiting[COUNT] > MOST - OF_A_BODY or waiting[USED] > ROOM - OF_A_BODY * BYTES_EACH:
            self._run()

    def __exit__(self, error: object, *rest: object) -> None:
        if numba.config.DISABLE_JIT:
            return
        waiting[OPEN] = 0
        try:
            if error is None:
                self._run()
        finally:
            waiting[USED] = waiting[COUNT] = 0
            self._given = []

    def _run(self) -> None:
        if self.by_parity is None:
            make_known()()
        else:
            self.by_parity(make_known(), self._given)
        self._given = []
        waiting[USED] = waiting[COUNT] = 0


joint_region = JointRegion()
