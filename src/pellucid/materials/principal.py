"""Eigenvalues and eigenvectors of a symmetric tensor at a point, by Jacobi's rotations.

Closed forms lose half of the digits where two eigenvalues are nearly equal, as at every undeformed point, and have no
eigenvectors there; rotations are as exact then as elsewhere. Source: Golub & Van Loan 2013, Matrix Computations, 4th ed.,
section 8.5.
"""

from math import sqrt

from pellucid.jit import pointwise
from pellucid.tensors import Symmetric

Triple = tuple[float, float, float]
SWEEPS = 12  # more than three to five are never needed
NEGLIGIBLE = 1e-34  # square of an entry off the diagonal by the product of those on it


@pointwise
def _turn(p: float, q: float, off: float) -> tuple[float, float, float]:
    """Cosine, sine and tangent of the turn that makes the entry `off` between the diagonal entries p and q vanish."""
    if off * off <= NEGLIGIBLE * abs(p * q):
        return 1.0, 0.0, 0.0
    d = q - p
    size = abs(d) + sqrt(d * d + 4.0 * off * off)
    t = (2.0 * off if d >= 0.0 else -2.0 * off) / size
    c = size / sqrt(size * size + 4.0 * off * off)
    return c, t * c, t


@pointwise
def _mixed(c: float, s: float, u: Triple, v: Triple) -> tuple[Triple, Triple]:
    return (c * u[0] - s * v[0], c * u[1] - s * v[1], c * u[2] - s * v[2]), (
        s * u[0] + c * v[0],
        s * u[1] + c * v[1],
        s * u[2] + c * v[2],
    )


@pointwise
def principal(a: Symmetric) -> tuple[Triple, Triple, Triple, Triple]:
    """The eigenvalues of a, in no order, and a unit eigenvector of each; those of a not finite tensor are not finite."""
    x, y, z, yz, xz, xy = a
    u, v, w = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    for _ in range(SWEEPS):
        if xy * xy <= NEGLIGIBLE * abs(x * y) and xz * xz <= NEGLIGIBLE * abs(x * z) and yz * yz <= NEGLIGIBLE * abs(y * z):
            break
        c, s, t = _turn(x, y, xy)
        x, y, xy, xz, yz = x - t * xy, y + t * xy, 0.0, c * xz - s * yz, s * xz + c * yz
        u, v = _mixed(c, s, u, v)
        c, s, t = _turn(x, z, xz)
        x, z, xz, xy, yz = x - t * xz, z + t * xz, 0.0, c * xy - s * yz, s * xy + c * yz
        u, w = _mixed(c, s, u, w)
        c, s, t = _turn(y, z, yz)
        y, z, yz, xy, xz = y - t * yz, z + t * yz, 0.0, c * xy - s * xz, s * xy + c * xz
        v, w = _mixed(c, s, v, w)
    return (x, y, z), u, v, w


@pointwise
def from_principal(values: Triple, u: Triple, v: Triple, w: Triple) -> Symmetric:
    """The symmetric tensor with these eigenvalues along three unit vectors."""
    p, q, r = values
    return (
        p * u[0] * u[0] + q * v[0] * v[0] + r * w[0] * w[0],
        p * u[1] * u[1] + q * v[1] * v[1] + r * w[1] * w[1],
        p * u[2] * u[2] + q * v[2] * v[2] + r * w[2] * w[2],
        p * u[1] * u[2] + q * v[1] * v[2] + r * w[1] * w[2],
        p * u[0] * u[2] + q * v[0] * v[2] + r * w[0] * w[2],
        p * u[0] * u[1] + q * v[0] * v[1] + r * w[0] * w[1],
    )
