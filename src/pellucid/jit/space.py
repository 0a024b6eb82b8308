"""Vectors in space for kernels: three doubles with the operators + - * / @.

A vector costs as much as three numbers, to compile and to run: the compiler keeps its components in registers. `a @ b` is the
dot product, `factor * a` and `a / divisor` are multiples. Rows of arrays are read by `vector_at` and written by `set_vector`
and `add_vector`.
"""

import operator
from typing import Any

from numba.core import cgutils, types
from numba.extending import lower_builtin, make_attribute_wrapper, models, overload, register_model, type_callable

from pellucid.jit.registry import inlined, pointwise


class Vector3:
    """A vector in space with the components x, y and z, in kernels and in plain Python."""

    __slots__ = ("x", "y", "z")

    def __init__(self, x: float, y: float, z: float) -> None:
        self.x, self.y, self.z = x, y, z

    def __add__(self, other: "Vector3") -> "Vector3":
        return _sum(self, other)

    def __sub__(self, other: "Vector3") -> "Vector3":
        return _difference(self, other)

    def __rmul__(self, factor: float) -> "Vector3":
        return _multiple(factor, self)

    def __truediv__(self, divisor: float) -> "Vector3":
        return _quotient(self, divisor)

    def __matmul__(self, other: "Vector3") -> float:
        return _dot(self, other)

    def __neg__(self) -> "Vector3":
        return _opposite(self)


def _sum(a, b):
    return Vector3(a.x + b.x, a.y + b.y, a.z + b.z)


def _difference(a, b):
    return Vector3(a.x - b.x, a.y - b.y, a.z - b.z)


def _multiple(a, b):
    return Vector3(a * b.x, a * b.y, a * b.z)


def _quotient(a, b):
    return Vector3(a.x / b, a.y / b, a.z / b)


def _dot(a, b):
    return a.x * b.x + a.y * b.y + a.z * b.z


def _opposite(a):
    return Vector3(-a.x, -a.y, -a.z)


class Vector3Type(types.Type):
    """Compiled type of a `Vector3`."""

    def __init__(self) -> None:
        super().__init__(name="Vector3")


VECTOR3 = Vector3Type()


@register_model(Vector3Type)
class _Vector3Model(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Vector3Type) -> None:
        super().__init__(manager, kind, [(name, types.float64) for name in Vector3.__slots__])


for _name in Vector3.__slots__:
    make_attribute_wrapper(Vector3Type, _name, _name)


@type_callable(Vector3)
def _type_of_vector(context: Any) -> Any:
    return lambda x, y, z: VECTOR3


@lower_builtin(Vector3, types.float64, types.float64, types.float64)
def _make_vector(context: Any, builder: Any, signature: Any, components: Any) -> Any:
    made = cgutils.create_struct_proxy(VECTOR3)(context, builder)
    made.x, made.y, made.z = components
    return made._getvalue()


OPTIONS = inlined()


def _compile(operation: Any, function: Any, first: type, second: type) -> None:
    """Let kernels call `function` for an operator on operands of these two compiled types."""
    overload(operation, jit_options=OPTIONS)(lambda a, b: function if isinstance(a, first) and isinstance(b, second) else None)


_compile(operator.add, _sum, Vector3Type, Vector3Type)
_compile(operator.sub, _difference, Vector3Type, Vector3Type)
_compile(operator.mul, _multiple, types.Float, Vector3Type)
_compile(operator.truediv, _quotient, Vector3Type, types.Float)
_compile(operator.matmul, _dot, Vector3Type, Vector3Type)
overload(operator.neg, jit_options=OPTIONS)(lambda a: _opposite if isinstance(a, Vector3Type) else None)


@pointwise
def cross(a, b):
    """Return the cross product of two vectors."""
    return Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@pointwise
def vector_at(values, i):
    """Return row i of an array of vectors, shape (n, 3)."""
    return Vector3(values[i, 0], values[i, 1], values[i, 2])


@pointwise
def set_vector(values, i, vector):
    """Write a vector to row i of an array, shape (n, 3)."""
    values[i, 0], values[i, 1], values[i, 2] = vector.x, vector.y, vector.z


@pointwise
def add_vector(values, i, vector):
    """Add a vector to row i of an array, shape (n, 3)."""
    values[i, 0] += vector.x
    values[i, 1] += vector.y
    values[i, 2] += vector.z
