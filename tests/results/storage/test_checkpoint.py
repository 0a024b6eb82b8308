import os
import resource
import time

import numpy as np
import pytest
from endless_writers import arrays, write_checkpoints
from other_processes import killed_at_last

from pellucid.results.storage import checkpoint
from pellucid.results.storage.files import OutputError

NUMBERS = {"time": 0.1 + 0.2, "steps": 12, "name": "µ", "nested": {"tiny": 5e-324}}


def written(folder):
    return sorted(folder.glob("*.npz"))


def test_comes_back_bit_for_bit(tmp_path):
    checkpoint.write(tmp_path, arrays(1), NUMBERS)
    found, numbers = checkpoint.read_latest(tmp_path)
    assert numbers == NUMBERS
    for name, array in arrays(1).items():
        assert found[name].dtype == array.dtype
        assert found[name].tobytes() == array.tobytes()


def test_without_any_there_is_none(tmp_path):
    assert checkpoint.read_latest(tmp_path / "checkpoint") is None


def test_the_last_two_are_kept(tmp_path):
    for step in range(5):
        checkpoint.write(tmp_path, arrays(step), {"step": step})
    assert len(list(tmp_path.iterdir())) == 2
    assert checkpoint.read_latest(tmp_path)[1] == {"step": 4}


def write_in_parts(folder, serial):
    rows = np.arange(12.0).reshape(6, 2) + serial
    parts = [
        checkpoint.write_part(folder, {"a": rows[2:3]}, 1, serial),
        checkpoint.write_part(folder, {"a": rows[3:]}, 2, serial),
    ]
    checkpoint.write(folder, {"a": rows[:2], "b": rows}, {"serial": serial}, parts, serial)
    return rows


def test_parts_are_joined(tmp_path):
    rows = write_in_parts(tmp_path, checkpoint.next_serial(tmp_path))
    found, numbers = checkpoint.read_latest(tmp_path)
    assert numbers == {"serial": 1}
    assert np.array_equal(found["a"][:], rows)
    for begin, end in ((1, 3), (0, 2), (3, 6), (2, 2)):
        assert np.array_equal(found["a"][begin:end], rows[begin:end])
    assert np.array_equal(found["b"], rows)


def test_parts_go_with_their_checkpoint(tmp_path):
    for serial in range(1, 5):
        write_in_parts(tmp_path, serial)
    assert {path.name[:6] for path in tmp_path.iterdir()} == {"000003", "000004"}
    assert len(list(tmp_path.iterdir())) == 6
    assert {*checkpoint.files(tmp_path)} >= {*tmp_path.iterdir()}


def test_with_a_damaged_part_the_one_before_is_taken(tmp_path):
    write_in_parts(tmp_path, 1)
    write_in_parts(tmp_path, 2)
    next(tmp_path.glob("000002-1-*")).write_bytes(b"no part")
    with pytest.warns(UserWarning, match="is damaged"):
        assert checkpoint.read_latest(tmp_path)[1] == {"serial": 1}


@pytest.mark.parametrize("at", [0, 200, -100])
def test_a_damaged_one_is_passed_over(tmp_path, at):
    for step in range(2):
        checkpoint.write(tmp_path, arrays(step), {"step": step})
    newest = written(tmp_path)[-1]
    data = bytearray(newest.read_bytes())
    data[at] ^= 1
    newest.write_bytes(data)
    with pytest.warns(UserWarning, match="is damaged.*the previous one is used"):
        found, numbers = checkpoint.read_latest(tmp_path)
    assert numbers == {"step": 0}
    assert np.array_equal(found["gas/position"], arrays(0)["gas/position"])
    checkpoint.write(tmp_path, arrays(7), {"step": 7})
    assert len(written(tmp_path)) == 2, "the damaged one does not count among the last two"


def test_a_cut_off_one_is_passed_over(tmp_path):
    for step in range(2):
        checkpoint.write(tmp_path, arrays(step), {"step": step})
    os.truncate(written(tmp_path)[-1], 500)
    told: list[str] = []
    assert checkpoint.read_latest(tmp_path, told.append)[1] == {"step": 0}
    assert "checksum" in told[0]


def test_when_all_are_damaged_nothing_is_made_up(tmp_path):
    checkpoint.write(tmp_path, arrays(1), NUMBERS)
    written(tmp_path)[0].write_bytes(b"")
    with pytest.raises(OutputError, match="all checkpoints"), pytest.warns(UserWarning, match="damaged"):
        checkpoint.read_latest(tmp_path)


def test_a_full_disk_ends_in_a_message_and_intact_checkpoints(tmp_path):
    folder = tmp_path / "checkpoint"
    checkpoint.write(folder, arrays(1), NUMBERS)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limits[1]))  # as a disk with no more room
    try:
        with pytest.raises(OutputError, match=r"cannot write the results.*\n.*earlier checkpoints are intact"):
            checkpoint.write(folder, arrays(2, size=5000), NUMBERS)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_kill_at_any_moment_leaves_a_whole_one(tmp_path):
    checkpoint.write(tmp_path, arrays(0), {"seed": 0})
    generator = np.random.default_rng(3)
    for _ in range(15):
        seed, before = checkpoint.read_latest(tmp_path)[1]["seed"], {path.name for path in tmp_path.iterdir()}
        with killed_at_last(write_checkpoints, tmp_path, seed):
            until = time.monotonic() + 60.0
            while not any(path.name not in before for path in tmp_path.iterdir()) and time.monotonic() < until:
                time.sleep(1e-3)  # a busy machine is slow to begin
            time.sleep(0.02 * generator.random())
        found, numbers = checkpoint.read_latest(tmp_path)
        assert np.array_equal(found["gas/position"], arrays(numbers["seed"])["gas/position"])
        assert len(written(tmp_path)) <= 3, "two, and a third for a moment"
    assert numbers["seed"] > 0
