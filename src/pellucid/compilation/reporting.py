"""Progress reports of kernel compilation (name, number and total number of kernels), the key of the kernels of a case, and
errors for laws that numba cannot compile: they name the user's line, where numba's own message names a kernel."""

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pellucid.errors import CaseError, Problem
from pellucid.jit import cache_folder, implementation_of
from pellucid.jit.registry import IN_KERNELS
from pellucid.materials.contract import PointMaterial
from pellucid.materials.membrane_material import SolidMembraneMaterial
from pellucid.materials.trial import Call, calls_of, calls_of_membrane
from pellucid.progress import Progress
from pellucid.users.users_code import is_users, line_at

if TYPE_CHECKING:
    from pellucid.case import Case


@contextmanager
def compilation_told(
    progress: Progress, key: str, at_first: Callable[[], None] = lambda: None
) -> Iterator[Callable[[], float]]:
    """Context manager that reports every kernel compiled in the block, not those loaded from the cache, to `progress`, and
    calls `at_first` before the first. Yields a function that returns the wall-clock time spent in compiling and loading so
    far [s].

    `key` identifies the kernels that the block needs, see `kernel_key`. The expected number of kernels is the number in an
    earlier compilation with this key, possibly with other sources or another version of numba; kernels in the cache are not
    compiled again.
    """
    from numba.core.event import Listener, TimingListener, install_listener

    expected = _kept_count(key)

    class Teller(Listener):  # type: ignore[misc]
        number = depth = 0

        def on_start(self, event: Any) -> None:
            self.number += 1
            self.depth += 1
            if self.number == 1:
                at_first()
            if self.depth == 1:  # what is compiled on the way to a kernel counts, but the kernel is named
                progress.compiling(event.data["dispatcher"].py_func.__name__.lstrip("_"), self.number, expected)

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if self.depth == 0:
                progress.compiled()

    teller, timer = Teller(), TimingListener()
    with install_listener("numba:compile", teller), install_listener("numba:compiler_lock", timer):
        yield lambda: timer.duration if timer.done else 0.0
    if teller.number > expected:
        _keep_count(key, teller.number)


@contextmanager
def laws_blamed(case: "Case") -> Iterator[None]:
    """Context manager that raises CaseError for a material law that numba cannot compile in the block; the error names the law
    and the reason."""
    from numba.core.errors import NumbaError, UnsupportedBytecodeError

    try:
        yield
    except (NumbaError, UnsupportedBytecodeError) as error:
        found = [(f"body.{body.name}.material", why_not_compiled(body.material)) for body in case.body]
        remedy = (
            "Use only scalars, tuples and NamedTuples in kernels, see docs/extending.md; to debug in Python, set "
            "NUMBA_DISABLE_JIT=1"
        )
        problems = [Problem(why, key, remedy=remedy) for key, why in found if why]
        if not problems:
            raise
        raise CaseError(problems) from error


def _kept_count(key: str) -> int:
    with suppress(OSError, ValueError):
        return int(_place(key).read_text(encoding="ascii"))
    return 0


def _keep_count(key: str, count: int) -> None:
    """Store the number of compiled kernels under the key of a case, see `kernel_key`; do nothing if the cache cannot be
    written."""
    with suppress(OSError):
        _place(key).parent.mkdir(parents=True, exist_ok=True)
        _place(key).write_text(str(count), encoding="ascii")


def _place(key: str) -> Path:
    """Return the path of the file with the number of kernels of a key, see `kernel_key`. It is next to the kernel folders,
    which change with the sources."""
    return cache_folder().parent / "counts" / key


def kernel_key(case: "Case") -> str:
    """Return a hash of those options of a case (texts and booleans, not numbers and names) that determine which kernels a
    run of the case needs."""
    data = case.to_data()
    bodies = sorted({json.dumps(_choices({**body, "name": "", "field": ""}), sort_keys=True) for body in data["body"]})
    shared = sorted(sum(other["field"] == body["field"] for other in data["body"]) > 1 for body in data["body"])
    conditions = sorted(name for name, tables in data.items() if isinstance(tables, list) and tables)
    functions = case.grid.functions if case.grid_or_none else ""
    several = len({body["field"] for body in data["body"]}) > 1
    scheme = case.time.scheme if case.time.method == "explicit" else case.time.method
    what = functions, case.thin, scheme, case.time.transfer, bodies, shared, several
    return hashlib.sha256(json.dumps((what, conditions)).encode()).hexdigest()[:16]


def _choices(value: Any) -> Any:
    """Return a copy of a part of a case with its texts and booleans; numbers are replaced by the names of their types."""
    if isinstance(value, dict):
        return {key: _choices(item) for key, item in value.items() if key not in ("shape", "surface")}
    return value if isinstance(value, (str, bool)) else type(value).__name__


COLOURS = re.compile(r"\x1b\[[0-9;]*m")
NOISE = ("Failed in", "Type Inference", "Compilation is", "- ", "There are", "Use of unsupported", "The above")


def why_not_compiled(material: Any) -> str:
    """Return a text that names the first function of a material's law that numba cannot compile, its file and line, and the
    reason; an empty text if all functions can be compiled."""
    from numba import njit

    for operation, call in _calls(material).items():
        function: Any = implementation_of(operation, type(call.arguments[0]))
        try:
            njit(function, **{**IN_KERNELS, "no_cpython_wrapper": False})(*call.arguments)
        except Exception as error:  # numba's have no base in common
            place = _line_of_users(str(error)) or f"{function.__code__.co_filename}:{function.__code__.co_firstlineno}"
            law = type(call.arguments[0]).__name__
            return f"`{operation.__name__}` of the law {law} cannot be compiled: {_reason(str(error))}, at {place}"
    return ""


def _calls(material: Any) -> dict[Any, Call]:
    if isinstance(material, PointMaterial):
        return calls_of(material, material.law(), material.initial_state())
    return calls_of_membrane(material, material.plain_law(1.0)) if isinstance(material, SolidMembraneMaterial) else {}


def _line_of_users(message: str) -> str:
    """Return file and line of the innermost line of a user's code that a numba message names; an empty text if none."""
    found = re.findall(r'File "([^"]+)", line (\d+)', message) + re.findall(r"(?:from|at) (\S+) \((\d+)\)", message)
    users = [(os.path.abspath(file), int(line)) for file, line in found if is_users(os.path.abspath(file))]
    return line_at(*users[0]) if users else ""


def _reason(message: str) -> str:
    """Return the first informative line of a numba message."""
    lines = [COLOURS.sub("", line).strip() for line in message.splitlines()]
    telling = [line for line in lines if line and not line.startswith(NOISE)]
    return telling[0].partition(". Raised from")[0].rstrip(".:") if telling else "numba reports no reason"
