"""Dense linear algebra on one thread: the libraries of numpy and scipy divide sums among threads, which changes their bits,
and small matrices take them longer on several."""

from contextlib import AbstractContextManager
from typing import Any

import scipy.linalg  # noqa: F401  its library is not numpy's, and must be loaded when the controller looks for them
from threadpoolctl import ThreadpoolController

_libraries = ThreadpoolController()


def on_one_thread() -> AbstractContextManager[Any]:
    """The context in which products and factors of dense matrices take one thread."""
    limit: AbstractContextManager[Any] = _libraries.limit(limits=1, user_api="blas")
    return limit
