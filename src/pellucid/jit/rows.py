"""Rows of arrays, one for each point, as vectors of `LANES` points or for a single point.

Rows are contiguous in memory. The rows of four points are read two components at a time, and a few shuffles sort these
pairs into one vector for each component; rows are also written for four points at a time. Values are (nested) tuples of
numbers or vectors. The matching arrays are a single array, or a tuple of arrays for the members of the values. Each array
has the shape (points,) or (points, components) in C order, with as many components as the member has numbers.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types

from pellucid.jit.columns import built, flat, is_tuple, lanes_of, leaves, numbers_in, rebuilt
from pellucid.jit.kernels import intrinsic_or
from pellucid.jit.registry import LINE
from pellucid.jit.vector import DOUBLES, LANES, SHUFFLE, VECTOR

DOUBLE = ir.DoubleType()
BYTE = ir.IntType(8).as_pointer()
SIZE = 8  # bytes of one
EVEN, ODD = [0, 4, 2, 6], [1, 5, 3, 7]
"""Shuffles of pairs: they sort numbers of two rows by component, or columns by point."""


def _lanes(builder: Any, one: Any, other: Any, lanes: list[int]) -> Any:
    return builder.shuffle_vector(one, other, ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes))


def address_of_row(context: Any, builder: Any, kind: Any, array: Any, p: Any, length: int, offset: int, count: int) -> Any:
    """Return the address of `count` doubles, starting `offset` doubles after the start of the row of point p, in generated
    code.

    context, builder: numba's target context and LLVM builder; kind: compiled type of the array; length: numbers in a row.
    """
    if not isinstance(kind, types.Array) or kind.dtype is not types.float64 or kind.layout != "C":
        raise TypeError(f"only arrays of doubles in C order have rows, not {kind}")
    data = context.make_array(kind)(context, builder, array).data
    place = builder.gep(data, [builder.add(builder.mul(p, p.type(length)), p.type(offset))], inbounds=True)
    return builder.bitcast(place, (ir.VectorType(DOUBLE, count) if count > 1 else DOUBLE).as_pointer())


def _walk(builder: Any, like: Any, kind: Any, arrays: Any, visit: Callable[[Any, Any, Any], Any]) -> Iterator[Any]:
    """Yield the result of `visit(part, type, array)` for each array of nested tuples of arrays, in generated code.

    like: compiled type of the values of a point, of which `part` belongs to the array; kind: compiled type of `arrays`.
    """
    if not is_tuple(kind):
        yield visit(like, kind, arrays)
        return
    for place, (part, inner) in enumerate(zip(like, kind, strict=True)):
        yield from _walk(builder, part, inner, builder.extract_value(arrays, place), visit)


def _columns(builder: Any, length: int, taken: Callable[[int, int], Any]) -> list[Any]:
    """Return one vector for each of `length` components of the rows of four points; taken: function that returns `count`
    numbers that begin at an offset from the first row."""
    columns = []
    for component in range(0, length - 1, 2):
        pairs = [taken(component + length * lane, 2) for lane in range(LANES)]
        even, odd = _lanes(builder, pairs[0], pairs[2], [0, 1, 2, 3]), _lanes(builder, pairs[1], pairs[3], [0, 1, 2, 3])
        columns += [_lanes(builder, even, odd, EVEN), _lanes(builder, even, odd, ODD)]
    if length % 2:
        last = ir.Constant(ir.VectorType(DOUBLE, LANES), ir.Undefined)
        for lane in range(LANES):
            last = builder.insert_element(last, taken(length - 1 + length * lane, 1), ir.IntType(32)(lane))
        columns.append(last)
    return columns


def _rows(builder: Any, columns: list[Any]) -> Iterator[tuple[int, Any]]:
    """Yield the numbers of the rows of four points as vectors of components of one row, each with its offset from the first
    row; columns: one vector for each component."""
    length = len(columns)
    together = zip(columns[:-1:2], columns[1::2], strict=True)
    pairs = [[_lanes(builder, one, other, lanes) for lanes in (EVEN, ODD)] for one, other in together]
    for lane in range(LANES):
        half = [lane // 2 * 2, lane // 2 * 2 + 1]  # of the vector of a pair, in which row `lane` lies
        of_row = [pair[lane % 2] for pair in pairs]
        for k in range(0, len(of_row) - 1, 2):
            yield length * lane + 2 * k, _lanes(builder, of_row[k], of_row[k + 1], [*half, half[0] + LANES, half[1] + LANES])
        if len(of_row) % 2:
            yield length * lane + 2 * (len(of_row) - 1), _lanes(builder, of_row[-1], of_row[-1], half)
        if length % 2:
            yield length * lane + length - 1, builder.extract_element(columns[-1], ir.IntType(32)(lane))


def _plain_take_rows(like: Any, arrays: Any, p: Any) -> Any:
    rows = [array[int(p) : int(p) + LANES].reshape(LANES, -1) for _, array in _plain_walk(like, arrays)]
    return rebuilt(like, iter([column.copy() for part in rows for column in part.T]))


@intrinsic_or(_plain_take_rows)
def take_rows(typing: Any, like: Any, arrays: Any, p: Any) -> Any:
    """Return nested tuples of vectors with the structure of `like` from the rows of four points, from point p on."""
    wanted = lanes_of(like)

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        def visit(part: Any, kind: Any, array: Any) -> list[Any]:
            length = leaves(part)

            def taken(offset: int, count: int) -> Any:
                address = address_of_row(context, builder, kind, array, given[2], length, offset, count)
                return builder.load(address, align=SIZE)

            return [taken(0, LANES)] if length == 1 else _columns(builder, length, taken)

        found = _walk(builder, like, arrays, given[1], visit)
        return built(context, builder, wanted, (vector for vectors in found for vector in vectors))

    return wanted(like, arrays, types.uintp), emit


def _plain_take_row(like: Any, arrays: Any, p: Any) -> Any:
    return rebuilt(like, iter([float(value) for _, array in _plain_walk(like, arrays) for value in np.atleast_1d(array[p])]))


@intrinsic_or(_plain_take_row)
def take_row(typing: Any, like: Any, arrays: Any, p: Any) -> Any:
    """Return nested tuples of numbers with the structure of `like` from the row of point p."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        def visit(part: Any, kind: Any, array: Any) -> list[Any]:
            length = leaves(part)
            first = address_of_row(context, builder, kind, array, given[2], length, 0, 1)
            return [builder.load(builder.gep(first, [given[2].type(place)], inbounds=True)) for place in range(length)]

        found = _walk(builder, like, arrays, given[1], visit)
        return built(context, builder, like, (number for numbers in found for number in numbers))

    return like(like, arrays, types.uintp), emit


