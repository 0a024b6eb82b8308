"""One parallel region for the loops of several bodies.

Loops that begin with `joint_for` or `joint_by_colour` in a block `with joint_region:` wait for its end. Then a thread does the
first chunk of them all, loop after loop, another the second, and so on; of loops by colour one colour after the other.
So bodies that add to the same nodes do not meet there, for their chunks are the same layers of the grid, and all is added in
one order on any number of threads. A loop may take what an earlier one of its kind left in the same chunk.
"""

import numba

from pellucid.jit.region import COUNT, MOST, OPEN, ROOM, USED, make_known, waiting

OF_A_BODY, BYTES_EACH = 8, 256
"""So many loops a body begins at most in a region, and their arguments take so many bytes each."""


class JointRegion:
    """Lets joint loops wait, and does them as one at the end of a block; not where an error ends it.

    What the loops take must live until then; what they give is there after it. Regions do not contain each other.
    """

    def __enter__(self) -> None:
        if not numba.config.DISABLE_JIT:
            waiting[OPEN] = 1

    def make_room(self) -> None:
        """Before a body begins its loops: do those that wait where its own might not all find room.

        A loop without room is done at once, before those that wait, of which it may take what they leave.
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

    def _run(self) -> None:
        make_known()()
        waiting[USED] = waiting[COUNT] = 0


joint_region = JointRegion()
