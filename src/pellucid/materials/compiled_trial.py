"""Search for the function of a user's material law that numba cannot compile. Numba's own message names a kernel instead of
the user's line."""

import os
import re
from typing import Any

from pellucid.jit import implementation_of
from pellucid.jit.registry import IN_KERNELS
from pellucid.materials.contract import PointMaterial
from pellucid.materials.solid_membrane import SolidMembraneMaterial
from pellucid.materials.trial import Call, calls_of, calls_of_membrane
from pellucid.users.users_code import is_users, line_at

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
            place = _place(str(error)) or f"{function.__code__.co_filename}:{function.__code__.co_firstlineno}"
            law = type(call.arguments[0]).__name__
            return f"`{operation.__name__}` of the law {law} cannot be compiled: {_reason(str(error))}, at {place}"
    return ""


def _calls(material: Any) -> dict[Any, Call]:
    if isinstance(material, PointMaterial):
        return calls_of(material, material.law(), material.initial_state())
    return calls_of_membrane(material, material.plain_law(1.0)) if isinstance(material, SolidMembraneMaterial) else {}


def _place(message: str) -> str:
    """Return file and line of the innermost line of a user's code that a numba message names; an empty text if none."""
    found = re.findall(r'File "([^"]+)", line (\d+)', message) + re.findall(r"(?:from|at) (\S+) \((\d+)\)", message)
    users = [(os.path.abspath(file), int(line)) for file, line in found if is_users(os.path.abspath(file))]
    return line_at(*users[0]) if users else ""


def _reason(message: str) -> str:
    """Return the first informative line of a numba message."""
    lines = [COLOURS.sub("", line).strip() for line in message.splitlines()]
    telling = [line for line in lines if line and not line.startswith(NOISE)]
    return telling[0].partition(". Raised from")[0].rstrip(".:") if telling else "numba reports no reason"
