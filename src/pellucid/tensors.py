"""Tensor algebra at a point, with tensors as tuples of numbers.

A second-order tensor is a 9-tuple, row by row; a symmetric tensor a 6-tuple (xx, yy, zz, yz, xz, xy); a tensor in a plane a
4-tuple (11, 12, 21, 22).
"""

from pellucid.jit import pointwise

Symmetric = tuple[float, float, float, float, float, float]
Tensor = tuple[float, float, float, float, float, float, float, float, float]
PlaneTensor = tuple[float, float, float, float]

IDENTITY: Tensor = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
SYMMETRIC_IDENTITY: Symmetric = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
ZERO_VECTOR = (0.0, 0.0, 0.0)
NO_STRESS: Symmetric = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pointwise
def symmetric_part(A: Tensor) -> Symmetric:
    """Return the symmetric part ½ (A + Aᵀ)."""
    return (A[0], A[4], A[8], 0.5 * (A[5] + A[7]), 0.5 * (A[2] + A[6]), 0.5 * (A[1] + A[3]))


@pointwise
def add(a: Symmetric, b: Symmetric) -> Symmetric:
    """Return the sum a + b of two symmetric tensors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


@pointwise
def scale(factor: float, a: Symmetric) -> Symmetric:
    """Return a symmetric tensor multiplied by a number."""
    return (factor * a[0], factor * a[1], factor * a[2], factor * a[3], factor * a[4], factor * a[5])


@pointwise
def trace(a: Symmetric) -> float:
    """Return the trace of a symmetric tensor."""
    return a[0] + a[1] + a[2]


@pointwise
def deviator(a: Symmetric) -> Symmetric:
    """Return the deviator a - tr(a)/3 I of a symmetric tensor."""
    mean = (a[0] + a[1] + a[2]) / 3.0
    return (a[0] - mean, a[1] - mean, a[2] - mean, a[3], a[4], a[5])


@pointwise
def stress_power(stress: Symmetric, L: Tensor) -> float:
    """Return the stress power σ:L of a stress and a velocity gradient L [W/m³]."""
    normal = stress[0] * L[0] + stress[1] * L[4] + stress[2] * L[8]
    return normal + stress[3] * (L[5] + L[7]) + stress[4] * (L[2] + L[6]) + stress[5] * (L[1] + L[3])


@pointwise
def end_stress_power(stress: Symmetric, L: Tensor, dt: float) -> float:
    """Return the stress power σ:L' [W/m³] of a stress and the velocity gradient L' at the end of a step Δt = dt [s], L' = L (I
    + Δt L)⁻¹ to second order in Δt L."""
    xx, yy, zz = (
        L[0] - dt * (L[0] * L[0] + L[1] * L[3] + L[2] * L[6]),
        L[4] - dt * (L[3] * L[1] + L[4] * L[4] + L[5] * L[7]),
        L[8] - dt * (L[6] * L[2] + L[7] * L[5] + L[8] * L[8]),
    )
    power = stress[0] * xx + stress[1] * yy + stress[2] * zz
    yz, xz, xy = L[5] + L[7], L[2] + L[6], L[1] + L[3]
    yz -= dt * (L[3] * L[2] + L[6] * L[1] + (L[5] + L[7]) * (L[4] + L[8]))
    xz -= dt * (L[1] * L[5] + L[7] * L[3] + (L[2] + L[6]) * (L[0] + L[8]))
    xy -= dt * (L[2] * L[7] + L[5] * L[6] + (L[1] + L[3]) * (L[0] + L[4]))
    return power + stress[3] * yz + stress[4] * xz + stress[5] * xy


@pointwise
def double_dot(a: Symmetric, b: Symmetric) -> float:
    """Return the double contraction a : b of two symmetric tensors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])


