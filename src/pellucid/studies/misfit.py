"""Misfit of a case to measured curves: the curves, their comparison with runs, and the objective of a fit."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.case.measured import CurveError, Table, read_table
from pellucid.errors import CaseError, UsageError
from pellucid.findings import absent
from pellucid.progress import Progress
from pellucid.results.metrics import Readings, mean_columns
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run import Run
from pellucid.studies.members import DONE, Member, Outcome, members_of, places
from pellucid.studies.pool import Pool
from pellucid.studies.ranges import Range, named
from pellucid.units import UnitError, to_si

if TYPE_CHECKING:
    from pellucid.case import Case


STEP = 0.02
"""Step of finite differences, as a share of the range of a parameter."""
MOST_EQUILIBRIA = 60
"""Largest number of equilibria that a fit adds to a steady analysis; curves are interpolated between them."""
SEARCHES, NEAR = 2, 2e-3
"""Largest number of runs that locate the measured abscissae in load time, and the tolerance as a share of their range."""
CLOSEST = 1e-4
"""Smallest distance of added equilibria, as a fraction of the load time."""
NOTICEABLE = 0.2
"""Interpolation error, relative to the standard deviation, above which a warning is issued."""
SMALLEST = 1e-3
"""Smallest deviation with which the interpolation error is compared, as a fraction of the spread of the measured values."""
FEWEST_ROWS, MOST_ROWS = 200, 5000
"""Smallest and largest number of history rows that a fit requests for a motion in time."""


class Curve(NamedTuple):
    """Measured curve of a probe (its values against time or against another probe), in SI units, from a CSV file."""

    path: Path  # the CSV file
    probe: str  # name of the probe
    against: str
    """Name of the abscissa of the curve: `time` or another probe."""
    x: np.ndarray
    """Measured abscissae, shape (n,); `y` and `deviation` have the same shape."""
    y: np.ndarray  # measured values of the probe
    deviation: np.ndarray
    """Standard deviations of the values; if none are stated, the spread of the values, so that all curves have equal
    weight."""
    is_stated: bool  # True if standard deviations are given by the file or the user
    unit: str  # SI unit of the values

    def residuals(self, run: Run) -> np.ndarray:
        """Return the computed minus the measured values of the probe, divided by the standard deviations, shape (n,)."""
        return (self.values(run) - self.y) / self.deviation

    def values(self, run: Run) -> np.ndarray:
        """Return the values of the probe in a run at the measured abscissae, shape (n,).

        A steady analysis is extrapolated linearly by up to a tenth of its range, because the end of its range may depend on the
        parameters, e.g. if the abscissa is a force. Raises NotReached if measured abscissae lie further outside the run.
        """
        x, y = self._branch(run)
        if self._beyond(x) > (EXTRAPOLATED if _is_smooth(run) and self.against != TIME else 1e-6) * np.ptp(x):
            raise NotReached(
                f"{self._reach(x, run)}; extend the run, e.g. by a later `time.end`, or remove the rows beyond its end"
            )
        return _read(x, y, self.x, _is_smooth(run))

    def extrapolation(self, run: Run) -> str | None:
        """Return a text for the user about measured values beyond the end of a run; None if there are none."""
        x, _ = self._branch(run)
        return self._reach(x, run) if self._beyond(x) > 1e-6 * np.ptp(x) else None

    def interpolation_error(self, run: Run) -> np.ndarray:
        """Estimate the error of `values` between the rows of the run as the difference of two interpolants, shape (n,)."""
        x, y = self._branch(run)
        return np.abs(_read(x, y, self.x, True) - _read(x, y, self.x, False))

    def distance_to_rows(self, run: Run) -> float:
        """Return the largest distance of a measured abscissa from the nearest row of a run's history, divided by the range of
        abscissae of the run."""
        x, _ = self._branch(run)
        apart = np.abs(self.x[:, None] - x).min(axis=1)
        return float(apart[(self.x >= x[0]) & (self.x <= x[-1])].max(initial=0.0) / np.ptp(x))

    def instants(self, run: Run) -> np.ndarray:
        """Return the load times [s] at which the abscissa (a probe) of a steady run has the measured values, shape (k,); values
        outside the range of the run are omitted."""
        x, times = self._branch(run, along=TIME)
        if len(x) < 2:
            return times
        forward = np.argsort(times)
        fine = np.union1d(np.linspace(times.min(), times.max(), FINE), times)
        passed = _read(times[forward], x[forward], fine, _is_smooth(run))  # smooth in time, while its inverse may be steep
        sign = 1.0 if times[-1] > times[0] else -1.0
        passed = np.maximum.accumulate(sign * passed)
        wanted = self.x[(self.x >= x[0]) & (self.x <= x[-1])]
        return np.asarray(np.interp(sign * wanted, passed, fine))

    def _branch(self, run: Run, along: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return abscissae and ordinates of a run in order of ascending abscissae, up to the first turning point of the
        abscissa. along: history column of the ordinates, by default the probe."""
        x, y = run.readings.curve(along or self.probe, self.against, whole=True)
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            raise UsageError(f"{self.path}: {self.probe} and {self.against} of the run in {run.out} have no finite values")
        x, y = x[known], y[known]
        sign = 1.0
        if self.against != TIME:
            sign = 1.0 if x[np.argmax(np.abs(x - x[0]))] >= x[0] else -1.0
        new = np.concatenate([[True], sign * x[1:] > np.maximum.accumulate(sign * x)[:-1]])
        x, y = x[new], y[new]
        return (x, y) if sign > 0.0 else (x[::-1], y[::-1])

    def _beyond(self, x: np.ndarray) -> float:
        """Return the largest distance by which measured abscissae lie outside the range of a run; 0 if all lie inside. x:
        ascending abscissae of the run."""
        return float(max(x[0] - self.x.min(), self.x.max() - x[-1], 0.0))

    def _reach(self, x: np.ndarray, run: Run) -> str:
        measured = f"the measured {self.against} ranges from {self.x.min():.6g} to {self.x.max():.6g}"
        return f"{self.path}: {measured}, but in the run in {run.out} from {x[0]:.6g} to {x[-1]:.6g}"


