"""Work that does not end is ended."""

import itertools
import threading

import pytest

from pellucid.geometry.files.through_meshlane import TooLong, within


def test_what_ends_gives_its_result_or_its_error():
    assert within(5.0, lambda: 7) == 7
    with pytest.raises(ZeroDivisionError):
        within(5.0, lambda: 1 // 0)
    with pytest.raises(SystemExit):
        within(5.0, lambda: exit(1))


def test_a_loop_without_an_end_is_left():
    before = threading.active_count()

    def forever():
        for _ in itertools.count():
            pass

    with pytest.raises(TooLong):
        within(0.1, forever)
    assert threading.active_count() == before, "nothing goes on behind"


def test_a_file_whose_reader_waits_for_an_end_is_refused(tmp_path, monkeypatch):
    pytest.importorskip("meshlane")
    from pellucid.geometry.files import through_meshlane
    from pellucid.geometry.solid_meshes.file import SolidFile

    monkeypatch.setattr(through_meshlane, "LEAST_TIME", 0.3)
    (tmp_path / "a.mdpa").write_text("Begin Nodes\n 1 0 0 0\n")
    with pytest.raises(ValueError, match=r"a\.mdpa cannot be read as a mesh: its reader did not finish in"):
        SolidFile(path=str(tmp_path / "a.mdpa"))
