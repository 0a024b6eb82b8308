"""The misfit of a case to measured curves, as a function of its free parameters; each value is a member that is kept."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.errors import CaseError, UsageError
from pellucid.progress import Progress
from pellucid.results.storage.run import Run
from pellucid.studies.measured import TIME, Curve
from pellucid.studies.members import DONE, Member, Outcome, members_of, places
from pellucid.studies.pool import Pool
from pellucid.studies.ranges import Range, named

if TYPE_CHECKING:
    from pellucid.case import Case

STEP = 0.02
"""Of differences, as a share of the range of a parameter."""


class Misfit:
    """Residuals by shares of the ranges of the free parameters, arrays of shape (parameters,) from 0 to 1."""

    def __init__(
        self, case: "Case", free: Mapping[str, Range], curves: Sequence[Curve], out: Path, pool: Pool, progress: Progress
    ) -> None:
        self.case, self.free, self.curves, self.out = case, free, curves, out
        self.members: dict[str, Member] = {}
        self.ended: dict[str, Outcome] = {}
        self._known: dict[tuple[float, ...], Member | None] = {}
        self._pool, self._progress = pool, progress
        last = max(float(curve.x.max()) for curve in curves)
        only_time = all(curve.against == TIME for curve in curves)
        self._until = last if only_time and not case.time.reached(last) else None

    def settings(self, shares: np.ndarray) -> dict[str, Any]:
        """The values of the parameters."""
        return {key: each.at(float(share)) for (key, each), share in zip(self.free.items(), shares, strict=True)}

    def run(self, shares: np.ndarray) -> Run | None:
        """The run with these values; None of one that failed, or of a case that cannot be."""
        member = self._member(shares)
        if member is None or self.ended[member.digest].state != DONE:
            return None
        return Run(places(self.out, member.digest).run)

    def residuals(self, several: Sequence[np.ndarray]) -> list[np.ndarray | None]:
        """The residuals at several places at once, each of shape (values,); None where there is no run."""
        members = [self._member(shares) for shares in several]
        new = {member.digest: member for member in members if member is not None and member.digest not in self.ended}
        if new:
            self.members |= new
            self.ended |= self._pool.compute(list(new.values()))
        found = [self._of_run(self.run(shares)) for shares in several]
        for member, values in zip(members, found, strict=True):
            if member is not None and new.pop(member.digest, None) is not None:
                told = "its run failed" if values is None else f"sum of squares {float(values @ values):.5g}"
                self._progress.note(f"{named(member.settings)}: {told}")
        return found

    def _of_run(self, run: Run | None) -> np.ndarray | None:
        return None if run is None else np.concatenate([curve.residuals(run) for curve in self.curves])

    def one(self, shares: np.ndarray) -> np.ndarray | None:
        """The residuals at one place."""
        return self.residuals([shares])[0]

    def jacobian(self, shares: np.ndarray, central: bool = False) -> np.ndarray:
        """Slopes of the residuals by the shares, shape (values, parameters), from members that run at once.

        Raises UsageError where no run beside the place gets to its end.
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
                    f"how the curves depend on {key} cannot be told: the run with {failed} failed; narrow its range"
                )
            (first, one), (second, other) = known[:2]
            columns.append((one - other) / (first - second))
        return np.column_stack(columns)

    def _rounded(self, shares: np.ndarray) -> np.ndarray:
        """The shares of the values that are run."""
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
