"""A vector of four doubles for kernels, i.e. four points at a time.

LLVM vectorizes loops by itself only if they contain no sums, and it runs the last few iterations as scalar code. The operators
+ - * / accept vectors and numbers. Without the compiler, numpy arrays of length four replace vectors.

Exponents of numbers follow from their bits (`exponent_and_rest`, `two_to`), for `pellucid.jit.elementary`. Conversions use 32
bits and shifts are logical: processors without AVX-512 have no other vector instructions for them.

Four doubles fill an AVX2 register, and there are sixteen registers: nine sums of eight doubles would not fit.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, models, overload, register_model

from pellucid.jit.kernels import intrinsic_or
from pellucid.jit.memory import address_of
from pellucid.jit.registry import IN_KERNELS

LANES = 4
DOUBLES = ir.VectorType(ir.DoubleType(), LANES)
SHUFFLE = ir.VectorType(ir.IntType(32), LANES)
"""Type of the lane indices of a shuffle."""
FUSED = ("contract",)
"""Flags that allow fused sums and products, as in all kernels."""


class VectorType(types.Type):
    """Compiled type of a vector of LANES doubles."""

    def __init__(self) -> None:
        super().__init__(name=f"Vector{LANES}")


VECTOR = VectorType()


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: VectorType) -> None:
        super().__init__(manager, kind, DOUBLES)


def vector_at(builder: Any, address: Any) -> Any:
    """Return the address of a double, converted to the address of a vector of LANES doubles, in generated code."""
    return builder.bitcast(address, DOUBLES.as_pointer())


def _place(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    """Return the address of LANES numbers of an array, starting at an index, converted to the address of a vector, in generated
    code.

    context, builder: numba's target context and LLVM builder; kind: compiled type of the array.
    """
    numbers = ir.VectorType(context.get_data_type(kind.dtype), LANES)
    data = address_of(context, builder, kind, array)
    return builder.bitcast(builder.gep(data, [index]), numbers.as_pointer())


@intrinsic_or(lambda array, index: array[index : index + LANES].astype(float))
def load(typing: Any, array: Any, index: Any) -> Any:
    """Read four contiguous numbers of an array, in single or double precision, from an index on."""
    size = array.dtype.bitwidth // 8

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        found = builder.load(_place(context, builder, signature.args[0], *values), align=size)
        return found if size == 8 else builder.fpext(found, DOUBLES)

    return VECTOR(array, types.intp), emit


def _plain_store(array: np.ndarray, index: int, vector: np.ndarray) -> None:
    array[index : index + LANES] = vector


@intrinsic_or(_plain_store)
def store(typing: Any, array: Any, index: Any, vector: Any) -> Any:
    """Write a vector to four contiguous numbers of an array, from an index on."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        builder.store(values[2], _place(context, builder, signature.args[0], *values[:2]), align=8)
        return context.get_dummy_value()

    return types.none(array, types.intp, VECTOR), emit


def repeat(builder: Any, number: Any) -> Any:
    """Return a vector with a scalar in all lanes, in generated code; builder: LLVM builder."""
    empty = ir.Constant(DOUBLES, ir.Undefined)
    first = builder.insert_element(empty, number, ir.IntType(32)(0))
    return builder.shuffle_vector(first, empty, ir.Constant(SHUFFLE, [0] * LANES))


def _plain_splat(number: float) -> np.ndarray:
    return np.full(LANES, number)


@intrinsic_or(_plain_splat)
def splat(typing: Any, number: Any) -> Any:
    """Return a vector with a number in all lanes."""
    return VECTOR(types.float64), lambda context, builder, signature, values: repeat(builder, values[0])


@intrinsic_or(lambda array, index: _plain_splat(array[index]))
def spread(typing: Any, array: Any, index: Any) -> Any:
    """Return a vector with a number of an array in all lanes."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        data = address_of(context, builder, signature.args[0], values[0])
        return repeat(builder, builder.load(builder.gep(data, [values[1]])))

    return VECTOR(array, types.intp), emit


def _plain_total(vector: np.ndarray) -> float:
    lanes = vector
    while len(lanes) > 1:
        lanes = lanes[::2] + lanes[1::2]
    return float(lanes[0])


@intrinsic_or(_plain_total)
def total(typing: Any, vector: Any) -> Any:
    """Return the sum of the lanes of a vector, added in a fixed order."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        lanes = [builder.extract_element(values[0], ir.IntType(32)(lane)) for lane in range(LANES)]
        while len(lanes) > 1:  # neighbours, then pairs of them
            lanes = [builder.fadd(*lanes[k : k + 2]) for k in range(0, len(lanes), 2)]
        return lanes[0]

    return types.float64(VECTOR), emit


