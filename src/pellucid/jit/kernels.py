"""Kernels: loops that numba compiles."""

import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pellucid.errors import UsageError
from pellucid.jit.registry import IN_KERNELS, activate, kernels
from pellucid.system.interrupts import signals_held

MOST_PER_CORE = 16

# Waiting threads look for work some tenths of a millisecond, as long as what lies between two kernels takes, and then sleep:
# woken each time, two would be slower than one below 50 000 points, and those that never sleep bring a busy machine to a crawl.
# OpenMP reads these when numba is first imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
os.environ.setdefault("GOMP_SPINCOUNT", "10000")


def kernel(inner: bool = False, inline: bool = False, allocates: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Decorator: compile a loop over points or nodes. Compiled code is stored on disk for each state of the sources on
    which it depends.

    inner: True for a kernel called only by other kernels, compiled without the interface to Python. inline: True for an
    inner kernel that is inlined in each calling loop. allocates: True for a kernel that creates arrays other than by
    `pellucid.jit.memory`; the compiled kernel then counts references to all arrays.
    """

    def decorate(function: Any) -> Any:
        activate()
        import numba

        called_by_kernels = inner or inline
        options = IN_KERNELS | {
            "forceinline": inner,  # else code depends on whether it was compiled here or came with its caller from the cache
            "no_cpython_wrapper": called_by_kernels,
            "_nrt": allocates,
        }
        compiled = numba.njit(function, inline="always" if inline else "never", **options)
        kernels[function.__module__, function.__qualname__] = compiled
        if not numba.config.DISABLE_JIT:
            from pellucid.jit.cache import KernelCache
            from pellucid.jit.kernel_folder import held

            compiled._cache = KernelCache(function)
            compiled.compile = signals_held()(_without_collection()(held.compiling()(compiled.compile)))
            if called_by_kernels:
                _keep_from_python(compiled)
            else:
                from pellucid.jit.calls import call_at_once

                call_at_once(compiled)
        return compiled

    return decorate


def intrinsic_or(plain: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator for a numba intrinsic, an operation of kernels whose code is generated. Without the compiler
    (`NUMBA_DISABLE_JIT`), the function `plain` is the operation.
    """
    import numba
    from numba.extending import intrinsic

    return lambda generated: plain if numba.config.DISABLE_JIT else intrinsic(generated)


@contextmanager
def _without_collection() -> Iterator[None]:
    """Disable garbage collection in the block: compilation creates so many objects that collection would take a seventh of
    its time."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _keep_from_python(compiled: Any) -> None:
    """Make calls from Python raise TypeError: numba would jump to a missing wrapper and the process would end."""

    def add_overload(result: Any) -> None:
        compiled.overloads[tuple(result.signature.args)] = result  # for kernels alone

    def refuse(*arguments: Any, **named: Any) -> None:
        raise TypeError(f"{compiled.__qualname__} is an inner kernel: only kernels can call it")

    compiled.add_overload = add_overload
    compiled._compile_for_args = refuse


def check_threads(threads: object) -> None:
    """Raise UsageError unless `threads` is a number of threads that this machine can use."""
    most_useful = MOST_PER_CORE * (os.cpu_count() or 1)
    if not (isinstance(threads, int) and 1 <= threads <= most_useful):
        text = f"threads = {threads!r} must be a whole number from 1 to {most_useful}"
        raise UsageError(
            f"{text}, {MOST_PER_CORE} times the cores of this machine; omit it, so that a run finds the fastest number"
        )


def set_threads(threads: int | None) -> int:
    """Set the number of threads, or the number of cores if `threads` is None; return the number in use. Results of a
    simulation do not depend on the number of threads.

    Raises UsageError for a number that this machine cannot use.
    """
    if threads is not None:
        check_threads(threads)
    if threads is not None and "numba" not in sys.modules:
        os.environ["NUMBA_NUM_THREADS"] = str(max(threads, os.cpu_count() or 1))
    import numba

    most = numba.config.NUMBA_NUM_THREADS
    numba.set_num_threads(min(threads or most, most))
    return int(numba.get_num_threads())
