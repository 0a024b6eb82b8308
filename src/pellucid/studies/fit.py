"""Fits: parameters for which a case matches measured curves best, and their uncertainty."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from pellucid.case.spec import required
from pellucid.errors import UsageError
from pellucid.findings import absent
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.storage.files import write_text
from pellucid.studies.estimates import Estimate, Estimates, estimated
from pellucid.studies.extra import need
from pellucid.studies.fit_page import write_fit_page
from pellucid.studies.measured import Curve, read_curve
from pellucid.studies.misfit import Misfit, interpolation_warnings
from pellucid.studies.pool import Pool, Workers
from pellucid.studies.ranges import Range, range_of, unit_at
from pellucid.studies.searches import METHODS
from pellucid.studies.table import tabulated, write_table

if TYPE_CHECKING:
    import numpy as np

    from pellucid.case import Case


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
    pairs = [(probe, Path(path)) for probe, paths in measured.items() for path in _several(paths)]
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


def _several(paths: Path | str | Sequence[Path | str]) -> Sequence[Path | str]:
    return [paths] if isinstance(paths, (str, Path)) else paths
