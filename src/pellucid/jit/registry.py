"""Registry of pointwise functions, which kernels and plain Python call. Numba is not imported here before the first kernel
is used."""

import inspect
from collections.abc import Callable
from importlib import import_module
from types import FunctionType
from typing import Any, NamedTuple

_helpers: dict[Callable[..., Any], None] = {}
_replaced: dict[Callable[..., Any], str] = {}
_generics: "dict[Callable[..., Any], Generic]" = {}  # by the function that dispatches in plain Python
kernels: dict[tuple[str, str], Any] = {}
"""Compiled kernels by module and name; if functions share a name, the last one."""
_active = False
IN_KERNELS: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"contract"},
    "nogil": True,
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}
"""Numba options for functions that only kernels call and that are inlined in them.

Python and C never call these functions, and arrays exist as long as the kernel, so references to them are not counted. All
callers need the same options: otherwise a shared function would be compiled for each.
"""

LINE = 64
"""Size of a cache line [bytes]; arrays of kernels start at a multiple of it."""


class MissingFunction(TypeError):
    """Error for a call of a pointwise operation with a first argument for whose type no function is registered."""

    def __init__(self, operation: Callable[..., Any], kind: type) -> None:
        self.operation, self.kind = operation, kind
        name = operation.__name__
        super().__init__(f"{kind.__name__} has no `{name}`: register one with `@point_function({name}, {kind.__name__})`")


class Generic(NamedTuple):
    """A pointwise operation, declared with `@generic`: its signature, and the registered implementations, of which a call
    uses the one for the type of the first argument."""

    signature: inspect.Signature  # arguments of all implementations
    implementations: dict[type, Callable[..., Any]]  # by type of the first argument
    makers: list[Callable[[type], Callable[..., Any] | None]]  # at most one, of implementations that follow from `source`
    source: list[Callable[..., Any]]  # at most one, the operation from whose implementations those of this one follow
    default: list[Callable[..., Any]]  # at most one, for types without their own implementation

    def own(self, kind: type) -> Callable[..., Any] | None:
        """Return the implementation that is registered for a first argument of the type `kind` or follows from others that
        are; None if there is none."""
        if kind not in self.implementations and self.makers and (made := self.makers[0](kind)):
            self.implementations[kind] = made
        return self.implementations.get(kind)

    def of(self, kind: type) -> Callable[..., Any] | None:
        """Return the implementation that a call with a first argument of the type `kind` uses; None if there is none."""
        return self.own(kind) or (self.default[0] if self.default else None)


