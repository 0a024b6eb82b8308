"""Exponents of numbers from their bits, for `pellucid.jit.elementary`.

Conversions use 32 bits and shifts are logical: processors without AVX-512 have no other vector instructions for them.
"""

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

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
