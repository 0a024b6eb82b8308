"""One loop that threads share: the chunks of a kernel are handed out by numba's own threads.

A `prange` loop compiles all that its body calls several times over, seconds for every driver that only hands out slabs. Here
the loop is a small function that numba's runtime calls on each thread, and it calls the kernel of a chunk where that lies: its
code is not made a second time, which would cost as much as the first and may round otherwise.
"""

from typing import Any, NamedTuple

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic


def _plain(kernel: Any, count: int, *arguments: Any) -> None:
    for chunk in range(count):
        kernel(chunk, *arguments)


def _plain_by_colour(kernel: Any, count: int, *arguments: Any) -> None:
    for colour in range(2):
        for chunk in range(colour, count, 2):
            kernel(chunk, *arguments)


@intrinsic
def _compiled(typing: Any, kernel: Any, count: Any, *arguments: Any) -> Any:
    return _loops(typing, kernel, arguments, lambda builder, count: [(0, 1, count)])


@intrinsic
def _compiled_by_colour(typing: Any, kernel: Any, count: Any, *arguments: Any) -> Any:
    def shares(builder: Any, count: Any) -> list[tuple[int, int, Any]]:
        odd = builder.ashr(count, INTP(1))
        return [(0, 2, builder.sub(count, odd)), (1, 2, odd)]

    return _loops(typing, kernel, arguments, shares)


def _loops(typing: Any, kernel: Any, arguments: Any, shares: Any) -> Any:
    """Type and code of loops over chunks, each from a first one on in steps, so many of them, as `shares` says."""
    from numba.np.ufunc.parallel import _launch_threads

    _launch_threads()  # the runtime's symbols are known from then on
    given = (types.intp, *arguments)
    kernel.get_call_type(typing, given, {})
    compiled = kernel.dispatcher.get_compile_result(types.none(*given))
    signature = types.none(kernel, types.intp, types.StarArgTuple(arguments))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        _, count, together = values
        chunk_kernels(context.active_code_library).append(ChunkKernel(kernel.dispatcher.py_func, given, compiled))
        rest = cgutils.unpack_tuple(builder, together, len(arguments))
        packed = ir.LiteralStructType([INTP, INTP, *(value.type for value in rest)])
        data = cgutils.alloca_once(builder, packed)
        for place, value in enumerate(rest):
            builder.store(value, cgutils.gep_inbounds(builder, data, 0, place + 2))
        share = _share(context, builder.module, packed, compiled, given)
        for first, step, number in shares(builder, count):
            builder.store(INTP(first), cgutils.gep_inbounds(builder, data, 0, 0))
            builder.store(INTP(step), cgutils.gep_inbounds(builder, data, 0, 1))
            _launch(builder, share, number, data)
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


BYTES = ir.IntType(8).as_pointer()
INTP = cgutils.intp_t
SHARE = ir.FunctionType(ir.VoidType(), [BYTES.as_pointer(), INTP.as_pointer(), INTP.as_pointer(), BYTES])


def _share(context: Any, module: Any, packed: Any, compiled: Any, given: Any) -> Any:
    """The function that a thread runs: the chunks from the number in args[0] on, dimensions[0] of them."""
    name = module.get_unique_name(f"share.{compiled.fndesc.mangled_name}")
    function = ir.Function(module, SHARE, name)
    function.linkage = "internal"
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    args, dimensions, _, data = function.args
    data = builder.bitcast(data, packed.as_pointer())
    start, step, *rest = (builder.load(cgutils.gep_inbounds(builder, data, 0, i)) for i in range(len(packed.elements)))
    first = builder.ptrtoint(builder.load(args), INTP)
    callee = context.declare_function(module, compiled.fndesc)
    with cgutils.for_range(builder, builder.load(dimensions), intp=INTP) as loop:
        chunk = builder.add(start, builder.mul(builder.add(first, loop.index), step))
        context.call_conv.call_function(builder, callee, types.none, given, [chunk, *rest])
    builder.ret_void()
    return function


def _launch(builder: Any, share: Any, count: Any, data: Any) -> None:
    """Run `count` chunks on numba's threads, on this one where there is nothing to divide."""
    module = builder.module
    args = cgutils.alloca_once_value(builder, ir.Constant(BYTES, None))  # a thread gets the number of its first chunk
    dimensions = cgutils.alloca_once(builder, INTP)
    builder.store(count, dimensions)
    steps = cgutils.alloca_once_value(builder, INTP(1))
    data = builder.bitcast(data, BYTES)
    asked = cgutils.get_or_insert_function(module, ir.FunctionType(INTP, []), "get_num_threads")
    threads = builder.sext(builder.trunc(builder.call(asked, []), ir.IntType(32)), INTP)
    alone = builder.or_(builder.icmp_signed("<=", threads, INTP(1)), builder.icmp_signed("<=", count, INTP(1)))
    with builder.if_else(alone) as (then, otherwise):
        with then:
            builder.call(share, [args, dimensions, steps, data])
        with otherwise:
            kind = ir.FunctionType(ir.VoidType(), [BYTES] * 5 + [INTP] * 3)
            parallel_for = cgutils.get_or_insert_function(module, kind, "numba_parallel_for")
            pointers = [builder.bitcast(pointer, BYTES) for pointer in (share, args, dimensions, steps)]
            builder.call(parallel_for, [*pointers, data, INTP(0), INTP(1), threads])


# Call a kernel with the number of each chunk from 0 to count - 1, and the arguments: in any order on the threads, or first the
# even ones and then the odd ones. The kernel must return nothing; what it raises is lost.
parallel_for, parallel_by_colour = (_plain, _plain_by_colour) if numba.config.DISABLE_JIT else (_compiled, _compiled_by_colour)
