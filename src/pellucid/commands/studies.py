"""Commands that run a case many times: sweep, fit."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from pellucid.commands.arguments import CaseArgument, Quick, Settings, Threads, Until, print_table, read_case, read_time
from pellucid.errors import Interrupted, RunStopped, Terminated, UsageError

WorkersOption = Annotated[
    int | None,
    typer.Option(
        "--workers",
        metavar="N",
        min=1,
        help="Number of members that run at the same time on this machine (default: one per core).",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Run the members on a dask cluster, such as tcp://head:8786."),
]
Slurm = Annotated[
    str | None,
    typer.Option("--slurm", metavar="KEY=VALUE,...", help="Run the members as Slurm jobs: queue=short,cores=8,memory=16GB,..."),
]


@contextmanager
def _gone_on_with(folder: Path) -> Iterator[None]:
    """Add the command that continues the study in `folder` to the message of an interruption in the block."""
    try:
        yield
    except KeyboardInterrupt as error:
        text = f"Interrupted; the finished members are in {folder}.\n    Run the same command again to continue."
        raise Interrupted(text, not isinstance(error, Terminated)) from None


def sweep(
    case: CaseArgument,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over", metavar="KEY=V1,V2,...", help="A key and its values, or KEY=LOW:HIGH with --samples; can be repeated."
        ),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option("--samples", metavar="N", help="Draw N members as a Latin hypercube sample instead of all combinations."),
    ] = None,
    listed: Annotated[
        Path | None,
        typer.Option("--from", metavar="TABLE.csv", help="Table of settings: a row of keys, then a row for each member."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the Latin hypercube.")] = 0,
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
    """Run a case for many values of its keys and write one table and one report. Exit status 3 if a member fails.
    An interrupted sweep continues when the same command is run again."""
    from pellucid.progress import watching
    from pellucid.studies.members import DONE
    from pellucid.studies.pool import read_slurm
    from pellucid.studies.ranges import read_rows, read_values, with_units
    from pellucid.studies.sweep import sweep as run_members

    values, members = read_values(over or []), read_rows(listed) if listed else []
    first = {key: several[0] for key, several in values.items()}
    base = read_case(case, quick, settings, members[0] if members else first)
    by: dict[str, Any] = {"workers": workers, "threads": threads, "scheduler": scheduler, "slurm": read_slurm(slurm)}
    end, folder = read_time("--until", until), out or Path("sweeps") / _name(case)
    with _gone_on_with(folder), watching() as progress:
        table = run_members(
            base, values, samples=samples, rows=members, seed=seed, out=folder, until=end, progress=progress, **by
        )
    shown = table[[name for name in table.columns if name not in ("steps", "message")][:8]]
    print_table(
        with_units(list(shown.columns), table.attrs["units"]),
        [[_cell(value) for value in row] for row in shown.itertuples(index=False, name=None)],
    )
    typer.echo(f"written: {folder / 'members.csv'}, {folder / 'members.parquet'}, {folder / 'report.html'}")
    if failed := int((table["state"] != DONE).sum()):
        raise RunStopped(f"{failed} of {len(table)} members failed; the column `message` of {folder / 'members.csv'} lists why")


def fit(
    case: CaseArgument,
    measured: Annotated[
        list[Path],
        typer.Option("--measured", metavar="FILE.csv", help="A measured curve, with a row of units; can be repeated."),
    ],
    probe: Annotated[
        list[str], typer.Option("--probe", metavar="NAME", help="Probe that belongs to each --measured, in the same order.")
    ],
    free: Annotated[
        list[str],
        typer.Option("--free", metavar="KEY=LOW:HIGH", help="A key to estimate and its range; can be repeated."),
    ],
    deviation: Annotated[
        list[str] | None,
        typer.Option(
            "--deviation", metavar="VALUE", help='Standard deviation such as "0.1 mN": one for each --measured, or one for all.'
        ),
    ] = None,
    method: Annotated[
        str, typer.Option("--method", metavar="NAME", help="least-squares, or optuna if the misfit is not smooth.")
    ] = ("least-squares"),
    trials: Annotated[
        int | None,
        typer.Option(
            "--trials", metavar="N", help="Largest number of least-squares steps (default 50) or optuna runs (default 100)."
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of optuna.")] = 0,
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
    """Fit values of keys to measured curves; print the estimates with 95 % confidence intervals.
    An interrupted fit continues when the same command is run again."""
    from pellucid.progress import watching
    from pellucid.studies.fit import run_fit
    from pellucid.studies.misfit import read_curve
    from pellucid.studies.pool import Workers, read_slurm
    from pellucid.studies.ranges import range_of, read_ends, split_setting

    ends = {}
    for text in free:
        key, values = split_setting("--free", text, "KEY=LOW:HIGH, for example body.tissue.material.young_modulus=1kPa:50kPa")
        ends[key] = read_ends("--free", text, values)
    base = read_case(case, quick, settings, {key: low for key, (low, _) in ends.items()})
    if len(probe) != len(measured):
        raise UsageError(
            f"{len(measured)} --measured and {len(probe)} --probe were given.\n    Add one --probe for each --measured."
        )
    given: list[str | None] = [*deviation] if deviation else [None]
    stated = given * len(measured) if len(given) == 1 else given
    if len(stated) != len(measured):
        raise UsageError(
            f"{len(measured)} --measured and {len(stated)} --deviation were given.\n    Add one for each curve, or one for all."
        )
    curves = [read_curve(file, name, base, spread) for file, name, spread in zip(measured, probe, stated, strict=True)]
    ranges = {key: range_of(base, key, *pair, option="--free") for key, pair in ends.items()}
    by = Workers(workers, threads, scheduler, read_slurm(slurm))
    folder = out or Path("fits") / _name(case)
    with _gone_on_with(folder), watching() as progress:
        found = run_fit(base, curves, ranges, folder, by, progress, method, trials, seed)
    rows = [(key, f"{one.value:.5g}", f"{one.low:.5g}", f"{one.high:.5g}", one.unit) for key, one in found.estimates.items()]
    print_table(("key", "estimate", "95 % from", "to", "unit"), rows)
    typer.echo(f"sum of squared residuals per degree of freedom: {found.chi_square:.4g}")
    typer.echo(f"written: {folder / 'estimates.json'}, {folder / 'fitted.toml'}, {folder / 'report.html'}")


def _name(case: str) -> str:
    return Path(case).stem if case.endswith(".toml") else case.rpartition("/")[2]


def _cell(value: object) -> str:
    return value if isinstance(value, str) else f"{value:.5g}" if isinstance(value, (int, float)) and value == value else ""


COMMANDS = (sweep, fit)
