"""SIGTERM and Ctrl-C: during a run they take effect after the current step, during compilation after the current kernel;
otherwise they raise an exception, and incomplete files are removed."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pellucid.errors import Terminated

CAUGHT = signal.SIGTERM, signal.SIGINT


@contextmanager
def signals_caught() -> Iterator[list[int]]:
    """Collect SIGTERM and SIGINT in a list instead of ending the process in the middle of a step; only in the main thread."""
    caught: list[int] = []
    with _handled({number: lambda n, _: caught.append(n) for number in CAUGHT}):
        yield caught


@contextmanager
def signals_held() -> Iterator[None]:
    """Defer SIGTERM and SIGINT to the end of the block; only in the main thread.

    An exception raised by a signal handler during compilation by numba may be lost, because the compiler's C++ code calls
    the handler and does not propagate errors.
    """
    caught: list[int] = []
    try:
        with signals_caught() as caught:
            yield
    finally:
        for number in dict.fromkeys(caught):
            signal.raise_signal(number)


@contextmanager
def termination_raised() -> Iterator[None]:
    """Raise Terminated at SIGTERM, as Ctrl-C raises KeyboardInterrupt; only in the main thread."""

    def end(*_: object) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a second one is obeyed at once
        raise Terminated

    with _handled({signal.SIGTERM: end}):
        yield


@contextmanager
def _handled(handlers: dict[int, Any]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # what was not put there from Python cannot be put back, and stays
    previous = {number: before for number in handlers if (before := signal.getsignal(number)) is not None}
    try:
        for number in previous:
            signal.signal(number, handlers[number])
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
