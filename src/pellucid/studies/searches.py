"""Searches for the parameters with the smallest misfit (sum of squared residuals): least squares, and Optuna for misfits that
are not smooth."""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.errors import UsageError
from pellucid.studies.extra import need
from pellucid.studies.misfit import STEP, Misfit
from pellucid.studies.ranges import named

FAILED_RUN = 1e3
"""Size of the residuals that replace those of a failed run, relative to the residuals at the start; it is large, so that
the search turns back."""
RESOLVED = 0.1
"""Smallest step of the search relative to the step of finite differences; differences between shorter steps cannot be
resolved."""
GAINED = 0.01
"""Decrease of the sum of squares in a search step, relative to the mean squared weighted residual, below which the
search ends; it corresponds to a seventh of a parameter's standard deviation."""


def by_least_squares(misfit: Misfit, trials: int, seed: int, at_once: int) -> np.ndarray:
    """Return the best parameters, as positions in their ranges from 0 to 1, shape (parameters,), by scipy's bounded least
    squares, started in the middle of the ranges.

    trials: largest number of steps. seed, at_once: not used. Raises UsageError if the run in the middle fails.
    """
    from scipy.optimize import least_squares

    middle = np.full(len(misfit.free), 0.5)
    first = misfit.one(middle)
    if first is None:
        if misfit.short is not None:
            raise misfit.short
        misfit.case.with_settings(misfit.settings(middle))  # says what is wrong with it, if it is not the run
        failed = misfit.ended[next(iter(misfit.members))].message
        raise UsageError(f"The run at the centre of the ranges, {named(misfit.settings(middle))}, failed: {failed}")
    bad = FAILED_RUN * (np.abs(first) + 1.0)

    def residuals(shares: np.ndarray) -> np.ndarray:
        found = misfit.one(shares)
        return bad if found is None else found

    found = least_squares(
        residuals,
        middle,
        misfit.jacobian,
        bounds=(0.0, 1.0),
        ftol=GAINED / len(first),
        xtol=RESOLVED * STEP,
        gtol=None,
        max_nfev=trials,
    )
    return np.asarray(found.x)


def by_optuna(misfit: Misfit, trials: int, seed: int, at_once: int) -> np.ndarray:
    """Return the best parameters, as positions in their ranges from 0 to 1, shape (parameters,), of `trials` runs chosen by
    Optuna's tree-structured Parzen estimator; `at_once` runs are computed in parallel.

    seed: seed of the estimator. Raises UsageError if all runs fail.
    """
    optuna = need("optuna")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    sampler = optuna.samplers.TPESampler(seed=seed, multivariate=True, constant_liar=True)
    study = optuna.create_study(sampler=sampler)
    every = {key: optuna.distributions.FloatDistribution(0.0, 1.0) for key in misfit.free}
    study.enqueue_trial(dict.fromkeys(misfit.free, 0.5))
    for begun in range(0, trials, at_once):
        asked = [study.ask(every) for _ in range(min(at_once, trials - begun))]
        found = misfit.residuals([np.array([trial.params[key] for key in misfit.free]) for trial in asked])
        for trial, residuals in zip(asked, found, strict=True):
            if residuals is None:
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
            else:
                study.tell(trial, float(residuals @ residuals))
    try:
        best = study.best_params
    except ValueError:
        if misfit.short is not None:
            raise misfit.short from None
        raise UsageError(f"All {trials} runs failed.\n    Use narrower ranges of --free.") from None
    return np.array([best[key] for key in misfit.free])


Search = Callable[[Misfit, int, int, int], np.ndarray]
METHODS: Mapping[str, tuple[Search, int]] = {"least-squares": (by_least_squares, 50), "optuna": (by_optuna, 100)}
"""Search functions by name, with their default numbers of trials."""
