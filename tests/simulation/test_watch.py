"""From when on the energy balance is judged, and what is advised."""

from types import SimpleNamespace

import pytest

from pellucid.case.spec import EnergyCase
from pellucid.errors import RunStopped
from pellucid.simulation.watch import FIRST_JUDGED, Watch

LOST = SimpleNamespace(energy_error=lambda: -0.5, transfer=0.0, time_integration=-1.0)


def clock(n_steps):
    return SimpleNamespace(
        n_steps=n_steps, finished=lambda until: False, progress=lambda: 1.0, against_energy_error=None, case=None
    )


@pytest.mark.parametrize(
    ("own_steps", "has_grid", "first", "advice"),
    [
        (False, True, FIRST_JUDGED, "use a smaller step, a finer grid, or raise energy.stop"),
        (False, False, FIRST_JUDGED, "use a smaller step, or raise energy.stop"),
        (True, False, 1, "use a lower `accuracy`, more nodes, or raise energy.stop"),
    ],
)
def test_a_loss_stops_a_run_with_an_advice_that_applies(own_steps, has_grid, first, advice):
    watch = Watch(EnergyCase(), own_steps, has_grid)
    if first > 1:
        watch.energy(LOST, clock(first - 1))
    with pytest.raises(RunStopped, match=advice):
        watch.energy(LOST, clock(first))
