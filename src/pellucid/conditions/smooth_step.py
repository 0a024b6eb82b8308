"""A smooth step from 0 to 1, by which loads, pressures and ramps begin."""


def smooth_step(s: float) -> float:
    """s³(10 - 15 s + 6 s²) between 0 at s <= 0 and 1 at s >= 1: first and second derivatives begin and end at zero."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
