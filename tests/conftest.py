"""Fixtures and hooks of all tests. This file also makes the modules of this folder that contain no tests, such as
`algebra`, importable from the tests in subfolders."""

import os
import signal
import sys
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read as numpy is imported; threads that wait take cores from other workers

settings.register_profile("without a clock", deadline=None)  # how long an example takes depends on what else runs
settings.load_profile("without a clock")


@pytest.fixture(scope="module", autouse=True)
def nothing_registered_stays():
    """Remove the kinds that extensions of gallery cases register, so that the next test files do not know them."""
    from registries import forgotten_afterwards

    with forgotten_afterwards():
        yield


SLOW = Path(__file__).with_name("slow.txt")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Mark the tests that `slow.txt` lists (`test_slow.py` checks the list), and give tests marked full any time."""
    by_file = {}
    for item in items:
        by_file.setdefault(item.nodeid.partition("tests/")[2].partition("::")[0], []).append(item)
        if item.get_closest_marker("full"):
            item.add_marker(pytest.mark.timeout(0))
    for line in SLOW.read_text(encoding="utf-8").splitlines():
        file, _, test = line.partition("::")
        for item in by_file.get(file, ()):
            if fnmatchcase(item.nodeid.partition("::")[2], test.replace("[", "[[]")):
                item.add_marker(pytest.mark.slow)


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_make_scheduler(config, log):
    """Return a scheduler that sends the tests of a file to one worker, as they share kernels. Tests of the gallery are
    distributed by case, or one worker would run all of them."""
    from xdist.scheduler import LoadFileScheduling

    class ByFileOrCase(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file, _, test = nodeid.partition("::")
            return test.partition("[")[2] or file if file.endswith("test_gallery.py") else file

    config.option.loadscopereorder = False  # long cases of the gallery have few tests and would come last, on one worker
    return ByFileOrCase(config, log) if config.getvalue("dist") == "loadfile" else None


@pytest.fixture(scope="session", autouse=True)
def _no_helpers():
    """Make runs compile, step and draw without other processes, as the workers of the suite use the cores. Tests of such
    processes set the number of free cores themselves."""
    from pellucid.compilation import ahead
    from pellucid.results.pictures import painter
    from pellucid.simulation import simulation

    with pytest.MonkeyPatch.context() as patch:
        for module in (ahead, painter, simulation):
            patch.setattr(module, "free_cores", lambda: 0)
        yield


@pytest.fixture
def fake(monkeypatch):
    """Replace the simulation of the package by the fake simulation of `free_flight`, and return its class."""
    from free_flight import FakeSimulation, fake_module

    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
    return FakeSimulation


@pytest.fixture
def gradients_in_doubles(monkeypatch):
    """Store the gradients of meshless solids in double precision, for tests to round-off."""
    import numpy as np

    from pellucid.bodies.meshless_solid import functions

    monkeypatch.setattr(functions, "STORAGE", np.float64)


@pytest.fixture
def interruptible():
    """Let Ctrl-C raise KeyboardInterrupt, also if a shell started the tests in the background, where it ignores the signal."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
