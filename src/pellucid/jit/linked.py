"""Calls of compiled kernels by their symbol, without a copy of their code in the caller.

Numba links the code of a called kernel into each caller and optimizes it again there. With `call_kernel`, the caller only
refers to the kernel, so callers with different types share one compiled kernel. A call costs some nanoseconds; kernels that
are called for each block of points gain nothing by a copy.
"""

from typing import Any, NamedTuple

import numba
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.address import AddressType, address_of, by_address


class LinkedKernel(NamedTuple):
    """A compiled kernel, by function and argument types, to which other compiled code refers by name; the kernel must be
    loaded before this code."""

    function: Any  # Python function of the kernel
    arguments: tuple[Any, ...]  # compiled types of its arguments
    compiled: Any  # numba's result of the compilation

    @property
    def symbol(self) -> str:
        """Name of the kernel in compiled code, to which callers refer."""
        return str(self.compiled.fndesc.llvm_func_name)


def linked_kernels(library: Any) -> list[LinkedKernel]:
    """Return the list of kernels that the code of a library (a unit of compiled code) refers to by name, without nested
    libraries. The list exists as long as the library."""
    if not hasattr(library, "linked_kernels"):
        library.linked_kernels = []
    kept: list[LinkedKernel] = library.linked_kernels
    return kept


def compiled_for(dispatcher: Any, arguments: tuple[Any, ...]) -> LinkedKernel:
    """Return a kernel compiled for the argument types `arguments`, compiled now or loaded from the cache; dispatcher: numba's
    object for the kernel."""
    dispatcher.compile(arguments)
    return LinkedKernel(dispatcher.py_func, arguments, dispatcher.overloads[arguments])


@intrinsic
def _call_kernel(typing: Any, kernel: Any, *arguments: Any) -> Any:
    given = tuple(map(by_address, arguments))
    linked = compiled_for(kernel.dispatcher, given)
    result = linked.compiled.signature.return_type
    signature = result(kernel, types.StarArgTuple(arguments))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        linked_kernels(context.active_code_library).append(linked)
        callee = context.declare_function(builder.module, linked.compiled.fndesc)
        parts = cgutils.unpack_tuple(builder, values[1], len(arguments))
        passed = [
            address_of(context, builder, kind, value) if isinstance(to, AddressType) else value
            for kind, to, value in zip(arguments, given, parts, strict=True)
        ]
        _, found = context.call_conv.call_function(builder, callee, result, given, passed)
        return found

    return signature, emit


def _plain_call(kernel: Any, *arguments: Any) -> Any:
    return kernel(*arguments)


# call_kernel(kernel, *arguments): call an inner kernel. Exceptions in it are lost, and arrays of one axis have no length there.
call_kernel = _plain_call if numba.config.DISABLE_JIT else _call_kernel
