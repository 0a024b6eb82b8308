"""A named tuple as one argument of kernels, whose compiled form is built once.

Numba unpacks a tuple at every call, member by member, with separate code in every kernel that Python calls. A `Bundle` is
unpacked once, into memory that it owns. Kernels receive its address and read the members by name. A member that is itself a
bundle lies within this memory and is an address too; otherwise all its members would be read at each access, with much more
code.

The row length of arrays is part of the compiled type. With a row length known only at run time, LLVM does not vectorize
loops over rows.
"""

import hashlib
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)
from numba.np.numpy_support import as_dtype

from pellucid.jit.sources import described

ADDRESS = ir.IntType(8).as_pointer()
ROWS = 3, 6, 9, 10
"""Row lengths for which kernels are compiled: vectors, symmetric and other tensors, affine fields."""


class Bundle:
    """A kernel argument that holds `content`, a named tuple of arrays, numbers, bundles and tuples of the same. Its members
    are accessed as attributes of the bundle."""

    __slots__ = ("address", "compiled_type", "content", "memory", "type_name")
    address: int  # address of `memory`, which compiled code receives
    memory: np.ndarray  # the members as compiled code stores them; filled at the first call of a kernel

    def __init__(self, content: Any) -> None:
        self.content = content
        self.compiled_type: BundleType | None = None
        self.type_name: str | None = None  # as soon as there is the type

    def __getattr__(self, name: str) -> Any:
        return getattr(self.content, name)


class BundleType(types.Type):
    """Compiled type of a `Bundle`, a named tuple that kernels receive as one argument."""

    def __init__(self, content: types.Type, rows: Any) -> None:
        self.content: Any = content
        self.rows = rows  # as `_rows_of` gives them
        text = f"{described(content)} {rows}"
        super().__init__(name=f"Bundle_{hashlib.sha256(text.encode()).hexdigest()[:16]}")


@typeof_impl.register(Bundle)
def _typeof(value: Bundle, context: Any) -> BundleType:
    if value.compiled_type is None:
        content = typeof_impl(value.content, context)
        value.memory = np.array(_native(value.content, content), dtype=_layout(content))
        value.address = value.memory.ctypes.data
        value.compiled_type = BundleType(content, _rows_of(value.content))
        value.type_name = value.compiled_type.name
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
    kind = bundle.content[place]
    _, begin = _layout(bundle.content).fields[f"f{place}"]  # type: ignore[index, misc]
    there = cgutils.gep_inbounds(builder, address, begin)
    if isinstance(kind, BundleType):
        return there
    value = context.unpack_value(builder, kind, builder.bitcast(there, context.get_data_type(kind).as_pointer()))
    return _with_rows(context, builder, kind, value, bundle.rows[place])


def _rows_of(value: Any) -> Any:
    """Return the length and the strides [bytes] of the rows of an array, or None if kernels are not compiled for rows of this
    length; for a tuple, a tuple of the results for its members."""
    if isinstance(value, tuple):
        return tuple(_rows_of(part) for part in value)
    if not (isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype == np.float64 and value.shape[1] in ROWS):
        return None
    # numpy says of an array without rows that its strides are zero
    strides = (value.itemsize * value.shape[1], value.itemsize) if value.flags.c_contiguous else value.strides
    return value.shape[1], *strides


def _with_rows(context: Any, builder: Any, kind: Any, value: Any, rows: Any) -> Any:
    """Return a member of a bundle in generated code, with the row lengths of its arrays as constants.

    context, builder: numba's target context and LLVM builder; kind: compiled type of the member; rows: result of `_rows_of`.
    value: the member as stored.
    """
    if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
        for place, (part, inner) in enumerate(zip(kind, rows, strict=True)):
            if inner is not None:
                found = _with_rows(context, builder, part, builder.extract_value(value, place), inner)
                value = builder.insert_value(value, found, place)
    elif rows is not None:
        length, *strides = (context.get_constant(types.intp, number) for number in rows)
        array = context.make_array(kind)(context, builder, value)
        array.shape = cgutils.pack_array(builder, [builder.extract_value(array.shape, 0), length])
        array.strides = cgutils.pack_array(builder, strides)
        return array._getvalue()
    return value


@cache
def _layout(kind: Any) -> np.dtype[Any]:
    """Return the memory layout of a compiled type as a numpy type. Raises TypeError for types that a bundle cannot hold."""
    if isinstance(kind, types.Array):
        dimensions = np.dtype([(f"f{axis}", np.intp) for axis in range(kind.ndim)])
        names = ("meminfo", "parent", "nitems", "itemsize", "data")
        return np.dtype([*((name, np.intp) for name in names), ("shape", dimensions), ("strides", dimensions)], align=True)
    if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
        return np.dtype([(f"f{place}", _layout(part)) for place, part in enumerate(kind)], align=True)
    if isinstance(kind, BundleType):
        return _layout(kind.content)
    if isinstance(kind, types.Integer | types.Float | types.Boolean):  # type: ignore[attr-defined]
        return as_dtype(kind)
    raise TypeError(f"a bundle cannot contain a value of the type {kind}")


def _native(value: Any, kind: Any) -> Any:
    """Return a value as nested tuples of numbers, as compiled code stores its type `kind`. Arrays have no reference count,
    since the bundle keeps them alive."""
    if isinstance(kind, types.Array):
        return 0, 0, value.size, value.itemsize, value.ctypes.data, value.shape, value.strides
    if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
        return tuple(_native(part, inner) for part, inner in zip(value, kind, strict=True))
    return _native(value.content, kind.content) if isinstance(kind, BundleType) else value
