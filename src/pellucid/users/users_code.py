"""Users' files and code: reading of files, loading of Python files and installed packages that register their own kinds, and
exceptions of users' code, reported with file, line and cause instead of a bare traceback."""

import errno
import hashlib
import linecache
import os
import re
import stat
import sys
import sysconfig
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pellucid.errors import PellucidError


def file_bytes(path: Path | str) -> bytes:
    """Return the bytes of a file. Raises OSError, also for an empty path or for a path that is no regular file, e.g. a
    pipe, which may never end."""
    try:
        mode = Path(path).stat().st_mode
    except ValueError as error:  # a null character within it
        raise OSError(errno.EINVAL, f"the path has an {error}") from None
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise OSError(errno.EINVAL, "it is a pipe or a device, not a file")
    return Path(path).read_bytes()


GROUP = "pellucid.extensions"
"""Group of entry points with which a package declares modules that register kinds."""

_loaded: dict[str, str] = {}  # digest of each file, by its path
_installed = False


class ExtensionError(Exception):
    """Error for a file of a user that cannot be loaded; the message has the cause, the line and the remedy."""

    def __init__(self, text: str, remedy: str) -> None:
        super().__init__(text)
        self.remedy = remedy


def load_file(path: str) -> None:
    """Run a Python file that registers kinds; an unchanged file is not run again.

    The module has the same name in every process, so that compiled kernels find its classes. Raises ExtensionError if the
    file cannot be loaded.
    """
    try:
        source = file_bytes(path)
    except OSError as error:
        text = f"the file cannot be read: {error.strerror}"
        raise ExtensionError(text, "Set the path of a Python file, relative to the case file.") from None
    digest = hashlib.sha256(source).hexdigest()
    if _loaded.get(path) == digest:
        return
    module = ModuleType(module_name(path))
    module.__file__ = path
    before = sys.modules.get(module.__name__)
    sys.modules[module.__name__] = module
    try:
        exec(compile(source, path, "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        sys.modules.pop(module.__name__)
        if before is not None:
            sys.modules[module.__name__] = before
        place = _line(error, path)
        words = " ".join(str(error).partition("\n\n")[0].split())
        raise ExtensionError(
            f"{place}{type(error).__name__}: {words}", f"Correct {path}, or remove it from `extensions`."
        ) from error
    _loaded[path] = digest


def is_loaded() -> bool:
    """Return True if code of users, of a file or of an installed package, has been loaded in this process."""
    return bool(_loaded) or (_installed and bool(entry_points(group=GROUP)))


def module_name(path: str) -> str:
    """Return the name under which a file of the user is imported as a module; it is the same in every process."""
    stem = re.sub(r"\W", "_", Path(path).stem)
    return f"pellucid_extension_{stem}_{hashlib.sha256(path.encode()).hexdigest()[:8]}"


def load_installed() -> None:
    """Load the extension modules of installed packages once. Issue a warning, not an error, if an extension cannot be
    loaded, since most cases do not need the extension."""
    global _installed
    if _installed:
        return
    _installed = True
    for entry in entry_points(group=GROUP):
        try:
            entry.load()
        except Exception as error:
            package = entry.dist.name if entry.dist else "a package"
            text = f"the extension {entry.value} of {package} could not be loaded: {type(error).__name__}: {error}"
            warnings.warn(f"{text}; correct or uninstall the package", stacklevel=2)


def _line(error: BaseException, path: str) -> str:
    """Return the line of a file where an error occurred as the start of a message, such as "line 17: "; empty if unknown."""
    if isinstance(error, SyntaxError) and error.filename == path:
        return f"line {error.lineno}: "
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
    return f"line {lines[-1]}: " if lines else ""


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