class Misfit:
    """Residuals of a case as a function of its free parameters: differences between runs and measurements, divided by the
    standard deviations.

    The parameters are given as `shares`: positions in their ranges from 0 (lower end) to 1 (upper end), shape (parameters,).
    case: the case. free: ranges by dotted key. curves: measured curves. out: folder of the study. pool: workers that run the
    members (runs of the study). `members` and `ended` have the members so far and their outcomes, by digest.
    """

    def __init__(
        self, case: "Case", free: Mapping[str, Range], curves: Sequence[Curve], out: Path, pool: Pool, progress: Progress
    ) -> None:
        self.case, self.free, self.curves, self.out = case, free, curves, out
        self.members: dict[str, Member] = {}
        self.ended: dict[str, Outcome] = {}
        self.short: NotReached | None = None
        """Error of a run that ended before it reached all measured values; None if all runs reached them."""
        self._known: dict[tuple[float, ...], Member | None] = {}
        self._pool, self._progress = pool, progress
        last = max(float(curve.x.max()) for curve in curves)
        only_time = all(curve.against == TIME for curve in curves)
        self._until = last if only_time and not case.time.reached(last) else None

    def observe_where_measured(self) -> None:
        """Add history rows at the measured abscissae, so that no interpolation between the rows of the case is needed.

        A steady analysis gets equilibria at the load times of the measured abscissae. For curves against another probe,
        these times are determined from a first run with all parameters in the middle of their ranges. A motion in time gets
        rows at the spacing of the measured times. A path of equilibria with arc-length control keeps its rows, since it has no
        given times.
        """
        if self.case.steady is not None and self.case.steady.control == "arc-length":
            return
        times = [curve.x for curve in self.curves if curve.against == TIME]
        if self.case.steady is None:
            self._refine_rows(times)
            return
        others = [curve for curve in self.curves if curve.against != TIME]
        if not others:
            self._add_equilibria(times)
            return
        own, middle = self.case, np.full(len(self.free), 0.5)
        for _ in range(SEARCHES):
            self._run_members([middle])
            run = self.run(middle)
            if run is None:  # the search reports why
                return
            if self.case is not own and max(curve.distance_to_rows(run) for curve in others) < NEAR:
                return
            found = [curve.instants(run) for curve in others]
            self.case = own
            self._add_equilibria([*times, *found])

    def _add_equilibria(self, times: Sequence[np.ndarray]) -> None:
        """Add equilibria at the load times `times` [s] to the steady analysis of the case, except at times close to other
        equilibria."""
        steady, end = self.case.steady, self.case.time.end
        if steady is None:
            return
        there = np.array(steady.levels(end)) * (end / steady.load_steps)
        instants = np.unique(np.concatenate(times))
        instants = instants[np.abs(instants[:, None] - there).min(axis=1) > CLOSEST * end]
        instants = instants[np.diff(instants, prepend=-end) > CLOSEST * end]
        if len(instants) > MOST_EQUILIBRIA:
            instants = instants[np.linspace(0, len(instants) - 1, MOST_EQUILIBRIA).round().astype(int)]
        data = self.case.to_data()
        data["steady"]["at"] = sorted([*steady.at, *instants.tolist()])
        data.get("output", {}).pop("history", None)  # a row at each equilibrium
        self.case = type(self.case).model_validate(data)
        self.members.clear()
        self._known.clear()

    def _refine_rows(self, times: Sequence[np.ndarray]) -> None:
        apart = [np.diff(np.unique(each)) for each in times]
        end, rows = self.case.time.end, self.case.output.rows_every(self.case.time.end)
        closest = min((float(np.median(each)) for each in apart if len(each)), default=rows)
        if rows > closest or rows > end / FEWEST_ROWS:
            interval = max(min(0.5 * closest, end / FEWEST_ROWS), end / MOST_ROWS)
            self.case = self.case.with_settings({"output.history": min(rows, interval)})

    def settings(self, shares: np.ndarray) -> dict[str, Any]:
        """Return the values of the parameters in SI units by dotted key; shares: as in the class."""
        return {key: each.at(float(share)) for (key, each), share in zip(self.free.items(), shares, strict=True)}

    def run(self, shares: np.ndarray) -> Run | None:
        """Return the results of the run with these parameters, which must have been computed; None if it failed or if the case
        is invalid."""
        member = self._member(shares)
        if member is None or self.ended[member.digest].state != DONE:
            return None
        return Run(places(self.out, member.digest).run)

    def residuals(self, several: Sequence[np.ndarray]) -> list[np.ndarray | None]:
        """Return the residuals for several sets of parameters (`shares`), whose runs are computed in parallel: shape (values,)
        each; None for a failed run."""
        members, new = self._run_members(several)
        found = [self._of_run(self.run(shares)) for shares in several]
        for member, values in zip(members, found, strict=True):
            if member is not None and new.pop(member.digest, None) is not None:
                failed = "the run failed, or ended before the last measured value"
                told = failed if values is None else f"sum of squares {float(values @ values):.5g}"
                self._progress.note(f"{named(member.settings)}: {told}")
        return found

    def _run_members(self, several: Sequence[np.ndarray]) -> tuple[list[Member | None], dict[str, Member]]:
        """Compute the runs for several sets of parameters (`shares`). Return the member of each set (None if the case is
        invalid), and the members that had to be run, by digest."""
        members = [self._member(shares) for shares in several]
        new = {member.digest: member for member in members if member is not None and member.digest not in self.ended}
        if new:
            self.members |= new
            self.ended |= self._pool.compute(list(new.values()))
        return members, new

    def _of_run(self, run: Run | None) -> np.ndarray | None:
        try:
            return None if run is None else np.concatenate([curve.residuals(run) for curve in self.curves])
        except NotReached as short:
            self.short = short
            return None

    def one(self, shares: np.ndarray) -> np.ndarray | None:
        """Return the residuals for one set of parameters (`shares`), shape (values,); None if the run failed."""
        return self.residuals([shares])[0]

    def jacobian(self, shares: np.ndarray, central: bool = False) -> np.ndarray:
        """Return the Jacobian of the residuals with respect to the shares, shape (values, parameters), by finite differences of
        runs that are computed in parallel.

        central: use central instead of one-sided differences. Raises UsageError if too few of the neighbouring runs succeed.
        """
        at, width = self._rounded(shares), len(shares)
        inward = np.where(at + STEP <= 1.0, 1.0, -1.0)
        ahead = [self._rounded(at + STEP * inward[i] * np.eye(width)[i]) for i in range(width)]
        behind = [self._rounded(np.clip(at - STEP * inward[i] * np.eye(width)[i], 0.0, 1.0)) for i in range(width)]
        found = self.residuals([at, *ahead, *(behind if central else [])])
        here, columns = found[0], []
        for i, key in enumerate(self.free):
            ends = [(ahead[i], found[1 + i]), *([(behind[i], found[1 + width + i])] if central else []), (at, here)]
            known = [(place[i], values) for place, values in ends if values is not None]
            if len(known) < 2 or known[0][0] == known[1][0]:
                failed = named(self.settings(ahead[i]))
                raise UsageError(
                    f"The derivative with respect to {key} cannot be computed: the run with {failed} failed.\n    Use a "
                    f"narrower range of {key}."
                )
            (first, one), (second, other) = known[:2]
            columns.append((one - other) / (first - second))
        return np.column_stack(columns)

    def _rounded(self, shares: np.ndarray) -> np.ndarray:
        """Return the parameters as shares of their ranges after rounding their values, since runs use rounded values."""
        pairs = zip(self.free.values(), shares, strict=True)
        return np.array([each.share(each.at(float(share))) for each, share in pairs])

    def _member(self, shares: np.ndarray) -> Member | None:
        place = tuple(map(float, shares))
        if place not in self._known:
            try:
                self._known[place] = members_of(self.case, [self.settings(shares)], self._until)[0]
            except CaseError:  # values that are possible one by one and not together
                self._known[place] = None
        return self._known[place]


