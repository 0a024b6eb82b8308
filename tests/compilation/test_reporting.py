from time import monotonic

import pytest

from pellucid.compilation.reporting import compilation_told
from pellucid.progress import QuietProgress


class Record(QuietProgress):
    def __init__(self) -> None:
        self.told: list[object] = []

    def compiling(self, kernel: str, number: int, expected: int) -> None:
        self.told.append((kernel, number, expected))

    def compiled(self) -> None:
        self.told.append("compiled")


def compile_two() -> None:
    """A kernel that calls another, and one alone."""
    numba = pytest.importorskip("numba")
    if numba.config.DISABLE_JIT:
        pytest.skip("nothing is compiled")

    @numba.njit
    def inner(x):
        return x + 1.0

    @numba.njit
    def _outer(x):
        return inner(x) * 2.0

    @numba.njit
    def alone(x):
        return x

    assert _outer(1.0) == 4.0
    assert alone(1.0) == 1.0
    assert alone(2.0) == 2.0


def test_each_kernel_is_told_once_with_how_many_there_were_before(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for expected in (0, 3):
        record = Record()
        begun = monotonic()
        with compilation_told(record, "key") as seconds:
            assert seconds() == 0.0
            compile_two()
        assert 0.0 < seconds() < monotonic() - begun
        assert record.told == [("outer", 1, expected), "compiled", ("alone", 3, expected), "compiled"]


def test_a_cache_that_cannot_be_written_stops_nothing(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    record = Record()
    with compilation_told(record, "key"):
        compile_two()
    assert len(record.told) == 4
