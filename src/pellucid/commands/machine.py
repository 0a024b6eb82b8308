"""Commands about this machine: bench, doctor, warm."""

from typing import Annotated

import typer

from pellucid.commands.arguments import Threads, console, print_table
from pellucid.errors import UsageError
from pellucid.jit import cache_folder


def bench(
    json_: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    points: Annotated[
        str | None, typer.Option("--points", metavar="N,N,...", help="Numbers of points (default: 1e4 to 4e6).")
    ] = None,
    peers: Annotated[
        bool, typer.Option("--peers", help="Also run the programs in benchmarks/peers that are installed.")
    ] = False,
    threads: Threads = None,
) -> None:
    """Measure point-steps per second for fluid and solid bodies and the memory bandwidth of this machine."""
    sizes = read_sizes(points)

    import json

    from pellucid.bench import bench as measure
    from pellucid.bench import table

    result = measure(sizes, threads=threads, peers=peers)
    if json_:
        typer.echo(json.dumps(result, indent=2))
    else:
        console().print(table(result))


def read_sizes(text: str | None) -> list[int] | None:
    """Return numbers of points from a text such as "10000,1e6". Raises UsageError for an invalid text."""
    if text is None:
        return None
    try:
        sizes = [round(float(item)) for item in text.split(",")]
    except (ValueError, OverflowError):
        raise UsageError(
            f"--points {text}: not a list of numbers\n    Write numbers separated by commas, such as 10000,1e6."
        ) from None
    if min(sizes) < 1:
        raise UsageError(f"--points {text}: every number must be at least 1")
    return sizes


def doctor() -> None:
    """Check this machine: versions, threads, kernel cache, drawing, memory, disk."""
    from pellucid.doctor import examine

    print_table(("what", "found", "advice"), examine())


def warm(
    cases: Annotated[
        list[str] | None, typer.Argument(metavar="[CASE]...", help="Gallery ids or TOML files (default: the whole gallery).")
    ] = None,
) -> None:
    """Compile the kernels of cases into the cache, so that later runs start without compilation."""
    from pellucid import catalogue
    from pellucid.case import load
    from pellucid.compilation.ahead import warm as compile_all
    from pellucid.progress import clock, watching

    loaded = {name: load(name) for name in cases or catalogue.ids()}
    with watching() as progress:
        found = compile_all(loaded, progress)
    print_table(("case", "kernels compiled", "time"), [(one.case, str(one.kernels), clock(one.seconds)) for one in found])
    troubles = [f"{one.case}: {one.trouble}" for one in found if one.trouble]
    if troubles:
        raise UsageError("\n".join(troubles))
    typer.echo(f"the kernels are in {cache_folder()}")


COMMANDS = (bench, doctor, warm)
