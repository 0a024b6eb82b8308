"""The processes that share a run, as each knows them."""

import os
import sys
import threading
import time

import pytest

from pellucid.ranks import group


@pytest.mark.skipif(sys.platform == "win32", reason="pipes tell there nothing of what is unread")
def test_an_abort_waits_until_the_launcher_has_read():
    """A launcher that is ended by an abort leaves unread all that stands in the pipe, seen where a machine is loaded."""
    reads, writes = os.pipe()
    began = []

    def launch():
        time.sleep(0.3)
        began.append(time.monotonic())
        os.read(reads, 100)

    launcher = threading.Thread(target=launch)
    launcher.start()
    with os.fdopen(writes, "w") as stream:
        print("only here", file=stream, flush=True)
        group._wait_until_read(stream, seconds=20.0)
        assert began
    launcher.join()
    os.close(reads)


def test_nobody_waits_for_a_file(tmp_path):
    with (tmp_path / "told.txt").open("w") as stream:
        print("only here", file=stream, flush=True)
        began = time.monotonic()
        group._wait_until_read(stream, seconds=20.0)
        assert time.monotonic() - began < 5.0