@intrinsic_or(lambda a, b, c: np.array([_plain_total(a), _plain_total(b), _plain_total(c), _plain_total(c)]))
def totals(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a vector with the sums of the lanes of three vectors; the fourth lane repeats the third."""

    def pick(builder: Any, one: Any, other: Any, *lanes: int) -> Any:
        return builder.shuffle_vector(one, other, ir.Constant(SHUFFLE, lanes))

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        a, b, c = values
        ab = builder.fadd(pick(builder, a, b, 0, 4, 2, 6), pick(builder, a, b, 1, 5, 3, 7))
        cc = builder.fadd(pick(builder, c, c, 0, 0, 2, 2), pick(builder, c, c, 1, 1, 3, 3))
        return builder.fadd(pick(builder, ab, cc, 0, 1, 4, 5), pick(builder, ab, cc, 2, 3, 6, 7))

    return VECTOR(VECTOR, VECTOR, VECTOR), emit


@intrinsic_or(lambda a, b, c, d: np.array([a, b, c, d]))
def row(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """Return a vector of four numbers."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        row = ir.Constant(DOUBLES, ir.Undefined)
        for lane, value in enumerate(values):
            row = builder.insert_element(row, value, ir.IntType(32)(lane))
        return row

    return VECTOR(*[types.float64] * 4), emit


@intrinsic_or(lambda like: 0.0 * np.asarray(like))
def nothing(typing: Any, like: Any) -> Any:
    """Return zero of the type of a number or vector."""
    kind: Any = VECTOR if like is VECTOR else types.float64
    return kind(like), lambda context, builder, signature, values: context.get_constant_null(kind)


@intrinsic_or(lambda one, other: np.where(one > other, one, other))
def larger(typing: Any, one: Any, other: Any) -> Any:
    """Return the larger number in each lane, and the second if the first is nan."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *values), *values)

    return VECTOR(VECTOR, VECTOR), emit


@intrinsic_or(lambda flag, one, other: np.where(flag > 0.0, one, other))
def where_positive(typing: Any, flag: Any, one: Any, other: Any) -> Any:
    """Return the lanes of `one` where `flag` is positive, else those of `other`."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        flag, one, other = values
        return builder.select(builder.fcmp_ordered(">", flag, ir.Constant(DOUBLES, [0.0] * LANES)), one, other)

    return VECTOR(VECTOR, VECTOR, VECTOR), emit


def _binary(instruction: str) -> Any:
    @intrinsic
    def combine(typing: Any, one: Any, other: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return getattr(builder, instruction)(*values, flags=FUSED)

        return VECTOR(VECTOR, VECTOR), emit

    return combine


def _overload(operation: Any, in_place: Any, combine: Any) -> None:
    def choose(one, other):  # type: ignore[no-untyped-def]  # numba compares its signature with those below
        if one is VECTOR and other is VECTOR:
            return lambda one, other: combine(one, other)
        if one is VECTOR and isinstance(other, types.Float):
            return lambda one, other: combine(one, splat(other))
        if other is VECTOR and isinstance(one, types.Float):
            return lambda one, other: combine(splat(one), other)
        return None

    for function in (operation, in_place):
        overload(function, jit_options=IN_KERNELS)(choose)


_overload(operator.add, operator.iadd, _binary("fadd"))
_overload(operator.sub, operator.isub, _binary("fsub"))
_overload(operator.mul, operator.imul, _binary("fmul"))
_overload(operator.truediv, operator.itruediv, _binary("fdiv"))


LONG, SHORT, DOUBLE = ir.IntType(64), ir.IntType(32), ir.DoubleType()
SQRT_HALF, ONE = 0x3FE6A09E00000000, 0x3FF0000000000000
"""Bits of √½, without its last digits, and of 1."""
DIGITS = 52


@intrinsic
def exponent_and_rest(typing: Any, x: Any) -> Any:
    """Return the exponent k and the mantissa m, √½ ≤ m < √2, of a positive number x = m 2ᵏ, in generated code (a numba
    intrinsic)."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        bits = builder.bitcast(values[0], LONG)
        above = builder.add(bits, LONG(ONE - SQRT_HALF))  # the exponent grows at √½, not at 1
        exponent = builder.sub(builder.trunc(builder.lshr(above, LONG(DIGITS)), SHORT), SHORT(ONE >> DIGITS))
        rest = builder.add(builder.and_(above, LONG((1 << DIGITS) - 1)), LONG(SQRT_HALF))
        found = builder.sitofp(exponent, DOUBLE), builder.bitcast(rest, DOUBLE)
        return context.make_tuple(builder, signature.return_type, found)

    return types.UniTuple(types.float64, 2)(types.float64), emit  # type: ignore[attr-defined]


@intrinsic
def two_to(typing: Any, k: Any) -> Any:
    """Return 2ᵏ for an integer k between -1022 and 1023, in generated code (a numba intrinsic)."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        exponent = builder.add(builder.fptosi(values[0], SHORT), SHORT(ONE >> DIGITS))
        return builder.bitcast(builder.shl(builder.zext(exponent, LONG), LONG(DIGITS)), DOUBLE)

    return types.float64(types.float64), emit
