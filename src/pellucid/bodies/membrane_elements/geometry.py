"""Geometry of membrane elements: frames of quadrilaterals from the bisector of their tangents, gradients at their centre.

Position and velocity in a triangle are linear in two edges; at the centre of a quadrilateral they are linear in two
tangents, and the rest is the hourglass mode:

    quadrilateral  χ = -x₁+x₂+x₃-x₄, ψ = -x₁-x₂+x₃+x₄, η = x₁-x₂+x₃-x₄, area |χ×ψ|/4
    triangle       χ = -x₁+x₂,       ψ = -x₁+x₃,                        area |χ×ψ|/2

For a quadrilateral, χ×ψ is parallel to the cross product of the diagonals. In the element's frame χ and ψ therefore have no
normal component, even if it is warped, and η₃ describes all of its warping. Source: Lian, Liu & Zhang 2014, eqs. 32-41,
with unit tangents in eq. 35; Flanagan & Belytschko 1981, Int. J. Numer. Methods Eng. 17, 679, for the gradient of one-point
elements.
"""

from math import sqrt

from numpy import uintp

from pellucid.jit import pointwise

HALF_ROOT = sqrt(0.5)


@pointwise
def dot(a, b):
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@pointwise
def cross(a, b):
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@pointwise
def edges(x, corners, e):
    """Return the edge vectors χ = x₂ - x₁ and ψ = x₃ - x₁ of triangle e for nodal positions, or any nodal field, x, shape (n,
    3). corners: node numbers, shape (m, 4); the last column is not used.
    """
    a, b, c = uintp(corners[e, 0]), uintp(corners[e, 1]), uintp(corners[e, 2])
    return (
        (x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]),
        (x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]),
    )


@pointwise
def area_slopes(chi, psi):
    """Return the derivatives of the area of a triangle with edges χ and ψ with respect to its second and its third corner
    [m]; the derivative for the first corner is minus the sum of the two."""
    n = cross(chi, psi)
    half = 0.5 / sqrt(dot(n, n))
    b, c = cross(psi, n), cross(n, chi)
    return (half * b[0], half * b[1], half * b[2]), (half * c[0], half * c[1], half * c[2])


@pointwise
def spans(x, corners, e):
    """Return the tangents χ = -x₁+x₂+x₃-x₄ and ψ = -x₁-x₂+x₃+x₄ and the hourglass vector η = x₁-x₂+x₃-x₄ of quadrilateral e for
    nodal positions, or any nodal field, x, shape (n, 3). corners: node numbers, shape (m, 4).
    """
    a, b, c, d = uintp(corners[e, 0]), uintp(corners[e, 1]), uintp(corners[e, 2]), uintp(corners[e, 3])
    # the diagonals
    ux, uy, uz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    wx, wy, wz = x[d, 0] - x[b, 0], x[d, 1] - x[b, 1], x[d, 2] - x[b, 2]
    eta = (
        (x[a, 0] - x[b, 0]) + (x[c, 0] - x[d, 0]),
        (x[a, 1] - x[b, 1]) + (x[c, 1] - x[d, 1]),
        (x[a, 2] - x[b, 2]) + (x[c, 2] - x[d, 2]),
    )
    return (ux - wx, uy - wy, uz - wz), (ux + wx, uy + wy, uz + wz), eta


@pointwise
def middle(now, rate, half):
    """Return the tangents χ, ψ and the hourglass vector η of an element (or any three vectors) at the middle of a time step
    from `now`, their values at its end, and `rate`, their rates of change; half: half the step [s].
    """
    return (
        (now[0][0] - half * rate[0][0], now[0][1] - half * rate[0][1], now[0][2] - half * rate[0][2]),
        (now[1][0] - half * rate[1][0], now[1][1] - half * rate[1][1], now[1][2] - half * rate[1][2]),
        (now[2][0] - half * rate[2][0], now[2][1] - half * rate[2][1], now[2][2] - half * rate[2][2]),
    )


