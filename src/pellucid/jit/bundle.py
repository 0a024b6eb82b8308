"""A tuple of anything as one opaque argument of a parallel loop.

Numba takes tuples that enter a `prange` body apart and fails where they nest. A `Bundle` is compiled as a structure with one
member, which passes untouched.
"""

from typing import Any

from numba.core import types
from numba.extending import NativeValue, make_attribute_wrapper, models, register_model, typeof_impl, unbox


class Bundle:
    """Holds `content`, a tuple. Its compiled type is found once, so a bundle that is kept costs little to pass."""

    __slots__ = ("compiled_type", "content")

    def __init__(self, *content: Any) -> None:
        self.content = content
        self.compiled_type: BundleType | None = None


class BundleType(types.Type):
    """The compiled type of a `Bundle`."""

    def __init__(self, content: types.Type) -> None:
        self.content = content
        super().__init__(name=f"Bundle({content})")


@typeof_impl.register(Bundle)
def _typeof(value: Bundle, context: Any) -> BundleType:
    if value.compiled_type is None:
        value.compiled_type = BundleType(typeof_impl(value.content, context))
    return value.compiled_type


@register_model(BundleType)
class _BundleModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, bundle: BundleType) -> None:
        super().__init__(manager, bundle, [("content", bundle.content)])


make_attribute_wrapper(BundleType, "content", "content")


@unbox(BundleType)
def _unbox(bundle: BundleType, value: Any, c: Any) -> NativeValue:
    from numba.core import cgutils

    content = c.pyapi.object_getattr_string(value, "content")
    native = c.unbox(bundle.content, content)
    c.pyapi.decref(content)
    structure = cgutils.create_struct_proxy(bundle)(c.context, c.builder)
    structure.content = native.value
    return NativeValue(structure._getvalue(), is_error=native.is_error, cleanup=native.cleanup)
