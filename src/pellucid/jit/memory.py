"""Memory of kernels: local arrays in their stack frame, and arrays that are passed by address.

`numbers` and `indices` create an array of doubles or of int64 with undefined content, `zeros` an array of zero doubles, in
the stack frame of a kernel: scratch memory of a fixed size without memory allocation. The arrays exist until the kernel that
created them returns, so a kernel must not return one.

Numba passes an array as seven numbers. A kernel that is called for each block of points would spend more time on these than
on some of its work. `call_kernel` therefore passes the address of the first number alone. Elements are read and written as
those of an array; the length is not known, so indices must not be negative.
"""

import operator
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np.arrayobj import populate_array

from pellucid.jit.registry import LINE


class AddressType(types.Type):
    """Compiled type of an array that is passed by its address."""

    def __init__(self, dtype: Any) -> None:
        self.dtype: Any = dtype
        super().__init__(name=f"Address({dtype})")


@register_model(AddressType)
class _AddressModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: AddressType) -> None:
        super().__init__(manager, kind, manager.lookup(kind.dtype).get_data_type().as_pointer())


def by_address(kind: Any) -> Any:
    """Return the compiled type in which an argument of the type `kind` is passed: arrays with one axis by the address of their
    first number, all others unchanged."""
    is_row = isinstance(kind, types.Array) and kind.ndim == 1 and kind.layout == "C" and isinstance(kind.dtype, types.Number)
    return AddressType(kind.dtype) if is_row else kind


def address_of(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Return the address of the first number of an array, in generated code.

    context, builder: numba's target context and LLVM builder; kind: compiled type of the array.
    """
    return array if isinstance(kind, AddressType) else context.make_array(kind)(context, builder, array).data


def _index(index: Any) -> Any:
    return types.intp if index.signed else types.uintp


@infer_global(operator.getitem)
class _Read(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        array, index = args
        if isinstance(array, AddressType) and isinstance(index, types.Integer):
            return signature(array.dtype, array, _index(index))
        return None


@infer_global(operator.setitem)
class _Write(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        array, index, _ = args
        if isinstance(array, AddressType) and isinstance(index, types.Integer):
            return signature(types.none, array, _index(index), array.dtype)
        return None


@lower_builtin(operator.getitem, AddressType, types.Integer)
def _read(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    return builder.load(builder.gep(values[0], [values[1]], inbounds=True))


@lower_builtin(operator.setitem, AddressType, types.Integer, types.Any)
def _write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    builder.store(values[2], builder.gep(values[0], [values[1]], inbounds=True))
    return context.get_dummy_value()


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