@pointwise
def frame_of(chi, psi):
    """Return the frame of a quadrilateral with tangents χ and ψ: e₁ and e₂ at 45° to the bisector of the unit tangents, and the
    unit normal e₃."""
    a, b = 1.0 / sqrt(dot(chi, chi)), 1.0 / sqrt(dot(psi, psi))
    normal = cross(chi, psi)
    c = 1.0 / sqrt(dot(normal, normal))
    n = (c * normal[0], c * normal[1], c * normal[2])
    sx, sy, sz = a * chi[0] + b * psi[0], a * chi[1] + b * psi[1], a * chi[2] + b * psi[2]
    s = HALF_ROOT / sqrt(sx * sx + sy * sy + sz * sz)
    alpha = (s * sx, s * sy, s * sz)
    beta = cross(n, alpha)
    return (
        (alpha[0] - beta[0], alpha[1] - beta[1], alpha[2] - beta[2]),
        (alpha[0] + beta[0], alpha[1] + beta[1], alpha[2] + beta[2]),
        n,
    )


@pointwise
def within(frame, vectors):
    """Return the components of three vectors, such as the tangents and the hourglass vector of an element, along an orthonormal
    frame (e₁, e₂, e₃).
    """
    a, b, c = vectors
    e, f, g = frame
    return (
        (dot(e, a), dot(f, a), dot(g, a)),
        (dot(e, b), dot(f, b), dot(g, b)),
        (dot(e, c), dot(f, c), dot(g, c)),
    )


@pointwise
def gradient(local, rate):
    """Return the in-plane derivatives ∂v_i/∂x_j of the velocity at the centre of a quadrilateral [1/s], i = 1, 2, 3 and j = 1,
    2, row by row. local: tangents χ, ψ and hourglass vector η of the element (see `spans`) [m]; rate: their rates [m/s]; both
    in the frame of the element.
    """
    c, p = local[0], local[1]
    cr, pr = rate[0], rate[1]
    inverse = 1.0 / (c[0] * p[1] - c[1] * p[0])
    return (
        inverse * (cr[0] * p[1] - pr[0] * c[1]),
        inverse * (pr[0] * c[0] - cr[0] * p[0]),
        inverse * (cr[1] * p[1] - pr[1] * c[1]),
        inverse * (pr[1] * c[0] - cr[1] * p[0]),
        inverse * (cr[2] * p[1] - pr[2] * c[1]),
        inverse * (pr[2] * c[0] - cr[2] * p[0]),
    )


@pointwise
def steepness(local):
    """Return the tensor Σ_K ∇N_K ∇N_K over the nodes K of a quadrilateral at its centre, with the shape functions N_K;
    components 11, 22, 12 [1/m²]. local: tangents χ, ψ and hourglass vector η (see `spans`) in the frame of the element [m].
    """
    c, p = local[0], local[1]
    det = c[0] * p[1] - c[1] * p[0]
    scale = 4.0 / (det * det)
    return (
        scale * (c[1] * c[1] + p[1] * p[1]),
        scale * (c[0] * c[0] + p[0] * p[0]),
        -scale * (c[0] * c[1] + p[0] * p[1]),
    )


@pointwise
def size_of(now):
    """Return the area of a quadrilateral [m²], and (ω/2c)² [1/m²] for its largest eigenfrequency ω and the speed c of plane
    waves. now: tangents χ, ψ and hourglass vector η [m].

    Each node has a quarter of the mass. The eigenvalues of M⁻¹K of a one-point element are below c² k Σ |∇N_K|², with k = 4
    nodes (Flanagan & Belytschko 1984, J. Eng. Mech. 110, 35).
    """
    chi, psi, _ = now
    normal = cross(chi, psi)
    square = dot(normal, normal)
    return 0.25 * sqrt(square), 4.0 * (dot(chi, chi) + dot(psi, psi)) / square


