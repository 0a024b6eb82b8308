"""Rows of an array, one for each point, as vectors for a single point.

`vector_at_point(array, p)`: a row of three numbers, followed by a zero. `symmetric_at_point(array, p)`: the three columns
of a symmetric tensor, from a row of six numbers (xx, yy, zz, yz, xz, xy). `tensor_at_point(array, p)`: the three columns of
a tensor, from a row of ten numbers, nine of the tensor row by row and one more. The last lane of a column has no meaning.
`cross(a, b)`: the vector product of two vectors whose last lanes are zero. `with_last(vector, number)`: the vector with its
last lane replaced by `number`.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from pellucid.jit.rows import address_of_row
from pellucid.jit.vector import DOUBLES, LANES, SHUFFLE, VECTOR

FLAGS = ir.VectorType(ir.IntType(1), LANES)
COLUMNS = types.UniTuple(VECTOR, 3)  # type: ignore[attr-defined]


@intrinsic
def _vector_at_point(typing: Any, array: Any, p: Any) -> Any:
    kind = ir.FunctionType(DOUBLES, [DOUBLES.as_pointer(), ir.IntType(32), FLAGS, DOUBLES])

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        masked = cgutils.get_or_insert_function(builder.module, kind, "llvm.masked.load.v4f64.p0")
        place = address_of_row(context, builder, signature.args[0], given[0], given[1], 3, 0, LANES)
        # beyond the row of the last point nothing may be read
        mask, rest = ir.Constant(FLAGS, [1, 1, 1, 0]), ir.Constant(DOUBLES, [0.0] * LANES)
        return builder.call(masked, [place, ir.IntType(32)(8), mask, rest])

    return VECTOR(array, types.uintp), emit


@intrinsic
def _symmetric_at_point(typing: Any, array: Any, p: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        places = (address_of_row(context, builder, signature.args[0], given[0], given[1], 6, first, LANES) for first in (0, 2))
        xx_yy_zz_yz, zz_yz_xz_xy = (builder.load(place, align=8) for place in places)
        lanes = (0, 7, 6, 0), (7, 1, 3, 0), (6, 3, 2, 0)
        found = [builder.shuffle_vector(xx_yy_zz_yz, zz_yz_xz_xy, ir.Constant(SHUFFLE, column)) for column in lanes]
        return context.make_tuple(builder, COLUMNS, found)

    return COLUMNS(array, types.uintp), emit


@intrinsic
def _tensor_at_point(typing: Any, array: Any, p: Any) -> Any:
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


@intrinsic
def _cross(typing: Any, a: Any, b: Any) -> Any:
    next_lanes = ir.Constant(SHUFFLE, [1, 2, 0, 3])

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        turned = [builder.shuffle_vector(vector, vector, next_lanes) for vector in given]
        one, other = builder.fmul(given[0], turned[1]), builder.fmul(turned[0], given[1])
        found = builder.fsub(one, other)  # a product each of equal roundings: parallel vectors have none
        return builder.shuffle_vector(found, found, next_lanes)

    return VECTOR(VECTOR, VECTOR), emit


@intrinsic
def _with_last(typing: Any, vector: Any, number: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.insert_element(*given, ir.IntType(32)(LANES - 1))

    return VECTOR(VECTOR, types.float64), emit


def _plain_vector_at_point(array: np.ndarray, p: Any) -> np.ndarray:
    return np.append(array[p], 0.0)


def _plain_symmetric_at_point(array: np.ndarray, p: Any) -> Any:
    xx, yy, zz, yz, xz, xy = array[p]
    return np.array([xx, xy, xz, xx]), np.array([xy, yy, yz, xx]), np.array([xz, yz, zz, xx])


def _plain_tensor_at_point(array: np.ndarray, p: Any) -> Any:
    columns = array[p, :9].reshape(3, 3).T
    return tuple(np.append(column, column[0]) for column in columns)


def _plain_cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.append(np.cross(a[:3], b[:3]), 0.0)


def _plain_with_last(vector: np.ndarray, number: float) -> np.ndarray:
    return np.append(vector[:-1], number)


_PLAIN = _plain_vector_at_point, _plain_symmetric_at_point, _plain_tensor_at_point, _plain_cross, _plain_with_last
_COMPILED = _vector_at_point, _symmetric_at_point, _tensor_at_point, _cross, _with_last
vector_at_point, symmetric_at_point, tensor_at_point, cross, with_last = _PLAIN if numba.config.DISABLE_JIT else _COMPILED
