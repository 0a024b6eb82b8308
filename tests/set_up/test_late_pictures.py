"""Pictures of instants that a run does not reach."""

import pytest
from small_cases import GAS, box, case

from pellucid.case import Case
from pellucid.simulation.simulation import Simulation


def test_the_last_instant_in_place_of_one_beyond_the_end_is_told():
    tables = case(box((1, 1, 0), (2, 2, 1), GAS, (2, 2, 1)), counts=(4, 4, 1), end=0.1)
    data = (tables if isinstance(tables, dict) else tables.to_data()) | {"picture": [{"name": "late", "times": [0.0, 0.2]}]}
    with pytest.warns(UserWarning, match=r"picture late: 0\.2 s is later than time\.end = 0\.1 s; the last frame is drawn"):
        Simulation(Case.model_validate(data), threads=1)
