"""Parallel loops, written for one chunk and called with the number of chunks.

    @parallel_loop()
    def scale(chunk, values, factor):
        for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(values))):
            values[i] *= factor

    scale(chunks, values, 2.0)  # all chunks, in any order on the threads

As for a vectorized function, one definition serves for the work on one chunk and for the call on all chunks. The kernel of
a chunk is compiled as `scale_chunk`. A driver with the same arguments is compiled as `scale`; it distributes the chunks to
the threads (`parallel_for`). A driver of several loops, or several drivers of one kernel, must be written
explicitly.

A `prange` loop compiles its body, with all functions that it calls, several times, which takes seconds for every driver.
Here the loop is a small function that numba's runtime calls on each thread, and it calls the compiled kernel of a chunk.
The code of the kernel is not compiled again; a second compilation would take as long as the first and could round
differently.

Threads that start and end a loop together wait for each other. For small bodies this costs more than a second thread gains.
Therefore the loops of several bodies can be combined in one region (`JointRegion`).
"""

import functools
import inspect
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from operator import attrgetter
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.calls import compiled_for, linked_kernels
from pellucid.jit.kernels import kernel
from pellucid.jit.region import (
    BEGIN,
    BEGIN_LOOP,
    BYTES,
    COLOURS,
    COUNT,
    DO_CHUNK,
    EVEN_ROWS,
    INTP,
    LEFT_OUT,
    MOST,
    OPEN,
    ROOM,
    USED,
    make_known,
    waiting,
)

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

    One thread runs the first chunk of all loops, one loop after another; another thread runs the second, and so on; loops by
    colour run one colour after the other. Bodies that add to the same nodes do not conflict, since their chunks are the same
    layers of the grid, and all contributions are added in the same order for any number of threads. A loop may use the results
    of an earlier loop of its kind in the same chunk.

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


def _parallel_loop(joint: bool) -> Any:
    if numba.config.DISABLE_JIT:
        return _plain_loop

    @intrinsic
    def loop(typing: Any, kernel: Any, count: Any, *arguments: Any) -> Any:
        return _emitted_loop(typing, kernel, [count], arguments, joint)

    return loop


def _parallel_loop_by_colour(joint: bool) -> Any:
    if numba.config.DISABLE_JIT:
        return _plain_by_colour

    @intrinsic
    def loop(typing: Any, kernel: Any, count: Any, across: Any, *arguments: Any) -> Any:
        return _emitted_loop(typing, kernel, [count, across], arguments, joint)

    return loop


def _plain_loop(kernel: Any, count: int, *arguments: Any) -> None:
    for chunk in range(0 if waiting[LEFT_OUT] & EVEN_ROWS else count):
        kernel(chunk, *arguments)