@pointwise
def bisector(chi_1, chi_2, psi_1, psi_2):
    """Return the unit vector along the bisector of two tangents χ and ψ in a plane, given by their components 1 and 2."""
    a, b = 1.0 / sqrt(chi_1 * chi_1 + chi_2 * chi_2), 1.0 / sqrt(psi_1 * psi_1 + psi_2 * psi_2)
    x, y = a * chi_1 + b * psi_1, a * chi_2 + b * psi_2
    s = 1.0 / sqrt(x * x + y * y)
    return s * x, s * y


@pointwise
def advanced(z, cosine, sine):
    """Return z, a unit vector in a plane, rotated counterclockwise by an angle with this cosine and sine."""
    return z[0] * cosine - z[1] * sine, z[0] * sine + z[1] * cosine


@pointwise
def turned(turn, local, rate, spin, half):
    """Return the rotation of the material relative to the bisector of the tangents χ and ψ of a quadrilateral, as (cosine,
    sine), at the middle and at the end of a step.

    The bisector of tangents that are not orthogonal does not rotate exactly with the material: stretching rotates it. turn: the
    rotation (cosine, sine) at the start of the step; local, rate: tangents χ, ψ and hourglass vector η [m] and their rates
    [m/s] at the middle of the step, in the frame of the element; spin: spin of the material [1/s]; half: half the step [s].
    """
    c, p, cr, pr = local[0], local[1], rate[0], rate[1]
    x0, y0 = bisector(c[0] - half * cr[0], c[1] - half * cr[1], p[0] - half * pr[0], p[1] - half * pr[1])
    x1, y1 = bisector(c[0] + half * cr[0], c[1] + half * cr[1], p[0] + half * pr[0], p[1] + half * pr[1])
    a = half * spin
    scale = 1.0 / sqrt(1.0 + a * a)
    turn_back = (turn[0] * x0 - turn[1] * y0, turn[0] * y0 + turn[1] * x0)  # of the material, from the axes of the middle
    mx, my = advanced(turn_back, scale, scale * a)
    ex, ey = advanced((mx, my), scale, scale * a)
    # the bisector at the middle is at 45°
    mid = (HALF_ROOT * (mx + my), HALF_ROOT * (my - mx))
    ex, ey = ex * x1 + ey * y1, ey * x1 - ex * y1
    length = 1.0 / sqrt(ex * ex + ey * ey)
    return mid, (length * ex, length * ey)


@pointwise
def rotated(s, cosine, sine):
    """Return the symmetric plane tensor s, components (11, 22, 12), rotated counterclockwise by an angle with this cosine and
    sine."""
    cc, ss, sc = cosine * cosine, sine * sine, sine * cosine
    return (
        cc * s[0] + ss * s[1] - 2.0 * sc * s[2],
        ss * s[0] + cc * s[1] + 2.0 * sc * s[2],
        sc * (s[0] - s[1]) + (cc - ss) * s[2],
    )


@pointwise
def in_space(s, t, u):
    """Return an in-plane tensor s, components (11, 22, 12) along the tangents t and u, in space: xx, yy, zz, yz, xz, xy."""
    return (
        s[0] * t[0] * t[0] + s[1] * u[0] * u[0] + 2.0 * s[2] * t[0] * u[0],
        s[0] * t[1] * t[1] + s[1] * u[1] * u[1] + 2.0 * s[2] * t[1] * u[1],
        s[0] * t[2] * t[2] + s[1] * u[2] * u[2] + 2.0 * s[2] * t[2] * u[2],
        s[0] * t[1] * t[2] + s[1] * u[1] * u[2] + s[2] * (t[1] * u[2] + t[2] * u[1]),
        s[0] * t[0] * t[2] + s[1] * u[0] * u[2] + s[2] * (t[0] * u[2] + t[2] * u[0]),
        s[0] * t[0] * t[1] + s[1] * u[0] * u[1] + s[2] * (t[0] * u[1] + t[1] * u[0]),
    )
