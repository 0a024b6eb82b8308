"""Exceptions of users' code: reported with file, line and cause instead of a bare traceback."""

import linecache
import os
import sys
import sysconfig
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.errors import PellucidError

OWN = str(Path(__file__).parents[1]) + os.sep
DERIVED = "<derived for "
"""Start of the file names of derived code (`pellucid.materials.derivatives`)."""
LIBRARIES = tuple({sysconfig.get_paths()[name] + os.sep for name in ("stdlib", "platstdlib", "purelib", "platlib")})


class WrongArray(ValueError):
    """Error for a user's function that returns no array of numbers or one of a wrong shape; the message has the required
    shape."""


@contextmanager
def failing_as(make: Callable[[str], Exception], function: Any = None) -> Iterator[None]:
    """Context manager that turns an exception of users' code in the block into another exception; exceptions of pellucid
    are not changed.

    make: function that builds the new exception from a description of the original one; function: the users' function that
    the block calls, which the description names.
    """
    try:
        yield
    except PellucidError:
        raise
    except (Exception, SystemExit) as error:
        raise make(failure(error, function)) from error


def failure(error: BaseException, function: Any = None) -> str:
    """Describe an exception of users' code in a text: type, message, place in the code (or the place of `function`), and a
    remedy if the cause is known."""
    words = " ".join(str(error).partition("\n\n")[0].split())
    text = f"{type(error).__name__}: {words}" if words else type(error).__name__
    if place := place_of(error):
        text += f", at {place}"
    elif function is not None:
        text += f", see {home_of(function)}"
    if isinstance(error, ValueError) and "read-only" in words:
        text += "; arrays of a body are read-only, so modify a copy, such as `position.copy()`"
    return text


def place_of(error: BaseException) -> str:
    """Return the innermost line of users' code in the traceback of an exception, such as "drag.py:17 (`return 1 / 0`)"; an
    empty text if the traceback contains no users' code."""
    if isinstance(error, SyntaxError) and error.filename:
        return line_at(error.filename, error.lineno or 1)
    frames = traceback.extract_tb(error.__traceback__)
    called = next((number for number, frame in enumerate(frames) if is_own(frame.filename)), 0)  # what calls pellucid is before
    behind = [frame for frame in frames[called:] if not is_own(frame.filename)]
    written = [frame for frame in behind if is_users(frame.filename)] or behind[:1]
    return line_at(written[-1].filename, written[-1].lineno or 1) if written else ""


def as_array(found: Any, shape: tuple[int, ...], function: Any) -> np.ndarray:
    """Convert the result `found` of a user's function to an array of numbers with this shape. Raises WrongArray, which names
    the function."""
    array, given = np.zeros(0), ""
    try:
        array = np.asarray(found)
    except ValueError:
        given = "a list of rows of different lengths"
    if found is None:
        given = "None"
    elif not given and array.dtype.kind not in "biuf":
        given = f"an array of {array.dtype.name}" if array.shape else f"a {type(found).__name__}"
    elif not given and array.shape != shape:
        given = f"an array of shape {array.shape}" if array.shape else "one number"
    if given:
        wanted = f"an array of shape {shape}" if shape else "one number"
        raise WrongArray(f"returns {given}; it must return {wanted}, see {home_of(function)}")
    return array.astype(float, copy=False)


def read_only(array: np.ndarray) -> np.ndarray:
    """Return a view of an array that users' code can read but not change."""
    view = array.view()
    view.flags.writeable = False
    return view


def home_of(function: Any) -> str:
    """Return the file and line of the definition of a function or method, such as "drag.py:9"; only the name of the
    function if its source is not available."""
    code = getattr(function, "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code else str(function)


def file_of(source: Any) -> str:
    """Return the path of the file that defines a class or function; its module if there is no file, as in a notebook."""
    return getattr(sys.modules.get(source.__module__), "__file__", None) or str(source.__module__)


def line_at(filename: str, line: int) -> str:
    """Return a line of a file with its content, such as "drag.py:17 (`return 1 / 0`)"."""
    text = linecache.getline(filename, line).strip()
    return f"{filename}:{line}" + (f" (`{text}`)" if text else "")


def is_own(filename: str) -> bool:
    """Return True if a source file is part of the package pellucid, or code that it derived, and not of the user's code."""
    return filename.startswith((OWN, DERIVED))


def is_users(filename: str) -> bool:
    """Return True if a file belongs neither to pellucid nor to an installed library."""
    return not (is_own(filename) or filename.startswith(("<", *LIBRARIES)))
