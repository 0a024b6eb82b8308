"""Commands that run a case many times: sweep, fit."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from pellucid.commands.arguments import CaseArgument, Quick, Settings, Threads, Until, read_case, read_time
from pellucid.commands.table import print_table
from pellucid.errors import Interrupted, RunStopped, Terminated, UsageError

WorkersOption = Annotated[
    int | None, typer.Option("--workers", metavar="N", min=1, help="Members that run at once here (default: one a core).")
]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Run members on a dask cluster, such as tcp://head:8786.")
]
Slurm = Annotated[
    str | None,
    typer.Option("--slurm", metavar="KEY=VALUE,...", help="Run members as jobs of Slurm: queue=short,cores=8,memory=16GB,..."),
]


@contextmanager
def _gone_on_with(folder: Path) -> Iterator[None]:
    """Add to an interruption the command that continues."""
    try:
        yield
    except KeyboardInterrupt as error:
        text = f"interrupted; the same command goes on with the members in {folder}"
        raise Interrupted(text, not isinstance(error, Terminated)) from None


def sweep(
    case: CaseArgument,
    over: Annotated[
        list[str] | None,
        typer.Option("--over", metavar="KEY=V1,V2,...", help="A field and its values, or KEY=LOW:HIGH with --samples."),
    ] = None,
    samples: Annotated[
        int | None, typer.Option("--samples", metavar="N", help="Draw N members as a Latin hypercube, not every combination.")
    ] = None,
    listed: Annotated[
        Path | None, typer.Option("--from", metavar="TABLE.csv", help="Settings: a row of keys, a row for each member.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of the Latin hypercube.")] = 0,
    quick: Quick = False,
    settings: Settings = None,
    until: Until = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder of the sweep (default: sweeps/NAME); an existing sweep continues."),
    ] = None,
    threads: Threads = None,
    workers: WorkersOption = None,
    scheduler: Scheduler = None,
    slurm: Slurm = None,
) -> None:
    """Run a case for many values of its fields; one table and one report. Status 3 if a member fails.
    The same command goes on where it was broken off."""
    from pellucid.progress import watching
    from pellucid.studies.members import DONE
    from pellucid.studies.pool import Workers, read_slurm
    from pellucid.studies.ranges import read_rows, read_values, with_units
    from pellucid.studies.samples import rows_of
    from pellucid.studies.sweep import run_sweep

    values, members = read_values(over or []), read_rows(listed) if listed else []
    first = {key: several[0] for key, several in values.items()}
    base = read_case(case, quick, settings, members[0] if members else first)
    rows = rows_of(base, values, samples, members, seed)
    by = Workers(workers, threads, scheduler, read_slurm(slurm))
    folder = out or Path("sweeps") / _name(case)
    with _gone_on_with(folder), watching() as progress:
        table = run_sweep(base, rows, folder, read_time("--until", until), by, progress, samples is not None)
    shown = table[[name for name in table.columns if name not in ("steps", "message")][:8]]
    print_table(
        with_units(list(shown.columns), table.attrs["units"]),
        [[_cell(value) for value in row] for row in shown.itertuples(index=False, name=None)],
    )
    typer.echo(f"written: {folder / 'members.csv'}, {folder / 'members.parquet'}, {folder / 'report.html'}")
    if failed := int((table["state"] != DONE).sum()):
        raise RunStopped(f"{failed} of {len(table)} members failed: see {folder / 'members.csv'}")


def fit(
    case: CaseArgument,
    measured: Annotated[
        list[Path],
        typer.Option("--measured", metavar="FILE.csv", help="A measured curve, with a row of units; may be given often."),
    ],
    probe: Annotated[list[str], typer.Option("--probe", metavar="NAME", help="The probe of each --measured, in their order.")],
    free: Annotated[
        list[str],
        typer.Option("--free", metavar="KEY=LOW:HIGH", help="A field to estimate, and its range; may be given often."),
    ],
    deviation: Annotated[
        list[str] | None,
        typer.Option("--deviation", metavar="VALUE", help='Standard deviation, "0.1 mN": of each --measured, or of all.'),
    ] = None,
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="least-squares, or optuna for rough misfits.")] = (
        "least-squares"
    ),
    trials: Annotated[
        int | None, typer.Option("--trials", metavar="N", help="Most steps of least squares (50), or runs of optuna (100).")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of optuna.")] = 0,
    quick: Quick = False,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder of the fit (default: fits/NAME); an existing fit continues."),
    ] = None,
    threads: Threads = None,
    workers: WorkersOption = None,
    scheduler: Scheduler = None,
    slurm: Slurm = None,
) -> None:
    """Find the values of fields with which a case follows measured curves; print them with 95 % intervals.
    The same command goes on where it was broken off."""
    from pellucid.progress import watching
    from pellucid.studies.fit import run_fit
    from pellucid.studies.measured import read_curve
    from pellucid.studies.pool import Workers, read_slurm
    from pellucid.studies.ranges import range_of, read_ends, split_setting

    ends = {}
    for text in free:
        key, values = split_setting("--free", text, "KEY=LOW:HIGH, for example body.tissue.material.young_modulus=1kPa:50kPa")
        ends[key] = read_ends("--free", text, values)
    base = read_case(case, quick, settings, {key: low for key, (low, _) in ends.items()})
    if len(probe) != len(measured):
        raise UsageError(f"{len(measured)} --measured and {len(probe)} --probe: give each curve its probe")
    given: list[str | None] = [*deviation] if deviation else [None]
    stated = given * len(measured) if len(given) == 1 else given
    if len(stated) != len(measured):
        raise UsageError(f"{len(measured)} --measured and {len(stated)} --deviation: give one for each curve, or one for all")
    curves = [read_curve(file, name, base, spread) for file, name, spread in zip(measured, probe, stated, strict=True)]
    ranges = {key: range_of(base, key, *pair, option="--free") for key, pair in ends.items()}
    by = Workers(workers, threads, scheduler, read_slurm(slurm))
    folder = out or Path("fits") / _name(case)
    with _gone_on_with(folder), watching() as progress:
        found = run_fit(base, curves, ranges, folder, by, progress, method, trials, seed)
    rows = [(key, f"{one.value:.5g}", f"{one.low:.5g}", f"{one.high:.5g}", one.unit) for key, one in found.estimates.items()]
    print_table(("parameter", "estimate", "95 % from", "to", "unit"), rows)
    typer.echo(f"sum of squares over its degrees of freedom: {found.chi_square:.4g}")
    typer.echo(f"written: {folder / 'estimates.json'}, {folder / 'fitted.toml'}, {folder / 'report.html'}")


def _name(case: str) -> str:
    return Path(case).stem if case.endswith(".toml") else case.rpartition("/")[2]


def _cell(value: object) -> str:
    return value if isinstance(value, str) else f"{value:.5g}" if isinstance(value, (int, float)) and value == value else ""


COMMANDS = (sweep, fit)
