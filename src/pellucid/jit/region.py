"""A parallel region: threads run the chunks of some loops, colour after colour, until all are done.

In each colour a thread first runs the items of its own share, and then items of other shares that have not been started. It
starts a colour when all items of the previous colour are done. The region is therefore entered and left only once, which
costs as much as some hundred points. A waiting thread polls for some microseconds, as long as most chunks take, and then
yields to other threads.

Shares are the same in every loop and step: with OpenMP, data written by a thread are then in the cache of the core that
reads them next. With dynamic scheduling of single items, two cores sometimes needed as long as one.

The code is generated once in a process, and drivers of loops refer to it by name; otherwise each would contain a copy.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba.core import cgutils

INTP = cgutils.intp_t
BYTES = ir.IntType(8).as_pointer()
DO_CHUNK = ir.FunctionType(ir.VoidType(), [BYTES, INTP])
"""Type of a function that runs one chunk; arguments: address of the arguments, number of the chunk."""
LOOP = ir.LiteralStructType([DO_CHUNK.as_pointer(), BYTES, INTP, INTP, INTP, INTP, INTP])
"""Type of a loop over the chunks of a kernel: function of one chunk, arguments, and the members of `Chunks`."""
COLOURS = 4
TASK = ir.LiteralStructType([INTP, LOOP.as_pointer(), INTP, INTP, INTP, INTP.as_pointer(), ir.ArrayType(INTP, COLOURS)])
"""Type of the data shared by the threads: number of items done; loops of the first colour, offset between the loops of two
colours, number of loops per colour; number of threads, counters of the items taken from each thread's shares; number of
items of each colour. Item n runs chunk n of each loop that has so many chunks."""
DONE, LOOPS_AT, TO_NEXT_COLOUR, PER_COLOUR, THREADS, TAKEN_AT, NUMBERS = range(7)
LINE = 8
"""Size of a cache line [8-byte integers]. Each thread has one line for the counters of its shares."""
SHARE = ir.FunctionType(ir.VoidType(), [BYTES.as_pointer(), INTP.as_pointer(), INTP.as_pointer(), BYTES])
"""Type of the function that numba's runtime calls on each thread."""
LOOKS = 5000
"""Number of polls of a waiting thread before it yields to other threads after each poll."""
BEGIN = "pellucid_begin_loop"
BEGIN_LOOP = ir.FunctionType(ir.VoidType(), [DO_CHUNK.as_pointer(), BYTES, INTP, INTP, INTP, INTP])
"""Type of the function that starts a loop; arguments: function of one chunk, the loop's arguments and their size in bytes,
number of chunks, number in a row for loops by colour (else 0), and whether the loop may be deferred."""

MOST, ROOM = 256, 65536
"""Largest number of deferred loops, and largest total size of their arguments [bytes]; further loops run at once."""
WAITING = ir.LiteralStructType([INTP, INTP, INTP, INTP, ir.ArrayType(ir.ArrayType(LOOP, MOST), COLOURS),
                                ir.ArrayType(ir.IntType(8), ROOM)])  # fmt: skip
