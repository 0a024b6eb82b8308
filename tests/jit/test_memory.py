"""Arrays of a kernel's own: they hold what is put into them, one apart from the other, and zeros are zero at each call."""

import numpy as np

from pellucid.jit import kernel
from pellucid.jit.memory import indices, numbers, zeros


@kernel()
def _fill(n, out):
    a, count, total = numbers(n), indices(n), zeros(n + 1)
    for k in range(n):
        a[k] = 0.5 * k
        count[k] = k * k
    for k in range(n):
        total[k + 1] += a[k] + count[k]
    for k in range(n + 1):
        out[k] = total[k]


def test_arrays_keep_their_numbers_apart_and_zeros_are_zero_at_each_call():
    for n in (1, 7, 40, 7):
        out, k = np.full(n + 1, np.nan), np.arange(n)
        _fill(n, out)
        assert out.tolist() == [0.0, *(0.5 * k + k * k)]
