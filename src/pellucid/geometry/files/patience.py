"""Time limit for readers that may wait forever for a line that a damaged file does not have."""

import ctypes
from collections.abc import Callable
from threading import Thread
from typing import TypeVar

Result = TypeVar("Result")
AGAIN = 0.2  # s between two calls to a halt


class TooLong(Exception):
    """Raised if work did not finish within its time limit."""


class _Halt(BaseException):
    """Exception that is raised in a running thread to stop it; it has no effect if the thread catches all exceptions."""


def within(seconds: float, work: Callable[[], Result]) -> Result:
    """Call `work` in a thread and return its result or raise its error. Raises TooLong after a time of `seconds` [s]; the
    work is then stopped at its next Python line."""
    found: list[Result] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            found.append(work())
        except BaseException as error:  # including SystemExit, which the caller handles
            failed.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    try:
        thread.join(seconds)
    finally:
        late = thread.is_alive()
        for _ in range(5):
            if thread.is_alive():
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(_Halt))
                thread.join(AGAIN)
    if late and not found:
        raise TooLong
    if failed:
        raise failed[0]
    return found[0]
