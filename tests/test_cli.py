import re
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.errors import Interrupted, RunStopped

COMMANDS = (
    "list",
    "show",
    "validate",
    "run",
    "resume",
    "verify",
    "converge",
    "sweep",
    "fit",
    "bench",
    "report",
    "view",
    "schema",
    "doctor",
)
HEAVY = ("numba", "h5py", "scipy", "matplotlib", "pint")


@pytest.mark.parametrize("arguments", [["--help"], ["show", "gan2011/shock-tube"], ["list"]])
def test_light_commands_import_nothing_heavy(arguments: list[str]) -> None:
    """Which is what makes them fast."""
    source = (
        "import sys\nfrom pellucid.cli import app\n"
        f"try: app({arguments!r})\nexcept SystemExit as end: status = end.code\n"
        f"sys.exit(status or int(any(name in sys.modules for name in {HEAVY!r})))"
    )
    subprocess.run([sys.executable, "-c", source], check=True, capture_output=True)


def test_the_package_itself_imports_nothing_heavy() -> None:
    source = f"import sys, pellucid; pellucid.Case; sys.exit(any(name in sys.modules for name in {HEAVY!r}))"
    subprocess.run([sys.executable, "-c", source], check=True)


def test_every_command_of_the_contract_is_there_and_has_help() -> None:
    for command in COMMANDS:
        result = CliRunner().invoke(app, [command, "--help"])
        assert result.exit_code == 0, command
        assert "Usage" in result.stdout


def test_the_version_is_printed() -> None:
    assert CliRunner().invoke(app, ["--version"]).stdout.startswith("pellucid 0.")


@pytest.mark.parametrize("arguments", [["fly"], ["run"], ["run", "basics/sod", "--threads", "0"], ["validate", "--fast"]])
def test_a_bad_argument_ends_with_status_2(arguments: list[str]) -> None:
    assert CliRunner().invoke(app, arguments).exit_code == 2


@pytest.mark.parametrize("number", ["0", "two", "-1", "2.5", "1000000"])
def test_a_bad_number_of_threads_is_told_with_limit_and_remedy(number: str) -> None:
    result = CliRunner().invoke(app, ["run", "basics/sod", "--threads", number])
    assert result.exit_code == 2
    told = re.sub("'", "", result.stderr)
    assert re.search(
        rf"threads = {number} must be a whole number from 1 to \d+, .*; omit it, so that a run finds the fastest number", told
    )


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (RunStopped("point 7 of body driver left the grid"), 3),
        (Interrupted("resume with `pellucid resume runs/x`"), 143),
        (Interrupted("resume with `pellucid resume runs/x`", by_keyboard=True), 130),
        (KeyboardInterrupt(), 130),
    ],
)
def test_errors_become_a_message_and_a_status(
    error: BaseException, status: int, monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    import pellucid.running.launch

    def fail(*_args: object, **_options: object) -> None:
        raise error

    monkeypatch.setattr(pellucid.running.launch, "run_case", fail, raising=False)
    result = CliRunner().invoke(app, ["run", "basics/sod", "--quick", "--out", f"{tmp_path}/out"])
    assert result.exit_code == status
    assert str(error) in result.stderr
    assert "Traceback" not in result.stderr
