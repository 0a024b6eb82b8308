"""A smooth step from 0 to 1, by which loads, pressures and ramps begin."""


def smooth_step(s: float) -> float:
    """s³(10 - 15 s + 6 s²) between 0 at s <= 0 and 1 at s >= 1: first and second derivatives begin and end at zero."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def risen(time: float, rise: float) -> float:
    """The share of a load that acts at a time [s] and rises smoothly from zero over `rise` [s], at once where that is 0."""
    return smooth_step(time / rise) if rise > 0.0 else 1.0
