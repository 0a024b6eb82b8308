"""Record of kernel calls without execution: the kernels that a piece of code calls, with their argument types."""

import ast
import inspect
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


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
