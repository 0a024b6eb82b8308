"""A parallel region: threads that do the chunks of some loops, colour after colour, until none is left.

Each thread takes the next number until there is none. The numbers of a colour begin where those of the one before end, and a
thread that takes one waits until all before the colour's are done. So the region is entered and left once, which costs as much
as some hundred points. Who waits looks for some microseconds, no longer than most chunks take, and then lets others run.
"""

from typing import Any, NamedTuple

from llvmlite import ir
from numba.core import cgutils

INTP = cgutils.intp_t
BYTES = ir.IntType(8).as_pointer()
DO_CHUNK = ir.FunctionType(ir.VoidType(), [BYTES, INTP])
"""Does the chunk of a number with the arguments at an address."""
LOOP = ir.LiteralStructType([DO_CHUNK.as_pointer(), BYTES, INTP, INTP, INTP, INTP, INTP])
"""Chunks of a kernel in rows: how one is done, the arguments, and what `Chunks` has."""
COLOURS = 4
COLOUR = ir.LiteralStructType([INTP, INTP, LOOP.as_pointer()])
"""How many numbers a colour has, how many loops, these. A number is a chunk of each loop that has so many."""
TASK = ir.LiteralStructType([INTP, INTP, *COLOURS * [COLOUR]])
"""What threads share: how many numbers are taken, how many are done, the colours."""
SHARE = ir.FunctionType(ir.VoidType(), [BYTES.as_pointer(), INTP.as_pointer(), INTP.as_pointer(), BYTES])
"""What numba's runtime calls on each thread."""
LOOKS = 5000
"""How often a thread looks whether others are done, before it lets others run each time."""


class Chunks(NamedTuple):
    """Chunks in rows: the first, so many in a row, the steps to the next in it and to the next row, how many in all."""

    first: Any
    in_row: Any
    step: Any
    row_step: Any
    count: Any


def fill(builder: Any, struct: Any, *values: Any) -> None:
    """Store the members of a struct."""
    for place, value in enumerate(values):
        builder.store(value, cgutils.gep_inbounds(builder, struct, 0, place))


def run(builder: Any, colours: list[tuple[Any, Any, Any]]) -> None:
    """Do the colours, with members as COLOUR has them, on numba's threads; on this one where there is nothing to divide."""
    module = builder.module
    task = cgutils.alloca_once(builder, TASK)
    fill(builder, task, INTP(0), INTP(0))
    total = INTP(0)
    for place in range(COLOURS):
        members = colours[place] if place < len(colours) else (INTP(0), INTP(0), ir.Constant(LOOP.as_pointer(), None))
        fill(builder, cgutils.gep_inbounds(builder, task, 0, 2 + place), *members)
        total = builder.add(total, members[0])
    args = cgutils.alloca_once_value(builder, ir.Constant(BYTES, None))
    steps = cgutils.alloca_once_value(builder, INTP(1))
    dimensions = cgutils.alloca_once(builder, INTP)
    asked = cgutils.get_or_insert_function(module, ir.FunctionType(INTP, []), "get_num_threads")
    threads = builder.sext(builder.trunc(builder.call(asked, []), ir.IntType(32)), INTP)
    builder.store(threads, dimensions)
    share, data = _share(module), builder.bitcast(task, BYTES)
    alone = builder.or_(builder.icmp_signed("<=", threads, INTP(1)), builder.icmp_signed("<=", total, INTP(1)))
    with builder.if_else(alone) as (then, otherwise):
        with then:
            builder.call(share, [args, dimensions, steps, data])
        with otherwise:
            kind = ir.FunctionType(ir.VoidType(), [BYTES] * 5 + [INTP] * 3)
            parallel_for = cgutils.get_or_insert_function(module, kind, "numba_parallel_for")
            pointers = [builder.bitcast(pointer, BYTES) for pointer in (share, args, dimensions, steps)]
            builder.call(parallel_for, [*pointers, data, INTP(0), INTP(1), threads])


def _share(module: Any) -> Any:
    """The function that each thread runs."""
    name = "pellucid.share"
    if name in module.globals:
        return module.globals[name]
    function = ir.Function(module, SHARE, name)
    function.linkage = "internal"
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    task = builder.bitcast(function.args[-1], TASK.as_pointer())
    taken, done = (cgutils.gep_inbounds(builder, task, 0, place) for place in range(2))
    colours = [
        [builder.load(cgutils.gep_inbounds(builder, task, 0, 2 + colour, member)) for member in range(3)]
        for colour in range(COLOURS)
    ]
    begins = [INTP(0)]
    for numbers, _, _ in colours:
        begins.append(builder.add(begins[-1], numbers))
    head, body, end = (function.append_basic_block(name) for name in ("head", "body", "end"))
    builder.branch(head)
    builder.position_at_end(head)
    number = builder.atomic_rmw("add", taken, INTP(1), "monotonic")
    builder.cbranch(builder.icmp_signed("<", number, begins[-1]), body, end)
    builder.position_at_end(body)
    begin, (_, count, loops) = begins[0], colours[0]
    for start, (_, its_count, its_loops) in zip(begins[1:], colours[1:], strict=False):
        reached = builder.icmp_signed(">=", number, start)
        begin = builder.select(reached, start, begin)
        count, loops = builder.select(reached, its_count, count), builder.select(reached, its_loops, loops)
    _await(builder, done, begin)
    _do_number(builder, builder.sub(number, begin), count, loops)
    builder.atomic_rmw("add", done, INTP(1), "release")
    builder.branch(head)
    builder.position_at_end(end)
    builder.ret_void()
    return function


def _await(builder: Any, done: Any, wanted: Any) -> None:
    """Wait until so many numbers are done."""
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
    """The chunks of a number of a colour, of one loop after the other."""
    with cgutils.for_range(builder, count, intp=INTP) as each:
        loop = builder.load(builder.gep(loops, [each.index]))
        do_chunk, arguments, *rest = (builder.extract_value(loop, i) for i in range(len(LOOP.elements)))
        chunks = Chunks(*rest)
        with builder.if_then(builder.icmp_signed("<", number, chunks.count)):
            row, place = builder.sdiv(number, chunks.in_row), builder.srem(number, chunks.in_row)
            behind = builder.add(builder.mul(row, chunks.row_step), builder.mul(place, chunks.step))
            builder.call(do_chunk, [arguments, builder.add(chunks.first, behind)])
