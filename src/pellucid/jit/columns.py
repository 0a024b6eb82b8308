"""Columns of a block of points for kernels: each number of a point becomes a vector for `LANES` points.

A block has up to BLOCK points. Each column of a scratch array has WIDTH numbers, so that a vector starting at the last
point stays within it; WIDTH is a multiple of eight, since LLVM does not vectorize otherwise. LLVM vectorizes a loop over
the points of a block automatically if the loop writes only to one such array.

Nested tuples of numbers use one column for each of their numbers, in order.

Sums over points that share their nodes have one vector for each node (`outer`, `no_sums`, `plus`, `moved`).
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types

from pellucid.jit.kernels import intrinsic_or
from pellucid.jit.memory import address_of
from pellucid.jit.vector import FUSED, LANES, VECTOR, repeat, vector_at

BLOCK = 32
WIDTH = BLOCK + 2 * LANES


def is_tuple(kind: Any) -> bool:
    """Return True if a compiled type is a tuple."""
    return isinstance(kind, types.BaseTuple)  # type: ignore[attr-defined]


def leaves(kind: Any) -> int:
    """Return the number of scalars in a value of a compiled type, i.e. of a number or nested tuples of numbers."""
    return sum(leaves(part) for part in kind) if is_tuple(kind) else 1


def lanes_of(kind: Any) -> Any:
    """Return the compiled type in which each number of a type (a number or nested tuples) is replaced by a vector of LANES
    numbers."""
    if not is_tuple(kind):
        return VECTOR
    parts = [lanes_of(part) for part in kind]
    if isinstance(kind, types.BaseNamedTuple):  # type: ignore[attr-defined]
        uniform = all(part == parts[0] for part in parts)
        make: Any = types.NamedUniTuple if uniform else types.NamedTuple  # type: ignore[attr-defined]
        return make(parts[0], len(parts), kind.instance_class) if uniform else make(parts, kind.instance_class)
    return types.Tuple(parts)  # type: ignore[attr-defined]


def numbers_in(value: Any) -> Iterator[Any]:
    """Yield the numbers, or vectors, of a number or nested tuples, in order."""
    if isinstance(value, tuple):
        for part in value:
            yield from numbers_in(part)
    else:
        yield value


def rebuilt(like: Any, values: Iterator[Any]) -> Any:
    """Build nested tuples with the structure of `like` from an iterator over their numbers or vectors."""
    if not isinstance(like, tuple):
        return next(values)
    parts = [rebuilt(part, values) for part in like]
    return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)


def built(context: Any, builder: Any, kind: Any, values: Iterator[Any]) -> Any:
    """Build nested tuples of the compiled type `kind` from an iterator over their scalars or vectors, in generated code.

    context, builder: numba's target context and LLVM builder.
    """
    if is_tuple(kind):
        return context.make_tuple(builder, kind, [built(context, builder, part, values) for part in kind])
    return next(values)


def flat(builder: Any, kind: Any, value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield compiled type and value of each scalar or vector in nested tuples of the type `kind`, in order, in generated code;
    builder: LLVM builder."""
    if is_tuple(kind):
        for place, part in enumerate(kind):
            yield from flat(builder, part, builder.extract_value(value, place))
    else:
        yield kind, value


def _column(builder: Any, data: Any, at: Any, column: int) -> Any:
    return builder.gep(data, [builder.add(at, at.type(column * WIDTH))], inbounds=True)


def _plain_size(like: Any) -> int:
    return sum(1 for _ in numbers_in(like))


@intrinsic_or(_plain_size)
def size(typing: Any, like: Any) -> Any:
    """Return the number of columns that the numbers of nested tuples use."""
    size = leaves(like)
    return types.intp(like), lambda context, builder, signature, values: ir.IntType(64)(size)


