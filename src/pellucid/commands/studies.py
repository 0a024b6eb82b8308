"""Commands that run a case many times: sweep, fit."""

from pathlib import Path
from typing import Annotated

import typer

from pellucid.commands.arguments import CaseArgument, Quick, Settings, Threads, Until, read_case, read_time
from pellucid.commands.table import print_table
from pellucid.errors import Interrupted, RunStopped, Terminated

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
        typer.Option("--out", metavar="DIR", help="Folder of the sweep (default: sweeps/NAME); it is gone on with."),
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
    from pellucid.studies.ranges import read_rows, read_values
    from pellucid.studies.samples import rows_of
    from pellucid.studies.sweep import run_sweep

    base = read_case(case, quick, settings)
    rows = rows_of(base, read_values(over or []), samples, read_rows(listed) if listed else (), seed)
    by = Workers(workers, threads, scheduler, read_slurm(slurm))
    folder = out or Path("sweeps") / (Path(case).stem if case.endswith(".toml") else case.rpartition("/")[2])
    try:
        with watching() as progress:
            table = run_sweep(base, rows, folder, read_time("--until", until), by, progress, samples is not None)
    except KeyboardInterrupt as error:
        text = f"interrupted; the same command goes on with the members in {folder}"
        raise Interrupted(text, not isinstance(error, Terminated)) from None
    shown = table[[name for name in table.columns if name not in ("steps", "message")][:8]]
    print_table(list(shown.columns), [[_cell(value) for value in row] for row in shown.itertuples(index=False, name=None)])
    typer.echo(f"written: {folder / 'members.csv'}, {folder / 'members.parquet'}, {folder / 'report.html'}")
    if failed := int((table["state"] != DONE).sum()):
        raise RunStopped(f"{failed} of {len(table)} members failed: see {folder / 'members.csv'}")


def _cell(value: object) -> str:
    return value if isinstance(value, str) else f"{value:.5g}" if isinstance(value, (int, float)) and value == value else ""


COMMANDS = (sweep,)