def _plain_keep_rows(arrays: Any, p: Any, values: Any) -> None:
    for part, array in _plain_walk(values, arrays):
        array[int(p) : int(p) + LANES] = np.stack(list(numbers_in(part)), axis=1).reshape(LANES, *array.shape[1:])


@intrinsic_or(_plain_keep_rows)
def keep_rows(typing: Any, arrays: Any, p: Any, values: Any) -> Any:
    """Store nested tuples of vectors in the rows of four points, from point p on."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        kept = (value for _, value in flat(builder, values, given[2]))

        def visit(part: Any, kind: Any, array: Any) -> None:
            length = leaves(part)
            columns = [next(kept) for _ in range(length)]
            parts = [(0, columns[0])] if length == 1 else _rows(builder, columns)
            for offset, value in parts:
                count = value.type.count if isinstance(value.type, ir.VectorType) else 1
                builder.store(value, address_of_row(context, builder, kind, array, given[1], length, offset, count), align=SIZE)

        list(_walk(builder, values, arrays, given[0], visit))
        return context.get_dummy_value()

    return types.none(arrays, types.uintp, values), emit


def _plain_keep_row(arrays: Any, p: Any, values: Any) -> None:
    for part, array in _plain_walk(values, arrays):
        array[p] = part if array.ndim == 1 else list(numbers_in(part))


@intrinsic_or(_plain_keep_row)
def keep_row(typing: Any, arrays: Any, p: Any, values: Any) -> Any:
    """Store nested tuples of numbers in the row of point p."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        kept = (value for _, value in flat(builder, values, given[2]))

        def visit(part: Any, kind: Any, array: Any) -> None:
            first = address_of_row(context, builder, kind, array, given[1], leaves(part), 0, 1)
            for place in range(leaves(part)):
                builder.store(next(kept), builder.gep(first, [given[1].type(place)], inbounds=True))

        list(_walk(builder, values, arrays, given[0], visit))
        return context.get_dummy_value()

    return types.none(arrays, types.uintp, values), emit


def _prefetch_line(builder: Any, place: Any) -> None:
    """Prefetch the cache line at an address, in compiled code."""
    flag = ir.IntType(32)
    kind = ir.FunctionType(ir.VoidType(), [BYTE, flag, flag, flag])
    prefetch = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
    to_read, to_stay, of_data = flag(0), flag(3), flag(1)
    builder.call(prefetch, [place, to_read, to_stay, of_data])


@intrinsic_or(lambda like, arrays, p: None)
def expect_rows(typing: Any, like: Any, arrays: Any, p: Any) -> Any:
    """Prefetch the rows of four points, from point p on, to the cache."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        def visit(part: Any, kind: Any, array: Any) -> None:
            length = leaves(part)
            data = builder.bitcast(context.make_array(kind)(context, builder, array).data, BYTE)
            first = builder.mul(given[2], given[2].type(length * SIZE))
            for line in range(0, LANES * length * SIZE, LINE):  # the last may lie beyond the array: that is no fault
                _prefetch_line(builder, builder.gep(data, [builder.add(first, first.type(line))]))

        list(_walk(builder, like, arrays, given[1], visit))
        return context.get_dummy_value()

    return types.none(like, arrays, types.uintp), emit


@intrinsic_or(lambda address: None)
def prefetch(typing: Any, address: Any) -> Any:
    """Prefetch the cache line at an address."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        _prefetch_line(builder, builder.inttoptr(given[0], BYTE))
        return context.get_dummy_value()

    return types.none(types.intp), emit