@pointwise
def multiply(A: Tensor, B: Tensor) -> Tensor:
    """Return the product A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


@pointwise
def determinant(A: Tensor) -> float:
    """Return the determinant det A."""
    return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) + A[2] * (A[3] * A[7] - A[4] * A[6])


@pointwise
def cofactor(A: Tensor) -> Tensor:
    """Return the cofactor cof A = det(A) A⁻ᵀ, also for a singular A."""
    return (
        A[4] * A[8] - A[5] * A[7],
        A[5] * A[6] - A[3] * A[8],
        A[3] * A[7] - A[4] * A[6],
        A[2] * A[7] - A[1] * A[8],
        A[0] * A[8] - A[2] * A[6],
        A[1] * A[6] - A[0] * A[7],
        A[1] * A[5] - A[2] * A[4],
        A[2] * A[3] - A[0] * A[5],
        A[0] * A[4] - A[1] * A[3],
    )


@pointwise
def full(s: Symmetric) -> Tensor:
    """Return the nine components of a symmetric tensor, row by row."""
    return (s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2])


@pointwise
def piola_transform(s: Symmetric, F: Tensor) -> Tensor:
    """Return the first Piola-Kirchhoff stress P = J σ F⁻ᵀ of a Cauchy stress σ (`s`) at a deformation gradient F; J = det F."""
    return multiply(full(s), cofactor(F))


@pointwise
def left_cauchy_green(F: Tensor) -> Symmetric:
    """Return the left Cauchy-Green tensor b = F Fᵀ."""
    return (
        F[0] * F[0] + F[1] * F[1] + F[2] * F[2],
        F[3] * F[3] + F[4] * F[4] + F[5] * F[5],
        F[6] * F[6] + F[7] * F[7] + F[8] * F[8],
        F[3] * F[6] + F[4] * F[7] + F[5] * F[8],
        F[0] * F[6] + F[1] * F[7] + F[2] * F[8],
        F[0] * F[3] + F[1] * F[4] + F[2] * F[5],
    )


@pointwise
def spin_rotation(L: Tensor, dt: float) -> Tensor:
    """Return the rotation (I - ½ dt W)⁻¹ (I + ½ dt W) over a step dt [s] by the spin W = ½ (L - Lᵀ) of a velocity gradient
    L; orthogonal for every dt.

    Source: Hughes & Winget 1980, Int. J. Numer. Methods Eng. 15, 1862.
    """
    a = 0.25 * dt * (L[7] - L[5])
    b = 0.25 * dt * (L[2] - L[6])
    c = 0.25 * dt * (L[3] - L[1])
    s = 2.0 / (1.0 + a * a + b * b + c * c)
    return (
        1.0 - s * (b * b + c * c),
        s * (a * b - c),
        s * (a * c + b),
        s * (a * b + c),
        1.0 - s * (a * a + c * c),
        s * (b * c - a),
        s * (a * c - b),
        s * (b * c + a),
        1.0 - s * (a * a + b * b),
    )


@pointwise
def rotate(Q: Tensor, s: Symmetric) -> Symmetric:
    """Return the symmetric tensor s rotated by Q, i.e. Q s Qᵀ."""
    m = multiply(Q, full(s))
    return (
        m[0] * Q[0] + m[1] * Q[1] + m[2] * Q[2],
        m[3] * Q[3] + m[4] * Q[4] + m[5] * Q[5],
        m[6] * Q[6] + m[7] * Q[7] + m[8] * Q[8],
        m[3] * Q[6] + m[4] * Q[7] + m[5] * Q[8],
        m[0] * Q[6] + m[1] * Q[7] + m[2] * Q[8],
        m[0] * Q[3] + m[1] * Q[4] + m[2] * Q[5],
    )


@pointwise
def deformed(L: Tensor, dt: float, F: Tensor) -> Tensor:
    """Return the deformation gradient (I + dt L) F after a step dt [s] with the velocity gradient L [1/s]; F: deformation
    gradient before the step."""
    increment = (
        1.0 + dt * L[0],
        dt * L[1],
        dt * L[2],
        dt * L[3],
        1.0 + dt * L[4],
        dt * L[5],
        dt * L[6],
        dt * L[7],
        1.0 + dt * L[8],
    )
    return multiply(increment, F)


@pointwise
def largest_row_sum(s: Symmetric) -> float:
    """Return an upper bound of the largest eigenvalue of a symmetric tensor (Gershgorin): the largest sum, over its rows, of
    the diagonal component and the absolute values of the others; exact for a diagonal tensor."""
    return max(
        s[0] + abs(s[5]) + abs(s[4]),
        s[1] + abs(s[5]) + abs(s[3]),
        s[2] + abs(s[4]) + abs(s[3]),
    )
