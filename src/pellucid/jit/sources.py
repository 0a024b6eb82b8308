"""Dependencies of a compiled kernel: all functions and constants that it uses, and its argument types.

A kernel uses the functions, classes and constants that its code names, recursively. A pointwise operation uses the
implementations for the classes that occur in the types of the kernel's arguments or are created by the code. Functions are
compared by their code: docstrings, comments and moved lines do not change a digest.
"""

import hashlib
import sys
from collections.abc import Iterable, Iterator
from enum import Enum
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import __version__ as llvmlite_version
from numba.core import types

from pellucid.jit import registry

VERSIONED = ("numpy", "numba", "math", "builtins", "operator")  # what they hold follows from their version


class Lead(NamedTuple):
    """Dependencies of the code of one function, from which the digest of a kernel is computed: digest of the code and its
    constants, and the functions, pointwise operations and named tuple classes that the code uses."""

    digest: str  # of the code and the constants of the function
    functions: list[FunctionType]  # functions and kernels that the code uses
    operations: list[Any]  # pointwise operations that the code uses
    classes: list[type]  # named tuple classes that the code uses


class Sources(NamedTuple):
    """Dependencies of a kernel that is called with certain argument types: the digest under which the cache stores the
    compiled kernel, and the named tuple classes in the kernel."""

    digest: str  # of all code and constants that the kernel uses
    classes: dict[tuple[str, str], type]  # named tuple classes in the kernel, by module and name


def sources_of(functions: Iterable[FunctionType], arguments: Iterable[types.Type]) -> Sources | None:
    """Return the dependencies of kernels (`functions`) that are called with arguments of these compiled types; None if two
    named tuple classes have the same name."""
    arguments = tuple(arguments)
    ahead: list[Any] = list(functions)
    seen: set[Any] = set()
    classes = {found for argument in arguments for found in classes_in(argument)}
    operations: set[Any] = set()
    while ahead:
        for function in ahead:
            seen.add(function)
            lead = lead_of(function)
            ahead = [*ahead, *lead.functions]
            classes.update(lead.classes)
            operations.update(lead.operations)
        for operation in operations:
            chosen = [registry.implementation_of(operation, kind) for kind in classes]
            ahead += [function for function in chosen if function]
            ahead += registry.defaults(operation)
        ahead = [function for function in dict.fromkeys(ahead) if function not in seen]
    named = {(kind.__module__, kind.__qualname__): kind for kind in classes}
    if len(named) < len(classes):
        return None
    parts = [compiler_state(), *map(described, arguments)]
    parts += sorted(f"{name} {kind._fields}" for name, kind in named.items())  # type: ignore[attr-defined]
    parts += sorted(lead_of(function).digest for function in seen)
    return Sources(hashlib.sha256("\n".join(parts).encode()).hexdigest()[:32], named)


def classes_in(kind: types.Type) -> Iterator[type]:
    """Yield the named tuple classes that occur within a compiled type."""
    if isinstance(kind, types.BaseNamedTuple):  # type: ignore[attr-defined]
        yield kind.instance_class
    for part in parts_of(kind):
        yield from classes_in(part)


def parts_of(kind: types.Type) -> tuple[types.Type, ...]:
    """Return the types of the members of a compiled type; empty for a simple type."""
    content = getattr(kind, "content", None)
    if isinstance(content, types.Type):  # of a bundle
        return (content,)
    if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
        return tuple(kind)
    if isinstance(kind, types.Optional):  # type: ignore[attr-defined]
        return (kind.type,)
    return ()


def described(kind: types.Type) -> str:
    """Return a text that identifies a compiled type and is identical in every process."""
    inner = ", ".join(map(described, parts_of(kind)))
    if isinstance(kind, types.BaseNamedTuple):  # type: ignore[attr-defined]
        return f"{kind.instance_class.__module__}.{kind.instance_class.__qualname__}({inner})"
    if isinstance(kind, types.Dispatcher):
        return lead_of(kind.dispatcher.py_func).digest
    rows = getattr(kind, "rows", "")  # of a bundle
    return f"{type(kind).__name__}({inner}){rows}" if inner else str(kind)


