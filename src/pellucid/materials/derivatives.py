"""First and second derivatives of an energy W, derived from its function alone and compiled like functions written by hand.

The function of W is called once with symbolic numbers (`Term`), which record its operations as a graph. Equal terms exist
once, and factors that consist of parameters only are collected, so that loops over points compute them once. Reverse
differentiation of the graph gives the slopes, differentiation of a slope the curvatures (Griewank & Walther 2008,
Evaluating Derivatives, 2nd ed., chapter 3). The results are straight lines of code: the same in every process, without
branches, with one division for each denominator. They keep the accuracy of W: where W is a sum of products of small
numbers, such as (a - 1) (a + 1), so are its derivatives.

W may use + - * / **, the functions in `FUNCTIONS` and those of `math` and numpy with the same names, pointwise functions and
parameters that are numbers. A law with another W, e.g. with branches or a varying number of terms, registers the derivatives
itself.
"""

import functools
import inspect
import math
from collections.abc import Callable, Sequence
from itertools import combinations
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from pellucid.findings import listed
from pellucid.jit import derived_function, elementary, implementation_of
from pellucid.jit.registry import is_operation, is_pointwise
from pellucid.users.users_code import DERIVED

FUNCTIONS = {"sqrt": math.sqrt} | {
    function.__name__: function
    for function in (elementary.exp, elementary.expm1, elementary.log, elementary.log1p, elementary.power)
}
"""Functions of derived code, by name. `partial_derivatives` adds functions."""
LIBRARIES = math, np
"""Modules whose functions with names in `FUNCTIONS` are equivalent in W."""


class NotTraced(TypeError):
    """Error for an energy whose derivatives cannot be derived from its function.

    Attributes
    ----------
    remedy : correction of a mistake in the function, as text for the user; empty if the function is valid, but uses more than
        can be differentiated.
    """

    def __init__(self, text: str, remedy: str = "") -> None:
        super().__init__(text)
        self.remedy = remedy


class Term:
    """Symbolic number: a node of the graph of an energy.

    Attributes
    ----------
    graph : the graph that has the term.
    operation : name of the operation or function, value of a constant, or text of a variable or parameter.
    operands : the terms on which the operation acts.
    varies : True if the term depends on a variable, False for constants and functions of parameters.
    order : place among the terms of the graph; operands come before the terms that use them.
    """

    __slots__ = ("graph", "operands", "operation", "order", "varies")

    def __init__(self, graph: "Graph", operation: str | float, operands: tuple["Term", ...], varies: bool) -> None:
        self.graph, self.operation, self.operands, self.varies = graph, operation, operands, varies
        self.order = len(graph.terms)

    def __add__(self, other: Any) -> "Term":
        return self.graph.add(self, self.graph.term_of(other))

    def __sub__(self, other: Any) -> "Term":
        return self.graph.subtract(self, self.graph.term_of(other))

    def __rsub__(self, other: Any) -> "Term":
        return self.graph.subtract(self.graph.term_of(other), self)

    def __mul__(self, other: Any) -> "Term":
        return self.graph.multiply(self, self.graph.term_of(other))

    def __truediv__(self, other: Any) -> "Term":
        return self * self.graph.invert(self.graph.term_of(other))

    def __rtruediv__(self, other: Any) -> "Term":
        return self.graph.term_of(other) * self.graph.invert(self)

    def __pow__(self, exponent: Any) -> "Term":
        return self.graph.power(self, exponent)

    def __rpow__(self, base: Any) -> "Term":
        return self.graph.power(self.graph.term_of(base), self)

    def __neg__(self) -> "Term":
        return -1.0 * self

    __radd__, __rmul__ = __add__, __mul__

    def _refuse(self, *_: Any) -> Any:
        raise NotTraced("it compares its arguments or parameters, or passes them to a function that cannot be differentiated")

    __bool__ = __float__ = __eq__ = __lt__ = __le__ = __gt__ = __ge__ = __abs__ = _refuse  # type: ignore[assignment]
    __hash__ = object.__hash__


