"""Fits: parameters for which a case matches measured curves best, and their uncertainty."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.case.spec import required
from pellucid.errors import UsageError
from pellucid.findings import absent
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.pictures.style import WIDTH, Figure, house_style, label, new_panels, pretty
from pellucid.results.report.html import number, table_of
from pellucid.results.storage.files import replacing, write_text
from pellucid.results.storage.run import Run
from pellucid.studies import need
from pellucid.studies.misfit import STEP, TIME, Curve, Misfit, interpolation_warnings, read_curve
from pellucid.studies.pages import figure, frame_table, tabulated, titled, write_page, write_table
from pellucid.studies.pool import Pool, Workers
from pellucid.studies.ranges import Range, named, range_of, unit_at

if TYPE_CHECKING:
    import numpy as np

    from pellucid.case import Case


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


@dataclass(frozen=True)
class Fit:
    """Result of a fit: estimates with their uncertainties, the case with the estimated parameters, and the table of runs."""

    estimates: dict[str, Estimate]
    """Estimates by the key of the parameter: value, lower and upper end of the 95 % confidence interval, in SI units."""
    correlations: "np.ndarray"
    """Correlation matrix of the estimates, in their order, shape (parameters, parameters)."""
    singular_values: "np.ndarray"
    """Singular values of the Jacobian of the weighted residuals with respect to shares of the ranges, largest first, shape
    (parameters,)."""
    chi_square: float
    """Sum of squares of the weighted residuals, divided by the degrees of freedom: about 1 if the stated deviations explain
    the residuals."""
    warnings: list[str]  # texts for the user, e.g. on parameters that the measurements do not determine
    case: "Case"
    """The case with the estimated parameters."""
    members: Any
    """A pandas table of all runs of the fit."""


def fit(
    case: "Case",
    measured: Mapping[str, Path | str | Sequence[Path | str]],
    free: Mapping[str, tuple[Any, Any]],
    *,
    deviation: Mapping[str, str | float] | None = None,
    method: str = "least-squares",
    trials: int | None = None,
    out: Path | str | None = None,
    workers: int | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    slurm: Mapping[str, str] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Fit parameters of a case to measured curves.

    `measured`: one or several CSV files, by name of a probe. `free`: ends (low, high) of the range of a parameter, by
    dotted key; a range that spans a decade is searched on a logarithmic scale. `deviation`: standard deviation of the
    values in files without such a column, by probe. `method`: "least-squares" or "optuna", with at most `trials` steps or
    runs. For the workers see `sweep`. `out`: folder in which everything is kept; the same call resumes an interrupted fit.

    Raises `CaseError` and `UsageError` before any run, and `UsageError` if runs within the ranges fail.
    """
    lists = {probe: [paths] if isinstance(paths, (str, Path)) else paths for probe, paths in measured.items()}
    pairs = [(probe, Path(path)) for probe, paths in lists.items() for path in paths]
    stated = dict(deviation or {})
    if unknown := set(stated) - set(measured):
        raise UsageError(absent("there is no measured curve for the probe", min(unknown), measured))
    curves = [read_curve(path, probe, required(case), stated.get(probe)) for probe, path in pairs]
    ranges = {key: range_of(case, key, *ends, option="--free") for key, ends in free.items()}
    parts = Workers(workers, threads, scheduler, dict(slurm or {}))
    if out is not None:
        return run_fit(case, curves, ranges, Path(out), parts, progress, method, trials, seed)
    with TemporaryDirectory(prefix="pellucid-") as scratch:
        return run_fit(case, curves, ranges, Path(scratch), parts, progress, method, trials, seed)


def run_fit(
    case: "Case",
    curves: Sequence[Curve],
    free: Mapping[str, Range],
    out: Path,
    workers: Workers,
    progress: Progress | None,
    method: str,
    trials: int | None,
    seed: int,
) -> Fit:
    """Run the fit, write `estimates.json`, `fitted.toml`, `fit.png`, `report.html` and the table of runs to `out`, and return
    the result.

    curves: measured curves. free: ranges of the parameters, by dotted key. workers: options of parallel runs. Other arguments
    as in `fit`.
    """
    workers.check()
    for module in ("distributed", "pandas", "pyarrow", *(["optuna"] if method == "optuna" else [])):
        need(module)
    if not curves or not free:
        raise UsageError(
            "A fit requires a measured curve and a free parameter.\n    Add --measured FILE.csv --probe NAME --free "
            "KEY=LOW:HIGH."
        )
    if (values := sum(len(curve.y) for curve in curves)) < len(free):
        text = f"{values} measured values cannot determine {len(free)} parameters"
        raise UsageError(f"{text}.\n    Add measured values, or remove some --free.")
    if method not in METHODS:
        raise UsageError(absent("there is no method", method, METHODS))
    if trials is not None and trials < 1:
        raise UsageError(f"--trials {trials}: must be at least 1")
    progress = progress or WarningsOnly()
    search, usual = METHODS[method]
    with Pool(out, workers, progress) as pool:
        misfit = Misfit(case, free, curves, out, pool, progress)
        misfit.observe_where_measured()
        shares = search(misfit, trials or usual, seed, pool.at_once)
        slopes = misfit.jacobian(shares, central=True)
        residuals, run = misfit.one(shares), misfit.run(shares)
    if residuals is None or run is None:
        raise UsageError("The run with the best parameters failed.\n    Use narrower ranges of --free.")
    found = estimated(free, shares, residuals, slopes, all(curve.is_stated for curve in curves))
    found = found._replace(by_key={key: one._replace(unit=unit_at(case, key)) for key, one in found.by_key.items()})
    found = found._replace(warnings=[*interpolation_warnings(curves, run), *found.warnings])
    best = case.with_settings(misfit.settings(shares))
    progress.begin("report")
    for text in found.warnings:
        progress.message(text)
    members = list(misfit.members.values())
    table = tabulated(out, members, misfit.ended)
    write_table(table, out)
    _write(out, best, found)
    write_fit_page(out, case.title, found, curves, run, table)
    return Fit(found.by_key, found.correlations, found.singular_values, found.chi_square, found.warnings, best, table)


