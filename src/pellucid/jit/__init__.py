"""Compiled kernels and the pointwise functions that they call.

Laws, shape functions and tensor algebra are plain scalar Python, marked with `@pointwise` or registered with
`@point_function`; nothing here imports numba until the first `@kernel` is used, so data models stay light.

Numba's disk cache does not detect edits in other files; `cache` stores kernels for the state of all sources that they
depend on.
"""

from pellucid.jit.kernel_folder import cache_folder
from pellucid.jit.kernels import check_threads, kernel, set_threads
from pellucid.jit.registry import (
    MissingFunction,
    default_function,
    derived_function,
    generic,
    implementation_of,
    point_function,
    pointwise,
)

__all__ = [
    "MissingFunction",
    "cache_folder",
    "check_threads",
    "default_function",
    "derived_function",
    "generic",
    "implementation_of",
    "kernel",
    "point_function",
    "pointwise",
    "set_threads",
]
