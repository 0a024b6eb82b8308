"""Joint parallel region for the loops of several bodies.

Loops that begin with `joint_for` or `joint_by_colour` in a block `with joint_region:` wait for its end. Then a thread runs
the first chunk of all loops, one loop after another; another thread runs the second, and so on; loops by colour run one
colour after the other. Bodies that add to the same nodes do not conflict, since their chunks are the same layers of the
grid, and all is added in one order on any number of threads. A loop may use the results of an earlier one of its kind in
the same chunk.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numba

from pellucid.jit.region import COUNT, LEFT_OUT, MOST, OPEN, ROOM, USED, make_known, waiting

OF_A_BODY, BYTES_EACH = 8, 256
"""So many loops a body begins at most in a region, and their arguments take so many bytes each."""


@contextmanager
def leaving_out(rows: int) -> Iterator[None]:
    """Make loops skip EVEN_ROWS or ODD_ROWS of `pellucid.jit.region`."""
    waiting[LEFT_OUT] = rows
    try:
        yield
    finally:
        waiting[LEFT_OUT] = 0


class JointRegion:
    """Lets joint loops wait, and does them as one at the end of a block; not where an error ends it.

    What the loops take must live until then; what they give is there after it. Regions do not contain each other.
    """

    by_parity: Callable[[Callable[[], None], Sequence[Any]], None] | None = None
    """Where several processes share the rows: does loops that give to nodal arrays row parity by row parity."""

    def __init__(self) -> None:
        self._given: list[Any] = []

    def give(self, begin: Callable[[], None], given: Callable[[], Sequence[Any]]) -> None:
        """Begin joint loops by colour. given: the arrays of the nodes of the grid, or of lists of them, to which these loops
        give: asked for where processes share the rows."""
        if self.by_parity is not None and waiting[OPEN]:
            self._given += [array for array in given() if not any(array is known for known in self._given)]
            begin()
        else:
            self.give_at_once(begin, given)

    def give_at_once(self, do: Callable[[], None], given: Callable[[], Sequence[Any]]) -> None:
        """The same of loops that never wait."""
        if self.by_parity is None:
            do()
        else:
            self.by_parity(do, given())

    def __enter__(self) -> None:
        if not numba.config.DISABLE_JIT:
            waiting[OPEN] = 1

    def make_room(self) -> None:
        """Run waiting loops before a body begins its own, if these might not find room.

        A loop without room runs at once, before the waiting loops whose results it may use.
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
