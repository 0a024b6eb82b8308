"""A named tuple as one argument of kernels, whose compiled form is made once.

Numba takes a tuple apart at every call, member by member, with code of its own in every kernel that Python calls. A `Bundle` is
taken apart once, into memory that it keeps; kernels take the address, and read the members by name.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from pellucid.jit.kernels import kernel

ADDRESS = ir.IntType(8).as_pointer()


class Bundle:
    """Holds `content`, a named tuple of arrays, numbers and tuples of these; its members are those of the bundle too."""

    __slots__ = ("address", "compiled_type", "content", "memory")
    address: int
    memory: np.ndarray

    def __init__(self, content: Any) -> None:
        self.content = content
        self.compiled_type: BundleType | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self.content, name)


class BundleType(types.Type):
    """The compiled type of a `Bundle`."""

    def __init__(self, content: types.Type) -> None:
        self.content: Any = content
        super().__init__(name=f"Bundle({content})")


@typeof_impl.register(Bundle)
def _typeof(value: Bundle, context: Any) -> BundleType:
    if value.compiled_type is None:
        value.compiled_type = BundleType(typeof_impl(value.content, context))
        value.memory = np.empty(-(-_pack(value.content, 0) // 8))  # of eight bytes each
        value.address = value.memory.ctypes.data
        _pack(value.content, value.address)
    return value.compiled_type


@register_model(BundleType)
class _BundleModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, bundle: BundleType) -> None:
        super().__init__(manager, bundle, ADDRESS)


@unbox(BundleType)
def _unbox(bundle: BundleType, value: Any, c: Any) -> NativeValue:
    number = c.pyapi.object_getattr_string(value, "address")
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return NativeValue(address)


@infer_getattr
class _Members(AttributeTemplate):  # type: ignore[misc]
    key = BundleType

    def generic_resolve(self, bundle: BundleType, name: str) -> types.Type | None:
        fields = bundle.content.fields
        return bundle.content[fields.index(name)] if name in fields else None


@lower_getattr_generic(BundleType)
def _member(context: Any, builder: Any, bundle: BundleType, address: Any, name: str) -> Any:
    place = bundle.content.fields.index(name)
    content = builder.bitcast(address, context.get_data_type(bundle.content).as_pointer())
    return context.unpack_value(builder, bundle.content[place], cgutils.gep_inbounds(builder, content, 0, place))


@kernel()
def _pack(content, address):  # type: ignore[no-untyped-def]
    return _store(content, address)


@intrinsic
def _store(typing: Any, content: Any, address: Any) -> Any:
    """Store a tuple where `address` is not 0; the number of bytes that it takes."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        value, address = values
        kind = context.get_data_type(content)
        with builder.if_then(builder.icmp_signed("!=", address, address.type(0))):
            pointer = builder.inttoptr(address, kind.as_pointer())
            context.pack_value(builder, content, _unowned(context, builder, content, value), pointer)
        return cgutils.intp_t(context.get_abi_sizeof(kind))

    return types.intp(content, types.intp), emit


def _unowned(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value with arrays that count no references: the bundle keeps them alive."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
        for place, part in enumerate(kind):
            member = _unowned(context, builder, part, builder.extract_value(value, place))
            value = builder.insert_value(value, member, place)
        return value
    if context.data_model_manager[kind].contains_nrt_meminfo():
        raise TypeError(f"a bundle cannot hold {kind}")
    return value