def interpolation_warnings(curves: Sequence[Curve], run: Run) -> list[str]:
    """Return warnings for the user: measured curves that lie partly beyond the end of a run, and curves whose interpolation
    error between the rows of the run is large compared with the standard deviations or residuals."""
    told = []
    for curve in curves:
        if (beyond := curve.extrapolation(run)) is not None:
            told.append(f"{beyond}; the curve is extrapolated linearly. Extend the run, e.g. by a larger motion or load")
        error = float(np.sqrt(np.mean(curve.interpolation_error(run) ** 2)))
        spread = curve.deviation if curve.is_stated else curve.values(run) - curve.y
        size = max(float(np.sqrt(np.mean(spread**2))), SMALLEST * float(np.std(curve.y)))
        if error <= NOTICEABLE * size:
            continue
        what = "the stated deviations" if curve.is_stated else "the differences from the measurements"
        key = "output.history" if run.stored.steady is None else "steady.load_steps"
        change = "Set a smaller" if run.stored.steady is None else "Set a larger"
        told.append(
            f"{curve.path}: {curve.probe} is interpolated between the rows of the run with an error of about {error:.2g} "
            f"{curve.unit}, {100.0 * error / size:.0f} % of {what}, which affects the estimates. {change} `{key}`"
        )
    return told


