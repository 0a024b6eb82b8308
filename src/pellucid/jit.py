"""Compiled kernels and the pointwise functions that they call.

Laws, shape functions and tensor algebra are plain scalar Python, marked with `@pointwise` or registered with
`@point_function`; nothing here imports numba until the first `@kernel` is met, so data models stay light.

Numba's disk cache does not see edits in other files, so the cache folder is named by a hash of the package's sources.
"""

import hashlib
import inspect
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

# Waiting threads sleep: spinning ones bring a busy machine to a crawl. OpenMP reads this when numba is first imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

_helpers: list[Callable[..., Any]] = []
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
    _helpers.append(function)
    if _active:
        _compile_helper(function)
    return function


def kernel(parallel: bool = False, inline: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Compile a loop over points or nodes; cached on disk under a name that changes with any source of the package.

    inline: a part of other kernels, which becomes part of each of their loops.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        _activate()
        import numba

        previous = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(cache_folder())  # read once, when the decorator runs
        try:
            return numba.njit(
                function,
                parallel=parallel,
                inline="always" if inline else "never",
                cache=True,
                error_model="numpy",
                fastmath={"contract"},
                nogil=True,
            )
        finally:
            numba.config.CACHE_DIR = previous

    return decorate


def cache_folder() -> Path:
    """Where compiled kernels are kept: one folder for each state of the package's sources."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        root = os.environ.get("XDG_CACHE_HOME")
        base = str((Path(root) if root else Path.home() / ".cache") / "pellucid")
    return Path(base) / source_hash()


def source_hash() -> str:
    """A short hash of every Python source of the package and of the versions that shape compiled code."""
    global _hash
    if _hash is None:
        import numba

        digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
        package = Path(__file__).parent
        for path in sorted(package.rglob("*.py")):
            digest.update(str(path.relative_to(package)).encode())
            digest.update(path.read_bytes())
        _hash = digest.hexdigest()[:16]
    return _hash


_hash: str | None = None


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
