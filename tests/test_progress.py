import sys

import pytest

from pellucid.progress import QuietProgress, TerminalProgress, clock, for_terminal

STATE = {"step": 12, "time": 0.5, "dt": 1e-3, "rate": 2.5e7, "energy_error": 1e-4, "eta": 75.0}


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(8.34, "8.3 s"), (125, "2 min 05 s"), (12000, "3 h 20 min"), (float("nan"), "?"), (float("inf"), "?")],
)
def test_times_are_told_for_people(seconds: float, text: str) -> None:
    assert clock(seconds) == text


def test_off_a_terminal_only_messages_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    progress = for_terminal()
    assert isinstance(progress, QuietProgress)
    progress.start(1.0)
    progress.update(**STATE)
    progress.message("compiling kernels (first run only) ...")
    progress.stop()
    assert capsys.readouterr() == ("", "compiling kernels (first run only) ...\n")


def test_on_a_terminal_a_line_tells_all(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    for name, value in {"TERM": "xterm", "COLUMNS": "200", "FORCE_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)
    progress = for_terminal()
    assert isinstance(progress, TerminalProgress)
    for _ in range(2):  # one object serves several runs
        progress.start(1.0)
        progress.update(**STATE)
        progress.message("energy error [above] 2 %")
        progress.stop()
    progress.stop()
    told = capsys.readouterr().err
    for word in ("50%", "step 12", "t 0.5 s", "dt 0.001 s", "25 M point-steps/s", "1.0e-04", "1 min 15 s left"):
        assert word in told
    assert "energy error [above] 2 %" in told
