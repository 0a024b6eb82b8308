"""Dense linear algebra on one thread: with several threads, the libraries of numpy and scipy give results that depend on
the number of threads, and small matrices take longer."""

from contextlib import AbstractContextManager
from typing import Any

import scipy.linalg  # noqa: F401  its library is not numpy's, and must be loaded when the controller looks for them
from threadpoolctl import ThreadpoolController

_libraries = ThreadpoolController()


def on_one_thread() -> AbstractContextManager[Any]:
    """Return a context that limits products and factorizations of dense matrices to one thread."""
    limit: AbstractContextManager[Any] = _libraries.limit(limits=1, user_api="blas")
    return limit
