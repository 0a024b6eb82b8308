"""Fast calls of kernels from Python.

At each call numba determines the compiled types of the arguments. The lookup takes four microseconds for a bundle, as long
as a small kernel runs, and twenty for a named tuple of a few arrays. For types that the kernel has been called with before,
a lookup in Python finds the compiled code, which is called directly. Without bundles numba determines the types faster.
"""

from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

from pellucid.jit.bundle import Bundle

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
