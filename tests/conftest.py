"""Makes the modules of this folder that hold no tests (`algebra`, `small_cases`) importable from the tests below it."""

import pytest


@pytest.fixture
def gradients_in_doubles(monkeypatch):
    """Meshless solids with gradients in doubles, for what holds to round-off but for the rounding of singles."""
    import numpy as np

    from pellucid.bodies.meshless_solid import tables

    monkeypatch.setattr(tables, "STORAGE", np.float64)
