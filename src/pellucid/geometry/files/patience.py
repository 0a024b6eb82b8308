"""Work that may never end, of readers that wait for a line that a damaged file has not."""

import ctypes
from collections.abc import Callable
from threading import Thread
from typing import TypeVar

Result = TypeVar("Result")
AGAIN = 0.2  # s between two calls to a halt


class TooLong(Exception):
    """Work that had not ended in its time."""


class _Halt(BaseException):
    """Ends a thread wherever it is, unless it catches everything."""


def within(seconds: float, work: Callable[[], Result]) -> Result:
    """What `work` returns or raises. Raises TooLong where it takes longer: then it is ended, at its next line of Python."""
    found: list[Result] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            found.append(work())
        except BaseException as error:  # the program ending included: it is the caller's to decide
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