def _emit_put(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    """Generate code that stores the numbers or vectors of nested tuples in columns, one column each. The last three arguments
    (`given`, with the types in `signature`) are the array, the position in its first column and the tuples."""
    (array_kind, _, values_kind), (array, at, found) = signature.args[-3:], given[-3:]
    data = address_of(context, builder, array_kind, array)
    for column, (kind, value) in enumerate(flat(builder, values_kind, found)):
        place = _column(builder, data, at, column)
        if kind is VECTOR:
            builder.store(value, vector_at(builder, place), align=8)
        else:
            builder.store(context.cast(builder, value, kind, types.float64), place)
    return context.get_dummy_value()


def _plain_put(array: np.ndarray, at: int, values: Any) -> None:
    for column, value in enumerate(numbers_in(values)):
        start = at + column * WIDTH
        array[start : start + np.size(value)] = value


@intrinsic_or(_plain_put)
def put(typing: Any, array: Any, at: Any, values: Any) -> Any:
    """Store the numbers, or vectors, of nested tuples, one per column, from the position `at` in the first column on."""
    return types.none(array, types.intp, values), _emit_put


def _plain_put_like(like: Any, array: np.ndarray, at: int, values: Any) -> None:
    if _plain_size(values) != _plain_size(like):
        raise TypeError(f"{_plain_size(values)} numbers were given, but {_plain_size(like)} were declared")
    _plain_put(array, at, values)


@intrinsic_or(_plain_put_like)
def put_like(typing: Any, like: Any, array: Any, at: Any, values: Any) -> Any:
    """Do the same as `put` for a tuple with as many numbers as `like`; otherwise raise TypeError."""
    if leaves(values) != leaves(like):
        raise TypeError(f"{leaves(values)} numbers were given, but {leaves(like)} were declared")
    return types.none(like, array, types.intp, values), _emit_put


def _taking(kind: Any, lanes: bool) -> Any:
    wanted = lanes_of(kind) if lanes else kind

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        data = address_of(context, builder, signature.args[1], given[1])
        places = (_column(builder, data, given[2], column) for column in range(leaves(kind)))
        values = (builder.load(vector_at(builder, place), align=8) if lanes else builder.load(place) for place in places)
        return built(context, builder, wanted, values)

    return wanted, emit


def _plain_take(like: Any, array: np.ndarray, at: int) -> Any:
    return rebuilt(like, (float(array[at + column * WIDTH]) for column in range(_plain_size(like))))


@intrinsic_or(_plain_take)
def take(typing: Any, like: Any, array: Any, at: Any) -> Any:
    """Return nested tuples of numbers with the structure of `like` from the columns, at the position `at` in the first."""
    wanted, emit = _taking(like, lanes=False)
    return wanted(like, array, types.intp), emit


def _plain_take_lanes(like: Any, array: np.ndarray, at: int) -> Any:
    starts = (at + column * WIDTH for column in range(_plain_size(like)))
    return rebuilt(like, (array[start : start + LANES].copy() for start in starts))


@intrinsic_or(_plain_take_lanes)
def take_lanes(typing: Any, like: Any, array: Any, at: Any) -> Any:
    """Return nested tuples of vectors with the structure of `like` from the columns, at the position `at` in the first."""
    wanted, emit = _taking(like, lanes=True)
    return wanted(like, array, types.intp), emit


@intrinsic_or(lambda a, b: tuple(one * other for one in numbers_in(a) for other in numbers_in(b)))
def outer(typing: Any, a: Any, b: Any) -> Any:
    """Return the products of each number of a with each number of b, ordered by the numbers of a."""
    made = types.UniTuple(types.float64, len(a) * len(b))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        first, second = ([value for _, value in flat(builder, *pair)] for pair in zip((a, b), given, strict=True))
        return context.make_tuple(builder, made, [builder.fmul(one, other) for one in first for other in second])

    return made(a, b), emit


@intrinsic_or(lambda like: tuple(np.zeros(LANES) for _ in like))
def no_sums(typing: Any, like: Any) -> Any:
    """Return a zero vector for each number of a tuple."""
    made = types.UniTuple(VECTOR, len(like))  # type: ignore[attr-defined]
    return made(like), lambda context, builder, signature, given: context.get_constant_null(made)


def _plain_plus(sums: Any, weights: Any, vectors: Any) -> Any:
    of = vectors if isinstance(vectors, tuple) else (vectors,) * len(weights)
    return tuple(so_far + weight * vector for so_far, weight, vector in zip(sums, weights, of, strict=True))


@intrinsic_or(_plain_plus)
def plus(typing: Any, sums: Any, weights: Any, vectors: Any) -> Any:
    """Return `sums` plus, for each of its vectors, the weight at the same place times `vectors`, one vector or a tuple of
    vectors.
    """

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        so_far, by, of = (
            [value for _, value in flat(builder, *pair)] for pair in zip((sums, weights, vectors), given, strict=True)
        )
        of = of if is_tuple(vectors) else of * len(by)
        more = (builder.fmul(repeat(builder, weight), vector, flags=FUSED) for weight, vector in zip(by, of, strict=True))
        added = [builder.fadd(one, other, flags=FUSED) for one, other in zip(so_far, more, strict=True)]
        return context.make_tuple(builder, sums, added)

    return sums(sums, weights, vectors), emit


@intrinsic_or(lambda vectors, like, step: tuple(vector + number * step for number in range(len(like)) for vector in vectors))
def moved(typing: Any, vectors: Any, like: Any, step: Any) -> Any:
    """Return, for the number k = 0, 1, ... of each entry of `like`, the vectors plus k times `step`."""
    made = types.UniTuple(VECTOR, len(vectors) * len(like))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        last = [value for _, value in flat(builder, vectors, given[0])]
        found = list(last)
        for _ in range(1, len(like)):
            last = [builder.fadd(vector, given[2], flags=FUSED) for vector in last]
            found += last
        return context.make_tuple(builder, made, found)

    return made(vectors, like, VECTOR), emit
