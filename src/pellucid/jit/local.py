"""Local arrays of a kernel, in its stack frame: scratch memory of a fixed size without memory allocation.

`numbers` and `indices` create an array of doubles or of int64 with undefined content, `zeros` an array of zero doubles. The
arrays exist until the kernel that created them returns, so a kernel must not return one.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from pellucid.jit.kernels import LINE


def _maker(kind: Any, cleared: bool) -> Any:
    @intrinsic
    def make(typing: Any, length: Any) -> Any:
        made = types.Array(kind, 1, "C")

        def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            size = context.get_abi_sizeof(context.get_data_type(kind))
            data = builder.alloca(context.get_data_type(kind), size=values[0])
            data.align = LINE
            if cleared:
                byte = ir.IntType(8)
                arguments = byte.as_pointer(), byte, ir.IntType(64), ir.IntType(1)
                fill = builder.module.declare_intrinsic("llvm.memset", arguments[:1] + arguments[2:3])
                bytes_in_all = builder.mul(values[0], values[0].type(size))
                builder.call(fill, [builder.bitcast(data, arguments[0]), byte(0), bytes_in_all, ir.IntType(1)(0)])
            array = context.make_array(made)(context, builder)
            step = context.get_constant(types.intp, size)
            populate_array(array, data=data, shape=[values[0]], strides=[step], itemsize=step, meminfo=None)
            return array._getvalue()

        return made(types.intp), emit

    return make


def _plain_numbers(length: int) -> np.ndarray:
    return np.full(length, np.nan)


def _plain_indices(length: int) -> np.ndarray:
    return np.full(length, -1, np.int64)


_PLAIN = _plain_numbers, np.zeros, _plain_indices
_COMPILED = _maker(types.float64, False), _maker(types.float64, True), _maker(types.int64, False)
numbers, zeros, indices = _PLAIN if numba.config.DISABLE_JIT else _COMPILED
