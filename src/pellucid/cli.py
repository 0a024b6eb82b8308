"""The command line: `pellucid COMMAND`. Slow imports are inside the commands that need them."""

import errno
import warnings
from typing import Any

import typer
from typer.core import TyperGroup

from pellucid.commands import cases, checks, machine, meshes, runs
from pellucid.errors import PellucidError, Terminated, printable
from pellucid.system.interrupts import termination_raised


class Commands(TyperGroup):
    """The commands, with warnings in a line each, and every expected error turned into a message and an exit status."""

    def invoke(self, ctx: Any) -> Any:
        try:
            with warnings.catch_warnings(), termination_raised():
                warnings.showwarning = lambda message, *_where, **_to: typer.echo(f"warning: {message}", err=True)
                return super().invoke(ctx)
        except PellucidError as error:
            typer.echo("\n    ".join([f"pellucid: {error}", *getattr(error, "__notes__", ())]), err=True)
            raise typer.Exit(error.exit_status) from None
        except KeyboardInterrupt as error:
            typer.echo("pellucid: interrupted", err=True)
            raise typer.Exit(143 if isinstance(error, Terminated) else 130) from None
        except OSError as error:
            if error.errno == errno.EPIPE:  # whoever reads the output has left: typer ends in silence
                raise
            place = f"{error.filename}: " if error.filename else ""
            reason = f"{place}{error.strerror or error or type(error).__name__}"
            typer.echo(f"pellucid: {printable(reason)}\n    mend this, and give the command again", err=True)
            raise typer.Exit(3) from None


app = typer.Typer(
    name="pellucid",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Membranes, fluids and soft tissue with particles. A CASE is a gallery id (gan2011/shock-tube) or TOML file.",
)


def _version(wanted: bool) -> None:
    if wanted:
        from pellucid import __version__

        typer.echo(f"pellucid {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version and leave."),
) -> None:
    """Options before the command."""


for _module in (cases, meshes, runs, checks, machine):
    _module.register(app)


def main() -> None:
    """Run the command line of this process."""
    app()
