"""Parallel loops: the chunks of a kernel are distributed to numba's threads.

A `prange` loop compiles its body, with all functions that it calls, several times, which takes seconds for every driver.
Here the loop is a small function that numba's runtime calls on each thread, and it calls the compiled kernel of a chunk.
The code of the kernel is not compiled again; a second compilation would take as long as the first and could round
differently.

Threads that start and end a loop together wait for each other. For small bodies this costs more than a second thread gains.
Therefore the loops of several bodies can be combined in one region, see `pellucid.jit.joint`.
"""

from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.linked import compiled_for, linked_kernels
from pellucid.jit.region import (
    BEGIN,
    BEGIN_LOOP,
    BYTES,
    COLOURS,
    DO_CHUNK,
    EVEN_ROWS,
    INTP,
    LEFT_OUT,
    make_known,
    waiting,
)


def _driver(joint: bool) -> Any:
    if numba.config.DISABLE_JIT:
        return _plain

    @intrinsic
    def loop(typing: Any, kernel: Any, count: Any, *arguments: Any) -> Any:
        return _loop(typing, kernel, [count], arguments, joint)

    return loop


def _driver_by_colour(joint: bool) -> Any:
    if numba.config.DISABLE_JIT:
        return _plain_by_colour

    @intrinsic
    def loop(typing: Any, kernel: Any, count: Any, across: Any, *arguments: Any) -> Any:
        return _loop(typing, kernel, [count, across], arguments, joint)

    return loop


def _plain(kernel: Any, count: int, *arguments: Any) -> None:
    for chunk in range(0 if waiting[LEFT_OUT] & EVEN_ROWS else count):
        kernel(chunk, *arguments)


def _plain_by_colour(kernel: Any, count: int, across: int, *arguments: Any) -> None:
    for colour in range(COLOURS):
        if waiting[LEFT_OUT] & 1 << colour // 2:
            continue
        for row in range(colour // 2 * across, count, 2 * across):
            for chunk in range(row + colour % 2, row + across, 2):
                kernel(chunk, *arguments)


def _loop(typing: Any, kernel: Any, sizes: list[Any], arguments: Any, joint: bool) -> Any:
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
parallel_for, joint_for = _driver(False), _driver(True)
# The same with the number of chunks in a row before the arguments: every other chunk of every other row, the others of these
# rows, and the same of the rows between, so that neighbours are never done at the same time.
parallel_by_colour, joint_by_colour = _driver_by_colour(False), _driver_by_colour(True)
