import pytest

from pellucid.errors import CaseError, Interrupted, PellucidError, Problem, RunStopped, UsageError, shown


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (CaseError("bad"), 2),
        (UsageError("bad"), 2),
        (RunStopped("NaN at point 3"), 3),
        (Interrupted(), 143),
        (Interrupted(by_keyboard=True), 130),
    ],
)
def test_every_error_knows_its_exit_status(error: PellucidError, status: int) -> None:
    assert error.exit_status == status
    assert isinstance(error, PellucidError)


def test_a_case_error_names_file_line_key_value_limit_and_remedy() -> None:
    problem = Problem("must be greater than 0 m", key="grid.cell", value=-1.0, remedy="use 0.01", line=7)
    assert str(CaseError(problem, "my.toml")) == ("my.toml:7: grid.cell = -1.0\n    must be greater than 0 m\n    use 0.01")


def test_several_problems_are_counted_and_listed() -> None:
    message = str(CaseError([Problem("one", line=1), Problem("two", line=2)], "my.toml"))
    assert message.splitlines() == ["2 errors in my.toml:", "my.toml:1: one", "my.toml:2: two"]


def test_a_setting_is_named_instead_of_a_line() -> None:
    error = CaseError(Problem("too small", key="grid.cell", value=-1), "my.toml").blame("--set grid.cell=-1")
    assert str(error) == "--set grid.cell=-1: too small"


@pytest.mark.parametrize(
    ("value", "text"),
    [("a", '"a"'), (True, "true"), ([1, 2.5], "[1, 2.5]"), ({"a": [1]}, "{ a = [1] }"), (list(range(99)), None)],
)
def test_values_are_shown_as_users_write_them(value: object, text: str | None) -> None:
    assert shown(value) == text if text else len(shown(value)) <= 60
