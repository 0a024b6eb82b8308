"""Calls of kernels: from other kernels by their symbol, from Python with a fast lookup, and as a record without execution.

Numba links the code of a called kernel into each caller and optimizes it again there. With `call_kernel`, the caller only
refers to the kernel, so callers with different types share one compiled kernel. A call costs some nanoseconds; kernels that
are called for each block of points gain nothing by a copy.

At each call from Python numba determines the compiled types of the arguments. The lookup takes four microseconds for a
bundle, as long as a small kernel runs, and twenty for a named tuple of a few arrays. For types that the kernel has been
called with before, a lookup in Python finds the compiled code, which is called directly (`KernelDispatcher`). Without bundles
numba determines the types faster.
"""

import ast
import inspect
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.core import cgutils, types
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

from pellucid.jit.bundle import Bundle
from pellucid.jit.memory import AddressType, address_of, by_address


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


PLAIN = int, float, bool, np.float64
"""Python types that numba always compiles as the same type."""


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """Dispatcher of a kernel (numba's object that calls it), which finds the compiled code for argument types by a fast
    lookup in Python."""

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel, after compiling it for these argument types if necessary; return its result."""
        kinds = tuple(map(_kind, arguments))
        entry = self.entries.get(kinds)
        if entry is None:
            if Bundle not in map(type, arguments):
                self.__class__ = CPUDispatcher
                return self(*arguments)
            result = super().__call__(*arguments)
            if None not in kinds:
                compiled = self.overloads.get(tuple(map(self.typeof_pyval, arguments)))
                if compiled is not None:  # none where calls are only put down
                    self.entries[kinds] = compiled.entry_point
            return result
        return entry(*arguments)


def call_at_once(compiled: Any) -> None:
    """Change a numba dispatcher to a `KernelDispatcher`, which finds the compiled code faster at each call."""
    compiled.__class__ = KernelDispatcher
    compiled.entries = {}


def _kind(value: Any) -> Any:
    """Return a key that identifies the compiled type of an argument and is fast to compute; None if there is none."""
    kind = type(value)
    if kind is Bundle:
        return value.type_name
    if kind is np.ndarray:
        return value.dtype, value.ndim, value.flags.num
    if kind in PLAIN:
        return kind
    members = tuple(map(_kind, value)) if isinstance(value, tuple) else (None,)
    return None if None in members else (kind, members)


@contextmanager
def record_kernel_calls() -> Iterator[dict[tuple[Any, tuple[Any, ...]], None]]:
    """Context manager that records the kernels called from Python in the block, without running them. Yields a dictionary
    whose keys, in call order, are pairs of a kernel and the types of its arguments.

    Arrays that the kernels would fill stay unchanged. Kernels that return values run as plain Python.
    """
    from numba.core.registry import CPUDispatcher

    calls: dict[tuple[Any, tuple[Any, ...]], None] = {}

    def instead(compiled: Any, *arguments: Any) -> Any:
        calls[compiled, tuple(map(compiled.typeof_pyval, arguments))] = None
        return compiled.py_func if _gives_something_back(compiled.py_func) else _nothing

    CPUDispatcher._compile_for_args = instead  # what numba then calls
    try:
        yield calls
    finally:
        del CPUDispatcher._compile_for_args


def _nothing(*arguments: Any) -> None:
    pass


@cache
def _gives_something_back(function: Any) -> bool:
    found = ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function))))
    return any(isinstance(node, ast.Return) and node.value is not None for node in found)
