"""Sweeps: run a case for many values of its parameters; results in one table and one page."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from pellucid.case.spec import required
from pellucid.progress import Progress, WarningsOnly
from pellucid.studies.extra import need
from pellucid.studies.members import FAILED, Member, Outcome, members_of
from pellucid.studies.pool import Pool, Workers
from pellucid.studies.ranges import named
from pellucid.studies.samples import rows_of
from pellucid.studies.sensitivities import sensitivities
from pellucid.studies.sweep_page import write_sweep_page
from pellucid.studies.table import keys_of, outputs_of, tabulated, write_table

if TYPE_CHECKING:
    from pellucid.case import Case


def sweep(
    case: "Case",
    over: Mapping[str, Any] | None = None,
    *,
    samples: int | None = None,
    rows: Sequence[Mapping[str, Any]] = (),
    out: Path | str | None = None,
    until: float | None = None,
    workers: int | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    slurm: Mapping[str, str] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Any:
    """Run a case for many settings; return a pandas table with a row for each member.

    `over`: a list of values, or a tuple (low, high), by dotted key. From ranges, `samples` members are drawn as a Latin
    hypercube with `seed`. `rows`: explicit settings of members. Members run `workers` at a time on this machine, each with
    `threads` threads, on the cluster of a dask `scheduler`, or as jobs of `slurm` (arguments of
    `dask_jobqueue.SLURMCluster`), up to the time `until` [s] or the end of the case. `out`: folder in which everything is
    kept, with `members.csv`, `members.parquet` and `report.html`. A repeated call skips finished members and resumes
    interrupted ones.

    Columns: `member`, `state` ("done" or "failed"), the settings in SI units, `steps`, `wall_seconds`, metrics, for each
    probe `_last`, `_min`, `_max` and `_mean`, and `message`. Raises `CaseError` and `UsageError` before any run.
    """
    parts = Workers(workers, threads, scheduler, dict(slurm or {}))
    drawn = rows_of(required(case), over or {}, samples, rows, seed)
    if out is not None:
        return run_sweep(case, drawn, Path(out), until, parts, progress, samples is not None)
    with TemporaryDirectory(prefix="pellucid-") as scratch:
        return run_sweep(case, drawn, Path(scratch), until, parts, progress, samples is not None)


def run_sweep(
    case: "Case",
    rows: Sequence[Mapping[str, Any]],
    out: Path,
    until: float | None,
    workers: Workers,
    progress: Progress | None,
    at_random: bool,
) -> Any:
    """Run the members with these settings (values by dotted key), write the results to `out` and return the pandas table of
    members.

    until: time at which the runs end [s]. workers: options of parallel runs. at_random: True if the settings are a random
    sample, from which sensitivities can be computed.
    """
    workers.check()
    for module in ("distributed", "pandas", "pyarrow", *(["SALib"] if at_random else [])):
        need(module)
    progress = progress or WarningsOnly()
    members = members_of(case, rows, until)

    def told(member: Member, ended: Outcome) -> None:
        if ended.state == FAILED:
            progress.message(f"member {member.digest} ({named(member.settings)}) failed: {ended.message}")

    with Pool(out, workers, progress) as pool:
        ended = pool.compute(members, told)
    table, keys = tabulated(out, members, ended), keys_of(members)
    numeric = [key for key in keys if table[key].dtype.kind in "fiu" and table[key].nunique() > 1]
    found = sensitivities(table, numeric, outputs_of(table, keys)) if at_random else []
    progress.begin("report")
    write_table(table, out)
    write_sweep_page(out, case.title, members, table, keys, found)
    return table
