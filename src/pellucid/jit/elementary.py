"""Logarithm, exponential and powers by arithmetic only, since LLVM vectorizes arithmetic but not library calls.

With x = m 2ᵏ, √½ ≤ m < √2, f = m - 1, s = f / (2 + f) and h = f²/2, ln m = f - (h - s (h + R(s²))). With x = k ln 2 + r,
|r| ≤ ½ ln 2, and c = r - P(r²), exp(r) = 1 + r + r c / (2 - c). Source of both formulas and of the polynomials: fdlibm,
e_log.c and e_exp.c (Sun Microsystems 1993), with errors below one unit in the last place. With k = 3j + s, |s| ≤ 1, the
cube root is 2ʲ (2ˢ m)^⅓, from a parabola in m by two steps of Halley's method. Each step reduces an error e to ⅔ e³. For y
= 1 + x, rounded, ln(1 + x) = ln(y) x/(y - 1) up to the square of the rounding error (Kahan; Goldberg 1991, ACM Comput.
Surv. 23, 5, theorem 4).
"""

from math import frexp, inf, nan, sqrt

from numpy import floor

from pellucid.jit.registry import compiled_by, pointwise

LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 in two parts. The first ends with zeros, so that its product with k is exact."""
INVERSE_LN2 = 1.44269504088896338700
R1, R2, R3, R4, R5, R6, R7 = (
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
)
P1, P2, P3, P4, P5 = (
    1.66666666666666019037e-01,
    -2.77777777770155933842e-03,
    6.61375632143793436117e-05,
    -1.65339022054652515390e-06,
    4.13813679705723846039e-08,
)
C0, C1, C2, ROOT_OF_TWO, THIRD = 0.5537057, 0.5536620, -0.1074770, 1.2599210, 1.0 / 3.0
"""Coefficients of a parabola that approximates m^⅓ to 7e-4, and 2^⅓."""
LEAST, WIDE, WIDE_BITS = 2.2250738585072014e-308, 2.0**54, 54.0
"""Smallest normal number, the factor that makes a subnormal number normal, and the exponent of this factor."""
LOWEST, HIGHEST = -745.1332191019412, 709.782712893384
"""Range of arguments: below LOWEST the exponential is 0, above HIGHEST it overflows."""
NOTHING_BESIDE_ONE, ONE_BESIDE_NOTHING = -40.0, 60.0
"""Limits of `expm1`: for x below the first, exp(x) is negligible compared with 1; for k above the second, 1 is negligible
compared with exp(x)."""


@compiled_by("pellucid.jit.vector")
def exponent_and_rest(x: float) -> tuple[float, float]:
    """Return the exponent k and the mantissa m, √½ ≤ m < √2, of a positive normal number x = m 2ᵏ."""
    m, k = frexp(x)
    return (float(k - 1), 2.0 * m) if m < sqrt(0.5) else (float(k), m)


@compiled_by("pellucid.jit.vector")
def two_to(k: float) -> float:
    """Return 2ᵏ for an integer k between -1022 and 1023."""
    return 2.0**k


@pointwise
def log(x: float) -> float:
    """Return ln x; -inf for x = 0, nan for x < 0."""
    is_small, is_number = x < LEAST, x < inf
    usable = x if x > 0.0 and is_number else 1.0
    k, m = exponent_and_rest(usable * WIDE if is_small else usable)
    k = k - WIDE_BITS if is_small else k
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    r = z * (R1 + z * (R2 + z * (R3 + z * (R4 + z * (R5 + z * (R6 + z * R7))))))
    h = 0.5 * f * f
    found = k * LN2_HIGH - ((h - (s * (h + r) + k * LN2_LOW)) - f)
    found = found if is_number else x
    found = found if x >= 0.0 else nan
    return -inf if x == 0.0 else found


@pointwise
def log1p(x: float) -> float:
    """Return ln(1 + x), accurate also for small x."""
    y = 1.0 + x
    seen = y - 1.0
    found = log(y) * (x / (seen if seen != 0.0 and seen < inf else 1.0))
    return x if seen == 0.0 else found


@pointwise
def _near_one(x: float) -> tuple[float, float]:
    """Return the integer k and exp(r) - 1 for x = k ln 2 + r, |r| ≤ ½ ln 2."""
    k = floor(x * INVERSE_LN2 + 0.5)
    high, low = x - k * LN2_HIGH, k * LN2_LOW
    r = high - low
    t = r * r
    c = r - t * (P1 + t * (P2 + t * (P3 + t * (P4 + t * P5))))
    return k, high - (low - (r * c) / (2.0 - c))


@pointwise
def _scaled(x: float, k: float) -> float:
    """Return x 2ᵏ for an integer k, also if 2ᵏ alone would overflow or underflow."""
    half = floor(0.5 * k)
    return (x * two_to(half)) * two_to(k - half)


@pointwise
def exp(x: float) -> float:
    """Return exp(x)."""
    k, beside_one = _near_one(x if LOWEST <= x <= HIGHEST else 0.0)
    found = _scaled(1.0 + beside_one, k)
    found = found if x <= HIGHEST else (inf if x > HIGHEST else x)
    return 0.0 if x < LOWEST else found


@pointwise
def expm1(x: float) -> float:
    """Return exp(x) - 1, accurate also for small x."""
    k, beside_one = _near_one(x if NOTHING_BESIDE_ONE <= x <= HIGHEST else 0.0)
    factor = two_to(k if k < ONE_BESIDE_NOTHING else 0.0)
    found = factor * beside_one + (factor - 1.0) if k < ONE_BESIDE_NOTHING else _scaled(1.0 + beside_one, k)
    found = found if x <= HIGHEST else (inf if x > HIGHEST else x)
    return -1.0 if x < NOTHING_BESIDE_ONE else found


@pointwise
def power(x: float, y: float) -> float:
    """Return x^y for x > 0, with a relative error of at most (1 + 1.5 |y ln x|) 2.2e-16."""
    return exp(y * log(x))


@pointwise
def _nearer_root(y: float, a: float) -> float:
    cube = y * y * y
    return y - y * (cube - a) / (2.0 * cube + a)


@pointwise
def cube_root(x: float) -> float:
    """Return the cube root of a positive normal number, to 1.5 units in the last place."""
    k, m = exponent_and_rest(x)
    j = floor(k * THIRD + 0.5)
    s = k - 3.0 * j
    part = 2.0 if s > 0.5 else (0.5 if s < -0.5 else 1.0)
    root_of_part = ROOT_OF_TWO if s > 0.5 else (1.0 / ROOT_OF_TWO if s < -0.5 else 1.0)
    a = part * m
    y = root_of_part * (C0 + m * (C1 + m * C2))
    return _nearer_root(_nearer_root(y, a), a) * two_to(j)