def generic(signature: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator: declare a pointwise operation, a function with one implementation per type of its first argument (a NamedTuple
    of parameters), see `point_function`. The body of `signature` is never run; only its arguments and docstring are used."""
    bare = [p.replace(annotation=p.empty) for p in inspect.signature(signature).parameters.values()]
    operation = Generic(inspect.Signature(bare), {}, [], [], [])  # implementations are not annotated, and numba compares

    def dispatch(first: Any, *rest: Any) -> Any:
        implementation = operation.of(type(first))
        if implementation is None:
            raise MissingFunction(dispatch, type(first))
        return implementation(first, *rest)

    dispatch.__name__ = signature.__name__
    dispatch.__doc__ = signature.__doc__
    _generics[dispatch] = operation
    if _active:
        _compile_generic(dispatch)
    return dispatch


def point_function(operation: Callable[..., Any], kind: type) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that registers a function as the implementation of `operation` for first arguments of the type `kind`,
    for compiled kernels and plain Python.

    Raises TypeError if `operation` is no operation, if the type is no NamedTuple, and if the arguments of the function
    differ from the arguments of the operation.
    """
    if not is_operation(operation):
        raise TypeError(
            f"{getattr(operation, '__name__', operation)} is not an operation for which a law can register a function"
        )
    if not (isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")):
        raise TypeError(
            f"{getattr(kind, '__name__', kind)} is not a NamedTuple: kernels require the parameters of a law as a NamedTuple"
        )

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        wanted, found = _generics[operation].signature, inspect.signature(implementation)
        if list(found.parameters) != list(wanted.parameters):  # numba asks for the same names
            name = implementation.__name__
            raise TypeError(f"{name}{found} must have the arguments of `{operation.__name__}`, {name}{wanted}")
        _generics[operation].implementations[kind] = implementation
        return implementation

    return register


def default_function(operation: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that registers a function as the implementation of `operation` for all types of the first argument
    for which no implementation is registered."""

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        _generics[operation].default[:] = [implementation]
        return implementation

    return register


def derived_function(
    operation: Callable[..., Any], source: Callable[..., Any]
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator for a function that makes implementations of `operation` which follow from those of the operation
    `source`: for a type of the first argument, it returns the implementation, or None if `source` has none. It is called
    when a type without an implementation of its own is first used."""

    def register(maker: Callable[..., Any]) -> Callable[..., Any]:
        _generics[operation].makers[:], _generics[operation].source[:] = [maker], [source]
        return maker

    return register


def pointwise(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator: make a small scalar function callable from kernels."""
    _helpers[function] = None
    if _active:
        _compile_helper(function)
    return function


def compiled_by(module: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator for a function of one argument: in kernels, the numba intrinsic of the same name in `module`
    replaces the function. The module is imported with the first kernel."""

    def mark(function: Callable[..., Any]) -> Callable[..., Any]:
        _replaced[function] = module
        if _active:
            _replace(function)
        return function

    return mark


def is_operation(value: Any) -> bool:
    """Return True for a pointwise operation, i.e. a function declared with `@generic`."""
    return isinstance(value, FunctionType) and value in _generics


def implementation_of(operation: Callable[..., Any], kind: type) -> Callable[..., Any] | None:
    """Return the function that is registered for an operation (declared with `@generic`) and a type of the first argument, or
    follows from registered ones; None if there is none. The default of the operation does not count."""
    return _generics[operation].own(kind)


def source_of(operation: Callable[..., Any]) -> Callable[..., Any] | None:
    """Return the operation from whose registered implementations those of an operation (declared with `@generic`) can follow;
    None if they follow from no other."""
    source = _generics[operation].source
    return source[0] if source else None


def defaults(operation: Callable[..., Any]) -> list[Callable[..., Any]]:
    """Return a list with the default function of an operation (declared with `@generic`), which applies to types without an
    implementation; an empty list if there is none."""
    return _generics[operation].default


def is_pointwise(value: Any) -> bool:
    """Return True for a function marked with `@pointwise`."""
    return value in _helpers


def activate() -> None:
    """Register all pointwise functions and operations with numba, and from now on each new one."""
    global _active
    if _active:
        return
    _active = True
    for helper in _helpers:
        _compile_helper(helper)
    for dispatch in _generics:
        _compile_generic(dispatch)
    for function in _replaced:
        _replace(function)


def _replace(function: Callable[..., Any]) -> None:
    from numba.extending import overload

    intrinsic = getattr(import_module(_replaced[function]), function.__name__)
    overload(function, jit_options=IN_KERNELS)(lambda x: lambda x: intrinsic(x))


def inlined() -> dict[str, Any]:
    """Return the numba options of functions that are linked into kernels, without machine code of their own."""
    from pellucid.jit.inlined import InlinedCompiler

    return IN_KERNELS | {"pipeline_class": InlinedCompiler}


def _compile_helper(function: Callable[..., Any]) -> None:
    from numba.extending import register_jitable

    register_jitable(**inlined())(function)


def _compile_generic(dispatch: Callable[..., Any]) -> None:
    from numba.core import types
    from numba.extending import overload

    operation = _generics[dispatch]

    def choose(*arguments: Any) -> Callable[..., Any] | None:
        first = arguments[0]
        if isinstance(first, types.BaseNamedTuple):  # type: ignore[attr-defined]
            return operation.of(first.instance_class)
        return None

    choose.__signature__ = operation.signature  # type: ignore[attr-defined]
    overload(dispatch, jit_options=inlined())(choose)
