import numpy as np
import pytest

from pellucid.results.storage.vtkhdf import StagedFile


@pytest.fixture
def raw(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(bytes(range(100)))
    with path.open("r+b", buffering=0) as file:
        yield file


def at(staged, offset, data):
    staged.seek(offset)
    return staged.write(memoryview(data))


def content(raw):
    raw.seek(0)
    return raw.read()


def test_changes_are_read_back_but_not_written(raw):
    staged = StagedFile(raw)
    at(staged, 10, b"abcd")
    at(staged, 12, b"XY")
    staged.seek(8)
    assert staged.read(8) == bytes([8, 9]) + b"abXY" + bytes([14, 15])
    assert staged.tell() == 16
    assert content(raw) == bytes(range(100))


def test_what_was_never_written_is_zero(raw):
    staged = StagedFile(raw)
    at(staged, 110, b"ab")
    staged.seek(98)
    assert staged.read(14) == bytes([98, 99]) + bytes(10) + b"ab"
    assert staged.seek(0, 2) == 112


def test_commit_writes_everything_and_the_size(raw):
    staged = StagedFile(raw)
    at(staged, 3, b"abc")
    at(staged, 90, b"end")
    staged.truncate(200)
    staged.commit()
    assert content(raw) == bytes([0, 1, 2]) + b"abc" + bytes(range(6, 90)) + b"end" + bytes(range(93, 100)) + bytes(100)


def test_commit_at_once_is_one_write(raw, monkeypatch):
    calls = []

    class Spy:
        def __getattr__(self, name):
            return getattr(raw, name)

        def write(self, data):
            calls.append(len(data))
            return raw.write(data)

    staged = StagedFile(Spy())
    at(staged, 50, b"abc")
    at(staged, 20, b"de")
    staged.commit_at_once()
    assert calls == [33]
    expected = np.arange(100, dtype=np.uint8)
    expected[50:53], expected[20:22] = list(b"abc"), list(b"de")
    assert content(raw) == expected.tobytes()