def _write(out: Path, best: "Case", found: Estimates) -> None:
    from pellucid.case import dumps

    data = {
        "estimates": {key: one._asdict() for key, one in found.by_key.items()},
        "correlations": found.correlations.tolist(),
        "singular_values": found.singular_values.tolist(),
        "chi_square": found.chi_square,
        "warnings": found.warnings,
    }
    write_text(out / "estimates.json", json.dumps(data, indent=2) + "\n")
    write_text(out / "fitted.toml", dumps(best))


CONFIDENCE = 0.95
UNDETERMINED = 0.5
"""Half width of a confidence interval, as a fraction of the parameter's range, above which the measurements are reported
not to determine the parameter."""
TAKES_PART = 0.3
"""Smallest component of a parameter in an undetermined direction for which the warning names the parameter."""
AT_BOUND = 0.01


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
    from scipy.special import ndtri, stdtrit  # scipy.stats takes half a second to import

    left = len(residuals) - len(shares)
    chi_square = float(residuals @ residuals) / left if left > 0 else float("nan")
    _, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    with np.errstate(divide="ignore"):
        spreads = np.where(sizes > 1e-12 * max(sizes[0], 1e-300), 1.0 / sizes, np.inf)  # along the directions
    quantile = ndtri(0.5 + CONFIDENCE / 2.0) if are_stated else stdtrit(max(left, 1), 0.5 + CONFIDENCE / 2.0)
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


def write_fit_page(out: Path, title: str, found: Estimates, curves: Sequence[Curve], run: Run, table: Any) -> Path:
    """Write `report.html` and `fit.png` of a fit to `out`; return the path of the page.

    title: title of the case. found: the estimates. curves: measured curves. run: run with the estimated parameters. table:
    pandas table of all runs.
    """
    with house_style():
        drawn = _fitted_curves(curves, run)
        with replacing(out / "fit.png") as file:
            drawn.savefig(file, format="png")
        picture = figure(drawn, "Measured values with their standard deviations and the fitted case; below, the residuals.")
    notes = "".join(f'<p class="note">Warning: {escape(text)}.</p>' for text in found.warnings)
    keys = list(found.by_key)
    estimates = table_of(
        ("key", "estimate", "95 % from", "to", "unit"),
        (
            [escape(key), *(number(value, 5) for value in one[:3]), escape(pretty(one.unit))]
            for key, one in found.by_key.items()
        ),
        "numbers",
    )
    rows = (
        [escape(key), *(number(float(value), 3) for value in row)] for key, row in zip(keys, found.correlations, strict=True)
    )
    together = table_of(("", *map(escape, keys)), rows, "numbers") if len(keys) > 1 else ""
    sizes = ", ".join(number(float(size), 3) for size in found.singular_values)
    misfit = f"<p>Sum of squared residuals per degree of freedom: {number(found.chi_square, 4)}; singular values {sizes}.</p>"
    columns = [name for name in table.columns if name not in ("steps", "message")]
    sections = [
        notes,
        titled("Estimates", estimates, misfit),
        titled("Correlations", together),
        titled("Fit", picture),
        titled("Members", frame_table(table, columns[: 3 + len(keys)])),
    ]
    return write_page(out / "report.html", f"Fit: {title}", sections)


def _fitted_curves(curves: Sequence[Curve], run: Run) -> Figure:
    drawn, axes = new_panels(2, len(curves), WIDTH, 5.0, squeeze=False, gridspec_kw={"height_ratios": [2, 1]})
    for (above, below), curve in zip(np.transpose(axes), curves, strict=True):
        bars = {"yerr": curve.deviation} if curve.is_stated else {}
        above.errorbar(curve.x, curve.y, fmt="o", markersize=3, linewidth=0.8, label=f"measured, {curve.path.name}", **bars)
        above.plot(*run.curve(curve.probe, curve.against), "-", label="fitted")
        unit = "s" if curve.against == TIME else run.units[curve.against]
        label(above, curve.against, curve.probe, unit, curve.unit, legend=True)
        below.axhline(0.0, color="#667", linewidth=0.8)
        below.plot(curve.x, curve.residuals(run), "o", markersize=3)
        label(below, curve.against, f"residual over\n{'deviation' if curve.is_stated else 'spread'}", unit)
    return drawn


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