PARTIALS: dict[str | float, tuple[Callable[[Term], Any], ...]] = {
    "+": (lambda t: 1.0, lambda t: 1.0),
    "-": (lambda t: 1.0, lambda t: -1.0),
    "*": (lambda t: t.operands[1], lambda t: t.operands[0]),
    "inverse": (lambda t: -t * t,),
    "sqrt": (lambda t: 0.5 / t,),
    "exp": (lambda t: t,),
    "expm1": (lambda t: 1.0 + t,),
    "log": (lambda t: 1.0 / t.operands[0],),
    "log1p": (lambda t: 1.0 / (1.0 + t.operands[0]),),
    "power": (lambda t: t.operands[1] * t / t.operands[0], lambda t: t * t.graph.call("log", t.operands[0])),
}
"""Partial derivatives of each operation with respect to its operands."""


def partial_derivatives(function: Callable[..., float]) -> Callable[..., Any]:
    """Return a decorator for a function that returns the partial derivatives of a pointwise function as a tuple, at least
    those with respect to arguments that vary. They replace those that follow from its operations, which are longer where the
    function is written without differences of large numbers."""

    def register(slopes: Callable[..., Any]) -> Callable[..., Any]:
        def partial(place: int) -> Callable[[Term], Any]:
            return lambda term: _on_terms(slopes)(*term.operands)[place]

        FUNCTIONS[function.__name__] = function
        PARTIALS[function.__name__] = tuple(map(partial, range(len(inspect.signature(function).parameters))))
        return slopes

    return register


