"""Calls of kernels from Python.

At each call numba finds the compiled types of the arguments. That takes it four microseconds for a bundle, as long as a small
kernel runs, and beside one twenty for a named tuple of a few arrays. Where Python itself sees that a kernel was called with
arguments of these types before, it calls the compiled code at once. Without bundles numba finds the types sooner.
"""

from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

from pellucid.jit.bundle import Bundle

PLAIN = int, float, bool, np.float64
"""Python types of one compiled type each."""


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel that Python calls."""

    def __call__(self, *arguments: Any) -> Any:
        """Run the kernel, compiled for these types where it is not yet."""
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
    """Make a numba kernel callable in this way."""
    compiled.__class__ = KernelDispatcher
    compiled.entries = {}


def _kind(value: Any) -> Any:
    """Return a fast key of the compiled type of an argument; None if there is none."""
    kind = type(value)
    if kind is Bundle:
        return value.type_name
    if kind is np.ndarray:
        return value.dtype, value.ndim, value.flags.num
    if kind in PLAIN:
        return kind
    members = tuple(map(_kind, value)) if isinstance(value, tuple) else (None,)
    return None if None in members else (kind, members)
