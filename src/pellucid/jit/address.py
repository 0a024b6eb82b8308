"""An array as an argument of a kernel, by the address of its first number alone.

Numba passes an array as seven numbers. A kernel that is called for each block of points would spend more time on these than
on some of its work. Elements are read and written as those of an array; the length is not known, so
indices must not be negative.
"""

import operator
from typing import Any

from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model


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
