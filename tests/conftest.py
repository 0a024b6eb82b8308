"""Makes the modules of this folder that hold no tests (`algebra`, `small_cases`) importable from the tests below it."""

import os
import signal
import sys

import pytest
from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read as numpy is imported; threads that wait take cores from other workers

settings.register_profile("without a clock", deadline=None)  # how long an example takes depends on what else runs
settings.load_profile("without a clock")


@pytest.fixture(scope="module", autouse=True)
def nothing_registered_stays():
    """What extensions of gallery cases register is unknown to the files that follow."""
    from registries import forgotten_afterwards

    with forgotten_afterwards():
        yield


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_make_scheduler(config, log):
    """A file goes to one worker, whose tests share kernels; of the gallery a case does, or one worker would run all of them."""
    from xdist.scheduler import LoadFileScheduling

    class ByFileOrCase(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file, _, test = nodeid.partition("::")
            return test.partition("[")[2] or file if file.endswith("test_gallery.py") else file

    config.option.loadscopereorder = False  # long cases of the gallery have few tests and would come last, on one worker
    return ByFileOrCase(config, log) if config.getvalue("dist") == "loadfile" else None


@pytest.fixture(scope="session", autouse=True)
def _no_helpers():
    """Runs compile, step and draw alone: the workers of the suite have the cores. Tests of helpers ask for cores themselves."""
    from pellucid.compilation import ahead
    from pellucid.results.pictures import painter
    from pellucid.simulation import simulation

    with pytest.MonkeyPatch.context() as patch:
        for module in (ahead, painter, simulation):
            patch.setattr(module, "free_cores", lambda: 0)
        yield


@pytest.fixture
def fake(monkeypatch):
    """Runs are made by the fake simulation."""
    from free_flight import FakeSimulation, fake_module

    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
    return FakeSimulation


@pytest.fixture
def gradients_in_doubles(monkeypatch):
    """Meshless solids with gradients in doubles, for what holds to round-off but for the rounding of singles."""
    import numpy as np

    from pellucid.bodies.meshless_solid import tables

    monkeypatch.setattr(tables, "STORAGE", np.float64)


@pytest.fixture
def interruptible():
    """Ctrl-C interrupts, also where the tests were started in the background, by a shell that ignores it there."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
