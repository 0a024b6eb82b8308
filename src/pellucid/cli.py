"""The command line: `pellucid COMMAND`. Slow imports are inside the commands that need them."""

import errno
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from pellucid.commands import cases, checks, machine, meshes, runs, studies
from pellucid.errors import PellucidError, Terminated, printable
from pellucid.ranks.group import processes
from pellucid.system.interrupts import termination_raised


class Commands(TyperGroup):
    """Group of the commands of `pellucid`: prints each warning on one line, and turns every expected error into a message
    and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            processes.join()
            with warnings.catch_warnings(), termination_raised():
                warnings.showwarning = lambda message, *_where, **_to: typer.echo(f"warning: {message}", err=True)
                if not processes.is_first:
                    warnings.simplefilter("ignore")
                return super().invoke(ctx)
        except PellucidError as error:
            message = "\n    ".join([f"pellucid: {error}", *getattr(error, "__notes__", ())])
            raise _end(error, message, error.exit_status) from None
        except KeyboardInterrupt as error:
            raise _end(error, "pellucid: interrupted", 143 if isinstance(error, Terminated) else 130) from None
        except OSError as error:
            if error.errno == errno.EPIPE:  # whoever reads the output has left: typer ends in silence
                raise
            place = f"{error.filename}: " if error.filename else ""
            reason = f"{place}{error.strerror or error or type(error).__name__}"
            raise _end(error, f"pellucid: {printable(reason)}\n    Correct this and run the command again.", 3) from None


def _end(error: BaseException, message: str, status: int) -> typer.Exit:
    """Print the reason why the command ends, only once if all processes of a run end for the same reason, and return the
    exception that exits with this status.

    error: error that ends the command; message: text printed for the user; status: exit status.
    """
    processes.end(error)
    if processes.is_first:
        typer.echo(message, err=True)
    return typer.Exit(status)


app = typer.Typer(
    name="pellucid",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Simulate membranes, fluids and soft tissue with particles. CASE: a gallery id (gan2011/shock-tube) or a TOML file.",
)


def _version(wanted: bool) -> None:
    if wanted:
        from pellucid import __version__

        typer.echo(f"pellucid {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version and exit."),
) -> None:
    """Define the options that precede the command, such as `--version`."""


app.command("list")(cases.list_cases)
for _module in (cases, meshes, runs, checks, studies, machine):
    for _command in _module.COMMANDS:
        app.command()(_command)


def main() -> None:
    """Run the command line of this process; an unexpected error also ends the other processes of the run."""
    try:
        app()
    except Exception as error:
        processes.end(error)
        raise
