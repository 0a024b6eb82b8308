"""The misfit between a case and measured curves as a function of the free parameters. Each evaluation runs the case as a
member of the study, whose results are kept."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import CaseError, UsageError
from pellucid.progress import Progress
from pellucid.results.storage.run import Run
from pellucid.studies.measured import TIME, Curve, NotReached
from pellucid.studies.members import DONE, Member, Outcome, members_of, places
from pellucid.studies.pool import Pool
from pellucid.studies.ranges import Range, named

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
        rows at the spacing of the measured times.
        """
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