"""Type of the memory of deferred loops: whether loops are deferred, bytes used, number of loops, omitted rows (EVEN_ROWS,
ODD_ROWS or 0), loops for each colour, their arguments."""
OPEN, USED, COUNT, LEFT_OUT, LOOPS, ARGUMENTS = range(6)
EVEN_ROWS, ODD_ROWS = 1, 2
"""Values of LEFT_OUT, which selects the rows that loops skip. Chunks of loops that are not by colour count as even rows."""
waiting = np.zeros(4 + COLOURS * MOST * len(LOOP.elements) + ROOM // 8, np.int64)
"""Memory of type WAITING."""


class Chunks(NamedTuple):
    """Chunks of a loop that belong to one colour, as LLVM values in generated code: the chunks form rows, with constant
    differences between the numbers of neighbouring chunks."""

    first: Any  # number of the first chunk
    in_row: Any  # number of chunks in a row
    step: Any  # difference of the numbers of neighbouring chunks in a row
    row_step: Any  # difference of the numbers of the first chunks of neighbouring rows
    count: Any  # total number of chunks


@cache
def make_known() -> Callable[[], None]:
    """Start numba's threads and make the function BEGIN, which starts a loop, available to compiled code; return the function
    that runs the deferred loops."""
    from numba.np.ufunc.parallel import _launch_threads

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    _launch_threads()  # the runtime's symbols are known from then on
    module = ir.Module("pellucid.region")
    run = _define_run(module, _define_share(module))
    _define_begin(module, run)
    _define_run_waiting(module, run)
    engine = llvm.create_mcjit_compiler(
        llvm.parse_assembly(str(module)), llvm.Target.from_default_triple().create_target_machine()
    )
    engine.finalize_object()
    llvm.add_symbol(BEGIN, engine.get_function_address(BEGIN))
    run_waiting = ctypes.PYFUNCTYPE(None)(engine.get_function_address("run_waiting"))
    run_waiting.engine = engine  # type: ignore[attr-defined]  # whose code it is
    return run_waiting


def _define(module: Any, kind: Any, name: str) -> tuple[Any, Any]:
    function = ir.Function(module, kind, name)
    return function, ir.IRBuilder(function.append_basic_block("entry"))


def _member(builder: Any, struct: Any, *place: Any) -> Any:
    return cgutils.gep_inbounds(builder, struct, 0, *place)


def _fill(builder: Any, struct: Any, *values: Any) -> None:
    for place, value in enumerate(values):
        builder.store(value, _member(builder, struct, place))


def _define_begin(module: Any, run: Any) -> None:
    function, builder = _define(module, BEGIN_LOOP, BEGIN)
    do_chunk, arguments, size, count, across, joint = function.args
    colours = [_chunks_of(builder, colour, count, across) for colour in range(COLOURS)]
    place = _waiting_loops()
    used, waits = builder.load(_member(builder, place, USED)), builder.load(_member(builder, place, COUNT))
    is_open = builder.icmp_signed("!=", builder.and_(joint, builder.load(_member(builder, place, OPEN))), INTP(0))
    fits = builder.icmp_signed("<=", builder.add(used, size), INTP(ROOM))
    fits = builder.and_(fits, builder.icmp_signed("<", waits, INTP(MOST)))
    with builder.if_else(builder.and_(is_open, fits)) as (then, otherwise):
        with then:
            kept = _member(builder, place, ARGUMENTS, used)
            cgutils.raw_memcpy(builder, kept, arguments, size, 1)
            size = builder.and_(builder.add(size, INTP(7)), INTP(~7))
            builder.store(builder.add(used, size), _member(builder, place, USED))
            builder.store(builder.add(waits, INTP(1)), _member(builder, place, COUNT))
            for colour, chunks in enumerate(colours):
                _fill(builder, _member(builder, place, LOOPS, colour, waits), do_chunk, kept, *chunks)
        with otherwise:
            loops = cgutils.alloca_once(builder, LOOP, COLOURS)
            for colour, chunks in enumerate(colours):
                _fill(builder, builder.gep(loops, [INTP(colour)]), do_chunk, arguments, *chunks)
            builder.call(run, [loops, INTP(1), INTP(1)])
    builder.ret_void()


def _chunks_of(builder: Any, colour: int, count: Any, across: Any) -> Chunks:
    """Return the chunks of a colour (0 to 3) in generated code: every second chunk of every second row, or, for loops without
    rows, all chunks in the first colour.

    count: number of chunks of the loop; across: number of chunks in a row, 0 without rows.
    """
    by_colour = builder.icmp_signed(">", across, INTP(0))
    in_row = builder.select(by_colour, across, INTP(1))
    row, place = INTP(colour // 2), INTP(colour % 2)
    rows = builder.ashr(builder.add(builder.sub(builder.sdiv(count, in_row), row), INTP(1)), INTP(1))
    places = builder.ashr(builder.add(builder.sub(in_row, place), INTP(1)), INTP(1))
    first = builder.add(builder.mul(row, in_row), place)
    colours = Chunks(first, places, INTP(2), builder.mul(INTP(2), in_row), builder.mul(rows, places))
    every = Chunks(INTP(0), INTP(1), INTP(0), INTP(1), INTP(0) if colour else count)
    return Chunks(*(builder.select(by_colour, *pair) for pair in zip(colours, every, strict=True)))


def _waiting_loops() -> Any:
    """Return the address of the memory `waiting`, which contains the deferred loops, in generated code."""
    return INTP(waiting.ctypes.data).inttoptr(WAITING.as_pointer())


def _define_run_waiting(module: Any, run: Any) -> None:
    _, builder = _define(module, ir.FunctionType(ir.VoidType(), []), "run_waiting")
    place = _waiting_loops()
    count = builder.load(_member(builder, place, COUNT))
    builder.call(run, [_member(builder, place, LOOPS, 0, 0), INTP(MOST), count])
    builder.ret_void()


def _define_run(module: Any, share: Any) -> Any:
    """Define the LLVM function that runs loops on numba's threads, or on the current thread if there is nothing to distribute,
    and return it.

    share: function of `_define_share`, which runs on each thread.
    """
    function, builder = _define(module, ir.FunctionType(ir.VoidType(), [LOOP.as_pointer(), INTP, INTP]), "run")
    loops, to_next, count = function.args
    task, total = cgutils.alloca_once(builder, TASK), INTP(0)
    asked = cgutils.get_or_insert_function(module, ir.FunctionType(INTP, []), "get_num_threads")
    threads = builder.sext(builder.trunc(builder.call(asked, []), ir.IntType(32)), INTP)
    taken = builder.alloca(INTP, builder.mul(threads, INTP(LINE)))
    taken.align = 8 * LINE
    cgutils.memset(builder, taken, builder.mul(threads, INTP(LINE * 8)), 0)
    _fill(builder, task, INTP(0), loops, to_next, count, threads, taken)
    for colour in range(COLOURS):
        numbers = _member(builder, task, NUMBERS, colour)
        builder.store(INTP(0), numbers)
        with cgutils.for_range(builder, count, intp=INTP) as each:
            loop = builder.gep(loops, [builder.add(builder.mul(INTP(colour), to_next), each.index)])
            several, most = builder.load(_member(builder, loop, len(LOOP.elements) - 1)), builder.load(numbers)
            builder.store(builder.select(builder.icmp_signed(">", several, most), several, most), numbers)
        left_out = builder.and_(builder.load(_member(builder, _waiting_loops(), LEFT_OUT)), INTP(1 << colour // 2))
        with builder.if_then(builder.icmp_signed("!=", left_out, INTP(0))):
            builder.store(INTP(0), numbers)
        total = builder.add(total, builder.load(numbers))
    args = cgutils.alloca_once_value(builder, ir.Constant(BYTES, None))
    steps, dimensions = cgutils.alloca_once_value(builder, INTP(1)), cgutils.alloca_once(builder, INTP)
    builder.store(threads, dimensions)
    data = builder.bitcast(task, BYTES)
    alone = builder.or_(builder.icmp_signed("<=", threads, INTP(1)), builder.icmp_signed("<=", total, INTP(1)))
    with builder.if_else(alone) as (then, otherwise):
        with then:
            builder.call(share, [args, dimensions, steps, data])
        with otherwise:
            kind = ir.FunctionType(ir.VoidType(), [BYTES] * 5 + [INTP] * 3)
            parallel_for = cgutils.get_or_insert_function(module, kind, "numba_parallel_for")
            pointers = [builder.bitcast(pointer, BYTES) for pointer in (share, args, dimensions, steps)]
            builder.call(parallel_for, [*pointers, data, INTP(0), INTP(1), threads])
    builder.ret_void()
    return function


def _define_share(module: Any) -> Any:
    """Define and return the LLVM function that runs on each thread: first the thread's own share of chunks, then chunks
    that other threads have not started."""
    function, builder = _define(module, SHARE, "share")
    task = builder.bitcast(function.args[-1], TASK.as_pointer())
    done = _member(builder, task, DONE)
    loops, to_next, count, threads, taken = (builder.load(_member(builder, task, place)) for place in range(LOOPS_AT, NUMBERS))
    own = builder.ptrtoint(builder.load(function.args[0]), INTP)  # steps of one from address 0: the number of the thread
    before = cgutils.alloca_once_value(builder, INTP(0))
    with cgutils.for_range(builder, INTP(COLOURS)) as colour:
        numbers = builder.load(_member(builder, task, NUMBERS, colour.index))
        of_colour = builder.gep(loops, [builder.mul(colour.index, to_next)])
        with builder.if_then(builder.icmp_signed(">", numbers, INTP(0))):
            _await(builder, done, builder.load(before))
            with cgutils.for_range(builder, threads) as further:
                owner = builder.srem(builder.add(own, further.index), threads)
                begin, end = (
                    builder.sdiv(builder.mul(numbers, place), threads) for place in (owner, builder.add(owner, INTP(1)))
                )
                of_owner = builder.gep(taken, [builder.add(builder.mul(owner, INTP(LINE)), colour.index)])
                _do_share(builder, of_owner, begin, end, done, count, of_colour)
        builder.store(builder.add(builder.load(before), numbers), before)
    builder.ret_void()
    return function


def _do_share(builder: Any, taken: Any, begin: Any, end: Any, done: Any, count: Any, loops: Any) -> None:
    """Generate code that runs the items (chunks with the same number in several loops) of a share that no thread has started
    yet.

    taken: address of the counter of started items; begin, end: first item of the share, and its end; done: address of the
    counter of completed items; count, loops: number and address of the loops of a colour.
    """
    head, take, body, on = (builder.append_basic_block(name) for name in ("head", "take", "body", "on"))
    builder.branch(head)
    builder.position_at_end(head)
    left = builder.icmp_signed("<", builder.load_atomic(taken, "monotonic", 8), builder.sub(end, begin))
    builder.cbranch(left, take, on)  # who looks only does not take the line from other cores
    builder.position_at_end(take)
    number = builder.add(begin, builder.atomic_rmw("add", taken, INTP(1), "monotonic"))
    builder.cbranch(builder.icmp_signed("<", number, end), body, on)
    builder.position_at_end(body)
    _do_number(builder, number, count, loops)
    builder.atomic_rmw("add", done, INTP(1), "release")
    builder.branch(head)
    builder.position_at_end(on)


def _await(builder: Any, done: Any, wanted: Any) -> None:
    """Generate code that waits until `wanted` items are completed; done: address of the counter of completed items."""
    looks = cgutils.alloca_once_value(builder, INTP(0))
    look, again, rest, on = (builder.append_basic_block(name) for name in ("look", "again", "rest", "on"))
    builder.store(INTP(0), looks)
    builder.branch(look)
    builder.position_at_end(look)
    found = builder.load_atomic(done, "acquire", 8)
    builder.cbranch(builder.icmp_signed(">=", found, wanted), on, again)
    builder.position_at_end(again)
    count = builder.add(builder.load(looks), INTP(1))
    builder.store(count, looks)
    builder.cbranch(builder.icmp_signed(">", count, INTP(LOOKS)), rest, look)
    builder.position_at_end(rest)
    let_others_run = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.IntType(32), []), "sched_yield")
    builder.call(let_others_run, [])
    builder.branch(look)
    builder.position_at_end(on)


def _do_number(builder: Any, number: Any, count: Any, loops: Any) -> None:
    """Generate code that runs one item of a colour: the chunk with the number `number`, in each of `count` loops one after the
    other."""
    with cgutils.for_range(builder, count, intp=INTP) as each:
        loop = builder.load(builder.gep(loops, [each.index]))
        do_chunk, arguments, *rest = (builder.extract_value(loop, i) for i in range(len(LOOP.elements)))
        chunks = Chunks(*rest)
        with builder.if_then(builder.icmp_signed("<", number, chunks.count)):
            row, place = builder.sdiv(number, chunks.in_row), builder.srem(number, chunks.in_row)
            behind = builder.add(builder.mul(row, chunks.row_step), builder.mul(place, chunks.step))
            builder.call(do_chunk, [arguments, builder.add(chunks.first, behind)])