def _plain_walk(like: Any, arrays: Any) -> Iterator[tuple[Any, np.ndarray]]:
    if isinstance(arrays, tuple):
        for part, inner in zip(like, arrays, strict=True):
            yield from _plain_walk(part, inner)
    else:
        yield like, arrays


FLAGS = ir.VectorType(ir.IntType(1), LANES)
COLUMNS = types.UniTuple(VECTOR, 3)  # type: ignore[attr-defined]


@intrinsic_or(lambda array, p: np.append(array[p], 0.0))
def vector_at_point(typing: Any, array: Any, p: Any) -> Any:
    """Return the row of three numbers of point p, followed by a zero."""
    kind = ir.FunctionType(DOUBLES, [DOUBLES.as_pointer(), ir.IntType(32), FLAGS, DOUBLES])

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        masked = cgutils.get_or_insert_function(builder.module, kind, "llvm.masked.load.v4f64.p0")
        place = address_of_row(context, builder, signature.args[0], given[0], given[1], 3, 0, LANES)
        # beyond the row of the last point nothing may be read
        mask, rest = ir.Constant(FLAGS, [1, 1, 1, 0]), ir.Constant(DOUBLES, [0.0] * LANES)
        return builder.call(masked, [place, ir.IntType(32)(8), mask, rest])

    return VECTOR(array, types.uintp), emit


def _plain_symmetric_at_point(array: np.ndarray, p: Any) -> Any:
    xx, yy, zz, yz, xz, xy = array[p]
    return np.array([xx, xy, xz, xx]), np.array([xy, yy, yz, xx]), np.array([xz, yz, zz, xx])


@intrinsic_or(_plain_symmetric_at_point)
def symmetric_at_point(typing: Any, array: Any, p: Any) -> Any:
    """Return the three columns of a symmetric tensor from the row of six numbers of point p (xx, yy, zz, yz, xz, xy). The
    last lane of a column has no meaning.
    """

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        places = (address_of_row(context, builder, signature.args[0], given[0], given[1], 6, first, LANES) for first in (0, 2))
        xx_yy_zz_yz, zz_yz_xz_xy = (builder.load(place, align=8) for place in places)
        lanes = (0, 7, 6, 0), (7, 1, 3, 0), (6, 3, 2, 0)
        found = [builder.shuffle_vector(xx_yy_zz_yz, zz_yz_xz_xy, ir.Constant(SHUFFLE, column)) for column in lanes]
        return context.make_tuple(builder, COLUMNS, found)

    return COLUMNS(array, types.uintp), emit


def _plain_tensor_at_point(array: np.ndarray, p: Any) -> Any:
    columns = array[p, :9].reshape(3, 3).T
    return tuple(np.append(column, column[0]) for column in columns)


@intrinsic_or(_plain_tensor_at_point)
def tensor_at_point(typing: Any, array: Any, p: Any) -> Any:
    """Return the three columns of a tensor from the row of ten numbers of point p: nine of the tensor, row by row, and one
    more. The last lane of a column has no meaning.
    """

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        places = (
            address_of_row(context, builder, signature.args[0], given[0], given[1], 10, first, LANES) for first in (0, 3, 6)
        )
        one, two, three = (builder.load(place, align=8) for place in places)
        pairs = (builder.shuffle_vector(one, two, ir.Constant(SHUFFLE, [d, 4 + d, 0, 0])) for d in range(3))
        lanes = ([0, 1, 4 + d, 0] for d in range(3))
        found = [
            builder.shuffle_vector(pair, three, ir.Constant(SHUFFLE, column)) for pair, column in zip(pairs, lanes, strict=True)
        ]
        return context.make_tuple(builder, COLUMNS, found)

    return COLUMNS(array, types.uintp), emit


@intrinsic_or(lambda a, b: np.append(np.cross(a[:3], b[:3]), 0.0))
def cross(typing: Any, a: Any, b: Any) -> Any:
    """Return the vector product of two vectors whose last lanes are zero."""
    next_lanes = ir.Constant(SHUFFLE, [1, 2, 0, 3])

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        turned = [builder.shuffle_vector(vector, vector, next_lanes) for vector in given]
        one, other = builder.fmul(given[0], turned[1]), builder.fmul(turned[0], given[1])
        found = builder.fsub(one, other)  # a product each of equal roundings: parallel vectors have none
        return builder.shuffle_vector(found, found, next_lanes)

    return VECTOR(VECTOR, VECTOR), emit


@intrinsic_or(lambda vector, number: np.append(vector[:-1], number))
def with_last(typing: Any, vector: Any, number: Any) -> Any:
    """Return a vector with its last lane replaced by a number."""

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.insert_element(*given, ir.IntType(32)(LANES - 1))

    return VECTOR(VECTOR, types.float64), emit
