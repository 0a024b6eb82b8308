"""Users' code that registers its own kinds: Python files that a case names, and installed packages."""

import hashlib
import re
import sys
import traceback
import warnings
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from pellucid.system.input_files import file_bytes

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
