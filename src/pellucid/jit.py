"""Compiled kernels and the pointwise functions that they call.

Laws, shape functions and tensor algebra are plain scalar Python, marked with `@pointwise` or registered with
`@point_function`; nothing here imports numba until the first `@kernel` is met, so data models stay light.

Numba's disk cache does not see edits in other files; `kernel_cache` keeps kernels for the sources that they depend on.
"""

import contextlib
import inspect
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

# Waiting threads sleep: spinning ones bring a busy machine to a crawl. OpenMP reads this when numba is first imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

_helpers: dict[Callable[..., Any], None] = {}
_kernels: list[FunctionType] = []
_generics: "dict[Callable[..., Any], Generic]" = {}  # by the function that dispatches in plain Python
_active = False


class Generic(NamedTuple):
    """A pointwise operation: its signature, and its implementation for each type of the first argument."""

    signature: inspect.Signature
    implementations: dict[type, Callable[..., Any]]


def generic(signature: Callable[..., Any]) -> Callable[..., Any]:
    """Declare a pointwise operation; the body of `signature` is never run, its arguments and docstring count."""
    bare = [p.replace(annotation=p.empty) for p in inspect.signature(signature).parameters.values()]
    operation = Generic(inspect.Signature(bare), {})  # implementations are not annotated, and numba compares
    table = operation.implementations

    def dispatch(first: Any, *rest: Any) -> Any:
        return table[type(first)](first, *rest)

    dispatch.__name__ = signature.__name__
    dispatch.__doc__ = signature.__doc__
    _generics[dispatch] = operation
    if _active:
        _compile_generic(dispatch)
    return dispatch


def point_function(operation: Callable[..., Any], kind: type) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register the decorated function as `operation` for a parameter type, for compiled kernels and plain Python."""

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        _generics[operation].implementations[kind] = implementation
        return implementation

    return register


def pointwise(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a small scalar function as callable from kernels."""
    _helpers[function] = None
    if _active:
        _compile_helper(function)
    return function


def kernel(parallel: bool = False, inline: bool = False, inner: bool = False) -> Callable[[FunctionType], Any]:
    """Compile a loop over points or nodes; kept on disk for each state of the sources that it depends on.

    inner: a kernel that only other kernels call, which spares the compiler what Python needs to call it.
    inline: an inner kernel that becomes part of each loop that calls it.
    """

    def decorate(function: FunctionType) -> Any:
        _activate()
        import numba

        compiled = numba.njit(
            function,
            parallel=parallel,
            inline="always" if inline else "never",
            error_model="numpy",
            fastmath={"contract"},
            nogil=True,
            no_cpython_wrapper=inner or inline,
            no_cfunc_wrapper=True,
        )
        _kernels.append(function)
        if not numba.config.DISABLE_JIT:
            from pellucid.kernel_cache import KernelCache

            compiled._cache = KernelCache(function)
            if inner or inline:
                _keep_from_python(compiled)
        return compiled

    return decorate


def _keep_from_python(compiled: Any) -> None:
    """Let a call from Python raise TypeError: numba would jump to the wrapper that there is not, and the process would end."""

    def add_overload(result: Any) -> None:
        compiled.overloads[tuple(result.signature.args)] = result  # for kernels alone

    def refuse(*arguments: Any, **named: Any) -> None:
        raise TypeError(f"{compiled.__qualname__} is an inner kernel: only kernels can call it")

    compiled.add_overload = add_overload
    compiled._compile_for_args = refuse


def cache_folder() -> Path:
    """Where compiled kernels are kept."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        root = os.environ.get("XDG_CACHE_HOME")
        base = str((Path(root) if root else Path.home() / ".cache") / "pellucid")
    return Path(base) / "kernels"


def kernel_key(*handed: Any) -> str:
    """Names the kernels that are called with these bundles and named tuples, in the present state of their sources."""
    from numba import typeof

    from pellucid.kernel_sources import sources_of

    sources = sources_of(_kernels, (typeof(thing) for thing in handed))
    return "" if sources is None else sources.digest


def kernels_are_cached(key: str) -> bool:
    """Whether the kernels that `key` stands for were compiled before on this machine."""
    return (cache_folder() / f"{key}.ready").exists()


def mark_cached(key: str) -> None:
    """Remember that the kernels that `key` stands for are compiled; silent where the cache cannot be written."""
    with contextlib.suppress(OSError):
        (cache_folder() / f"{key}.ready").touch()


def is_operation(value: Any) -> bool:
    """Whether this is a function declared with `@generic`."""
    return isinstance(value, FunctionType) and value in _generics


def implementations(operation: Callable[..., Any]) -> dict[type, Callable[..., Any]]:
    """The functions registered for an operation, by the type of the first argument."""
    return _generics[operation].implementations


def is_pointwise(value: Any) -> bool:
    """Whether this function is marked with `@pointwise`."""
    return value in _helpers


def _activate() -> None:
    global _active
    if _active:
        return
    _active = True
    for helper in _helpers:
        _compile_helper(helper)
    for dispatch in _generics:
        _compile_generic(dispatch)


def _compile_helper(function: Callable[..., Any]) -> None:
    from numba.extending import register_jitable

    register_jitable(forceinline=True)(function)


def _compile_generic(dispatch: Callable[..., Any]) -> None:
    from numba.core import types
    from numba.extending import overload

    operation = _generics[dispatch]

    def choose(*arguments: Any) -> Callable[..., Any] | None:
        first = arguments[0]
        if isinstance(first, types.BaseNamedTuple):  # type: ignore[attr-defined]
            return operation.implementations.get(first.instance_class)
        return None

    choose.__signature__ = operation.signature  # type: ignore[attr-defined]
    overload(dispatch, jit_options={"forceinline": True})(choose)


def set_threads(threads: int | None) -> int:
    """Use this many threads, all cores where None; the number in use. Results do not depend on it."""
    if threads is not None and "numba" not in sys.modules:
        os.environ["NUMBA_NUM_THREADS"] = str(max(threads, os.cpu_count() or 1))
    import numba

    most = numba.config.NUMBA_NUM_THREADS
    numba.set_num_threads(min(threads or most, most))
    return int(numba.get_num_threads())
