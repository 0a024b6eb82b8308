"""Smooth approximate distances from faces, by R-functions, with their derivatives.

A face trimmed by a disc (a segment) or by the three planes through its edges (a triangle) has the distance
ρ = sqrt(f² + ¼ (sqrt(t² + f⁴) - t)²), where f vanishes on the line or plane of the face and t ≥ 0 on the face itself
(Biswas & Shapiro 2004, Graph. Models 66, 133; Millán, Sukumar & Arroyo 2015; Mountris et al. 2019, section 3). f⁴ beside t²
makes ρ depend on the unit of length, so that lengths are to be divided by a length of the problem before.
"""

from math import sqrt

from pellucid.jit import pointwise

TINY = 1e-150  # keeps divisors, and products of two of them, from zero, where what they divide is zero too


@pointwise
def trimmed_distance(f, t):
    """ρ and its derivatives by f and t, without a branch, so that loops over faces can take several at a time."""
    V = sqrt(t * t + f * f * f * f) + TINY
    total = V + abs(t)
    gap = f * f * f * f / total if t > 0.0 else total  # V - t, without cancellation
    rho = sqrt(f * f + 0.25 * gap * gap)
    over = 1.0 / ((rho + TINY) * V)
    half = 0.5 * gap
    return rho, (f * V + half * f * f * f) * over, -half * half * over


@pointwise
def triangle_trim(f, p1, p2, p3, alpha):
    """t of a triangle and its derivatives by f, p1, p2, p3.

    f: distance from its plane; p1, p2, p3: from the planes through its edges orthogonal to it, positive inside.
    """
    G = sqrt(p1 * p1 + p2 * p2 + alpha * f * f)
    over_G = 1.0 / (G + TINY)
    q = p1 + p2 - G
    R = sqrt(q * q + p3 * p3 + alpha * f * f)
    over_R = 1.0 / (R + TINY)
    rest = 1.0 - q * over_R
    by_f = -alpha * f * (over_G * rest + over_R)
    return q + p3 - R, by_f, (1.0 - p1 * over_G) * rest, (1.0 - p2 * over_G) * rest, 1.0 - p3 * over_R
