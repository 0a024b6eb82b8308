import sys
import types

import pytest
from free_flight import FakeSimulation, kernel_key


@pytest.fixture
def fake(monkeypatch):
    """Runs are made by the fake simulation."""
    module = types.ModuleType("pellucid.simulation.simulation")
    module.Simulation = FakeSimulation
    module.kernel_key = kernel_key
    monkeypatch.setitem(sys.modules, "pellucid.simulation.simulation", module)
    return FakeSimulation
