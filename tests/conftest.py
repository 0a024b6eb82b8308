"""Makes the modules of this folder that hold no tests (`algebra`, `small_cases`) importable from the tests below it."""

import os

import pytest
from hypothesis import settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read as numpy is imported; threads that wait take cores from other workers

settings.register_profile("without a clock", deadline=None)  # how long an example takes depends on what else runs
settings.load_profile("without a clock")


@pytest.fixture(scope="session", autouse=True)
def _no_helpers():
    """Runs compile and draw alone: the workers of the suite have the cores. Tests of helpers ask for cores themselves."""
    from pellucid.results.pictures import painter
    from pellucid.simulation import ahead

    with pytest.MonkeyPatch.context() as patch:
        for module in (ahead, painter):
            patch.setattr(module, "free_cores", lambda: 0)
        yield


@pytest.fixture
def gradients_in_doubles(monkeypatch):
    """Meshless solids with gradients in doubles, for what holds to round-off but for the rounding of singles."""
    import numpy as np

    from pellucid.bodies.meshless_solid import tables

    monkeypatch.setattr(tables, "STORAGE", np.float64)
