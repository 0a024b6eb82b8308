"""Loops that threads share: the chunks of a kernel are handed out to numba's own threads.

A `prange` loop compiles all that its body calls several times over, seconds for every driver that only hands out slabs. Here
the loop is a small function that numba's runtime calls on each thread, and it calls the kernel of a chunk where that lies: its
code is not made a second time, which would cost as much as the first and may round otherwise.

Threads that begin and end a loop together wait for each other, which costs small bodies more than a second thread gains. So
the loops of several bodies can become one region, see `pellucid.jit.joint`.
"""

from typing import Any, NamedTuple

import llvmlite.binding
import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.region import BYTES, COLOURS, DO_CHUNK, INTP, LOOP, Chunks, fill, run

MOST, ROOM = 256, 65536
"""So many loops of a colour can wait, and their arguments take so many bytes; what is beyond is done at once."""
WAITING = ir.LiteralStructType([INTP, INTP, ir.ArrayType(INTP, COLOURS), ir.ArrayType(ir.ArrayType(LOOP, MOST), COLOURS),
                                ir.ArrayType(ir.IntType(8), ROOM)])  # fmt: skip
"""Whether loops wait, the bytes in use, how many loops of each colour there are, these, their arguments."""
OPEN, USED, COUNTS, LOOPS, ARGUMENTS = range(5)
waiting = np.zeros(2 + COLOURS + COLOURS * MOST * len(LOOP.elements) + ROOM // 8, np.int64)
"""The memory of WAITING."""
llvmlite.binding.add_symbol("pellucid_waiting_loops", waiting.ctypes.data)


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
    for chunk in range(count):
        kernel(chunk, *arguments)


def _plain_by_colour(kernel: Any, count: int, across: int, *arguments: Any) -> None:
    for colour in range(COLOURS):
        for row in range(colour // 2 * across, count, 2 * across):
            for chunk in range(row + colour % 2, row + across, 2):
                kernel(chunk, *arguments)


def _every_chunk(builder: Any, count: Any) -> list[Chunks]:
    return [Chunks(INTP(0), INTP(1), INTP(0), INTP(1), count)]


def _chunks_by_colour(builder: Any, count: Any, across: Any) -> list[Chunks]:
    """Every other chunk of every other row, of `across` chunks each."""
    rows, found = builder.sdiv(count, across), []
    for colour in range(COLOURS):
        row, place = INTP(colour // 2), INTP(colour % 2)
        n_rows = builder.ashr(builder.add(builder.sub(rows, row), INTP(1)), INTP(1))
        in_row = builder.ashr(builder.add(builder.sub(across, place), INTP(1)), INTP(1))
        first = builder.add(builder.mul(row, across), place)
        found.append(Chunks(first, in_row, INTP(2), builder.mul(INTP(2), across), builder.mul(n_rows, in_row)))
    return found


def _loop(typing: Any, kernel: Any, sizes: list[Any], arguments: Any, joint: bool) -> Any:
    """Type and code of a loop over chunks; sizes: how many, and for one by colour how many are in a row."""
    from numba.np.ufunc.parallel import _launch_threads

    _launch_threads()  # the runtime's symbols are known from then on
    given = (types.intp, *arguments)
    kernel.get_call_type(typing, given, {})
    compiled = kernel.dispatcher.get_compile_result(types.none(*given))
    signature = types.none(kernel, *[types.intp] * len(sizes), types.StarArgTuple(arguments))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        *given_sizes, together = values[1:]
        chunk_kernels(context.active_code_library).append(ChunkKernel(kernel.dispatcher.py_func, given, compiled))
        packed = cgutils.pack_struct(builder, cgutils.unpack_tuple(builder, together, len(arguments)))
        do_chunk = _do_chunk(context, builder.module, packed.type, compiled, given)
        size = context.get_abi_sizeof(packed.type)
        colours = (_every_chunk if len(sizes) == 1 else _chunks_by_colour)(builder, *given_sizes)
        if joint:
            with builder.if_else(_can_wait(builder, size)) as (then, otherwise):
                with then:
                    _wait(builder, do_chunk, packed, size, colours)
                with otherwise:
                    _run_at_once(builder, do_chunk, packed, colours)
        else:
            _run_at_once(builder, do_chunk, packed, colours)
        return context.get_dummy_value()

    return signature, emit


class ChunkKernel(NamedTuple):
    """A kernel that the code of a driver refers to by name: it must be there before the driver is."""

    function: Any
    arguments: tuple[Any, ...]
    compiled: Any

    @property
    def symbol(self) -> str:
        """The name."""
        return str(self.compiled.fndesc.llvm_func_name)


def chunk_kernels(library: Any) -> list[ChunkKernel]:
    """Those that the code of a library refers to, without those of libraries within it; they live as long as it does."""
    if not hasattr(library, "chunk_kernels"):
        library.chunk_kernels = []
    kept: list[ChunkKernel] = library.chunk_kernels
    return kept


def _do_chunk(context: Any, module: Any, packed: Any, compiled: Any, given: Any) -> Any:
    """The function that does one chunk."""
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


def _run_at_once(builder: Any, do_chunk: Any, packed: Any, colours: list[Chunks]) -> None:
    arguments = cgutils.alloca_once(builder, packed.type)
    builder.store(packed, arguments)
    loops = [cgutils.alloca_once(builder, LOOP) for _ in colours]
    for loop, chunks in zip(loops, colours, strict=True):
        fill(builder, loop, do_chunk, builder.bitcast(arguments, BYTES), *chunks)
    run(builder, [(chunks.count, INTP(1), loop) for loop, chunks in zip(loops, colours, strict=True)])


def waiting_loops(module: Any) -> Any:
    """WAITING, as code knows it."""
    name = "pellucid_waiting_loops"
    return module.globals.get(name) or ir.GlobalVariable(module, WAITING, name)


def _can_wait(builder: Any, size: int) -> Any:
    """Whether loops wait, and there is room for one of each colour, with `size` bytes of arguments."""
    place = waiting_loops(builder.module)
    found = builder.icmp_signed("!=", builder.load(cgutils.gep_inbounds(builder, place, 0, OPEN)), INTP(0))
    used = builder.load(cgutils.gep_inbounds(builder, place, 0, USED))
    found = builder.and_(found, builder.icmp_signed("<=", builder.add(used, INTP(size)), INTP(ROOM)))
    for colour in range(COLOURS):
        count = builder.load(cgutils.gep_inbounds(builder, place, 0, COUNTS, colour))
        found = builder.and_(found, builder.icmp_signed("<", count, INTP(MOST)))
    return found


def _wait(builder: Any, do_chunk: Any, packed: Any, size: int, colours: list[Chunks]) -> None:
    """Put a loop down."""
    place = waiting_loops(builder.module)
    at = cgutils.gep_inbounds(builder, place, 0, USED)
    used = builder.load(at)
    arguments = cgutils.gep_inbounds(builder, place, 0, ARGUMENTS, used)
    builder.store(packed, builder.bitcast(arguments, packed.type.as_pointer()), align=8)
    builder.store(builder.add(used, INTP((size + 7) // 8 * 8)), at)
    for colour, chunks in enumerate(colours):
        at = cgutils.gep_inbounds(builder, place, 0, COUNTS, colour)
        count = builder.load(at)
        loop = cgutils.gep_inbounds(builder, place, 0, LOOPS, colour, count)
        fill(builder, loop, do_chunk, arguments, *chunks)
        builder.store(builder.add(count, INTP(1)), at)


# Call a kernel with the number of each chunk from 0 to count - 1, and the arguments, in any order on the threads. The kernel
# must return nothing; what it raises is lost. Within a `joint_region` joint loops wait for its end.
parallel_for, joint_for = _driver(False), _driver(True)
# The same with the number of chunks in a row before the arguments: every other chunk of every other row, the others of these
# rows, and the same of the rows between, so that neighbours are never done at the same time.
parallel_by_colour, joint_by_colour = _driver_by_colour(False), _driver_by_colour(True)
