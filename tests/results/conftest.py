import sys

import pytest
from free_flight import FakeSimulation, fake_module


@pytest.fixture
def fake(monkeypatch):
    """Runs are made by the fake simulation."""
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", fake_module())
    return FakeSimulation
