"""Commands on cases: list, show, validate, schema."""

from typing import Annotated

import typer

from pellucid.commands.arguments import CaseArgument, Quick, Settings, print_table, read_case


def list_cases() -> None:
    """List the gallery: id, title, source, and wall-clock time of the quick and the full run on two cores."""
    import tomllib

    from pellucid import catalogue
    from pellucid.progress import clock

    rows = []
    for name in catalogue.ids():
        case = tomllib.loads(catalogue.text(name))  # as it stands: to build every case, with its surfaces, takes a while
        rows.append((name, case["title"], case["source"], clock(case["times"]["quick"]), clock(case["times"]["full"])))
    print_table(("id", "title", "source", "quick", "full"), rows)


def show(case: CaseArgument) -> None:
    """Print a case file, to copy and edit: pellucid show gan2011/shock-tube > mine.toml"""
    from pathlib import Path

    from pellucid import catalogue
    from pellucid.case import load

    if catalogue.has(case):
        typer.echo(catalogue.to_copy(case), nl=False)
    else:
        load(case)  # says what is wrong with it, or that it is not there
        typer.echo(Path(case).read_text(encoding="utf-8"), nl=False)


def validate(
    file: Annotated[str, typer.Argument(metavar="FILE.toml", help="The case file, or a gallery id.")],
    quick: Quick = False,
    settings: Settings = None,
) -> None:
    """Check a case file as a run does before its first step: keys, types, units, limits, names, places, memory, set-up.
    Print the time step, the number of steps and the run time. Exit status 2 if the case cannot be run."""
    from pellucid.case import located
    from pellucid.errors import CaseError
    from pellucid.progress import watching
    from pellucid.running.launch import try_set_up

    case = read_case(file, quick, settings)
    try:
        with watching() as progress:
            ahead = try_set_up(case, progress)
    except CaseError as error:
        raise located(error, file, quick, settings or ()) from None
    cells = f"grid of {' x '.join(map(str, case.grid.counts()))} cells" if case.grid_or_none else "no grid"
    bodies = ", ".join(body.name for body in case.body)
    typer.echo(f"{file} is valid: {case.title}; {cells}; bodies {bodies}; to t = {case.time.end:g} s")
    for line in ahead:
        typer.echo(line)


def schema(
    case: Annotated[
        str | None, typer.Argument(metavar="[CASE]", help="A case whose extensions are included in the schema.")
    ] = None,
) -> None:
    """Print the JSON schema of case files, for editors and other programs."""
    import json

    from pellucid.case import json_schema, load

    if case is not None:
        load(case)
    typer.echo(json.dumps(json_schema(), indent=2))


COMMANDS = (show, validate, schema)
