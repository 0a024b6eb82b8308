import sys
import warnings
from math import isnan

import pytest

from pellucid.progress import WINDOW, Pace, QuietProgress, TerminalProgress, WarningsOnly, clock, for_terminal

STATE = {"step": 12, "time": 0.5, "dt": 1e-3, "points": 2_500_000, "energy_error": 1e-4}


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(8.34, "8.3 s"), (125, "2 min 05 s"), (12000, "3 h 20 min"), (float("nan"), "?"), (float("inf"), "?")],
)
def test_times_are_told_for_people(seconds: float, text: str) -> None:
    assert clock(seconds) == text


def test_off_a_terminal_only_messages_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    progress = for_terminal()
    assert isinstance(progress, QuietProgress)
    for phase in ("setting up", "running"):
        progress.begin(phase, 1.0)
        progress.compiling("update_stress", 1, 0)
        progress.compiled()
    progress.update(**STATE)
    progress.count(3)
    progress.message("energy error above 2 %")
    progress.stop()
    assert capsys.readouterr() == ("", "compiling kernels (first run only) ...\nenergy error above 2 %\n")


def test_in_a_program_messages_are_warnings(capsys: pytest.CaptureFixture[str]) -> None:
    progress = WarningsOnly()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        progress.compiling("update_stress", 1, 0)
    with pytest.warns(UserWarning, match="no checkpoint"):
        progress.message("no checkpoint yet")
    assert capsys.readouterr() == ("", "")


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> TerminalProgress:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    for name, value in {"TERM": "xterm", "COLUMNS": "200", "FORCE_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)
    progress = for_terminal()
    assert isinstance(progress, TerminalProgress)
    return progress


def test_on_a_terminal_a_line_tells_all(terminal: TerminalProgress, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):  # one object serves several runs
        terminal.begin("running", 1.0)
        terminal.update(**STATE)
        terminal._bar.refresh()
        terminal.message("energy error [above] 2 %")
        terminal.begin("film", 26)
        terminal.count(13)
        terminal._bar.refresh()
    terminal.stop()
    told = capsys.readouterr().err
    for word in ("50%", "step 12", "t 0.5 s", "dt 0.001 s", "1.0e-04", "? left", "film", "13 of 26"):
        assert word in told
    assert "energy error [above] 2 %" in told


def test_there_is_one_bar_at_a_time(terminal: TerminalProgress) -> None:
    for phase in ("setting up", "running", "figures", "setting up", "running"):
        terminal.begin(phase, 1.0)
        assert [task.description for task in terminal._bar.tasks] == [phase]
    terminal.stop()
    assert not terminal._bar.tasks


def test_compilation_is_a_phase_within_others(
    terminal: TerminalProgress, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [100.0]
    monkeypatch.setattr("pellucid.progress.monotonic", lambda: now[0])
    terminal.begin("running", 1.0)
    now[0] += 2.0
    terminal.compiling("update_stress", 3, 14)
    (task,) = terminal._bar.tasks
    assert (task.description, task.fields["state"]) == ("compiling", "kernel 3 of 14, update_stress")
    now[0] += 40.0
    assert terminal._taken() == pytest.approx(40.0)
    terminal.compiled()
    (task,) = terminal._bar.tasks
    assert task.description == "running"
    now[0] += 1.0
    assert terminal._taken() == pytest.approx(3.0)
    terminal.begin("figures")
    now[0] += 5.0
    capsys.readouterr()
    terminal.stop()
    assert "running 3.0 s, compiling 40.0 s, figures 5.0 s" in capsys.readouterr().err


def test_more_kernels_than_expected_are_not_counted_against_fewer(terminal: TerminalProgress) -> None:
    terminal.begin("running", 1.0)
    terminal.compiling("update_stress", 15, 14)
    assert terminal._bar.tasks[0].fields["state"] == "kernel 15, update_stress"
    terminal.stop()


def test_the_pace_is_that_of_steps_since_the_last_compilation() -> None:
    """A step during which kernels are compiled takes more time than their compilation."""
    pace = Pace()
    assert isnan(pace.time_left(1.0))
    pace.add(0.0, 1, 0.01)
    pace.add(0.2, 2, 0.02)
    pace.start_again()
    pace.add(61.0, 3, 0.03)
    assert isnan(pace.time_left(1.0))
    for step in range(1, 11):
        pace.add(61.0 + 0.1 * step, 3 + step, 0.03 + 0.01 * step)
        assert pace.is_known == (step == 10)
    assert pace.steps_per_second() == pytest.approx(10.0)
    assert pace.time_left(1.13) == pytest.approx(10.0)


def test_one_slow_step_has_no_influence_on_the_typical_time_left() -> None:
    pace = Pace()
    assert isnan(pace.typical_time_left(1.0))
    for step in range(21):
        pace.add(0.1 * step + (30.0 if step >= 2 else 0.0), step, 0.01 * step)
    assert pace.typical_time_left(1.2) == pytest.approx(10.0)
    assert pace.time_left(1.2) > 100.0


def test_slow_steps_are_measured_over_more_than_the_window() -> None:
    pace = Pace()
    for step in range(30):
        pace.add(7.0 * step, step, 0.01 * step)
    assert pace.steps_per_second() == pytest.approx(1.0 / 7.0)
    assert len(pace._samples) == 11


def test_the_pace_is_that_of_the_last_seconds() -> None:
    pace = Pace()
    for second in range(100):  # at first a step takes a second, then a tenth
        pace.add(second, second if second < 50 else 50 + 10 * (second - 50), 0.0)
    assert pace.steps_per_second() == pytest.approx(10.0)
    assert len(pace._samples) <= WINDOW + 2