class Graph:
    """Terms of an energy and its derivatives, each once."""

    def __init__(self) -> None:
        self.terms: dict[tuple[Any, ...], Term] = {}
        self.derivatives: dict[tuple[Term, Term], Term] = {}
        self.bottlenecks: dict[Term, Term | None] = {}
        self.zero, self.one = self.term(0.0), self.term(1.0)

    def term(self, operation: str | float, *operands: Term, varies: bool = False) -> Term:
        """Return the term of an operation on operands; of a variable (`varies`), parameter or constant without operands."""
        key = (operation, *operands)
        if key not in self.terms:
            self.terms[key] = Term(self, operation, operands, varies or any(operand.varies for operand in operands))
        return self.terms[key]

    def term_of(self, value: Any) -> Term:
        """Return a value as a term. Raises NotTraced unless it is a term or a number."""
        if isinstance(value, Term):
            return value
        if isinstance(value, int | float):
            return self.term(float(value))
        raise NotTraced(f"it combines a number with a {type(value).__name__}")

    def add(self, x: Term, y: Term) -> Term:
        """Return x + y."""
        if isinstance(x.operation, float) and isinstance(y.operation, float):
            return self.term(x.operation + y.operation)
        if x is self.zero or y is self.zero:
            return y if x is self.zero else x
        if x is y:
            return 2.0 * x
        for one, other in ((x, y), (y, x)):
            factor, rest = _split(other)
            if factor.operation == -1.0:
                return self.subtract(one, rest)
        (c, u), (d, v) = _parts(x), _parts(y)
        if u is v:
            return self.add(self.add(c, d), 2.0 * u)
        return self.term("+", *sorted((x, y), key=lambda term: term.order))

    def subtract(self, x: Term, y: Term) -> Term:
        """Return x - y."""
        if x is y or y is self.zero:
            return self.zero if x is y else x
        if x is self.zero or (isinstance(x.operation, float) and isinstance(y.operation, float)):
            return self.add(x, -y)
        factor, rest = _split(y)
        return self.add(x, rest) if factor.operation == -1.0 else self.term("-", x, y)

    def multiply(self, x: Term, y: Term) -> Term:
        """Return x y, with the factors that do not vary as one factor, which comes first."""
        (p, u), (q, v) = _split(x), _split(y)
        return self._product(self._product(p, q), self._product(u, v))

    def _product(self, x: Term, y: Term) -> Term:
        x, y = sorted((x, y), key=lambda term: (not isinstance(term.operation, float), term.varies, term.order))
        if isinstance(x.operation, float):
            if isinstance(y.operation, float):
                return self.term(x.operation * y.operation)
            if x is self.zero or x is self.one:
                return x if x is self.zero else y
            if y.operation == "*" and isinstance(y.operands[0].operation, float):
                return self._product(self.term(x.operation * y.operands[0].operation), y.operands[1])
        return self.term("*", x, y)

    def invert(self, x: Term) -> Term:
        """Return 1/x."""
        if isinstance(x.operation, float):
            return self.term(1.0 / x.operation)
        if x.operation == "inverse":
            return x.operands[0]
        parts = x.operands if x.operation == "*" else ()
        if parts and (parts[0] is parts[1] or not parts[0].varies or any(part.operation == "inverse" for part in parts)):
            return self.invert(x.operands[0]) * self.invert(x.operands[1])
        return self.term("inverse", x)

    def power(self, x: Term, exponent: Any) -> Term:
        """Return x to a power; small whole exponents are products."""
        if isinstance(exponent, Term) or exponent % 0.5 != 0.0 or abs(exponent) > 8.0:
            return self.call("power", x, exponent)
        if exponent < 0.0:
            return self.invert(self.power(x, -exponent))
        if exponent % 1.0 == 0.5:
            return self.power(x, exponent - 0.5) * self.call("sqrt", x)
        half = self.power(x, exponent // 2) if exponent > 1.0 else self.one
        return half * half * (x if exponent % 2.0 == 1.0 else self.one)

    def call(self, name: str, *arguments: Any) -> Term:
        """Return the value of one of `FUNCTIONS`."""
        return self.term(name, *map(self.term_of, arguments))

    def sum(self, terms: Sequence[Term]) -> Term:
        """Return the sum of terms, with common factors taken out."""
        groups: dict[Term, list[Term]] = {}
        for term in terms:
            factor, rest = _split(term)
            groups.setdefault(factor, []).append(rest)
        scale, total = 0.0, self.zero
        for factor, rests in groups.items():
            factor, rest = _split(factor * self._sum_of_products(rests))
            number, parameters = _number(factor)
            if not scale:  # a power of 2 is taken out too: derivatives of squares have it in common
                scale = number if abs(math.frexp(number)[0]) == 0.5 else 1.0
            total += number / scale * parameters * rest
        return scale * total

    def _sum_of_products(self, terms: list[Term]) -> Term:
        others: dict[Term, list[Term]] = {}  # by a factor of a term: the other factors
        for term in terms:
            for factor, other in _factors(term).items():
                if factor.varies:
                    others.setdefault(factor, []).append(other)
        factor = max(others, key=lambda factor: len(others[factor]), default=self.one)
        if len(others.get(factor, ())) < 2:
            return functools.reduce(self.add, terms)
        rest = [term for term in terms if factor not in _factors(term)]
        return self.sum([factor * self.sum(others[factor]), *rest])

    def gradient(self, of: Term, variables: Sequence[Term]) -> list[Term]:
        """Return the derivatives of a term with respect to variables by reverse differentiation."""
        factor, rest = _split(of)
        shares: dict[Term, list[Term]] = {variable: [] for variable in variables} | {rest: [self.one]}
        for term in reversed(_needed([rest])):
            for operand, partial in zip(term.operands, PARTIALS.get(term.operation, ()), strict=True):
                if operand.varies:
                    shares.setdefault(operand, []).append(self.sum(shares[term]) * partial(term))
        return [factor * self.sum(shares[variable]) for variable in variables]

    def derivative(self, of: Term, by: Term) -> Term:
        """Return the derivative of a term with respect to a variable, or to a term on which it depends, by forward
        differentiation. What depends on the variable through one term only is differentiated by the chain rule."""
        if of is by:
            return self.one
        if (of, by) not in self.derivatives:
            inner = self._bottleneck(of)
            self.derivatives[of, by] = self.sum([
                self.derivative(operand, by) * partial(of)
                for operand, partial in zip(of.operands, PARTIALS.get(of.operation, ()), strict=True)
                if operand.varies
            ]) if inner is None or inner is by else self.derivative(of, inner) * self.derivative(inner, by)  # fmt: skip
        return self.derivatives[of, by]

    def _bottleneck(self, of: Term) -> Term | None:
        """Return the last term through which a term depends on all its variables; None if there is none."""
        if of not in self.bottlenecks:
            ahead = {operand for operand in of.operands if operand.varies}
            while len(ahead) > 1:
                last = max(ahead, key=lambda term: term.order)
                inner = self._bottleneck(last)
                ahead = ahead - {last} | {inner} if inner is not None else set()
            self.bottlenecks[of] = ahead.pop() if ahead else None
        return self.bottlenecks[of]


class Energy:
    """Energy of a law as a graph, with its derivatives.

    Attributes
    ----------
    slopes : derivatives with respect to the one to three variables x, y, z.
    curvatures : second derivatives, in the order xx, yy, zz, xy, xz, yz.
    """

    def __init__(self, operation: Callable[..., Any], kind: type, function: Callable[..., Any]) -> None:
        self.kind, self.names, graph = kind, list(inspect.signature(function).parameters), Graph()
        law = kind(*[graph.term(f"{self.names[0]}.{field}") for field in kind._fields])  # type: ignore[attr-defined]
        variables = [graph.term(name, varies=True) for name in self.names[1:]]
        try:
            value = _on_terms(function)(law, *variables)
            if not isinstance(value, Term | int | float):
                raise NotTraced(f"it returns a {type(value).__name__}", "return one number, the energy")
        except Exception as error:
            text = f"`{operation.__name__}` of the law {kind.__name__} cannot be differentiated: {error}"
            wrong = NotTraced(text, _remedy(error, law))
            raise wrong.with_traceback(error.__traceback__) from None  # which has the line of the function
        self.slopes = graph.gradient(graph.term_of(value), variables)
        self.curvatures = [graph.derivative(slope, x) for slope, x in zip(self.slopes, variables, strict=True)]
        for one, other in combinations(range(len(variables)), 2):
            self.curvatures.append(graph.derivative(self.slopes[other], variables[one]))

    @property
    def is_linear(self) -> bool:
        """True if the second derivatives are zero for all parameters."""
        return all(term.operation == 0.0 for term in self.curvatures)

    def depends_on(self, place: int) -> bool:
        """Return True if the energy depends on the variable at a place (from 0)."""
        return self.slopes[place].operation != 0.0

    def function(self, operation: Callable[..., Any], results: Sequence[Term]) -> Callable[..., Any]:
        """Return a pointwise function, an implementation of `operation`, that computes these terms. Its docstring is its
        source."""
        texts: dict[Term, str] = {}
        lines: list[str] = []
        for term in _needed(results):
            operands = [texts[operand] for operand in term.operands]
            texts[term] = f"t{len(lines)}" if operands else str(term.operation)
            if operands:
                lines.append(f"    {texts[term]} = {_code(str(term.operation), operands)}\n")
        head = f"def {operation.__name__}({', '.join(self.names)}):\n"
        source = f"{head}{''.join(lines)}    return {', '.join(texts[term] for term in results)}\n"
        known: dict[str, Any] = {**FUNCTIONS, "__name__": self.kind.__module__}
        exec(compile(source, f"{DERIVED}{self.kind.__name__}>", "exec"), known)
        function: Callable[..., Any] = known[operation.__name__]
        function.__qualname__, function.__doc__ = f"{self.kind.__qualname__}.{operation.__name__}", source
        return function


_traced = functools.cache(Energy)  # once for all operations that follow from it


def derive(operation: Callable[..., Any], energy: Callable[..., Any], choose: Callable[[Energy], Any]) -> None:
    """Derive the implementations of an operation from an energy, a function of one to three variables: for each law that
    registers `energy` and has no implementation of its own, `choose` returns terms of the energy or a function. If the energy
    cannot be differentiated, NotTraced is raised where the operation is first used for the law."""

    @derived_function(operation, energy)
    def make(kind: type) -> Callable[..., Any] | None:
        function = implementation_of(energy, kind)
        if function is None:
            return None
        W = _traced(energy, kind, function)
        chosen = choose(W)
        return chosen if callable(chosen) else W.function(operation, chosen)  # type: ignore[no-any-return]


def _split(x: Term) -> tuple[Term, Term]:
    """Return the factor of a term that does not vary, and the rest."""
    if not x.varies:
        return x, x.graph.one
    return x.operands if x.operation == "*" and not x.operands[0].varies else (x.graph.one, x)  # type: ignore[return-value]


def _factors(x: Term) -> dict[Term, Term]:
    """Return the term and the factors of a product, each with the other factor."""
    pairs = zip(x.operands, x.operands[::-1], strict=True) if x.operation == "*" else ()
    return {x: x.graph.one, **dict(pairs)}


def _number(x: Term) -> tuple[float, Term]:
    """Return the number in a product, and the rest."""
    if isinstance(x.operation, float):
        return x.operation, x.graph.one
    first = x.operands[0].operation if x.operation == "*" else 1.0
    return (first, x.operands[1]) if x.operation == "*" and isinstance(first, float) else (1.0, x)


def _parts(x: Term) -> tuple[Term, Term]:
    """Return the constant in a sum or difference, and the rest."""
    if x.operation in ("+", "-"):
        for place, sign in ((0, 1.0), (1, 1.0 if x.operation == "+" else -1.0)):
            if isinstance(x.operands[place].operation, float) and (place or x.operation == "+"):
                return sign * x.operands[place], x.operands[1 - place]
    return x.graph.zero, x


def _needed(results: Sequence[Term]) -> list[Term]:
    """Return the terms and all terms on which they depend, operands first."""
    found: dict[Term, None] = {}
    ahead = list(results)
    while ahead:
        term = ahead.pop()
        if term not in found:
            found[term] = None
            ahead += term.operands
    return sorted(found, key=lambda term: term.order)


def _code(operation: str, operands: list[str]) -> str:
    if operation == "inverse":
        return f"1.0 / {operands[0]}"
    return f" {operation} ".join(operands) if operation in "+-*" else f"{operation}({', '.join(operands)})"


def _remedy(error: Exception, law: Any) -> str:
    """Return the correction of a mistake that an error in the function of an energy shows; an empty text if there is none."""
    if isinstance(error, AttributeError) and error.obj is law and hasattr(law, "_fields"):
        return f"correct the name, or add the field; the law has {listed([f'`{name}`' for name in law._fields])}"
    if isinstance(error, NameError):
        return "correct the name"
    return error.remedy if isinstance(error, NotTraced) else ""


def _on_terms(function: Any) -> Callable[..., Any]:
    """Return a function that accepts terms: the functions that it calls are replaced by functions of terms."""
    used = {name: function.__globals__[name] for name in function.__code__.co_names if name in function.__globals__}
    known = function.__globals__ | {name: _replaced(value) for name, value in used.items()}
    return FunctionType(function.__code__, known, function.__name__, function.__defaults__, function.__closure__)


class _Library:
    """A module of `LIBRARIES` with functions of terms."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return _replaced(getattr(self._module, name))


def _replaced(value: Any) -> Any:
    """Return the function of terms, or module of such functions, for a function or module; other values unchanged."""
    if any(value is module for module in LIBRARIES):
        return _Library(value)
    name = getattr(value, "__name__", "")
    alike = [FUNCTIONS.get(name), *(getattr(module, name, None) for module in LIBRARIES)] if name in FUNCTIONS else []
    if any(value is function for function in alike):

        def call(*arguments: Any) -> Any:
            graph = next((x.graph for x in arguments if isinstance(x, Term)), None)
            return graph.call(name, *arguments) if graph else value(*arguments)

        return call
    if is_operation(value):  # of the law itself

        def of_law(*arguments: Any) -> Any:
            function = implementation_of(value, type(arguments[0]))
            return value(*arguments) if function is None else _on_terms(function)(*arguments)

        return of_law
    if not isinstance(value, FunctionType):
        return value
    if is_pointwise(value):
        return _on_terms(value)

    def refuse(*arguments: Any) -> Any:
        if any(isinstance(x, Term) for x in arguments):
            raise NotTraced(f"it calls `{name}`, which is no pointwise function", f"decorate `{name}` with `@pointwise`")
        return value(*arguments)

    return refuse
