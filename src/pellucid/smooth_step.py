"""A smooth step from 0 to 1 for the start of loads, pressures and ramps."""


def smooth_step(s: float) -> float:
    """Return the smooth step s³(10 - 15 s + 6 s²), 0 for s <= 0 and 1 for s >= 1. Its first and second derivatives are zero
    at both ends."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def risen(time: float, rise: float) -> float:
    """Return the fraction (0 to 1) of its final value that a load has reached at a time [s]. The load rises smoothly over
    the time `rise` [s]; for `rise` = 0 the fraction is 1 at once."""
    return smooth_step(time / rise) if rise > 0.0 else 1.0
