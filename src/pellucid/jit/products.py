"""Sums over points that share their nodes, with one vector for each node, from tuples of weights and of vectors.

`outer(a, b)`: products of each number of a with each number of b, ordered by the numbers of a. `no_sums(like)`: a zero
vector for each number of a tuple. `plus(sums, weights, vectors)`: to each vector of `sums`, add the weight at the same
place times `vectors`, a single vector or a tuple of vectors. `moved(vectors, like, step)`: for the number k = 0, 1, ... of
each entry of `like`, the vectors plus k times `step`.
"""

from typing import Any

import numba
import numpy as np
from numba.core import types
from numba.extending import intrinsic

from pellucid.jit.columns import flat, is_tuple, numbers_in
from pellucid.jit.vector import FUSED, LANES, VECTOR, repeat


@intrinsic
def _outer(typing: Any, a: Any, b: Any) -> Any:
    made = types.UniTuple(types.float64, len(a) * len(b))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        first, second = ([value for _, value in flat(builder, *pair)] for pair in zip((a, b), given, strict=True))
        return context.make_tuple(builder, made, [builder.fmul(one, other) for one in first for other in second])

    return made(a, b), emit


@intrinsic
def _no_sums(typing: Any, like: Any) -> Any:
    made = types.UniTuple(VECTOR, len(like))  # type: ignore[attr-defined]
    return made(like), lambda context, builder, signature, given: context.get_constant_null(made)


@intrinsic
def _plus(typing: Any, sums: Any, weights: Any, vectors: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        so_far, by, of = (
            [value for _, value in flat(builder, *pair)] for pair in zip((sums, weights, vectors), given, strict=True)
        )
        of = of if is_tuple(vectors) else of * len(by)
        more = (builder.fmul(repeat(builder, weight), vector, flags=FUSED) for weight, vector in zip(by, of, strict=True))
        added = [builder.fadd(one, other, flags=FUSED) for one, other in zip(so_far, more, strict=True)]
        return context.make_tuple(builder, sums, added)

    return sums(sums, weights, vectors), emit


@intrinsic
def _moved(typing: Any, vectors: Any, like: Any, step: Any) -> Any:
    made = types.UniTuple(VECTOR, len(vectors) * len(like))  # type: ignore[attr-defined]

    def emit(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        last = [value for _, value in flat(builder, vectors, given[0])]
        found = list(last)
        for _ in range(1, len(like)):
            last = [builder.fadd(vector, given[2], flags=FUSED) for vector in last]
            found += last
        return context.make_tuple(builder, made, found)

    return made(vectors, like, VECTOR), emit


def _plain_outer(a: Any, b: Any) -> Any:
    return tuple(one * other for one in numbers_in(a) for other in numbers_in(b))


def _plain_no_sums(like: Any) -> Any:
    return tuple(np.zeros(LANES) for _ in like)


def _plain_plus(sums: Any, weights: Any, vectors: Any) -> Any:
    of = vectors if isinstance(vectors, tuple) else (vectors,) * len(weights)
    return tuple(so_far + weight * vector for so_far, weight, vector in zip(sums, weights, of, strict=True))


def _plain_moved(vectors: Any, like: Any, step: np.ndarray) -> Any:
    return tuple(vector + number * step for number in range(len(like)) for vector in vectors)


_PLAIN = _plain_outer, _plain_no_sums, _plain_plus, _plain_moved
outer, no_sums, plus, moved = _PLAIN if numba.config.DISABLE_JIT else (_outer, _no_sums, _plus, _moved)
