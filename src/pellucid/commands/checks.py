"""Commands that compare with references: verify, converge."""

from pathlib import Path
from typing import Annotated

import typer

from pellucid.commands.arguments import CaseArgument, Quick, Settings, Threads, number, print_metrics, print_table, read_case
from pellucid.errors import RunStopped, UsageError


def verify(
    cases: Annotated[
        list[str] | None,
        typer.Argument(metavar="[CASE|FILE]...", help="Gallery ids (default: all) or case files with checks."),
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="Run the full cases instead of their quick variants.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Keep the runs, with figures and reports, in DIR/CASE.")
    ] = None,
    threads: Threads = None,
) -> None:
    """Run cases and compare their metrics with references. Exit status 3 if a metric fails."""
    from pellucid import catalogue
    from pellucid.progress import watching
    from pellucid.studies.verification import verify as run_checks

    for name in cases or ():
        if not catalogue.has(name) and not name.endswith(".toml"):
            raise UsageError(f"The gallery has no case {name}.\n    {catalogue.suggestion(name)}")
    with watching() as progress:
        checks = run_checks(cases or list(catalogue.ids()), full=full, out=out, threads=threads, progress=progress)
    names = {"case": [check.case for check in checks], "metric": [check.name for check in checks]}
    print_metrics(names, [check.metric for check in checks])
    short = [check for check in checks if not check.metric.passed]
    for check in short:
        typer.echo(f"{check.case}: {check.name}: {check.metric.meaning}", err=True)
    if short:
        raise RunStopped(f"{len(short)} of {len(checks)} metrics failed: their errors exceed the tolerances")
    typer.echo(f"all {len(checks)} metrics pass")


def converge(
    case: CaseArgument,
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="KEY=V1,V2,...",
            help="A key and its values; a second --over varies with the first, value by value.",
        ),
    ],
    metric: Annotated[str, typer.Option("--metric", metavar="NAME", help="The metric whose error is studied.")],
    quick: Quick = False,
    settings: Settings = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Keep the runs here, with convergence.csv and a figure.")
    ] = None,
    threads: Threads = None,
) -> None:
    """Run a case for several values of a key; print a metric's error, the ratio of errors and the observed order."""
    from pellucid.progress import watching
    from pellucid.studies.verification import observed_order, read_sweep, study, write_study

    sweep = read_sweep(over)
    base = read_case(case, quick, settings, {key: values[0] for key, values in sweep.items()})
    with watching() as progress:
        steps = study(base, sweep, metric, out, threads, progress)
    key = next(iter(sweep))
    rows = [(str(step.value), number(step.error), number(step.ratio), number(step.order)) for step in steps]
    print_table((key, f"error of {metric}", "ratio", "order"), rows)
    order = observed_order(steps)
    if order is not None:
        typer.echo(f"observed order of convergence (least squares over all values): {order:.2f}")
    if out:
        write_study(steps, key, metric, out)
        typer.echo(f"written: {out / 'convergence.csv'}, {out / 'convergence.png'}")


COMMANDS = (verify, converge)