DEVIATION = "deviation"
TIME = "time"


FINE = 2001
"""Number of times at which an abscissa is sampled when it is inverted by linear interpolation."""
EXTRAPOLATED = 0.1
"""Largest extrapolation of a steady analysis, as a fraction of its range of abscissae."""


class NotReached(UsageError):
    """Error for measured values that lie beyond the end of a run."""


def _is_smooth(run: Run) -> bool:
    """Return True if a run is a steady analysis, whose history is a smooth curve through few equilibria. Motions in time have
    many rows, jumps and noise."""
    return run.stored.steady is not None


def _read(x: np.ndarray, y: np.ndarray, at: np.ndarray, smooth: bool) -> np.ndarray:
    """Return the values at abscissae `at` of the curve through the points (x, y): a cubic spline if `smooth`, otherwise a
    monotone piecewise cubic; extrapolated linearly."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if len(x) < 2:
        return np.full(len(at), y[0])
    cubic, within = (CubicSpline if smooth else PchipInterpolator)(x, y), np.clip(at, x[0], x[-1])
    return np.asarray(cubic(within) + (at - within) * cubic(within, 1))


def read_curve(path: Path, probe: str, case: "Case", deviation: str | float | None = None) -> Curve:
    """Read a measured curve for a probe of a case.

    The abscissa is the column `time` or the name of another probe, by default the first column. The ordinate is the column
    with the name of the probe, by default the second column. Standard deviations are in the column `deviation` or
    `<probe>_deviation`; without it, the argument `deviation`, a number in SI units or a text with a unit, applies to all
    values. The second row has the units, with or without a leading #. Raises UsageError with file and line.
    """
    units = {TIME: "s", **ProbeReader(case.probe).units()}
    if probe not in units or probe == TIME:
        raise UsageError(absent("the case has no probe", probe, [name for name in units if name != TIME]))
    try:
        return _curve(read_table(path), probe, case, units, deviation)
    except CurveError as error:
        raise UsageError(f"--measured: {error}") from None


def _curve(table: Table, probe: str, case: "Case", units: Mapping[str, str], deviation: str | float | None) -> Curve:
    path, names, lines = table.path, list(table.values), table.lines
    across = TIME if TIME in names else next((name for name in names if name in units and name != probe), "")
    if not across:
        raise CurveError(f"{path}:1: no column has the name time or the name of a probe; the columns are {', '.join(names)}")
    along = probe if probe in names else next((name for name in names if name != across and DEVIATION not in name), "")
    if not along:
        raise CurveError(f"{path}:1: no column has the name {probe}; the columns are {', '.join(names)}")
    if len(lines) < 2:
        raise CurveError(f"{path}: a curve requires at least two rows of numbers")
    unit = units[probe]
    x, y = _columns(table, across, along, probe, case, units)
    lines = lines[-len(y) :]
    stated = next((name for name in (f"{probe}_{DEVIATION}", DEVIATION) if name in names), None)
    if across == TIME and (wrong := np.flatnonzero((x < 0.0) | np.array([case.time.passed(t) for t in x]))).size:
        where = f"{path}:{lines[wrong[0]]}: t = {x[wrong[0]]:.6g} s"
        raise CurveError(
            f"{where} is not between 0 and time.end = {case.time.end:g} s; set a later time.end, or remove the row"
        )
    if stated is not None and deviation is not None:
        text = f"--deviation {deviation}: {path} already has standard deviations in the column {stated}"
        raise UsageError(f"{text}.\n    Remove the option or the column.")
    if stated is not None:
        spread = table.column(stated, unit)[-len(y) :]
        where = f"{path}:{lines[int(np.argmin(spread))]}: {stated}"
    else:
        spread = np.full(len(y), float(np.std(y)) if deviation is None else _in_si(deviation, unit))
        where = f"{path}: the spread of {along}" if deviation is None else f"--deviation {deviation}"
    if not spread.min() > 0.0:
        raise UsageError(f"{where} is {spread.min():g}; it must be greater than 0")
    return Curve(path, probe, across, x, y, spread, stated is not None or deviation is not None, unit)


def _columns(table: Table, across: str, along: str, probe: str, case: "Case", units: Mapping[str, str]) -> list[np.ndarray]:
    """Return abscissae and values of a measured curve in SI units. If the table is the history of a run, columns that are means
    over an interval are evaluated at the middle of the interval, as in the fitted run.

    table: columns of the CSV file. across, along: names of its columns of abscissae and values. probe: name of the probe.
    units: SI units of time and of the probes.
    """
    x, y = table.column(across, units[across]), table.column(along, units[probe])
    if along != probe or not {TIME, "step", "dt"} <= table.values.keys():
        return [x, y]
    means = mean_columns([(each.name, each.quantity) for each in case.probe], case.steady is not None)
    history = {TIME: table.column(TIME, "s"), across: x, along: y}
    return list(Readings(history, means).curve(along, across))


def _in_si(deviation: str | float, unit: str) -> float:
    try:
        return float(deviation)
    except ValueError:
        try:
            return to_si(str(deviation), unit)
        except UnitError as error:
            raise UsageError(f"--deviation {deviation}: {error}") from None