@cache
def compiler_state() -> str:
    """Return a text with the versions (Python, numba, numpy) and the digests of source files that affect all compiled code; the
    files of this folder count as part of the compiler."""
    texts = [file_digest(str(path)) for path in sorted(Path(__file__).parent.glob("*.py"))]
    return " ".join([numba.__version__, llvmlite_version, np.__version__, sys.version, *texts])


@cache
def lead_of(function: FunctionType) -> Lead:
    """Return the dependencies of the code of one function, without those of the functions that it calls."""
    lead = Lead("", [], [], [])
    parts = [f"{function.__module__}.{function.__qualname__}", repr(function.__defaults__)]
    parts.append(code_text(function.__code__, function.__doc__))
    parts += [f"{name} = {follow(value, lead)}" for name, value in named_values(function)]
    return lead._replace(digest=hashlib.sha256("\n".join(parts).encode()).hexdigest())


def code_text(code: CodeType, doc: str | None = None) -> str:
    """Return the content of a code object as text, without its place in a file; doc: docstring, which is left out."""
    constants = [
        code_text(value) if isinstance(value, CodeType) else str(sorted(map(repr, value)))
        if isinstance(value, frozenset) else repr(value)
        for value in code.co_consts
        if doc is None or value != doc
    ]  # fmt: skip
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_argcount, code.co_flags)
    return f"{code.co_code.hex()} {names} {constants}"


def named_values(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield the name and value of each global, closure variable or module attribute that the code of a function uses."""
    closed = dict(zip(function.__code__.co_freevars, (cell.cell_contents for cell in function.__closure__ or ()), strict=True))
    names = sorted(names_in(function.__code__))
    around = {name: function.__globals__[name] for name in names if name in function.__globals__} | closed
    yield from around.items()
    modules = [value for value in around.values() if isinstance(value, ModuleType)]
    for module in modules:
        if not from_versioned(module.__name__):
            for name in names:
                if hasattr(module, name):
                    value = getattr(module, name)
                    yield f"{module.__name__}.{name}", value
                    if isinstance(value, ModuleType):
                        modules.append(value)


def names_in(code: CodeType) -> set[str]:
    """Return the names of globals and attributes in a code object and its nested code objects."""
    inner = (names_in(value) for value in code.co_consts if isinstance(value, CodeType))
    return set(code.co_names).union(*inner)


def from_versioned(module: str | None) -> bool:
    """Return True for a module of Python or of a package in VERSIONED, whose version determines its content."""
    return (module or "builtins").split(".")[0] in VERSIONED


def follow(value: Any, lead: Lead) -> str:
    """Return a text that identifies a value used by a function, and add functions, operations and classes in this value to
    `lead`."""
    if registry.is_operation(value):
        lead.operations.append(value)
    elif isinstance(value, FunctionType):
        if not from_versioned(value.__module__):
            lead.functions.append(value)
            return value.__qualname__ if registry.is_pointwise(value) else file_digest(value.__code__.co_filename)
    elif isinstance(getattr(value, "py_func", None), FunctionType):  # a kernel
        lead.functions.append(value.py_func)
        return repr(sorted(value.targetoptions.items()))
    elif isinstance(value, type):
        if issubclass(value, tuple) and hasattr(value, "_fields"):
            lead.classes.append(value)
        members = [(member.name, member.value) for member in value] if issubclass(value, Enum) else ""
        return f"{value.__module__}.{value.__qualname__} {members}"
    elif isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    elif isinstance(value, bool | int | float | complex | str | bytes | tuple | np.generic | Enum | None):
        return repr(value)
    return str(getattr(value, "__qualname__", getattr(value, "__name__", type(value).__qualname__)))


@cache
def file_digest(path: str) -> str:
    """Return the SHA-256 digest of a file, or the path if the file cannot be read.

    The digest represents a function whose implementation an extension of the compiler may replace.
    """
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return path