def _plain_by_colour(kernel: Any, count: int, across: int, *arguments: Any) -> None:
    for colour in range(COLOURS):
        if waiting[LEFT_OUT] & 1 << colour // 2:
            continue
        for row in range(colour // 2 * across, count, 2 * across):
            for chunk in range(row + colour % 2, row + across, 2):
                kernel(chunk, *arguments)


def _emitted_loop(typing: Any, kernel: Any, sizes: list[Any], arguments: Any, joint: bool) -> Any:
    """Return the type of a parallel loop over chunks and the function that generates its code (a numba intrinsic).

    kernel, arguments: types of the kernel of a chunk and of its arguments; sizes: types of the number of chunks and, for a
    loop by colour, of the number in a row; joint: True if the loop may be deferred in a joint region.
    """
    make_known()
    given = (types.intp, *arguments)
    linked = compiled_for(kernel.dispatcher, given)
    signature = types.none(kernel, *[types.intp] * len(sizes), types.StarArgTuple(arguments))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        *given_sizes, together = values[1:]
        linked_kernels(context.active_code_library).append(linked)
        packed = cgutils.pack_struct(builder, cgutils.unpack_tuple(builder, together, len(arguments)))
        do_chunk = _do_chunk(context, builder.module, packed.type, linked.compiled, given)
        at = cgutils.alloca_once_value(builder, packed)
        size, across = INTP(context.get_abi_sizeof(packed.type)), given_sizes[1] if len(sizes) > 1 else INTP(0)
        begin = cgutils.get_or_insert_function(builder.module, BEGIN_LOOP, BEGIN)
        builder.call(begin, [do_chunk, builder.bitcast(at, BYTES), size, given_sizes[0], across, INTP(int(joint))])
        return context.get_dummy_value()

    return signature, emit


def _do_chunk(context: Any, module: Any, packed: Any, compiled: Any, given: Any) -> Any:
    """Return the LLVM function of type DO_CHUNK that calls the kernel with one chunk.

    packed: type of the memory with the kernel's arguments; compiled: the kernel; given: compiled types of its arguments.
    """
    name = module.get_unique_name(f"chunk.{compiled.fndesc.mangled_name}")
    function = ir.Function(module, DO_CHUNK, name)
    function.linkage = "internal"
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    arguments = builder.load(builder.bitcast(function.args[0], packed.as_pointer()))
    rest = [builder.extract_value(arguments, i) for i in range(len(packed.elements))]
    callee = context.declare_function(module, compiled.fndesc)
    context.call_conv.call_function(builder, callee, types.none, given, [function.args[1], *rest])
    builder.ret_void()
    return function


# Call a kernel with the number of each chunk from 0 to count - 1, and the arguments, in any order on the threads. The kernel
# must return nothing; what it raises is lost. Within a `joint_region` joint loops wait for its end.
parallel_for, joint_for = _parallel_loop(False), _parallel_loop(True)
# The same with the number of chunks in a row before the arguments: every other chunk of every other row, the others of these
# rows, and the same of the rows between, so that neighbours are never done at the same time.
parallel_by_colour, joint_by_colour = _parallel_loop_by_colour(False), _parallel_loop_by_colour(True)


def parallel_loop(allocates: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that turns the kernel of a chunk into a parallel loop over chunks. The first argument of the
    kernel is the index of the chunk; the first argument of the loop is the number of chunks.

    The kernel must not return a value; exceptions that the kernel raises are lost. Python and kernels can call the loop.
    allocates: see `kernel`.
    """
    return lambda function: _driver(function, parallel_for, [], allocates)


def parallel_loop_by_colour(gives: str) -> Callable[[Callable[..., Any]], Callable[..., None]]:
    """Return a decorator like `parallel_loop` for kernels of a slab of points: slabs that are neighbours add to the same nodes
    and never run at the same time.

    The second argument of the kernel has `slabs`, with the number of slabs in a row (`across`). gives: name of the argument
    that holds the arrays to which neighbouring slabs add, or of a member of an argument, such as "walls.gap"; see
    `JointRegion.give`. Only Python can call the loop.
    """
    name, _, member = gives.partition(".")

    def decorate(function: Callable[..., Any]) -> Callable[..., None]:
        parameters = list(inspect.signature(function).parameters)
        place = parameters.index(name)
        driver = _driver(function, parallel_by_colour, [f"{parameters[1]}.slabs.across"])

        @functools.wraps(driver)
        def loop(*arguments: Any) -> None:
            given = arguments[place]
            joint_region.give_at_once(lambda: driver(*arguments), lambda: [attrgetter(member)(given) if member else given])

        return loop

    return decorate


def _driver(function: Any, loop: Any, sizes: list[str], allocates: bool = False) -> Any:
    """Return the driver: a kernel with the name of `function` that distributes the chunks to the threads by the parallel loop
    `loop`.

    function: kernel of one chunk; sizes: expressions for further arguments of the loop, such as the number of slabs in a
    row; allocates: see `kernel`. Its source text is generated with the arguments of the function, since numba is slow to
    determine the types of a variable number of arguments (`*others`). Messages give the location of the function.
    """
    number, *others = inspect.signature(function).parameters
    given = ", ".join(["chunk_kernel", number, *sizes, *others])
    text = f"def driver({', '.join([number, *others])}): loop({given})"
    file, line = function.__code__.co_filename, function.__code__.co_firstlineno
    known: dict[str, Any] = {"loop": loop}
    exec(compile("\n" * (line - 1) + text, file, "exec"), known)
    driver = functools.wraps(function)(known["driver"])
    function.__name__, function.__qualname__ = f"{function.__name__}_chunk", f"{function.__qualname__}_chunk"
    known["chunk_kernel"] = kernel(inner=True, allocates=allocates)(function)
    return kernel()(driver)
