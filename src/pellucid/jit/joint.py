"""One parallel region for the loops of several bodies.

Loops that begin with `joint_for` or `joint_by_colour` in a block `with joint_region:` wait for its end. Then a thread does the
first chunk of them all, loop after loop, another the second, and so on; of loops by colour one colour after the other.
So bodies that add to the same nodes do not meet there, for their chunks are the same layers of the grid, and all is added in
one order on any number of threads. A loop may take what an earlier one of its kind left in the same chunk.
"""

from typing import Any

import numba
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.kernels import kernel
from pellucid.jit.parallel import COUNTS, LOOPS, MOST, OPEN, ROOM, USED, waiting, waiting_loops
from pellucid.jit.region import COLOURS, INTP, LOOP, run

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
        if waiting[COUNTS] > MOST - OF_A_BODY or waiting[USED] > ROOM - OF_A_BODY * BYTES_EACH:
            self._run()

    def __exit__(self, error: object, *rest: object) -> None:
        if numba.config.DISABLE_JIT:
            return
        waiting[OPEN] = 0
        try:
            if error is None:
                self._run()
        finally:
            waiting[USED : COUNTS + COLOURS] = 0

    def _run(self) -> None:
        _run_waiting()
        waiting[USED : COUNTS + COLOURS] = 0


joint_region = JointRegion()


@intrinsic
def _run_colours(typing: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        place = waiting_loops(builder.module)
        colours = []
        for colour in range(COLOURS):
            count = builder.load(cgutils.gep_inbounds(builder, place, 0, COUNTS, colour))
            loops = cgutils.gep_inbounds(builder, place, 0, LOOPS, colour, 0)
            numbers = cgutils.alloca_once_value(builder, INTP(0))
            with cgutils.for_range(builder, count, intp=INTP) as each:
                loop = builder.gep(loops, [each.index])
                several = builder.load(cgutils.gep_inbounds(builder, loop, 0, len(LOOP.elements) - 1))
                most = builder.load(numbers)
                builder.store(builder.select(builder.icmp_signed(">", several, most), several, most), numbers)
            colours.append((builder.load(numbers), count, loops))
        run(builder, colours)
        return context.get_dummy_value()

    return types.none(), emit


@kernel()
def _run_waiting() -> None:
    _run_colours()
