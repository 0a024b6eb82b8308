"""Ways to the parameters with the least misfit: least squares, and Optuna where the misfit is rough."""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.errors import UsageError
from pellucid.studies.extra import need
from pellucid.studies.misfit import STEP, Misfit
from pellucid.studies.ranges import named

FAILED_RUN = 1e3
"""Times as large as those at the start are the residuals of a run that fails, so that the search turns back from there."""
RESOLVED = 0.1
"""Of the differences by which slopes are found: shorter steps say nothing."""
GAINED = 0.01
"""Of the squared deviation of one value: what a last step may gain, which is a seventh of the deviation of a parameter."""


def by_least_squares(misfit: Misfit, trials: int, seed: int, at_once: int) -> np.ndarray:
    """Shares of the ranges by scipy's bounded least squares, from the middle of the ranges on; `trials` bounds its steps.

    Raises UsageError where the run in the middle fails.
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
    """Shares of the ranges of the best of so many trials of Optuna's tree-structured Parzen estimator, `at_once` a time.

    Raises UsageError where all runs fail.
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
"""By name: the search, and its trials if nobody says how many."""
