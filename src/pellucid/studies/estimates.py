"""Estimates of parameters from measurements, with confidence intervals, correlations, and undetermined combinations."""

from collections.abc import Mapping
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.studies.ranges import Range

CONFIDENCE = 0.95
UNDETERMINED = 0.5
"""Half width of a confidence interval, as a fraction of the parameter's range, above which the measurements are reported
not to determine the parameter."""
TAKES_PART = 0.3
"""Smallest component of a parameter in an undetermined direction for which the warning names the parameter."""
AT_BOUND = 0.01


class Estimate(NamedTuple):
    """Estimate of a parameter (`value`) and the lower and upper end of its 95 % confidence interval, in SI units."""

    value: float  # estimate of the parameter
    low: float  # lower end of the confidence interval
    high: float  # upper end of the confidence interval
    unit: str = ""  # SI unit of these numbers


class Estimates(NamedTuple):
    """Estimates of all parameters of a fit, and the quality of the fit; arrays are in the order of the parameters."""

    by_key: dict[str, Estimate]  # by dotted key of the parameter
    correlations: np.ndarray
    """Correlation matrix of the estimates, shape (parameters, parameters)."""
    singular_values: np.ndarray
    """Singular values of the Jacobian of the weighted residuals with respect to shares of the ranges, shape (parameters,)."""
    chi_square: float
    """Sum of squares of the weighted residuals, divided by the degrees of freedom."""
    warnings: list[str]  # texts for the user, e.g. on parameters that the measurements do not determine


def estimated(
    free: Mapping[str, Range], shares: np.ndarray, residuals: np.ndarray, slopes: np.ndarray, are_stated: bool
) -> Estimates:
    """Compute the estimates and their confidence intervals at the minimum of the misfit.

    free: ranges of the parameters, by key. shares: positions of the parameters in their ranges, from 0 to 1, shape
    (parameters,). residuals: differences from the measurements divided by the standard deviations, shape (values,). slopes:
    Jacobian J of the residuals with respect to the shares, shape (values, parameters). are_stated: whether the standard
    deviations are known. The covariance is (JᵀJ)⁻¹, as for a linear model; if the standard deviations are not known, the
    covariance is scaled by the variance of the residuals.
    """
    from scipy.stats import norm, t

    left = len(residuals) - len(shares)
    chi_square = float(residuals @ residuals) / left if left > 0 else float("nan")
    _, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    with np.errstate(divide="ignore"):
        spreads = np.where(sizes > 1e-12 * max(sizes[0], 1e-300), 1.0 / sizes, np.inf)  # along the directions
    quantile = norm.ppf(0.5 + CONFIDENCE / 2.0) if are_stated else t.ppf(0.5 + CONFIDENCE / 2.0, max(left, 1))
    scale = float(quantile) * (1.0 if are_stated else sqrt(chi_square) if left > 0 else np.inf)
    finite = np.where(np.isfinite(spreads), spreads, 1e6)
    covariance = (directions.T * finite**2) @ directions
    deviations = np.sqrt(np.diag(covariance))
    halves = scale * deviations
    by_key = {
        key: Estimate(each.at(share), each.beyond(share - min(half, 50.0)), each.beyond(share + min(half, 50.0)))
        for (key, each), share, half in zip(free.items(), map(float, shares), map(float, halves), strict=True)
    }
    told = [*_undetermined(list(free), scale * spreads, directions), *_at_bounds(free, shares)]
    if are_stated and left > 0 and chi_square > 1.0 + 3.0 * sqrt(2.0 / left):
        told.append(
            f"the misfit is {chi_square:.3g} times the value expected from the stated deviations, so the confidence intervals "
            f"are too narrow: the model does not describe the measurements, or the stated deviations are too small"
        )
    if left <= 0:
        told.append(
            f"there are {len(residuals)} values for {len(shares)} parameters, so the quality of the fit cannot be estimated"
        )
    return Estimates(by_key, covariance / np.outer(deviations, deviations), sizes, chi_square, told)


def _undetermined(keys: list[str], halves: np.ndarray, directions: np.ndarray) -> list[str]:
    """Return a warning for each parameter, or combination of parameters, that the measurements do not determine: its confidence
    interval is as wide as its range.

    keys: of the parameters. halves: half widths of the intervals in units of the ranges, shape (parameters,), along the
    directions in the rows of `directions`, shape (parameters, parameters).
    """
    told = []
    for half, direction in zip(halves, directions, strict=True):
        if half > UNDETERMINED:
            named = [key for key, part in zip(keys, direction, strict=True) if abs(part) > TAKES_PART]
            what = named[0] if len(named) == 1 else f"{' and '.join(named)} independently"
            told.append(f"the data do not determine {what}; add another curve that depends on it, or fix one value")
    return told


def _at_bounds(free: Mapping[str, Range], shares: np.ndarray) -> list[str]:
    ends = {key: "lower" if share < AT_BOUND else "upper" for key, share in zip(free, shares, strict=True)}
    at = [key for key, share in zip(free, shares, strict=True) if not AT_BOUND <= share <= 1.0 - AT_BOUND]
    return [f"{key} is at the {ends[key]} end of its range, so the best value may be outside; extend the range" for key in at]
