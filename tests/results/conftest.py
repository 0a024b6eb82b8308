import sys
import types

import pytest
from free_flight import FakeSimulation


@pytest.fixture
def fake(monkeypatch):
    """Runs are made by the fake simulation."""
    module = types.ModuleType("pellucid.simulation.simulation")
    module.Simulation = FakeSimulation
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", module)
    return FakeSimulation
