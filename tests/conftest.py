"""Makes the modules of this folder that hold no tests (`algebra`, `small_cases`) importable from the tests below it."""

import pytest
from hypothesis import settings

settings.register_profile("without a clock", deadline=None)  # how long an example takes depends on what else runs
settings.load_profile("without a clock")


@pytest.fixture
def gradients_in_doubles(monkeypatch):
    """Meshless solids with gradients in doubles, for what holds to round-off but for the rounding of singles."""
    import numpy as np

    from pellucid.bodies.meshless_solid import tables

    monkeypatch.setattr(tables, "STORAGE", np.float64)
